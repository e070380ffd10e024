//! The frames whose processing is counted: a simulated press on a draft mesh.
//!
//! They are rendered once and written to a file, so that the counted program only reads them.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use fingervision_gel::{Keyframe, Motif, PressCache, Scene, Simulation, Truth};
use fingervision_image::{Image, Pixels};
use fingervision_simulation::simulated_profile;
use fingervision_touch::Profile;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

/// Focal length by the width of the image: the gel then fills it.
const FOCAL_LENGTH: f64 = 533.0 / 640.0;
/// Width of a cell of the pattern, mm, times the width of the image.
const CELL_MM_PX: f64 = 0.1 * 640.0;
const JPEG_QUALITY: u8 = 85;

/// Frames at rest after the reference, frame 0: first those that are not counted.
pub(super) const REST_START: [usize; 1] = [1];
pub(super) const REST: [usize; 2] = [2, 3];
/// The frame at rest that becomes the new reference after the pressed frames. Only one is counted: it takes as many instructions as ten
/// pressed frames.
pub(super) const NEW_REFERENCE: [usize; 1] = [2];
/// Pressed frames: first those that are not counted. From the third on, the ball moves by .1 mm a frame.
pub(super) const PRESSED_START: [usize; 4] = [4, 5, 6, 7];
pub(super) const PRESSED: [usize; 4] = [8, 9, 8, 7];
const FRAMES: usize = 10;
/// Depth of the ball, mm, after so many frames; in between it moves evenly.
const COURSE: [(f64, f64); 3] = [(3.0, 0.0), (5.0, 1.2), (9.0, 1.6)];

/// The frames, all in memory.
pub(super) struct Film {
    frames: Vec<Image<[u8; 3]>>,
}

/// The press, with cells of the pattern that are 2 px wide.
fn scene(size: (usize, usize)) -> Result<Scene> {
    let mut scene = Scene::find("sphere")?;
    scene.make_draft();
    (scene.render.width, scene.render.height) = size;
    let width = size.0 as f64;
    scene.camera.focal_length_px = [FOCAL_LENGTH * width; 2];
    scene.pattern.motif = Motif::Colour { cell_mm: CELL_MM_PX / width };
    scene.motion.frames = FRAMES;
    scene.motion.keyframes =
        COURSE.map(|(at, depth_mm)| Keyframe { at, depth_mm: Some(depth_mm), ..Keyframe::default() }).into();
    Ok(scene)
}

impl Film {
    /// Solves the press and renders it; returns the truth of every frame, too.
    pub(super) fn make(size: (usize, usize)) -> Result<(Self, Vec<Truth>)> {
        let mut simulation = Simulation::new(&scene(size)?)?;
        let solved = simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(()))?.states.len();
        ensure!(solved == FRAMES, "the press has {solved} frames, and {FRAMES} are needed");
        let (mut frames, mut truths) = (Vec::new(), Vec::new());
        for number in 0..FRAMES {
            let Pixels::Rgb8(image) = simulation.frame(number)?.clone() else {
                anyhow::bail!("the frames of the press are not in 8-bit colour")
            };
            frames.push(image);
            truths.push(simulation.truth(number)?.clone());
        }
        Ok((Self { frames }, truths))
    }

    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let bytes: Vec<u8> = self.frames.iter().flat_map(|frame| frame.values().as_flattened()).copied().collect();
        fs::write(path, bytes).with_context(|| format!("{} cannot be written", path.display()))
    }

    pub(super) fn read(path: &Path, size: (usize, usize)) -> Result<Self> {
        let (width, height) = size;
        let bytes = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let (pixels, rest) = bytes.as_chunks::<3>();
        ensure!(
            rest.is_empty() && pixels.len() == FRAMES * width * height,
            "{} does not contain {FRAMES} frames",
            path.display()
        );
        let frames = pixels.chunks_exact(width * height).map(|frame| Image::from_vec(width, height, frame.to_vec()));
        Ok(Self { frames: frames.collect::<Result<_, _>>()? })
    }

    /// Columns and rows of a frame, px.
    pub(super) fn size(&self) -> (usize, usize) {
        self.frame(0).size()
    }

    pub(super) fn frame(&self, number: usize) -> &Image<[u8; 3]> {
        &self.frames[number]
    }

    /// The sensor that the film shows.
    pub(super) fn profile(&self) -> Result<Profile> {
        Ok(simulated_profile(&scene(self.size())?))
    }

    /// A frame as JPEG with chroma halved across, as USB cameras send it.
    pub(super) fn coded(&self, number: usize) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, JPEG_QUALITY);
        encoder.set_sampling_factor(SamplingFactor::F_2_1);
        let values = self.frame(number).values().as_flattened();
        let (width, height) = self.size();
        encoder.encode(values, width as u16, height as u16, ColorType::Rgb)?;
        Ok(bytes)
    }
}
