use std::io;
use std::path::PathBuf;

use fingervision_settings::SettingsError;

/// An impossible indenter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IndenterError {
    /// A value outside its range. It names its key as in a scene, `indenter.radius_mm`.
    #[error(transparent)]
    Setting(#[from] SettingsError),
    /// A polygon two of whose edges touch.
    #[error("indenter.points_mm: edge {} and edge {} meet: {:?} to {:?} and {:?} to {:?}", edges[0], edges[1], places_mm[0][0], places_mm[0][1], places_mm[1][0], places_mm[1][1])]
    EdgesMeet {
        /// Which edges, from 0: edge 0 goes from the first point to the second.
        edges: [usize; 2],
        /// Their ends, mm.
        places_mm: [[[f64; 2]; 2]; 2],
    },
    /// A character that the typeface does not contain.
    #[error("indenter.text = {text:?}: there is no letter for {character:?}")]
    NoGlyph {
        /// The text.
        text: String,
        /// The character.
        character: char,
    },
    /// A body wider than the gel.
    #[error("indenter.{key} = {value}: the indenter is {:.3} by {:.3} mm wide 3 mm behind its foremost point, the gel {} by {} mm", size_mm[0], size_mm[1], gel_mm[0], gel_mm[1])]
    WiderThanGel {
        /// The key that gives its size.
        key: &'static str,
        /// Its value.
        value: String,
        /// Width along x and y 3 mm behind the foremost point, mm.
        size_mm: [f64; 2],
        /// The gel's, mm.
        gel_mm: [f64; 2],
    },
    /// A face that is not on the gel.
    #[error("motion.centre_mm = {centre_mm:?}: the indenter's face reaches from x {:.3} to {:.3} and y {:.3} to {:.3} mm, the gel to x ±{} and y ±{} mm", face_mm[0][0], face_mm[0][1], face_mm[1][0], face_mm[1][1], gel_mm[0] / 2.0, gel_mm[1] / 2.0)]
    OffTheGel {
        /// Position of the indenter's origin, mm.
        centre_mm: [f64; 2],
        /// Extent of its foremost part, `[[from, to]; 2]` along x and y, mm.
        face_mm: [[f64; 2]; 2],
        /// The gel's width along x and y, mm.
        gel_mm: [f64; 2],
    },
    /// A file that cannot be read.
    #[error("indenter.file: cannot read {}: {}", file.display(), why_unreadable(*kind))]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's message.
        kind: io::ErrorKind,
    },
    /// An image that is not a height map.
    #[error("indenter.file: {} is not a height map: {why}", file.display())]
    NoHeightMap {
        /// The file.
        file: PathBuf,
        /// The actual format.
        why: String,
    },
    /// A file that is not an STL mesh, or contains no body.
    #[error("indenter.file: {} contains no mesh: {why}", file.display())]
    NoMesh {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// A mesh with holes.
    #[error("indenter.file: the mesh of {} is not closed: {open_edges} of its {edges} edges belong to an odd number of its {triangles} triangles, one of them at {place:?}", file.display())]
    OpenMesh {
        /// The file.
        file: PathBuf,
        /// Edges at the border of a hole.
        open_edges: usize,
        /// All edges.
        edges: usize,
        /// Triangles.
        triangles: usize,
        /// The middle of an open edge, in the file's coordinates.
        place: [f64; 3],
    },
}

impl IndenterError {
    /// The key of a scene that causes the error.
    #[must_use]
    pub fn key(&self) -> String {
        match self {
            Self::Setting(SettingsError::OutOfRange { key, .. }) => key.clone(),
            Self::Setting(_) => "indenter".into(),
            Self::EdgesMeet { .. } => "indenter.points_mm".into(),
            Self::NoGlyph { .. } => "indenter.text".into(),
            Self::WiderThanGel { key, .. } => format!("indenter.{key}"),
            Self::OffTheGel { .. } => "motion.centre_mm".into(),
            Self::Read { .. } | Self::NoHeightMap { .. } | Self::NoMesh { .. } | Self::OpenMesh { .. } => {
                "indenter.file".into()
            }
        }
    }

    /// What to do about it.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Setting(error) => error.hint().unwrap_or_default(),
            Self::EdgesMeet { .. } => {
                "give the corners in the order in which they follow around the outline; it is closed by itself".into()
            }
            Self::NoGlyph { .. } => "use letters, digits and signs of western European languages".into(),
            Self::WiderThanGel { .. } => "give a smaller indenter or a wider gel".into(),
            Self::OffTheGel { .. } => "move the indenter towards the middle, or give a smaller one".into(),
            Self::Read { .. } => "paths are relative to the scene's folder".into(),
            Self::NoHeightMap { .. } => {
                "give a PNG in 8 or 16 bit grey without transparency; white is the foremost".into()
            }
            Self::NoMesh { .. } => "export the body again, as a binary or text STL in mm".into(),
            Self::OpenMesh { .. } => {
                "repair the mesh so that every edge joins two triangles, or export the solid and not a surface".into()
            }
        }
    }
}

fn why_unreadable(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "no such file".into(),
        _ => kind.to_string(),
    }
}
