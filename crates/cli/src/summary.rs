//! The result of a run.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use fingervision_touch::{FORCE_COLUMNS, Flag, HealthCounts, Reading, ReadingNumbers};
use serde::{Serialize, Serializer};

use crate::skipped::Skipped;

/// Reasons why a frame has no depth, the most important first.
const NO_DEPTH: [Flag; 3] = [Flag::NoTexture, Flag::Lost, Flag::GelMisfit];
/// A depth that is printed as zero, mm.
const LEAST_DEPTH_MM: f32 = 0.005;

/// The result of a run.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) folder: PathBuf,
    /// Absent if it could not be drawn.
    pub(crate) preview: Option<PathBuf>,
    /// The video, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) overlay: Option<PathBuf>,
    /// Columns and rows of the fields, px.
    pub(crate) size: (usize, usize),
    pub(crate) has_depth: bool,
    /// From opening to closing, with all reading and writing, s.
    pub(crate) seconds: f64,
    #[serde(flatten)]
    pub(crate) tally: Tally,
    #[serde(flatten)]
    pub(crate) skipped: Skipped,
}

impl Summary {
    /// The frames, the deepest reading and the flags, without line breaks.
    pub(crate) fn in_one_line(&self) -> String {
        let Tally { frames, flagged, deepest, .. } = &self.tally;
        let mut parts = vec![format!("{frames} frame{}", if *frames == 1 { "" } else { "s" })];
        if let Some(Deepest { max_depth_mm, force, .. }) = deepest {
            parts.push(format!("depth up to {max_depth_mm:.2} mm"));
            parts.extend(force.map(|force| format!("force {force}")));
        }
        parts.extend(flagged.flagged().map(|(flag, count)| format!("{} in {count}", flag.name())));
        if self.skipped.count > 0 {
            parts.push(format!("{} skipped", self.skipped.count));
        }
        parts.join(", ")
    }
}

/// Counts made while readings arrive.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Tally {
    pub(crate) frames: u64,
    /// Sum of the frames' times from arrival to reading, ms.
    tracking_ms: f64,
    /// The time of each frame, ms: 8 bytes a frame, 20 MB for a day at 30 frames per second.
    #[serde(rename = "median_latency_ms", serialize_with = "as_median", skip_serializing_if = "Vec::is_empty")]
    latencies_ms: Vec<f64>,
    /// Number of frames with each flag that was ever set.
    flagged: HealthCounts,
    /// Number of frames skipped by the source.
    dropped_frames: u64,
    /// Number of frames without depth, by the flag that is the reason; `not-valid` if no pixel is valid.
    without_depth: BTreeMap<&'static str, u64>,
    /// The last of the deepest readings; none without depth.
    pub(crate) deepest: Option<Deepest>,
}

/// The values of the deepest reading.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Deepest {
    pub(crate) sequence: u64,
    pub(crate) max_depth_mm: f32,
    pub(crate) contact_area_mm2: Option<f32>,
    #[serde(flatten)]
    pub(crate) force: Option<Force<f32>>,
    pub(crate) torque_z_nmm: Option<f32>,
}

/// Force on the gel `(x, y, z)`, N, named as in the tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Force<T>([T; 3]);

impl<T> From<[T; 3]> for Force<T> {
    fn from(force: [T; 3]) -> Self {
        Self(force)
    }
}

impl<T: Serialize> Serialize for Force<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(FORCE_COLUMNS.into_iter().zip(&self.0))
    }
}

impl<T: Copy + Into<f64>> fmt::Display for Force<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0.map(|part| rounded(part.into(), 2));
        write!(f, "({x:.2}, {y:.2}, {z:.2}) N")
    }
}

/// A number as it is printed with this many decimals, zero without a sign.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// The middle value; none without values. Frames with a new reference, such as the first, take several times longer than
/// the others: in a short run they would dominate the mean.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn as_median<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    median(values).serialize(serializer)
}

