//! Recorded pairs whose motion is known.

use super::{Recordings, files};
use crate::matcher::Matcher;
use crate::{Asked, EvaluateError, Table, end_point_errors, mean, without_border};
use fingervision_flow::{FlowField, FlowParams, Preset};
use fingervision_image::Image;
use rayon::prelude::*;
use std::path::Path;

/// Border that is left out on every side of the DIC samples, px.
const DIC_BORDER_PX: usize = 32;

/// In a flow file a larger flow means "unknown", px.
const UNKNOWN_PX: f32 = 1e9;

/// The true motion.
enum Truth {
    /// The same displacement everywhere, px.
    Shift([f32; 2]),
    /// Displacement along x by column: a file and its column.
    Columns(&'static str, usize),
    /// A flow file.
    Dense(&'static str),
}

/// Two image files and the motion between them.
struct RecordedPair {
    name: &'static str,
    reference: &'static str,
    current: &'static str,
    truth: Truth,
    border_px: usize,
    asked_px: Option<f64>,
    opencv_px: f64,
}

fn recorded_pairs() -> Vec<RecordedPair> {
    let shift = |name, current, by_px: f32| RecordedPair {
        name,
        reference: "dic_pixelshift/ref.tif",
        current,
        truth: Truth::Shift([by_px; 2]),
        border_px: DIC_BORDER_PX,
        asked_px: Some(0.005),
        opencv_px: 0.019,
    };
    let chirp = |name, current, column| RecordedPair {
        name,
        reference: "dic_challenge14/Sample14_Reference.tif",
        current,
        truth: Truth::Columns("dic_challenge14/command.csv", column),
        border_px: DIC_BORDER_PX,
        asked_px: Some(0.012),
        opencv_px: 0.024,
    };
    let noisy = |name, current, by_px: f32, asked_px, opencv_px| RecordedPair {
        name,
        reference: "dic_challenge5/Sample5_Reference.tif",
        current,
        truth: Truth::Shift([by_px; 2]),
        border_px: DIC_BORDER_PX,
        asked_px,
        opencv_px,
    };
    vec![
        shift("shift by 1 px", "dic_pixelshift/def_1.tif", 1.0),
        shift("shift by 5 px", "dic_pixelshift/def_5.tif", 5.0),
        shift("shift by 11 px", "dic_pixelshift/def_11.tif", 11.0),
        shift("shift by 15 px", "dic_pixelshift/def_15.tif", 15.0),
        chirp("Sample 14 L1", "dic_challenge14/Sample14_L1_Amp0.1b.tif", 1),
        chirp("Sample 14 L3", "dic_challenge14/Sample14_L3_Amp0.1b.tif", 3),
        chirp("Sample 14 L5", "dic_challenge14/Sample14_L5_Amp0.1b.tif", 5),
        noisy("Sample 5-000", "dic_challenge5/Sample5-000_X0.00_Y0.00_N2_C75_R10.tif", 0.0, None, 0.019),
        noisy("Sample 5-001", "dic_challenge5/Sample5-001_X0.10_Y0.10_N2_C100_R20.tif", 0.1, Some(0.025), 0.045),
        RecordedPair {
            name: "RubberWhale",
            reference: "rubberwhale/RubberWhale1.png",
            current: "rubberwhale/RubberWhale2.png",
            truth: Truth::Dense("rubberwhale/RubberWhale.flo"),
            border_px: 0,
            asked_px: Some(0.20),
            opencv_px: 0.223,
        },
    ]
}

/// Mean end-point errors of the recorded pairs, px. A border of 32 px is left out of the DIC samples, and pixels with
/// unknown flow are left out of `RubberWhale`.
///
/// # Errors
///
/// [`EvaluateError::File`] if a file is missing or cannot be read.
pub fn measure(recordings: &Recordings) -> Result<Table, EvaluateError> {
    let pairs = recorded_pairs();
    let rows = pairs.par_iter().map(|pair| errors_px(recordings, pair)).collect::<Result<Vec<_>, _>>()?;
    let mut table = Table::new(
        "Recorded pairs: mean end-point error, px",
        &["default", "ultrafast", "fast", "medium", "OpenCV medium"],
    );
    for (pair, mut values) in pairs.iter().zip(rows) {
        values.push(pair.opencv_px);
        table.push(pair.name, pair.asked_px.map(Asked::AtMost), values);
    }
    Ok(table)
}

fn errors_px(recordings: &Recordings, pair: &RecordedPair) -> Result<Vec<f64>, EvaluateError> {
    let reference = files::pixels(&recordings.path(pair.reference))?;
    let current = files::pixels(&recordings.path(pair.current))?;
    let (width, height) = reference.size();
    let truth = true_flow(recordings, &pair.truth, (width, height))?;
    let region = without_border((width, height), pair.border_px);
    let presets = [Preset::Affine, Preset::Ultrafast, Preset::Fast, Preset::Medium];
    let error_px = |preset| {
        let params = FlowParams { preset, colour: preset == Preset::Affine, ..FlowParams::default() };
        let mut matcher = Matcher::new(&reference, &params)?;
        let estimate = matcher.find(&current)?;
        let errors = end_point_errors(&estimate.flow, &truth, region);
        // An estimate that is not a number must make the mean not a number.
        Ok(mean(errors.filter(|&error| error.is_nan() || error < UNKNOWN_PX)))
    };
    presets.into_iter().map(error_px).collect()
}

fn true_flow(
    recordings: &Recordings,
    truth: &Truth,
    (width, height): (usize, usize),
) -> Result<FlowField, EvaluateError> {
    match truth {
        Truth::Shift([u, v]) => {
            Ok(FlowField { u: Image::filled(width, height, *u), v: Image::filled(width, height, *v) })
        }
        Truth::Columns(file, column) => {
            let file = recordings.path(file);
            let command = column_values(&file, *column)?;
            if command.len() < width {
                return Err(EvaluateError::file(&file, format!("{} rows for {width} columns", command.len())));
            }
            Ok(FlowField { u: Image::from_fn(width, height, |x, _| command[x]), v: Image::filled(width, height, 0.0) })
        }
        Truth::Dense(file) => files::flow(&recordings.path(file)),
    }
}

fn column_values(file: &Path, column: usize) -> Result<Vec<f32>, EvaluateError> {
    let rows = files::numbers(file)?;
    let value = |row: &Vec<f64>| row.get(column).map(|&value| value as f32);
    rows.iter().map(value).collect::<Option<_>>().ok_or_else(|| EvaluateError::file(file, "a row is too short"))
}
