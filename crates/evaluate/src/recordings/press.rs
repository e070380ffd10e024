//! Measures the whole tracker on the recorded press.

use super::punyo::{FRAMES, Punyo};
use crate::matcher::Matcher;
use crate::{Asked, EvaluateError, Table};
use fingervision_calibrate::depth::fit_line;
use fingervision_flow::{Estimate, FlowField, FlowParams, Preset};
use fingervision_image::{Between, Frame, Image};
use fingervision_touch::{Fields, Flag, Profile, Reading, Tracker};
use std::ops::RangeInclusive;

/// Frames per second.
const RATE_HZ: f64 = 30.0;
/// A step of the depth camera, mm.
const DEPTH_STEP_MM: f64 = 0.1;
/// Frames at rest whose depth is averaged.
const DEPTH_AT_REST: [usize; 5] = [0, 10, 20, 30, 40];
/// Frames of the steady press at which the contact is located.
const STEADY: [usize; 3] = [80, 90, 100];
/// The frames from shortly before the press to shortly after it.
const PRESS: RangeInclusive<usize> = 57..=113;
/// Distance between the frames that are examined closely, from the first on.
const EVERY: usize = 3;
/// Two flows that differ by this much cannot both be right, px.
const APART_PX: f32 = 1.0;

impl Punyo<'_> {
    /// The table of single pairs and of the tracked press, with the required values.
    ///
    /// # Errors
    ///
    /// [`EvaluateError::File`] if a file is missing or cannot be read.
    pub fn measure(&self) -> Result<Table, EvaluateError> {
        let (pairs, press) = rayon::join(|| self.measure_pairs(), || PressEvidence::measure(self));
        let (mut table, press) = (pairs?, press?);
        press.append_to(&mut table);
        Ok(table)
    }
}

/// The results of a tracked press, over the membrane.
#[derive(Debug, Clone, PartialEq)]
pub struct PressEvidence {
    /// Mean length of the flow, px, by frame.
    pub mean_flow_px: Vec<f64>,
    /// Pearson's correlation of the mean flow with the force over every third frame of the recording: rest, press and
    /// rest. Of the tracked flow and of the preset medium.
    pub force_correlation: [f64; 2],
    /// The same over the frames of the press alone.
    ///
    /// The noise of the force limits it: in the steady press the force varies by 0.1 N while the flow does not change.
    pub press_correlation: [f64; 2],
    /// Largest distance, during the steady press, between the centres of contact from the flow and from the depth
    /// camera, px.
    ///
    /// A centre is the centroid of a quantity where it is above half its peak. The two quantities are the length of the
    /// flow, and the displacement towards the depth camera of the points of the gel, tracked with the flow.
    pub centre_distance_px: f64,
    /// Smallest radius, during the steady press, of a circle with the area in which the depth is above half its peak,
    /// px.
    pub contact_radius_px: f64,
    /// Smallest part of the membrane that is valid in any frame.
    pub least_valid: f64,
    /// Largest part of the membrane that is valid in the tracked flow but differs by more than 1 px from a flow
    /// searched without a start, over every third frame from the press on.
    pub apart: f64,
    /// Frames whose reading is flagged as lost or as pressed at the start.
    pub flagged: usize,
}

