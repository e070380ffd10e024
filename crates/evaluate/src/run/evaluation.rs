//! Reads a run and its truth, one frame at a time.

use std::path::Path;

use fingervision_image::Image;

use super::compare::Comparer;
use super::force;
use super::inputs::Inputs;
use super::picture::Shown;
use super::report::{FieldErrors, FrameReport, Report};
use super::{BORDER_MM, Options, RunError};

/// A depth or flow also counts as the largest if it is smaller by at most this part. If a press is held, its last frame
/// is therefore shown.
const AS_DEEP: f64 = 1e-3;

/// If the gel moves by this much or more, px, a correct flow has at least this correlation with the true flow.
const LEAST_MOTION_PX: f64 = 1.0;
const LEAST_CORRELATION: f64 = 0.9;

/// A comparison under way.
#[derive(Debug)]
pub struct Evaluation {
    inputs: Inputs,
    comparer: Comparer,
    force_peak_n: f64,
    frames: Vec<FrameReport>,
    deepest: Deepest,
    shown: Shown,
}

/// The deepest frame so far.
#[derive(Debug, Clone, Copy)]
struct Deepest {
    row: usize,
    largest: f64,
}

/// The result of a finished comparison.
#[derive(Debug)]
pub struct Outcome {
    /// All figures.
    pub report: Report,
    shown: Shown,
}

impl Outcome {
    /// The deepest frame's fields, true and estimated, and the errors over all frames.
    #[must_use]
    pub fn draw(&self) -> Image<[u8; 3]> {
        self.shown.draw(&self.report)
    }
}

impl Evaluation {
    /// Opens a run and its truth.
    ///
    /// `run` contains `flow.npy`, `depth.npy` or both; `truth` or its subfolder `truth` contains them, too.
    ///
    /// # Errors
    ///
    /// [`RunError`] if a file cannot be used or the two do not belong together.
    pub fn open(run: &Path, truth: &Path, options: Options) -> Result<Self, RunError> {
        let inputs = Inputs::open(run, truth, options)?;
        Ok(Self {
            comparer: Comparer::new(&inputs),
            force_peak_n: inputs.forces.as_ref().map_or(0.0, |[_, truth]| force::peak_n(truth, inputs.frames)),
            frames: Vec::with_capacity(inputs.frames as usize),
            deepest: Deepest { row: 0, largest: f64::NEG_INFINITY },
            shown: Shown::new(&inputs),
            inputs,
        })
    }

    /// Number of frames to compare.
    #[must_use]
    pub fn frame_count(&self) -> u64 {
        self.inputs.frames
    }

    /// Compares the next frame; false after the last one.
    ///
    /// # Errors
    ///
    /// [`RunError::Read`] if a file can no longer be read, [`RunError::NotFinite`] if the run has a value that is not
    /// finite where it is marked as valid.
    pub fn advance(&mut self) -> Result<bool, RunError> {
        let row = self.frames.len();
        if row as u64 == self.inputs.frames {
            return Ok(false);
        }
        self.inputs.advance()?;
        let errors = self.comparer.compare(&mut self.inputs, row as u64)?;
        let report = self.frame_report(row, &errors);
        let depth = report.true_depth_mm.or(report.true_flow_px).unwrap_or(f64::NEG_INFINITY);
        if row == 0 || depth >= self.deepest.largest - AS_DEEP * self.deepest.largest.abs() {
            self.deepest = Deepest { row, largest: depth.max(self.deepest.largest) };
            self.shown.copy_from(&self.inputs, &self.comparer);
        }
        self.frames.push(report);
        Ok(true)
    }

    /// The result of the frames compared so far.
    #[must_use]
    pub fn finish(self) -> Outcome {
        let Self { inputs, comparer, force_peak_n, frames, deepest, shown } = self;
        let forces: Vec<_> = frames.iter().filter_map(|frame| frame.force).collect();
        let run = &inputs.run;
        let fields = [
            ("flow", run.flow.is_some()),
            ("depth", run.depth.is_some()),
            ("displacement", run.displacement.is_some()),
            ("contact", run.contact.is_some()),
            ("force", inputs.forces.is_some()),
        ];
        let place = inputs.place;
        let deepest = frames.get(deepest.row);
        let mut notes = inputs.notes;
        notes.extend(deepest.and_then(unlike_truth));
        let report = Report {
            run: inputs.run_folder,
            truth: inputs.truth_folder,
            frames: frames.len() as u64,
            region: [place.x, place.y, place.width, place.height],
            fields: fields.into_iter().filter_map(|(name, is_compared)| is_compared.then_some(name)).collect(),
            border_mm: BORDER_MM,
            notes,
            deepest_frame: deepest.map_or(0, |deepest| deepest.frame),
            mean: FieldErrors::mean_of(&frames),
            pooled: comparer.pooled(),
            peak_depth_correlation: comparer.peak_depth_correlation(),
            force: (!forces.is_empty()).then(|| force::report(&forces, force_peak_n)),
            per_frame: frames,
        };
        Outcome { report, shown }
    }

    fn frame_report(&self, row: usize, errors: &FieldErrors) -> FrameReport {
        FrameReport {
            frame: self.inputs.number(row),
            true_depth_mm: self.largest_seen(self.inputs.truth.depth.as_ref().map(|depth| {
                let values = depth.values();
                move |at: usize| f64::from(values[at])
            })),
            true_flow_px: self.largest_seen(self.inputs.truth.flow.as_ref().map(|flow| {
                let values = flow.values();
                move |at: usize| f64::from(values[2 * at]).hypot(f64::from(values[2 * at + 1]))
            })),
            errors: *errors,
            force: self
                .inputs
                .forces
                .as_ref()
                .map(|[estimated, truth]| force::frame_errors(estimated[row], truth[row], self.force_peak_n)),
        }
    }

    /// The largest true value among the pixels of the run in which the truth is visible.
    fn largest_seen(&self, value: Option<impl Fn(usize) -> f64>) -> Option<f64> {
        let value = value?;
        let seen = self.comparer.on_truth().iter().zip(self.comparer.seen()).filter(|(_, seen)| **seen != 0);
        seen.map(|(&at, _)| value(at)).reduce(f64::max)
    }
}
/// A warning if the flow of the deepest frame differs from the truth so much that the truth may belong to other frames.
fn unlike_truth(deepest: &FrameReport) -> Option<String> {
    let true_px = deepest.true_flow_px.filter(|&px| px >= LEAST_MOTION_PX)?;
    let correlation = deepest.errors.flow_px?.everywhere?.correlation.filter(|&value| value < LEAST_CORRELATION)?;
    Some(format!(
        "the correlation of the flow of frame {} with the true flow, of up to {true_px:.1} px, is only {correlation:.2}: is this \
         the truth of these frames?",
        deepest.frame
    ))
}
