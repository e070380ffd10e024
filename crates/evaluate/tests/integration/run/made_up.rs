//! An artificial run and its truth, with errors that can be computed by hand.
//!
//! On 40×30 px of 0.25 mm a square of 20×20 px, columns 10 to 29 and rows 5 to 24, is touched. Its border, 1 mm to
//! either side, is 4 px wide: 256 px inside, and outside 4·20·4 px along its sides and 11 px at each corner.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_evaluate::run::{Evaluation, Options, Outcome, RunError};
use fingervision_sink::{ArrayWriter, Element};
use tempfile::TempDir;

pub(crate) const WIDTH: usize = 40;
pub(crate) const HEIGHT: usize = 30;
/// How strong each frame's press is; the errors go with it.
pub(crate) const STRENGTHS: [f32; 3] = [0.0, 0.5, 1.0];

pub(crate) const PROFILE: &str = "name = \"made up\"\n\
    [camera]\n\
    focal_length_px = [100.0, 100.0]\n\
    principal_point_px = [19.5, 14.5]\n\
    translation_mm = [0.0, 0.0, 25.0]\n";

/// Where a pixel lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Zone {
    /// In contact, farther than 1 mm from its border.
    Core,
    /// In contact, near its border.
    InnerBorder,
    /// Not in contact, near its border.
    OuterBorder,
    Away,
}

/// The zone of a pixel, from its distance to the square in px: the border's points lie beside pixel centres.
pub(crate) fn zone(x: usize, y: usize) -> Zone {
    let beyond = |at: usize, low: usize, high: usize| low.saturating_sub(at).max(at.saturating_sub(high));
    let (right, down) = (beyond(x, 10, 29), beyond(y, 5, 24));
    if right == 0 && down == 0 {
        let depth = (x - 10).min(29 - x).min(y - 5).min(24 - y);
        return if depth < 4 { Zone::InnerBorder } else { Zone::Core };
    }
    // Beside a corner the nearest border point is half a pixel off along one axis and a whole one along the other.
    let (far, near) = (right.max(down) as f64, right.min(down) as f64);
    if (far - 0.5).powi(2) + near.powi(2) <= 16.0 { Zone::OuterBorder } else { Zone::Away }
}

/// Not seen by the truth, or not valid in the run; all of them lie away.
pub(crate) fn is_hidden(_x: usize, y: usize) -> bool {
    y == 0
}

pub(crate) fn is_invalid(x: usize, y: usize) -> bool {
    x == 0 && y != 0
}

pub(crate) fn true_depth(x: usize, y: usize) -> f32 {
    match zone(x, y) {
        Zone::Core | Zone::InnerBorder => 2.0,
        _ => -0.125,
    }
}

pub(crate) fn depth_error(x: usize, y: usize) -> f32 {
    match zone(x, y) {
        Zone::Core => -0.125,
        Zone::InnerBorder => -0.5,
        Zone::OuterBorder => 0.25,
        Zone::Away => 0.0625,
    }
}

/// What the run has for it: no number where it is not valid.
pub(crate) fn estimated_depth(strength: f32, x: usize, y: usize) -> f32 {
    if is_invalid(x, y) { f32::NAN } else { strength * (true_depth(x, y) + depth_error(x, y)) }
}

pub(crate) fn is_touched(x: usize, y: usize) -> bool {
    matches!(zone(x, y), Zone::Core | Zone::InnerBorder)
}

pub(crate) struct MadeUp {
    folder: TempDir,
}

