//! A press as a curve: the density feature of every frame against its depth.

use fingervision_image::{Frame, Image};
use fingervision_touch::{Fields, Flag, Profile, Reading, TrackError, Tracker, perspective_slopes_mm};
use serde::Serialize;

use super::DepthFitError;
use super::limits::check_depths;
use super::maximum::{Maximum, MaximumFinder};
use super::order::{disorder, largest_motion_px};
use super::thresholds::THRESHOLDS;

/// One frame of a press.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PressPoint {
    /// Counted from 0.
    pub frame: u64,
    /// Known depth of the indenter, mm.
    pub depth_mm: f64,
    /// The maximum of the density feature `1 − density` after the filter, dimensionless.
    pub feature: f64,
    /// The maximum of the feature over the growth of the surface in the image, mm: the depth at a gain of 1. Absent
    /// without a camera.
    pub perspective_mm: Option<f64>,
}

/// Position of a press in the image: the distance of the most expanded point from the image's centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// Within 15 % of the half diagonal.
    Centre,
    /// Up to 45 %.
    Midway,
    /// Beyond that.
    Corner,
}

/// A press: its frames, starting with the untouched gel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressCurve {
    /// Its name.
    pub name: String,
    /// Its position in the image.
    pub place: Place,
    /// The valid frames, in order.
    pub points: Vec<PressPoint>,
    /// Frames left out because the tracker lost them.
    pub lost: usize,
}

/// Tracks a press and stores its curve.
#[derive(Debug)]
pub struct PressRecorder {
    press: String,
    depths_mm: Vec<f64>,
    tracker: Tracker,
    finder: MaximumFinder,
    /// Depth per unit of the feature by perspective alone, mm, and memory for the product of both.
    perspective: Option<[Image<f32>; 2]>,
    points: Vec<PressPoint>,
    /// Depth, mm, and largest motion, px, of the tracked frames.
    motions: Vec<[f64; 2]>,
    frames: usize,
    lost: usize,
    was_pressed: bool,
    /// The largest depth so far, mm, and the most expanded place there, px.
    deepest: (f64, [f64; 2]),
}

impl PressRecorder {
    /// A recorder for a press with images of this size, px, and known depths, mm.
    ///
    /// # Errors
    ///
    /// [`DepthFitError`] if the depths are not those of a press, or the profile does not fit the images.
    pub fn new(
        press: &str,
        depths_mm: &[f64],
        profile: &Profile,
        frame_size: (usize, usize),
        is_colour: bool,
        maximum: Maximum,
    ) -> Result<Self, DepthFitError> {
        check_depths(press, depths_mm, profile)?;
        let mut profile = profile.clone();
        // The law that is about to be fitted must not affect the tracking.
        profile.depth.density = None;
        if maximum == Maximum::Robust {
            let limit_px = &mut profile.flow.validity.max_deviation_px;
            *limit_px = limit_px.max(THRESHOLDS.median_deviation_px);
        }
        let fields = Fields { density: true, ..Fields::NONE };
        let tracker = Tracker::new(&profile, frame_size, is_colour, fields).map_err(tracking(press))?;
        let size = tracker.size();
        check_camera(press, &profile, size)?;
        let slopes = profile.camera.and_then(|camera| perspective_slopes_mm(&camera, size));
        Ok(Self {
            press: press.into(),
            depths_mm: depths_mm.to_vec(),
            finder: MaximumFinder::new(maximum, size),
            perspective: slopes.map(|slopes| [Image::filled(size.0, size.1, 0.0), slopes]),
            tracker,
            points: Vec::new(),
            motions: Vec::new(),
            frames: 0,
            lost: 0,
            was_pressed: false,
            deepest: (f64::NEG_INFINITY, [0.0; 2]),
        })
    }

    /// Takes the next image.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::Track`] if the image cannot be tracked, [`DepthFitError::Count`] if the depths have no row for
    /// it.
    pub fn push(&mut self, frame: &Frame) -> Result<(), DepthFitError> {
        let Some(&depth_mm) = self.depths_mm.get(self.frames) else {
            return Err(self.miscounted(self.frames as u64 + 1));
        };
        let reading = self.tracker.track(frame).map_err(tracking(&self.press))?;
        let number = self.frames as u64;
        self.frames += 1;
        self.was_pressed |= reading.flags.has(Flag::PressedAtStart);
        let is_useless = reading.flags.has(Flag::Lost) || reading.flags.has(Flag::TornImage);
        let values = if is_useless { None } else { maxima(reading, &mut self.finder, &mut self.perspective) };
        let Some((feature, perspective_mm)) = values else {
            self.lost += 1;
            return Ok(());
        };
        if depth_mm > self.deepest.0
            && let Some(place) = spreading_place(reading, feature)
        {
            self.deepest = (depth_mm, place);
        }
        self.motions.push([depth_mm, largest_motion_px(reading)]);
        self.points.push(PressPoint { frame: number, depth_mm, feature, perspective_mm });
        Ok(())
    }