impl PressEvidence {
    /// Tracks the recording with the default profile.
    ///
    /// # Errors
    ///
    /// [`EvaluateError::File`] if a file is missing or cannot be read, [`EvaluateError::Track`] if the default profile
    /// does not fit the recording.
    pub fn measure(punyo: &Punyo<'_>) -> Result<Self, EvaluateError> {
        let size = punyo.mask.size();
        let mut tracker = Tracker::new(&Profile::default(), size, false, Fields::NONE)?;
        let first = punyo.frame(0)?;
        let mut searched = Matcher::new(&first, &FlowParams::default())?;
        let mut medium = Matcher::new(&first, &FlowParams { preset: Preset::Medium, ..FlowParams::default() })?;
        let at_rest = depth_at_rest(punyo)?;
        let mut evidence = Self::nothing();
        let mut flows_px = Vec::new();
        for index in 0..FRAMES {
            let pixels = punyo.frame(index)?;
            let frame = Frame { sequence: index as u64, capture_time_s: index as f64 / RATE_HZ, pixels };
            let reading = tracker.track(&frame)?;
            evidence.take(punyo, reading);
            if STEADY.contains(&index) {
                evidence.locate(punyo, &reading.flow, &at_rest, &punyo.distances(index)?);
            }
            if index.is_multiple_of(EVERY) {
                let medium_px = punyo.mean_length_px(&medium.find(&frame.pixels)?.flow);
                flows_px.push((index, [evidence.mean_flow_px[index], medium_px]));
                if index >= *PRESS.start() {
                    evidence.apart = evidence.apart.max(part_apart(punyo, reading, searched.find(&frame.pixels)?));
                }
            }
        }
        evidence.force_correlation = [0, 1].map(|way| correlation_with_force(punyo, &flows_px, way, 0..=FRAMES));
        evidence.press_correlation = [0, 1].map(|way| correlation_with_force(punyo, &flows_px, way, PRESS));
        Ok(evidence)
    }

    fn nothing() -> Self {
        Self {
            mean_flow_px: Vec::with_capacity(FRAMES),
            force_correlation: [f64::NAN; 2],
            press_correlation: [f64::NAN; 2],
            centre_distance_px: 0.0,
            contact_radius_px: f64::INFINITY,
            least_valid: 1.0,
            apart: 0.0,
            flagged: 0,
        }
    }

    fn take(&mut self, punyo: &Punyo<'_>, reading: &Reading) {
        self.mean_flow_px.push(punyo.mean_length_px(&reading.flow));
        let valid = part(punyo, |x, y| reading.valid.at(x, y) == 1);
        self.least_valid = self.least_valid.min(valid);
        let is_flagged = reading.flags.has(Flag::Lost) || reading.flags.has(Flag::PressedAtStart);
        self.flagged += usize::from(is_flagged);
    }

    /// Compares the centre of contact from the flow with that from the depth camera.
    fn locate(&mut self, punyo: &Punyo<'_>, flow: &FlowField, at_rest: &Image<f32>, distances: &Image<u16>) {
        let (width, height) = distances.size();
        let distances = Image::from_fn(width, height, |x, y| distance_mm(distances.at(x, y)));
        let depth = |x: usize, y: usize| {
            let (u, v) = (flow.u.at(x, y), flow.v.at(x, y));
            let place = Between::inside((x as f32 + u, y as f32 + v), distances.size());
            let now = place.map_or(f32::NAN, |place| place.sample(&distances));
            f64::from(at_rest.at(x, y) - now)
        };
        let by_flow = Blob::above_half(punyo, |x, y| f64::from(flow.u.at(x, y).hypot(flow.v.at(x, y))));
        let by_depth = Blob::above_half(punyo, depth);
        let [dx, dy] = [0, 1].map(|axis| by_flow.centre_px[axis] - by_depth.centre_px[axis]);
        self.centre_distance_px = self.centre_distance_px.max(dx.hypot(dy));
        self.contact_radius_px = self.contact_radius_px.min((by_depth.area_px2 / std::f64::consts::PI).sqrt());
    }

    /// Mean flow of the last frame, px: the press is over, so it should be zero.
    #[must_use]
    pub fn flow_left_px(&self) -> f64 {
        self.mean_flow_px.last().copied().unwrap_or(f64::NAN)
    }

    /// Largest mean flow from frame 1 to 50, before the press, px.
    #[must_use]
    pub fn flow_at_rest_px(&self) -> f64 {
        self.mean_flow_px[1..=50].iter().copied().fold(0.0, f64::max)
    }