impl MadeUp {
    /// Both folders whole: `run`, and `simulation` with its `truth`.
    pub(crate) fn new() -> Self {
        let made_up = Self { folder: tempfile::tempdir().unwrap() };
        fs::create_dir_all(made_up.path("run")).unwrap();
        fs::create_dir_all(made_up.path("simulation/truth")).unwrap();
        made_up.write_truth();
        made_up.write_run();
        made_up
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn remove(&self, name: &str) {
        fs::remove_file(self.path(name)).unwrap();
    }

    /// Writes an array of three frames.
    pub(crate) fn array<T: Element>(&self, name: &str, value: impl Fn(f32, usize, usize) -> T) {
        self.array_of(name, (WIDTH, HEIGHT), &STRENGTHS, value);
    }

    pub(crate) fn array_of<T: Element>(
        &self,
        name: &str,
        (width, height): (usize, usize),
        strengths: &[f32],
        value: impl Fn(f32, usize, usize) -> T,
    ) {
        let mut writer = ArrayWriter::create(&self.path(name), width, height).unwrap();
        for &strength in strengths {
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let values: Vec<T> = pixels.map(|(x, y)| value(strength, x, y)).collect();
            writer.write(values.into_iter()).unwrap();
        }
        writer.finish().unwrap();
    }

    pub(crate) fn open(&self, options: Options) -> Result<Evaluation, RunError> {
        Evaluation::open(&self.path("run"), &self.path("simulation"), options)
    }

    pub(crate) fn evaluate(&self) -> Outcome {
        finish(self.open(Options::default()).unwrap()).unwrap()
    }

    /// What the evaluation fails with, and its hint.
    pub(crate) fn failure(&self) -> (String, String) {
        let error = self.open(Options::default()).and_then(finish).unwrap_err();
        let text = error.to_string().replace(&format!("{}/", self.folder.path().display()), "");
        (text, error.hint().unwrap_or_default())
    }

    fn write_truth(&self) {
        let unless_hidden = |x, y, value: f32| if is_hidden(x, y) { f32::NAN } else { value };
        self.array("simulation/truth/depth.npy", |s, x, y| unless_hidden(x, y, s * true_depth(x, y)));
        self.array("simulation/truth/flow.npy", |s, x, y| {
            let size = if is_touched(x, y) { s } else { 0.0 };
            [3.0, 4.0].map(|part| unless_hidden(x, y, size * part))
        });
        self.array("simulation/truth/displacement.npy", |s, x, y| {
            [1.0, 0.0, 2.0].map(|part| unless_hidden(x, y, s * part))
        });
        self.array("simulation/truth/contact.npy", |s, x, y| u8::from(s > 0.0 && is_touched(x, y)));
        self.array("simulation/truth/visible.npy", |_, x, y| u8::from(!is_hidden(x, y)));
        self.write(
            "simulation/truth/force.csv",
            "frame,depth_mm,force_x_n,force_y_n,force_z_n,torque_z_nmm\n\
             0,0,0,0,0,0\n1,1,1.5,0,2,0\n2,2,3,0,4,0\n",
        );
        self.write("simulation/profile.toml", PROFILE);
    }

    fn write_run(&self) {
        let unless_invalid = |x, y, value: f32| if is_invalid(x, y) { f32::NAN } else { value };
        self.array("run/depth.npy", estimated_depth);
        self.array("run/flow.npy", |s, x, y| {
            let size = if is_touched(x, y) { s } else { 0.0 };
            [3.375, 3.5].map(|part| unless_invalid(x, y, size * part))
        });
        self.array("run/valid.npy", |_, x, y| u8::from(!is_invalid(x, y)));
        self.write(
            "run/readings.csv",
            "sequence,capture_time_s,force_x_n,force_y_n,force_z_n,flags\n\
             7,0.0,,,0.5,\n8,0.1,1,0.25,1,lost+dropped\n9,0.2,2.5,-0.25,5,\n",
        );
        self.write("run/run.toml", "version = \"0.1.0\"\nsource = \"made up\"\n[profile]\nname = \"unnamed\"\n");
    }
}

pub(crate) fn finish(mut evaluation: Evaluation) -> Result<Outcome, RunError> {
    while evaluation.advance()? {}
    Ok(evaluation.finish())
}

pub(crate) fn run_beside(run: &Path, truth: &Path) -> Outcome {
    finish(Evaluation::open(run, truth, Options::default()).unwrap()).unwrap()
}
