//! Samples of a flow, and the properties of a recording that follow from them.

use fingervision_flow::FlowField;
use fingervision_image::Image;

use super::fault::{Fault, What};
use super::thresholds::THRESHOLDS;
use crate::camera::median;

/// Distance between samples along both axes: half a patch.
const STEP: usize = 8;

/// Samples of one flow.
#[derive(Debug)]
pub(super) struct Samples {
    /// Median of the predicted deviation, px; infinite where most of the image was not found.
    pub(super) deviation_px: f64,
    /// Place, px, and flow, px, of every sample that is a measurement.
    flows: Vec<[f64; 4]>,
    size: (usize, usize),
}

impl Samples {
    pub(super) fn of(flow: &FlowField, deviation: &Image<f32>, valid: &Image<u8>) -> Self {
        let (width, height) = flow.size();
        let places = || {
            let rows = (STEP / 2..height).step_by(STEP);
            rows.flat_map(|y| (STEP / 2..width).step_by(STEP).map(move |x| (x, y)))
        };
        let deviations = places().map(|(x, y)| f64::from(deviation.at(x, y))).collect();
        let flows = places()
            .filter(|&(x, y)| valid.at(x, y) == 1)
            .map(|(x, y)| [x as f64, y as f64, flow.u.at(x, y).into(), flow.v.at(x, y).into()]);
        Self { deviation_px: median(deviations), flows: flows.collect(), size: (width, height) }
    }

    /// Whether no sample is valid.
    pub(super) fn is_empty(&self) -> bool {
        self.flows.is_empty()
    }

    /// The flow's median, px.
    pub(super) fn median(&self) -> [f64; 2] {
        [2, 3].map(|axis| median(self.flows.iter().map(|sample| sample[axis]).collect()))
    }

    /// Distance of the samples from this flow, px, exceeded only by a given part of them.
    pub(super) fn apart_from(&self, [x, y]: [f64; 2], but_part: f64) -> f64 {
        let mut lengths: Vec<f64> = self.flows.iter().map(|[_, _, u, v]| (u - x).hypot(v - y)).collect();
        if lengths.is_empty() {
            return 0.0;
        }
        lengths.sort_by(f64::total_cmp);
        lengths[((1.0 - but_part) * (lengths.len() - 1) as f64) as usize]
    }

    /// The largest length of all samples, and of those that lie within a margin along the border, px.
    pub(super) fn largest(&self, margin: f64) -> [f64; 2] {
        let (right, bottom) = (self.size.0 as f64 - 1.0, self.size.1 as f64 - 1.0);
        let is_at_border = |x: f64, y: f64| x.min(y).min(right - x).min(bottom - y) <= margin;
        self.flows.iter().fold([0.0, 0.0], |[all, border], &[x, y, u, v]| {
            let length = u.hypot(v);
            [length.max(all), if is_at_border(x, y) { length.max(border) } else { border }]
        })
    }
}

/// The fault of a recording whose flow has this deviation, px, if it is one.
pub(super) fn unsharp(deviation_px: f64) -> Option<Fault> {
    let measured = if deviation_px.is_finite() {
        format!("the flow has a standard deviation of {deviation_px:.3} px")
    } else {
        "half of the image or more cannot be tracked".into()
    };
    let remedy = "bring the pattern into focus and lock it, and keep still while the image is taken; if it is sharp, more light and less \
         gain lower the noise, and fingervision pattern --score shows which cell size suits this camera";
    let allowed = format!("at most {} px", THRESHOLDS.most_deviation_px);
    (deviation_px > THRESHOLDS.most_deviation_px).then(|| Fault::new(What::Unsharp, measured, allowed, remedy))
}
