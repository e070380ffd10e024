//! The description of an indenter: the `[indenter]` table of a scene.

use std::path::{Path, PathBuf};

use fingervision_elastic::GelBlock;

use super::face::Face;
use super::grid::HeightGrid;
use super::height_field::HeightField;
use super::height_map::HeightMap;
use super::mesh::{Mesh, check_size};
use super::outline::Outline;
use super::profile::Profile;
use super::{IndenterError, IndenterRelief, letter};

/// A rigid body and its edges.
///
/// As a table: `shape` is one of `"circle"`, `"rectangle"`, `"triangle"`, `"polygon"`, `"crossing"`, `"ring"`,
/// `"sphere"`, `"pins"`, `"letter"`, `"height-map"`, `"stl"`; beside it stand the sizes of that shape, as named in
/// [`IndenterShape`], and `fillet_mm`, `wall_slope`, `rotation_rad`. A size of another shape is refused.
///
/// ```
/// use fingervision_elastic::Relief;
/// use fingervision_gel::{Indenter, IndenterShape};
///
/// let indenter = Indenter::new(IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 });
/// let relief = indenter.relief(".".as_ref())?;
/// assert_eq!(relief.at(3.0, 0.0).height_mm, 0.0);
/// assert!(relief.at(0.0, 0.0).height_mm > 6.0 && !relief.is_face(0.0, 0.0));
/// # Ok::<(), fingervision_gel::IndenterError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Indenter {
    /// Its shape and size.
    pub shape: IndenterShape,
    /// Radius of the fillet around a flat face, mm. On a height map or a mesh, the width over which edges are rounded.
    /// A sphere has no edge: it is ignored there.
    pub fillet_mm: f64,
    /// Slope at which walls end, dimensionless: 3 is 72°.
    pub wall_slope: f64,
    /// Angle by which the body is turned about z, from x towards y: clockwise on screen, rad.
    pub rotation_rad: f64,
}

/// Shapes of indenters. Sizes are those of the flat face.
#[derive(Debug, Clone, PartialEq)]
pub enum IndenterShape {
    /// A round face.
    Circle {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A rectangular face.
    Rectangle {
        /// Width along x and y, mm.
        size_mm: [f64; 2],
    },
    /// An equilateral triangle that points up in the image, its centroid at the origin.
    Triangle {
        /// Length of a side, mm.
        side_mm: f64,
    },
    /// Any outline of straight edges that does not meet itself.
    Polygon {
        /// Its corners in order, mm, in either sense.
        points_mm: Vec<[f64; 2]>,
    },
    /// Two equal bars crossing at right angles.
    Crossing {
        /// Length and width of a bar, mm.
        bar_mm: [f64; 2],
    },
    /// A round face with a round hole.
    Ring {
        /// Radius of the hole, mm.
        inner_radius_mm: f64,
        /// Radius of the face, mm.
        outer_radius_mm: f64,
    },
    /// A ball.
    Sphere {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// Round pins with flat ends.
    Pins {
        /// Radius of a pin's flat end, mm.
        radius_mm: f64,
        /// Where the pins stand, mm.
        centres_mm: Vec<[f64; 2]>,
    },
    /// Letters as flat faces with their holes, to be read in the camera's image.
    Letter {
        /// One letter or a few.
        text: String,
        /// Height of a capital, mm.
        height_mm: f64,
    },
    /// A grey PNG of 8 or 16 bit, its first row at the top. Colour and transparency are refused.
    HeightMap {
        /// The file, relative to the scene's folder.
        file: PathBuf,
        /// Width and height of the image, mm.
        size_mm: [f64; 2],
        /// Height difference between white and black, mm: black lies behind white.
        height_mm: f64,
    },
    /// A closed mesh, seen from its top: X is right, Y up in the image, Z towards the gel. Its box is centred.
    Stl {
        /// The file, relative to the scene's folder.
        file: PathBuf,
        /// Length of the file's unit, mm.
        scale: f64,
    },
}

impl Default for Indenter {
    /// A circle of radius 4 mm.
    fn default() -> Self {
        Self::new(IndenterShape::Circle { radius_mm: 4.0 })
    }
}

impl Indenter {
    /// Default radius of the fillet, mm.
    pub const FILLET_MM: f64 = 0.3;
    /// Default slope of the walls, dimensionless.
    pub const WALL_SLOPE: f64 = 3.0;

    /// A shape with the default fillet and walls, not rotated.
    #[must_use]
    pub fn new(shape: IndenterShape) -> Self {
        Self { shape, fillet_mm: Self::FILLET_MM, wall_slope: Self::WALL_SLOPE, rotation_rad: 0.0 }
    }

    /// The file that the shape comes from, as it is named; absent for a shape that needs none.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match &self.shape {
            IndenterShape::HeightMap { file, .. } | IndenterShape::Stl { file, .. } => Some(file),
            _ => None,
        }
    }

