//! The folder of a simulated press: frames, their truth, and the files that are needed to track and to repeat it.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use fingervision_gel::Scene;
use fingervision_sink::{ArrayWriter, Field, FolderKind, FolderLock, Rows, SinkError, write_file, write_pixels};
use fingervision_touch::{DEPTH_COLUMN, FORCE_COLUMNS, FRAME_COLUMN, TORQUE_COLUMN};

use crate::frame::SimulatedFrame;
use crate::profile::simulated_profile;

const FRAMES: &str = "frames";

/// The contents of a simulated press; `scene.toml` reproduces it.
const SIMULATION: FolderKind = FolderKind {
    noun: "simulation",
    marker: "scene.toml",
    files: &[
        "truth/flow.npy",
        "truth/depth.npy",
        "truth/displacement.npy",
        "truth/contact.npy",
        "truth/visible.npy",
        "truth/force.csv",
        "profile.toml",
        "preview.png",
        Scene::FILES_BESIDE[0],
        Scene::FILES_BESIDE[1],
    ],
    images: Some(FRAMES),
    folders: &["truth"],
};

/// The columns of `truth/force.csv`, in order.
const COLUMNS: [&str; 6] =
    [FRAME_COLUMN, DEPTH_COLUMN, FORCE_COLUMNS[0], FORCE_COLUMNS[1], FORCE_COLUMNS[2], TORQUE_COLUMN];

/// A folder that takes a simulated press frame by frame, in constant memory.
///
/// | file | type | meaning |
/// | --- | --- | --- |
/// | `frames/000000.png` … | 8 bit, colour or grey | the camera image |
/// | `truth/flow.npy` | float32 `[N, H, W, 2]` | px, (x, y), reference grid |
/// | `truth/depth.npy` | float32 `[N, H, W]` | mm, positive pressed in |
/// | `truth/displacement.npy` | float32 `[N, H, W, 3]` | mm, gel space |
/// | `truth/contact.npy` | uint8 `[N, H, W]` | 1 where the point touches the indenter |
/// | `truth/visible.npy` | uint8 `[N, H, W]` | 1 where the camera sees the point |
/// | `truth/force.csv` | | frame, depth, force on the gel, torque about the centre of contact |
/// | `profile.toml` | | camera and gel, for the tracker |
/// | `scene.toml` | | the scene, every default written out |
///
/// Where a pixel shows no gel, numbers are NaN and masks 0. After every frame the arrays can be read up to it.
#[derive(Debug)]
pub struct SimulationFolder {
    path: PathBuf,
    has_frames: bool,
    count: u64,
    flow: ArrayWriter<[f32; 2]>,
    depth: ArrayWriter<f32>,
    displacement: ArrayWriter<[f32; 3]>,
    contact: ArrayWriter<u8>,
    visible: ArrayWriter<u8>,
    forces: Rows,
    lock: FolderLock,
}

impl SimulationFolder {
    /// Prepares a folder for a scene, and writes the scene and the sensor's profile.
    ///
    /// A folder that contains a previous simulation is refused, or with `overwrite` its files are removed first. A
    /// folder that holds anything else is always refused. Without `has_frames` no images are to be written.
    ///
    /// # Errors
    ///
    /// [`SinkError::Busy`], [`SinkError::Previous`] or [`SinkError::FolderNotEmpty`] if the folder is taken,
    /// [`SinkError::Write`] if it or a file in it cannot be written.
    pub fn create(path: &Path, scene: &Scene, has_frames: bool, overwrite: bool) -> Result<Self, SinkError> {
        let lock = SIMULATION.claim(path, overwrite)?;
        let (resolved, file) = scene.with_file_beside();
        write_file(&path.join(SIMULATION.marker), resolved.to_toml().as_bytes())?;
        if let (Some(from), Some(beside)) = (file, resolved.file()) {
            let to = path.join(beside);
            fs::copy(from, &to).map_err(SinkError::writing(&to))?;
        }
        write_file(&path.join("profile.toml"), simulated_profile(scene).to_toml().as_bytes())?;
        for folder in has_frames.then_some(FRAMES).into_iter().chain(["truth"]) {
            let folder = path.join(folder);
            fs::create_dir_all(&folder).map_err(SinkError::writing(&folder))?;
        }
        let (width, height) = (scene.render.width, scene.render.height);
        let truth = path.join("truth");
        Ok(Self {
            path: path.to_owned(),
            has_frames,
            count: 0,
            flow: ArrayWriter::create(&truth.join(Field::Flow.file_name()), width, height)?,
            depth: ArrayWriter::create(&truth.join(Field::Depth.file_name()), width, height)?,
            displacement: ArrayWriter::create(&truth.join(Field::Displacement.file_name()), width, height)?,
            contact: ArrayWriter::create(&truth.join(Field::Contact.file_name()), width, height)?,
            visible: ArrayWriter::create(&truth.join("visible.npy"), width, height)?,
            forces: Rows::create(&truth.join("force.csv"), &COLUMNS)?,
            lock,
        })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Appends the next frame.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] if the truth has another size than the scene's images, [`SinkError::FieldAbsent`] if
    /// an image was to be written and is absent, [`SinkError::Write`] if a file cannot take it. The frame is then in no
    /// array.
    pub fn write(&mut self, frame: &SimulatedFrame) -> Result<(), SinkError> {
        self.write_image(frame)?;
        let truth = frame.truth;
        self.flow.stage(truth.flow.values().iter().copied())?;
        self.depth.stage(truth.depth.values().iter().copied())?;
        self.displacement.stage(truth.displacement.values().iter().copied())?;
        self.contact.stage(truth.contact.values().iter().copied())?;
        self.visible.stage(truth.visible.values().iter().copied())?;
        let count = self.count;
        self.forces.write(|row| write_force(row, count, frame))?;
        self.flow.commit()?;
        self.depth.commit()?;
        self.displacement.commit()?;
        self.contact.commit()?;
        self.visible.commit()?;
        self.count += 1;
        Ok(())
    }

    /// Flushes everything to the disk and returns the number of frames.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses a file.
    pub fn finish(self) -> Result<u64, SinkError> {
        self.flow.finish()?;
        self.depth.finish()?;
        self.displacement.finish()?;
        self.contact.finish()?;
        self.visible.finish()?;
        self.forces.finish()?;
        drop(self.lock);
        Ok(self.count)
    }

    fn write_image(&self, frame: &SimulatedFrame) -> Result<(), SinkError> {
        if !self.has_frames {
            return Ok(());
        }
        let pixels = frame.pixels.ok_or(SinkError::FieldAbsent { field: "image", sequence: self.count })?;
        write_pixels(pixels, &self.path.join(FRAMES).join(format!("{:06}.png", self.count)))
    }
}

fn write_force(row: &mut String, number: u64, frame: &SimulatedFrame) -> std::fmt::Result {
    let [x, y, z] = frame.force_n;
    write!(row, "{number}")?;
    for value in [frame.depth_mm, x, y, z, frame.torque_z_nmm] {
        // Adding zero leaves no negative zero.
        write!(row, ",{}", value + 0.0)?;
    }
    Ok(())
}