impl Tally {
    pub(crate) fn count(&mut self, reading: &Reading) {
        self.frames += 1;
        self.dropped_frames = reading.dropped_frames;
        if reading.depth.is_some() && reading.max_depth_mm.is_none() {
            let reason = NO_DEPTH.into_iter().find(|&flag| reading.flags.has(flag)).map_or("not-valid", Flag::name);
            *self.without_depth.entry(reason).or_default() += 1;
        }
        self.tracking_ms += reading.latency_ms;
        self.latencies_ms.push(reading.latency_ms);
        self.flagged.count(&reading.numbers);
        let is_deeper = |depth: &f32| self.deepest.is_none_or(|deepest| *depth >= deepest.max_depth_mm);
        if let Some(max_depth_mm) = reading.max_depth_mm.filter(is_deeper) {
            let ReadingNumbers { sequence, contact_area_mm2, force_n, torque_nmm: torque_z_nmm, .. } = reading.numbers;
            let force = force_n.map(Force::from);
            self.deepest = Some(Deepest { sequence, max_depth_mm, contact_area_mm2, force, torque_z_nmm });
        }
    }

    /// Leaves out the deepest reading if it is meaningless: an untouched gel, while most frames have no depth.
    pub(crate) fn finish(&mut self) {
        let is_untouched = |deepest: &Deepest| {
            deepest.contact_area_mm2.map_or(deepest.max_depth_mm < LEAST_DEPTH_MM, |area| area <= 0.0)
        };
        let without_depth: u64 = self.without_depth.values().sum();
        if 2 * without_depth > self.frames && self.deepest.as_ref().is_some_and(is_untouched) {
            self.deepest = None;
        }
    }
}

/// A few lines for people.
impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Tally { frames, latencies_ms, flagged, dropped_frames, without_depth, deepest, .. } = &self.tally;
        let ((width, height), seconds) = (self.size, self.seconds);
        let plural = if *frames == 1 { "" } else { "s" };
        write!(f, "{frames} frame{plural} of {width}x{height} px in {seconds:.1} s")?;
        if let Some(median) = median(latencies_ms) {
            write!(f, "; tracking takes {median:.1} ms per frame (median)")?;
        }
        writeln!(f)?;
        if self.skipped.count > 0 {
            let frames = if self.skipped.count == 1 { "frame" } else { "frames" };
            writeln!(f, "skipped  {} {frames} that could not be read", self.skipped.count)?;
        }
        for (flag, count) in flagged.flagged() {
            write!(f, "flagged  {} in {count} of {frames} frames", flag.name())?;
            match flag {
                Flag::Dropped if *dropped_frames > 0 => writeln!(f, ": {dropped_frames} missing before them")?,
                Flag::GelDamaged => writeln!(f, ": up to {:.1} % of the image", 100.0 * flagged.damaged_part())?,
                _ => writeln!(f)?,
            }
        }
        for (reason, count) in without_depth {
            writeln!(f, "no depth in {count} of {frames} frames: {}", in_words(reason))?;
        }
        if let Some(deepest) = deepest {
            writeln!(f, "deepest  {deepest}")?;
        }
        writeln!(f, "folder   {}", self.folder.display())?;
        if let Some(preview) = &self.preview {
            writeln!(f, "preview  {}", preview.display())?;
        }
        self.overlay.as_ref().map_or(Ok(()), |overlay| writeln!(f, "overlay  {}", overlay.display()))
    }
}

/// The meaning of a reason for no depth.
fn in_words(reason: &str) -> &str {
    match reason {
        "gel-misfit" => "the flow does not fit the profile's gel and camera (gel-misfit)",
        "lost" => "the images do not match the reference (lost)",
        "no-texture" => "the images have too little texture (no-texture)",
        _ => "no pixel is valid",
    }
}

