//! Computes displacement and density feature from images, with the dense pattern or with dots.

use fingervision_flow::FlowField;
use fingervision_image::{Frame, Image};
use fingervision_touch::{Fields, Profile, Tracker};
use std::time::Instant;

use super::{ExperimentError, Recording};
use crate::dots::{DotSensor, DotTouch};
use crate::filtered_density::FilteredDensity;

/// How points of the gel are tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Following {
    /// By the tracker, on a dense pattern.
    Dense,
    /// By the centroids of dots, interpolated smoothly.
    Dots,
}

/// The measurements of a frame, on the reference grid.
#[derive(Debug, Clone, Copy)]
pub struct Followed<'a> {
    /// Displacement, px.
    pub flow: &'a FlowField,
    /// The density feature `1 − density` after the filter, dimensionless. As in the publication, it is computed from
    /// the displacement everywhere, valid or not.
    pub feature: &'a Image<f32>,
    /// Predicted standard deviation of the displacement, px; infinite where it is not known, as for dots.
    pub deviation: &'a Image<f32>,
    /// 1 where the displacement is valid.
    pub valid: &'a Image<u8>,
    /// From the arrival of the image to the feature, ms.
    pub latency_ms: f64,
}

/// Tracks a recording and passes the fields of every frame to `take`.
///
/// # Errors
///
/// [`ExperimentError::Track`] or [`ExperimentError::Dots`] if a frame cannot be tracked.
pub fn follow(
    recording: &Recording,
    profile: &Profile,
    following: Following,
    mut take: impl FnMut(usize, Followed),
) -> Result<(), ExperimentError> {
    match following {
        Following::Dense => by_tracker(recording, profile, &mut take),
        Following::Dots => by_dots(recording, profile, &mut take),
    }
}

/// Tracks a recording, passes every frame to `each`, and returns the result of `take` for the last one.
///
/// # Errors
///
/// As [`follow`]; [`ExperimentError::EndedEarly`] if the recording has no frame.
pub fn follow_last<T>(
    recording: &Recording,
    profile: &Profile,
    following: Following,
    mut each: impl FnMut(Followed),
    mut take: impl FnMut(Followed) -> T,
) -> Result<T, ExperimentError> {
    let count = recording.depths_mm.len();
    let mut taken = None;
    follow(recording, profile, following, |number, found| {
        each(found);
        if number + 1 == count {
            taken = Some(take(found));
        }
    })?;
    taken.ok_or_else(|| ExperimentError::EndedEarly {
        scene: recording.name.clone(),
        reason: "the last frame was not tracked".into(),
    })
}

fn by_tracker(
    recording: &Recording,
    profile: &Profile,
    take: &mut impl FnMut(usize, Followed),
) -> Result<(), ExperimentError> {
    let mut density = FilteredDensity::new(recording.size(), &profile.density)?;
    let mut tracker: Option<Tracker> = None;
    for (number, frame) in recording.frames().enumerate() {
        let begin = Instant::now();
        let tracker = match &mut tracker {
            Some(tracker) => tracker,
            none => none.insert(new_tracker(recording, profile, &frame)?),
        };
        let reading = tracker.track(&frame)?;
        density.update(&reading.flow);
        let latency_ms = begin.elapsed().as_secs_f64() * 1e3;
        let (flow, deviation, valid) = (&reading.flow, &reading.deviation, &reading.valid);
        take(number, Followed { flow, feature: density.feature(), deviation, valid, latency_ms });
    }
    Ok(())
}

fn new_tracker(recording: &Recording, profile: &Profile, first: &Frame) -> Result<Tracker, ExperimentError> {
    let mut profile = profile.clone();
    profile.depth.density = None;
    let fields = Fields::NONE;
    Ok(Tracker::new(&profile, recording.size(), first.pixels.is_colour(), fields)?)
}

fn by_dots(
    recording: &Recording,
    profile: &Profile,
    take: &mut impl FnMut(usize, Followed),
) -> Result<(), ExperimentError> {
    let mut sensor: Option<DotSensor> = None;
    let (width, height) = recording.size();
    let deviation = &Image::filled(width, height, f32::INFINITY);
    for (number, frame) in recording.frames().enumerate() {
        let begin = Instant::now();
        let sensor = match &mut sensor {
            Some(sensor) => sensor,
            none => none.insert(DotSensor::new(&frame.pixels, &profile.density)?),
        };
        let DotTouch { flow, feature, valid, .. } = sensor.read(&frame.pixels)?;
        let latency_ms = begin.elapsed().as_secs_f64() * 1e3;
        take(number, Followed { flow, feature, deviation, valid, latency_ms });
    }
    Ok(())
}