    /// The curve, after the last image.
    ///
    /// # Errors
    ///
    /// [`DepthFitError::Count`] if there are more depths than images, [`DepthFitError::PressedAtStart`] if the first
    /// image shows a pressed gel, [`DepthFitError::Lost`] if more than half of the images were lost,
    /// [`DepthFitError::Unordered`] if motion does not grow with depth.
    pub fn finish(self) -> Result<PressCurve, DepthFitError> {
        if self.frames != self.depths_mm.len() {
            return Err(self.miscounted(self.frames as u64));
        }
        let Self { press, lost, frames, .. } = self;
        if self.was_pressed {
            return Err(DepthFitError::PressedAtStart { press, depth_mm: None });
        }
        if 2 * lost > frames {
            return Err(DepthFitError::Lost { press, lost, frames });
        }
        if let Some(correlation) = disorder(&self.motions) {
            return Err(DepthFitError::Unordered { press, correlation });
        }
        let place = Place::of(self.deepest.1, self.tracker.size());
        Ok(PressCurve { name: press, place, points: self.points, lost })
    }

    fn miscounted(&self, images: u64) -> DepthFitError {
        DepthFitError::Count { press: self.press.clone(), images, depths: self.depths_mm.len() as u64 }
    }
}

impl Place {
    fn of([x, y]: [f64; 2], (width, height): (usize, usize)) -> Self {
        let (half_width, half_height) = (0.5 * width as f64, 0.5 * height as f64);
        let part = (x - half_width).hypot(y - half_height) / half_width.hypot(half_height);
        match part {
            part if part < 0.15 => Self::Centre,
            part if part < 0.45 => Self::Midway,
            _ => Self::Corner,
        }
    }

    /// Its name as a heading.
    #[must_use]
    pub fn heading(self) -> &'static str {
        match self {
            Self::Centre => "Centre",
            Self::Midway => "Midway",
            Self::Corner => "Corner",
        }
    }
}

pub(crate) fn tracking(press: &str) -> impl Fn(TrackError) -> DepthFitError + '_ {
    |source| DepthFitError::Track { press: press.into(), source: Box::new(source) }
}

/// A principal point outside the image belongs to another image.
pub(crate) fn check_camera(press: &str, profile: &Profile, region: (usize, usize)) -> Result<(), DepthFitError> {
    let Some(camera) = &profile.camera else { return Ok(()) };
    let principal_point_px = camera.principal_point_px;
    let is_inside = |at: f64, length: usize| (-0.5..length as f64 - 0.5).contains(&at);
    if is_inside(principal_point_px[0], region.0) && is_inside(principal_point_px[1], region.1) {
        return Ok(());
    }
    Err(DepthFitError::OtherSize { press: press.into(), region, principal_point_px })
}

/// The maximum of the feature and that of the depth by perspective, mm; none where nothing is valid.
fn maxima(
    reading: &Reading,
    finder: &mut MaximumFinder,
    perspective: &mut Option<[Image<f32>; 2]>,
) -> Option<(f64, Option<f64>)> {
    let feature = reading.density.as_ref()?;
    let largest = finder.find(feature, &reading.valid)?;
    let Some([product, slopes]) = perspective else { return Some((largest.into(), None)) };
    for ((product, slope), feature) in product.values_mut().iter_mut().zip(slopes.values()).zip(feature.values()) {
        *product = slope * feature;
    }
    Some((largest.into(), finder.find(product, &reading.valid).map(f64::from)))
}

/// The mean place of the valid pixels with at least half of the largest feature, px: the face and the expanded gel
/// around it. None where there are none.
fn spreading_place(reading: &Reading, largest: f64) -> Option<[f64; 2]> {
    let feature = reading.density.as_ref()?;
    let (mut count, mut place) = (0.0, [0.0; 2]);
    for (y, (features, valid)) in feature.rows().zip(reading.valid.rows()).enumerate() {
        for (x, (&feature, &valid)) in features.iter().zip(valid).enumerate() {
            if valid == 1 && f64::from(feature) >= 0.5 * largest {
                count += 1.0;
                place[0] += x as f64;
                place[1] += y as f64;
            }
        }
    }
    (count > 0.0).then(|| place.map(|sum| sum / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_follows_from_its_distance_from_the_centre() {
        let at = |x: f64, y: f64| Place::of([x, y], (480, 480));
        assert_eq!(
            [at(240.0, 250.0), at(312.0, 312.0), at(384.0, 384.0)],
            [Place::Centre, Place::Midway, Place::Corner]
        );
    }
}
