//! A press of known depth.

use fingervision_flow::FlowParams;
use fingervision_image::{Frame, Rect};
use fingervision_touch::{Fields, Flag, Profile, ProfileError, TrackError, Tracker};

use super::Check;
use super::exposure::Exposure;
use super::fault::{Fault, RecordingCheck, What};
use super::rest::RestImage;
use super::samples::{Samples, unsharp};
use super::thresholds::THRESHOLDS;
use crate::depth::{DepthFitError, LEAST_CORRELATION, PressFolder, check_depths, disorder};

/// Checks a recording of a press.
#[derive(Debug)]
pub struct PressCheck {
    exposure: Exposure,
    tracker: Tracker,
    region: Rect,
    is_colour: bool,
    flow: FlowParams,
    depths_mm: Vec<f64>,
    /// The untouched gel, to compare the first image with.
    rest: Option<RestImage>,
    /// The result of that comparison.
    rest_fault: Option<Fault>,
    /// Depth, mm, and largest motion, px, of every tracked image.
    motions: Vec<[f64; 2]>,
    frames: usize,
    lost: usize,
    was_pressed: bool,
    light_changed: bool,
    /// Median deviation of the first image that is tracked, px: later ones are stretched.
    deviation_px: Option<f64>,
    /// The largest motion overall, and the motion at the border in the same image, px.
    largest: [f64; 2],
    refused: Option<TrackError>,
}

impl PressCheck {
    /// A check of a press whose depths are known, for frames of this size, px, in grey or colour.
    ///
    /// # Errors
    ///
    /// What is wrong with the depths, or why the profile cannot track such frames.
    pub fn new(
        folder: &PressFolder,
        profile: &Profile,
        frame_size: (usize, usize),
        is_colour: bool,
    ) -> Result<Self, Fault> {
        check_depths(&folder.name, &folder.depths_mm, profile).map_err(|error| Fault::from(&error))?;
        let unfit = |error: ProfileError| Fault::unreadable(&error, error.hint());
        let region = profile.region(frame_size).map_err(unfit)?;
        let fields = Fields::NONE;
        let tracker = Tracker::new(profile, frame_size, is_colour, fields)
            .map_err(|error| Fault::unreadable(&error, error.hint()))?;
        Ok(Self {
            exposure: Exposure::new(region, false),
            tracker,
            region,
            is_colour,
            flow: profile.flow,
            depths_mm: folder.depths_mm.clone(),
            rest: None,
            rest_fault: None,
            motions: Vec::new(),
            frames: 0,
            lost: 0,
            was_pressed: false,
            light_changed: false,
            deviation_px: None,
            largest: [0.0; 2],
            refused: None,
        })
    }

    /// Compares the first image with one that shows the gel untouched, as the same camera sees it.
    ///
    /// # Errors
    ///
    /// Why no image can be compared with that one.
    pub fn with_rest(mut self, rest: &Frame) -> Result<Self, Fault> {
        self.rest = Some(RestImage::new(rest, self.region, self.is_colour, &self.flow)?);
        Ok(self)
    }

    /// Tests whether the images move more the deeper they are.
    fn order_fault(&self) -> Option<Fault> {
        let correlation = disorder(&self.motions)?;
        let measured = format!("motion does not grow with depth: their correlation is {correlation:.2}");
        let remedy = "number the images in the order in which they were taken, and give each row of depth.csv the depth of its own image";
        let allowed = format!("at least {LEAST_CORRELATION}");
        Some(Fault::new(What::Order, measured, allowed, remedy))
    }

    fn count_fault(&self) -> Option<Fault> {
        let (images, depths) = (self.frames as u64, self.depths_mm.len() as u64);
        (images != depths).then(|| Fault::from(&DepthFitError::Count { press: String::new(), images, depths }))
    }

