//! Presses of another finite-element program and renderer, with its truth of depth and force.
//!
//! The gel sticks as soon as it is found to touch, at the end of a step of 0.1 mm; in the first step it slides freely. Each press
//! has 21 images: the gel at rest, then a step per image. Leaving out images makes it fast.

use super::{Recordings, files};
use crate::experiment::force_errors;
use crate::{Asked, EvaluateError, Table};
use fingervision_image::Frame;
use fingervision_touch::{Fields, Profile, Reading, Tracker};
use std::fs;
use std::path::{Path, PathBuf};

/// The presses: a folder, what the table calls it, and the largest error of depth allowed over the image, mm.
const PRESSES: [(&str, &str, f64); 3] = [
    ("circle_nu35", "circle, ν 0.35", 0.012),
    ("letterH_nu48", "letter, ν 0.48", 0.015),
    ("shear_nu35", "square, then shear, ν 0.35", 0.012),
];
/// Images of each.
const IMAGES: usize = 21;
/// Every which image is tracked.
const STEPS: [usize; 4] = [1, 4, 10, 20];
/// Normal forces count from this depth of the object on, mm.
const LEAST_DEPTH_MM: f64 = 0.45;
/// A place is in contact if it is this deep, over the largest depth.
const IN_CONTACT: f32 = 0.9;

const COLUMNS: [&str; 6] =
    ["depth, mm", "in contact", "within 2 deviations", "normal force", "its largest", "shear force"];

/// Tracks the presses at several speeds: errors of depth and force in the last image, the part of contact where the error of depth is
/// at most two deviations, and the largest error of the normal force in the images from a depth of 0.45 mm on. Depth counts at every
/// place that the truth has. Errors of forces are parts of the true ones; positive: too large.
///
/// # Errors
///
/// [`EvaluateError::File`] if a file is missing or cannot be read, [`EvaluateError::Track`] if an image cannot be tracked.
pub fn measure(recordings: &Recordings) -> Result<Table, EvaluateError> {
    let mut table = Table::new("Presses of another program: depth, mm, and parts of the true force", &COLUMNS);
    for (folder, name, most_mm) in PRESSES {
        let press = Press::open(recordings.path("independent").join(folder))?;
        for step in STEPS {
            let values = press.measure(step)?;
            let name = if step == 1 { format!("{name}, every image") } else { format!("{name}, every {step}th image") };
            table.push(name, Some(Asked::AtMost(most_mm)), values.to_vec());
        }
    }
    Ok(table)
}

/// A press with its truth.
struct Press {
    folder: PathBuf,
    profile: Profile,
    /// The columns, which are also the rows, of the pixels that the truth has.
    places: Vec<usize>,
    /// Depth at these places, image by image, mm.
    depth_mm: Vec<f32>,
    /// Depth of the object, mm, and the force, N.
    poses: Vec<[f64; 4]>,
}

impl Press {
    fn open(folder: PathBuf) -> Result<Self, EvaluateError> {
        let file = folder.join("sensor.toml");
        let text = fs::read_to_string(&file).map_err(|error| EvaluateError::file(&file, error.to_string()))?;
        let profile = Profile::from_toml(&text).map_err(|error| EvaluateError::file(&file, error.to_string()))?;
        let file = folder.join("truth.npz");
        let places = files::packed_array(&file, "px")?.into_iter().map(|place| place as usize).collect::<Vec<_>>();
        let depth_mm = files::packed_array(&file, "depth")?;
        if depth_mm.len() != IMAGES * places.len().pow(2) {
            let reason =
                format!("depth has {} values, not {IMAGES} images of {} places squared", depth_mm.len(), places.len());
            return Err(EvaluateError::file(&file, reason));
        }
        let poses = poses(&folder.join("force.csv"))?;
        Ok(Self { folder, profile, places, depth_mm, poses })
    }

    /// The figures of the table for every `step`-th image.
    fn measure(&self, step: usize) -> Result<[f64; COLUMNS.len()], EvaluateError> {
        let mut tracker: Option<Tracker> = None;
        let (mut figures, mut worst) = ([f64::NAN; COLUMNS.len()], 0.0_f64);
        for index in (0..IMAGES).step_by(step) {
            let pixels = files::pixels(&self.folder.join(format!("frames/{index:03}.png")))?;
            let tracker = match &mut tracker {
                Some(tracker) => tracker,
                none => {
                    let fields = Fields { depth: true, ..Fields::NONE };
                    none.insert(Tracker::new(&self.profile, pixels.size(), pixels.is_colour(), fields)?)
                }
            };
            let frame = Frame { sequence: index as u64, capture_time_s: index as f64 / 30.0, pixels };
            let reading = tracker.track(&frame)?;
            let [_, x, y, z] = self.poses[index];
            let errors = reading.numbers.force_n.map(|force_n| force_errors(force_n, [x, y, z]));
            let [normal, shear] = errors.unwrap_or_default().map(|error| error.unwrap_or(f64::NAN));
            if self.poses[index][0] >= LEAST_DEPTH_MM {
                // The largest of a missing force is missing, too.
                worst = if normal.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(normal.abs()) };
            }
            let [all_mm, in_contact_mm, within] = self.depth_errors(index, reading);
            figures = [all_mm, in_contact_mm, within, normal, worst, shear];
        }
        Ok(figures)
    }

    /// Mean absolute error of depth everywhere and in contact, mm, and the part of contact where the error is at most two
    /// deviations.
    fn depth_errors(&self, index: usize, reading: &Reading) -> [f64; 3] {
        let (Some(found_mm), Some(deviation_mm)) = (&reading.depth, &reading.depth_deviation) else {
            return [f64::NAN; 3];
        };
        let count = self.places.len();
        let truth = &self.depth_mm[index * count * count..][..count * count];
        let deepest = truth.iter().copied().fold(0.0, f32::max);
        let (mut sums, mut counts) = ([0.0; 3], [0.0; 2]);
        for (row, truth) in self.places.iter().zip(truth.chunks_exact(count)) {
            for (column, &truth) in self.places.iter().zip(truth).filter(|(_, truth)| truth.is_finite()) {
                let error = (found_mm.at(*column, *row) - truth).abs();
                sums[0] += f64::from(error);
                counts[0] += 1.0;
                if truth > IN_CONTACT * deepest {
                    sums[1] += f64::from(error);
                    let deviation_mm = deviation_mm.at(*column, *row);
                    sums[2] += f64::from(u8::from(deviation_mm.is_finite() && error <= 2.0 * deviation_mm));
                    counts[1] += 1.0;
                }
            }
        }
        [sums[0] / counts[0], sums[1] / counts[1], sums[2] / counts[1]]
    }
}

fn poses(file: &Path) -> Result<Vec<[f64; 4]>, EvaluateError> {
    let rows = files::numbers(file)?;
    let pose = |row: &Vec<f64>| Some([*row.get(1)?, *row.get(4)?, *row.get(5)?, *row.get(6)?]);
    let poses = rows.iter().map(pose).collect::<Option<Vec<_>>>().filter(|poses| poses.len() == IMAGES);
    poses.ok_or_else(|| EvaluateError::file(file, format!("not {IMAGES} rows of depth and forces")))
}
