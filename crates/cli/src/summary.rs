//! What a run came to.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use fingervision_touch::{Flag, Reading};
use serde::Serialize;

/// What a run came to.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) folder: PathBuf,
    /// Absent if it could not be drawn.
    pub(crate) preview: Option<PathBuf>,
    /// Columns and rows of the fields, px.
    pub(crate) size: (usize, usize),
    pub(crate) has_depth: bool,
    /// From opening to closing, with all reading and writing, s.
    pub(crate) seconds: f64,
    #[serde(flatten)]
    pub(crate) tally: Tally,
}

/// What is counted while readings come.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Tally {
    pub(crate) frames: u64,
    /// Sum of the frames' times from arrival to reading, ms.
    tracking_ms: f64,
    /// How many frames carried each flag that was ever up.
    flagged: BTreeMap<&'static str, u64>,
    /// The last of the deepest readings; none without depth.
    pub(crate) deepest: Option<Deepest>,
}

/// What the deepest reading says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Deepest {
    pub(crate) sequence: u64,
    pub(crate) max_depth_mm: f32,
    pub(crate) contact_area_mm2: Option<f32>,
    pub(crate) force_n: Option<[f32; 3]>,
    pub(crate) torque_nmm: Option<f32>,
}

impl Tally {
    pub(crate) fn count(&mut self, reading: &Reading) {
        self.frames += 1;
        self.tracking_ms += reading.latency_ms;
        for flag in reading.flags.iter() {
            *self.flagged.entry(flag.name()).or_default() += 1;
        }
        let is_deeper = |depth: &f32| self.deepest.is_none_or(|deepest| *depth >= deepest.max_depth_mm);
        if let Some(max_depth_mm) = reading.max_depth_mm.filter(is_deeper) {
            let &Reading { sequence, contact_area_mm2, force_n, torque_nmm, .. } = reading;
            self.deepest = Some(Deepest { sequence, max_depth_mm, contact_area_mm2, force_n, torque_nmm });
        }
    }
}

/// A few lines for people.
impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Tally { frames, tracking_ms, flagged, deepest } = &self.tally;
        let ((width, height), seconds) = (self.size, self.seconds);
        let mean_ms = tracking_ms / *frames as f64;
        writeln!(
            f,
            "{frames} frames of {width}x{height} px in {seconds:.1} s; tracking takes {mean_ms:.1} ms a frame"
        )?;
        for flag in Flag::ALL.map(Flag::name) {
            if let Some(count) = flagged.get(flag) {
                writeln!(f, "flagged  {flag} in {count} of {frames} frames")?;
            }
        }
        if let Some(deepest) = deepest {
            writeln!(f, "deepest  {deepest}")?;
        }
        writeln!(f, "folder   {}", self.folder.display())?;
        match &self.preview {
            Some(preview) => writeln!(f, "preview  {}", preview.display()),
            None => Ok(()),
        }
    }
}

/// Depth, contact and force with their units, as far as they are known.
impl fmt::Display for Deepest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame {}: depth up to {:.2} mm", self.sequence, self.max_depth_mm)?;
        if let Some(area) = self.contact_area_mm2 {
            write!(f, ", contact {area:.1} mm²")?;
        }
        if let Some([x, y, z]) = self.force_n {
            write!(f, ", force ({x:.2}, {y:.2}, {z:.2}) N")?;
        }
        self.torque_nmm.map_or(Ok(()), |torque| write!(f, ", torque {torque:.1} N mm"))
    }
}