    fn motion_fault(&self) -> Option<Fault> {
        let Self { lost, frames, largest: [largest, at_border], .. } = *self;
        if self.light_changed {
            let remedy = "switch automatic exposure, gain and white balance off and keep daylight out";
            let measured = "the mean level changes by more than a quarter";
            return Some(Fault::new(What::Light, measured, "steady light", remedy));
        }
        if self.was_pressed {
            let measured = "the gel is released after the first image: it was pressed there";
            let remedy = "begin the recording before the indenter touches the gel";
            return Some(Fault::new(What::PressedAtStart, measured, "an untouched gel in the first image", remedy));
        }
        if lost as f64 > THRESHOLDS.most_lost * frames as f64 {
            let measured = format!("{lost} of {frames} images cannot be tracked");
            let remedy = "press in smaller steps, take an image after each, and do not change light and exposure";
            return Some(Fault::new(
                What::Lost,
                measured,
                format!("at most {:.0} %", 100.0 * THRESHOLDS.most_lost),
                remedy,
            ));
        }
        if largest < THRESHOLDS.least_motion_px {
            let measured = format!("the largest motion is {largest:.2} px");
            let remedy = "press deeper, within the camera's field of view";
            return Some(Fault::new(
                What::MotionTooSmall,
                measured,
                format!("at least {} px", THRESHOLDS.least_motion_px),
                remedy,
            ));
        }
        let measured = format!("the surface moves by {at_border:.1} px at the border, and by at most {largest:.1} px");
        let remedy = "press farther from the image's border, or with a smaller indenter";
        let allowed = format!("below {:.0} %", 100.0 * THRESHOLDS.most_at_border);
        let is_cut = at_border > THRESHOLDS.most_at_border * largest;
        self.order_fault().or_else(|| is_cut.then(|| Fault::new(What::CutByBorder, measured, allowed, remedy)))
    }
}

impl Check for PressCheck {
    fn push(&mut self, frame: &Frame) {
        self.frames += 1;
        self.exposure.push(frame);
        if let Some(rest) = &mut self.rest.take() {
            self.rest_fault = rest.fault(frame);
        }
        if self.refused.is_some() {
            return;
        }
        let reading = match self.tracker.track(frame) {
            Ok(reading) => reading,
            Err(error) => {
                self.refused = Some(error);
                return;
            }
        };
        self.was_pressed |= reading.flags.has(Flag::PressedAtStart);
        self.light_changed |= reading.flags.has(Flag::LightChanged);
        self.lost += usize::from(reading.flags.has(Flag::Lost));
        if reading.flags.has(Flag::NoTexture) {
            self.deviation_px.get_or_insert(f64::INFINITY);
        }
        let depth_mm = self.depths_mm.get(self.frames - 1).copied();
        if self.frames == 1 {
            self.motions.extend(depth_mm.map(|depth_mm| [depth_mm, 0.0]));
        }
        if self.frames == 1 || reading.flags.has(Flag::Lost) {
            return;
        }
        let samples = Samples::of(&reading.flow, &reading.deviation, &reading.valid);
        self.deviation_px.get_or_insert(samples.deviation_px);
        let (width, height) = reading.flow.size();
        let [all, border] = samples.largest(THRESHOLDS.border * width.min(height) as f64);
        self.motions.extend(depth_mm.map(|depth_mm| [depth_mm, all]));
        if all > self.largest[0] {
            self.largest = [all, border];
        }
    }

    fn finish(self: Box<Self>) -> RecordingCheck {
        let refused = self.refused.as_ref().map(|error| Fault::unreadable(error, error.hint()));
        let followed = || self.rest_fault.clone().or_else(|| self.motion_fault());
        let cause = || unsharp(self.deviation_px.unwrap_or(0.0)).or_else(followed);
        let cause = refused.or_else(|| self.exposure.fault()).or_else(cause);
        RecordingCheck {
            deviation_px: self.deviation_px.filter(|deviation| deviation.is_finite()),
            motion_px: Some(self.largest[0]),
            faults: self.count_fault().into_iter().chain(cause).collect(),
            ..self.exposure.figures()
        }
    }
}