    /// The body's shape. A file is read, relative to `folder`.
    ///
    /// # Errors
    ///
    /// The errors of [`Indenter::validate`], a letter that the typeface lacks, or an error of the file.
    pub fn relief(&self, folder: &Path) -> Result<IndenterRelief, IndenterError> {
        self.validate()?;
        let profile = Profile::new(self.fillet_mm, self.wall_slope);
        let face = match &self.shape {
            IndenterShape::Sphere { radius_mm } => {
                return Ok(IndenterRelief::of_ball(Profile::new(*radius_mm, self.wall_slope)));
            }
            IndenterShape::HeightMap { file, size_mm, height_mm } => {
                let map = HeightMap::read(&folder.join(file), *size_mm, *height_mm)?;
                return Ok(self.field(size_mm.map(|size| 0.5 * size), |grid| map.over(grid)));
            }
            IndenterShape::Stl { file, scale } => {
                let file = folder.join(file);
                let mesh = Mesh::read(&file, *scale)?;
                check_size(&file, mesh.half_extent_mm())?;
                return Ok(self.field(mesh.half_extent_mm(), |grid| mesh.over(grid)));
            }
            IndenterShape::Circle { radius_mm } => Face::Discs { radius_mm: *radius_mm, centres_mm: vec![[0.0; 2]] },
            IndenterShape::Pins { radius_mm, centres_mm } => {
                let centres_mm = centres_mm.iter().map(|&centre| self.turned(centre)).collect();
                Face::Discs { radius_mm: *radius_mm, centres_mm }
            }
            IndenterShape::Ring { inner_radius_mm, outer_radius_mm } => {
                Face::Ring { inner_radius_mm: *inner_radius_mm, outer_radius_mm: *outer_radius_mm }
            }
            IndenterShape::Letter { text, height_mm } => self.outline(letter::outlines(text, *height_mm)?),
            IndenterShape::Polygon { points_mm } => self.outline(vec![points_mm.clone()]),
            IndenterShape::Rectangle { size_mm } => self.outline(vec![rectangle(size_mm.map(|size| 0.5 * size))]),
            IndenterShape::Triangle { side_mm } => self.outline(vec![triangle(*side_mm)]),
            IndenterShape::Crossing { bar_mm } => self.outline(vec![crossing(bar_mm.map(|size| 0.5 * size))]),
        };
        Ok(IndenterRelief::of_face(face, profile))
    }

    /// The body's shape, if it fits on a gel with its origin at `centre_mm`.
    ///
    /// The part at most 3 mm behind the foremost point must not be wider than the gel, and the part at most 0.1 mm
    /// behind it must be on the gel.
    ///
    /// # Errors
    ///
    /// The errors of [`Indenter::relief`], [`IndenterError::WiderThanGel`] or [`IndenterError::OffTheGel`].
    pub fn relief_on(
        &self,
        block: &GelBlock,
        centre_mm: [f64; 2],
        folder: &Path,
    ) -> Result<IndenterRelief, IndenterError> {
        let relief = self.relief(folder)?;
        self.check_on(&relief, block, centre_mm)?;
        Ok(relief)
    }

    fn outline(&self, mut loops: Vec<Vec<[f64; 2]>>) -> Face {
        for corner in loops.iter_mut().flatten() {
            *corner = self.turned(*corner);
        }
        Face::Outline(Outline::new(&loops))
    }

    fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.rotation_rad.sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    }

    fn field(&self, half_extent_mm: [f64; 2], sample: impl Fn(&mut HeightGrid)) -> IndenterRelief {
        let mut grid = HeightGrid::around(half_extent_mm, self.fillet_mm, self.wall_slope);
        sample(&mut grid);
        IndenterRelief::of_field(HeightField::new(grid, self.fillet_mm, self.wall_slope, self.rotation_rad))
    }
}

fn rectangle([x, y]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[-x, -y], [x, -y], [x, y], [-x, y]]
}

fn triangle(side: f64) -> Vec<[f64; 2]> {
    let half_height = 0.25 * 3.0_f64.sqrt() * side;
    let [top, base] = [-4.0 / 3.0 * half_height, 2.0 / 3.0 * half_height];
    vec![[0.0, top], [0.5 * side, base], [-0.5 * side, base]]
}

/// Two bars of half-length `l` and half-width `w`.
fn crossing([l, w]: [f64; 2]) -> Vec<[f64; 2]> {
    let arm = [[w, -w], [l, -w], [l, w]];
    let quarter = |turns: usize| arm.map(|corner| (0..turns).fold(corner, |[x, y], _| [-y, x]));
    (0..4).flat_map(quarter).collect()
}
