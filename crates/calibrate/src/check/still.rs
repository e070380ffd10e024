//! The untouched gel, recorded for a few seconds: the quality of camera and light.

use fingervision_flow::{Estimate, FlowError, FlowEstimator, FlowParams, Picture, Reference, Start};
use fingervision_image::{Frame, Rect};

use super::Check;
use super::exposure::Exposure;
use super::fault::{Fault, RecordingCheck, What};
use super::samples::{Samples, unsharp};
use super::thresholds::THRESHOLDS;

/// Fewer images do not show whether light and camera are steady.
pub const STILL_IMAGES: usize = 10;

/// Checks a recording of the untouched gel. All images are matched with the first.
#[derive(Debug)]
pub struct StillCheck {
    region: Rect,
    exposure: Exposure,
    estimator: FlowEstimator,
    picture: Picture,
    reference: Reference,
    estimate: Estimate,
    /// Of the worst image: median deviation, motion as a whole, motion of parts; px.
    worst: [f64; 3],
    /// The first image that does not match the first one, from 1.
    other: Option<usize>,
    refused: Option<Fault>,
}

impl StillCheck {
    /// A check of the region of interest of frames in grey or colour.
    ///
    /// # Errors
    ///
    /// [`FlowError`] for a region too small or parameters out of range.
    pub fn new(region: Rect, is_colour: bool, params: &FlowParams) -> Result<Self, FlowError> {
        let params = FlowParams { colour: params.colour && is_colour, ..*params };
        let estimator = FlowEstimator::new(region.width, region.height, &params)?;
        Ok(Self {
            region,
            exposure: Exposure::new(region, true),
            picture: estimator.picture(),
            reference: estimator.reference(),
            estimate: Estimate::new(region.width, region.height),
            estimator,
            worst: [0.0; 3],
            other: None,
            refused: None,
        })
    }

    fn count_fault(&self) -> Option<Fault> {
        let images = self.exposure.images();
        let remedy = "record the untouched gel for some seconds";
        let measured = format!("{images} images");
        (images < STILL_IMAGES).then(|| Fault::new(What::Count, measured, format!("at least {STILL_IMAGES}"), remedy))
    }

    fn light_fault(&self) -> Option<Fault> {
        let flicker = self.exposure.flicker();
        let measured = format!("the mean level changes by {:.1} % within the recording", 100.0 * flicker);
        let allowed = format!("at most {:.0} %", 100.0 * THRESHOLDS.most_flicker);
        let remedy = "switch automatic exposure, gain and white balance off, drive the lamp with direct current, keep daylight out";
        (flicker > THRESHOLDS.most_flicker).then(|| Fault::new(What::Light, measured, allowed, remedy))
    }

    fn motion_fault(&self) -> Option<Fault> {
        let [_, drift, motion] = self.worst;
        if self.exposure.noise_levels().is_some_and(|noise| noise < THRESHOLDS.least_noise_levels) {
            let remedy = "save consecutive images of the camera, not the same image several times";
            return Some(Fault::new(What::Copies, "all images are the same", "images with the camera's noise", remedy));
        }
        if drift > THRESHOLDS.most_drift_px || self.other.is_some() {
            let moved = || format!("the whole image moves by {drift:.3} px");
            let measured = self.other.map_or_else(moved, |image| format!("image {image} does not match image 1"));
            let remedy =
                "fix camera, lens and gel in one rigid frame, lock the focus, let everything warm up for some minutes";
            return Some(Fault::new(What::Drift, measured, format!("at most {} px", THRESHOLDS.most_drift_px), remedy));
        }
        let measured = format!("a part of the image moves by {motion:.2} px");
        let remedy = "do not touch the gel; after a press, wait until it has come to rest";
        let fault = || Fault::new(What::Touched, measured, format!("at most {} px", THRESHOLDS.most_motion_px), remedy);
        (motion > THRESHOLDS.most_motion_px).then(fault)
    }
}

impl Check for StillCheck {
    fn push(&mut self, frame: &Frame) {
        if let Err(error) = self.picture.load(&frame.pixels, self.region) {
            self.refused.get_or_insert_with(|| Fault::unreadable(&error, None));
            return;
        }
        self.exposure.push(frame);
        if self.exposure.images() == 1 {
            self.estimator.prepare(&self.picture, &mut self.reference);
            return;
        }
        self.estimator.estimate(&self.reference, &self.picture, Start::Search(None), &mut self.estimate);
        if self.reference.textured() >= THRESHOLDS.least_textured && self.estimate.matched < THRESHOLDS.least_matched {
            self.other.get_or_insert(self.exposure.images());
            return;
        }
        let samples = Samples::of(&self.estimate.flow, &self.estimate.deviation, &self.estimate.valid);
        self.worst[0] = self.worst[0].max(samples.deviation_px);
        if !samples.is_empty() {
            let [x, y] = samples.median();
            self.worst[1] = self.worst[1].max(x.hypot(y));
            self.worst[2] = self.worst[2].max(samples.apart_from([x, y], THRESHOLDS.moving_part));
        }
    }

    fn finish(self: Box<Self>) -> RecordingCheck {
        let [deviation, drift, _] = self.worst;
        let cause = || self.light_fault().or_else(|| unsharp(deviation)).or_else(|| self.motion_fault());
        let cause = self.refused.clone().or_else(|| self.exposure.fault()).or_else(cause);
        RecordingCheck {
            deviation_px: deviation.is_finite().then_some(deviation),
            motion_px: Some(drift),
            faults: self.count_fault().into_iter().chain(cause).collect(),
            ..self.exposure.figures()
        }
    }
}