/// Depth, contact and force with their units, as far as they are known.
impl fmt::Display for Deepest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame {}: depth up to {:.2} mm", self.sequence, self.max_depth_mm)?;
        if let Some(area) = self.contact_area_mm2 {
            write!(f, ", contact {area:.1} mm²")?;
        }
        if let Some(force) = &self.force {
            write!(f, ", force {force}")?;
        }
        let torque = self.torque_z_nmm.map(|torque| rounded(torque.into(), 1));
        torque.map_or(Ok(()), |torque| write!(f, ", torque {torque:.1} N mm"))
    }
}

#[cfg(test)]
mod tests {
    use fingervision_image::Image;
    use fingervision_touch::{Fields, Profile, Tracker};

    use super::*;

    fn summary(readings: &[Reading]) -> Summary {
        let mut tally = Tally::default();
        for reading in readings {
            tally.count(reading);
        }
        tally.finish();
        let (folder, preview, size) = ("run".into(), None, (64, 64));
        Summary {
            folder,
            preview,
            overlay: None,
            size,
            has_depth: true,
            seconds: 1.0,
            tally,
            skipped: Skipped::default(),
        }
    }

    fn reading(flag: Option<Flag>, max_depth_mm: Option<f32>, contact_area_mm2: f32) -> Reading {
        let tracker = Tracker::new(&Profile::default(), (64, 64), false, Fields::NONE).unwrap();
        let mut reading = tracker.reading().clone();
        if let Some(flag) = flag {
            reading.numbers.flags.raise(flag);
        }
        (reading.depth, reading.numbers.force_n) = (Some(Image::filled(64, 64, 0.0)), Some([0.0; 3]));
        (reading.numbers.max_depth_mm, reading.numbers.contact_area_mm2) = (max_depth_mm, Some(contact_area_mm2));
        reading
    }

    #[test]
    fn frames_without_depth_are_counted_with_their_reason_and_no_zeros_are_printed() {
        let misfit = reading(Some(Flag::GelMisfit), None, 0.0);
        let text = summary(&[reading(None, Some(0.001), 0.0), misfit.clone(), misfit.clone()]).to_string();
        assert!(text.contains("no depth in 2 of 3 frames: the flow does not fit the profile's"), "{text}");
        assert!(!text.contains("deepest"), "{text}");
        let touched = summary(&[reading(None, Some(1.0), 9.0), misfit]).to_string();
        assert!(touched.contains("deepest  frame 0: depth up to 1.00 mm, contact 9.0 mm²"), "{touched}");
    }

    #[test]
    fn a_zero_is_printed_without_a_sign() {
        assert_eq!(Force::from([-0.001_f32, 0.004, -0.02]).to_string(), "(0.00, 0.00, -0.02) N");
    }

    #[test]
    fn the_first_frame_does_not_distort_the_time_per_frame() {
        let readings = [192.4, 40.0, 39.0, 41.0].map(|latency_ms| {
            let mut reading = reading(None, None, 0.0);
            reading.numbers.latency_ms = latency_ms;
            reading
        });
        let text = summary(&readings[..3]).to_string();
        assert!(text.contains("; tracking takes 40.0 ms per frame (median)"), "{text}");
        let json = serde_json::to_value(summary(&readings)).unwrap();
        assert_eq!(json["median_latency_ms"], 41.0, "{json}");
    }

    #[test]
    fn a_run_without_frames_has_no_median() {
        let text = summary(&[]).to_string();
        assert!(text.starts_with("0 frames of 64x64 px in 1.0 s\n"), "{text}");
    }

    #[test]
    fn json_names_forces_as_the_table_does() {
        let json = serde_json::to_value(summary(&[reading(None, Some(1.0), 9.0)])).unwrap();
        assert_eq!(json["deepest"]["force_z_n"], 0.0, "{json}");
        assert!(json["deepest"].get("torque_z_nmm").is_some(), "{json}");
    }
}