    pub(super) fn append_to(&self, table: &mut Table) {
        for (frames, asked, [tracked, medium], opencv) in [
            ("every third frame", Some(Asked::AtLeast(0.993)), self.force_correlation, 0.993),
            ("57 to 111 only", None, self.press_correlation, 0.990),
        ] {
            let name = format!("tracked: flow against force, {frames}");
            table.push(name, asked, vec![tracked, medium, opencv]);
        }
        let mut row = |name: &str, asked, value| table.push(name, asked, vec![value, f64::NAN, f64::NAN]);
        row("tracked: largest mean flow at rest", Some(Asked::AtMost(0.012)), self.flow_at_rest_px());
        row("tracked: mean flow in the last frame, at rest again", None, self.flow_left_px());
        row("tracked: distance of the centres from flow and depth", None, self.centre_distance_px);
        row("tracked: radius of the contact", None, self.contact_radius_px);
        row("tracked: least valid part", None, self.least_valid);
        row("tracked: valid, but > 1 px from searched", None, self.apart);
        row("tracked: frames lost or pressed at start", None, self.flagged as f64);
    }
}

/// The part of an image where a quantity is large.
struct Blob {
    centre_px: [f64; 2],
    area_px2: f64,
}

impl Blob {
    /// The part where a quantity is above half its peak, without pixels where it is not a number.
    fn above_half(punyo: &Punyo<'_>, quantity: impl Fn(usize, usize) -> f64) -> Self {
        let peak = punyo.membrane().map(|(x, y)| quantity(x, y)).fold(0.0, f64::max);
        let (mut weights, mut sums, mut area_px2) = (0.0, [0.0; 2], 0.0);
        for (x, y) in punyo.membrane() {
            let weight = quantity(x, y);
            if weight > 0.5 * peak {
                weights += weight;
                area_px2 += 1.0;
                sums[0] += weight * x as f64;
                sums[1] += weight * y as f64;
            }
        }
        Self { centre_px: sums.map(|sum| sum / weights), area_px2 }
    }
}

/// Distance from the depth camera; not a number where it measured nothing.
fn distance_mm(steps: u16) -> f32 {
    if steps == 0 { f32::NAN } else { (f64::from(steps) * DEPTH_STEP_MM) as f32 }
}

/// The mean of the depth camera's images at rest, mm.
fn depth_at_rest(punyo: &Punyo<'_>) -> Result<Image<f32>, EvaluateError> {
    let images = DEPTH_AT_REST.into_iter().map(|index| punyo.distances(index)).collect::<Result<Vec<_>, _>>()?;
    let (width, height) = images[0].size();
    Ok(Image::from_fn(width, height, |x, y| {
        images.iter().map(|image| distance_mm(image.at(x, y))).sum::<f32>() / images.len() as f32
    }))
}

fn part_apart(punyo: &Punyo<'_>, tracked: &Reading, searched: &Estimate) -> f64 {
    part(punyo, |x, y| {
        let du = tracked.flow.u.at(x, y) - searched.flow.u.at(x, y);
        let dv = tracked.flow.v.at(x, y) - searched.flow.v.at(x, y);
        tracked.valid.at(x, y) == 1 && du.hypot(dv) > APART_PX
    })
}

/// Part of the membrane where a condition holds.
fn part(punyo: &Punyo<'_>, holds: impl Fn(usize, usize) -> bool) -> f64 {
    let (holding, all) =
        punyo.membrane().fold((0.0, 0.0), |(holding, all), (x, y)| (holding + f64::from(holds(x, y)), all + 1.0));
    holding / all
}

/// Correlation of the force with flows of one of two methods, over some frames.
fn correlation_with_force(
    punyo: &Punyo<'_>,
    flows_px: &[(usize, [f64; 2])],
    way: usize,
    frames: RangeInclusive<usize>,
) -> f64 {
    let pairs = flows_px.iter().filter(|(index, _)| frames.contains(index));
    let pairs: Vec<_> = pairs.map(|(index, flow_px)| [flow_px[way], punyo.force_n[*index]]).collect();
    fit_line(&pairs).map_or(f64::NAN, |line| line.correlation)
}
