//! The press whose tracking is timed; its images can also be written, to time other programs on them.

use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use fingervision_gel::{GelError, Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Image, Pixels};
use fingervision_sink::{ArrayWriter, SinkError, write_png};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::failure::Failure;

/// Frames of the press, including the reference.
pub(super) const FRAMES: u64 = 31;
/// The largest displacement of the last frame, px, on images whose shorter side is [`ROWS`].
const AMPLITUDE_PX: f64 = 25.0;
/// Distance of the largest displacement from the middle, px, on the same images.
const RADIUS_PX: f64 = 80.0;
/// On other images the bump grows with the shorter side: one gel, seen by another camera.
const ROWS: f64 = 450.0;

/// A round bump that grows linearly after the reference.
#[derive(Debug)]
pub(super) struct Press {
    renderer: SheetRenderer,
    deepest: Motion,
    amplitude_px: f64,
}

/// The files of a press.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    /// The folder of images.
    frames: PathBuf,
    /// Their displacement, px: `[frame][row][column][x, y]`.
    flow: PathBuf,
}

impl Press {
    /// A press in the middle of images of this size, px.
    pub(super) fn new((width, height): (usize, usize)) -> Result<Self, GelError> {
        let renderer = SheetRenderer::new(&Sheet { width, height, ..Sheet::default() })?;
        let scale = width.min(height) as f64 / ROWS;
        let (radius_px, amplitude_px) = (scale * RADIUS_PX, scale * AMPLITUDE_PX);
        let deepest = Motion::RadialBump { centre_px: renderer.sheet().centre_px(), radius_px, amplitude_px };
        Ok(Self { renderer, deepest, amplitude_px })
    }

    /// The largest displacement of the last frame, px.
    pub(super) fn amplitude_px(&self) -> f64 {
        self.amplitude_px
    }

    /// Columns and rows, px.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.renderer.sheet().width, self.renderer.sheet().height)
    }

    /// The motion of a frame; the reference, frame 0, is at rest.
    pub(super) fn motion(&self, frame: u64) -> Motion {
        self.deepest.at(frame as f64 / (FRAMES - 1) as f64)
    }

    /// A frame with its own noise.
    pub(super) fn frame(&self, sequence: u64) -> Result<Frame, GelError> {
        Ok(Frame { sequence, capture_time_s: sequence as f64, pixels: Pixels::Rgb8(self.image(sequence)?) })
    }

    fn image(&self, frame: u64) -> Result<Image<[u8; 3]>, GelError> {
        self.renderer.render(&self.motion(frame), Light::EVEN, 1 + frame)
    }

    /// Writes all frames and their true flow into new folders of `folder`.
    pub(super) fn write(&self, folder: &Path, progress: &ProgressBar) -> Result<Written, Failure> {
        let (width, height) = self.size();
        let (frames, truth) = (new_folder(folder, "frames")?, new_folder(folder, "truth")?);
        let flow = truth.join("flow.npy");
        let mut array = ArrayWriter::create(&flow, width, height)?;
        for frame in 0..FRAMES {
            write_png(&self.image(frame)?, &frames.join(format!("{frame:06}.png")))?;
            let truth = self.motion(frame).flow(width, height);
            array.write(truth.u.values().iter().zip(truth.v.values()).map(|(&u, &v)| [u, v]))?;
            progress.inc(1);
        }
        array.finish()?;
        progress.finish_and_clear();
        Ok(Written { frames, flow })
    }
}

fn new_folder(parent: &Path, name: &str) -> Result<PathBuf, Failure> {
    let path = parent.join(name);
    match fs::create_dir_all(parent).and_then(|()| fs::create_dir(&path)) {
        Ok(()) => Ok(path),
        Err(error) if error.kind() == ErrorKind::AlreadyExists && path.exists() => {
            Err(Failure::new(format!("{} exists already", path.display()), "choose a new folder"))
        }
        Err(error) => Err(SinkError::Write { path, error }.into()),
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "frames    {FRAMES} in {}, the reference first", self.frames.display())?;
        writeln!(f, "truth     {}", self.flow.display())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_grows_evenly_behind_the_reference() {
        let press = Press::new((610, 450)).unwrap();
        assert_eq!(press.size(), (610, 450));
        for (frame, expected) in [(0, 0.0), (15, 12.5), (30, 25.0)] {
            let (u, v) = press.motion(frame).displacement(304.5 + 80.0, 224.5);
            assert!((u - expected).abs() < 1e-9 && v.abs() < 1e-9, "frame {frame}: {u} px, expected {expected} px");
        }
    }

    #[test]
    fn a_press_grows_with_the_image() {
        let press = Press::new((300, 90)).unwrap();
        let (u, _) = press.motion(30).displacement(149.5 + 16.0, 44.5);
        assert!((u - 5.0).abs() < 1e-9 && (press.amplitude_px() - 5.0).abs() < 1e-12, "{u} px, expected 5 px");
        assert!((Press::new((1280, 900)).unwrap().amplitude_px() - 50.0).abs() < 1e-12);
    }
}
