//! The stack of references of [Du2021], as published.
//!
//! In addition to the fine flow, a coarse flow is computed on a small grid. The current image, warped back with the
//! coarse flow, is compared with the reference on top of the stack. If the largest photometric error is above the push
//! threshold, the frame and its flow are added to the stack. If the error against an older reference is below the loop
//! threshold, all later references are dropped. The flow from the first reference is the composition of the flow to the
//! current reference and the flow from there.
//!
//! The fine flow starts from that of the previous frame; if this does not match, it is searched without a start.
//!
//! The paper adds flows; here they are composed, because the sum is wrong by several per cent for a strong press.

use super::compose::compose_into;
use super::follow::follow;
use super::{Matched, ReferenceParams};
use fingervision_flow::{
    Estimate, FlowError, FlowEstimator, FlowField, FlowHistory, FlowParams, Picture, Preset, Reference, Start,
};
use fingervision_image::{Image, average_into};

/// A reference, its coarse version and the flow from the first reference to it.
#[derive(Debug)]
struct Layer {
    id: u64,
    reference: Reference,
    /// Grey levels on the coarse grid.
    coarse: Image<f32>,
    coarse_reference: Reference,
    /// Flow from the first reference.
    from_first: Estimate,
}

/// The stack.
#[derive(Debug)]
pub(crate) struct Stack {
    params: ReferenceParams,
    layers: Vec<Layer>,
    pushed: u64,
    coarse: FlowEstimator,
    coarse_picture: Picture,
    coarse_current: Image<f32>,
    coarse_flow: Estimate,
    /// Flow from the top reference to the last frames.
    history: FlowHistory,
    from_top: Estimate,
}

impl Stack {
    pub(crate) fn new(size: (usize, usize), params: &ReferenceParams) -> Result<Self, FlowError> {
        let [columns, rows] = params.coarse_grid;
        let flow = FlowParams { preset: Preset::Medium, finest_level: Some(0), colour: false, ..FlowParams::default() };
        let coarse = FlowEstimator::new(columns, rows, &flow)?;
        Ok(Self {
            params: *params,
            layers: Vec::new(),
            pushed: 0,
            coarse_picture: coarse.picture(),
            coarse,
            coarse_current: Image::filled(columns, rows, 0.0),
            coarse_flow: Estimate::new(columns, rows),
            history: FlowHistory::at_rest(size.0, size.1),
            from_top: Estimate::new(size.0, size.1),
        })
    }

    /// Drops all references; the next frame becomes the first one.
    pub(crate) fn restart(&mut self) {
        self.layers.clear();
        self.history.restart();
        self.coarse.restart();
    }

    /// Matches a frame and writes its flow from the first reference.
    pub(crate) fn track(
        &mut self,
        estimator: &mut FlowEstimator,
        current: &mut Picture,
        out: &mut Estimate,
    ) -> Matched {
        average_into(current.grey(), &mut self.coarse_current);
        self.coarse_picture.load_grey(&self.coarse_current);
        if self.layers.is_empty() {
            self.push(estimator, current, Estimate::new(current.size().0, current.size().1));
        }
        let error = self.close_loop();
        let last = self.layers.len() - 1;
        let top = &mut self.layers[last];
        follow(estimator, &mut top.reference, current, &self.history, &mut self.from_top);
        let top = &self.layers[last];
        if self.from_top.matched < self.params.min_matched {
            estimator.estimate(&top.reference, current, Start::SearchHistory(&self.history), &mut self.from_top);
        }
        self.history.push(&self.from_top.flow);
        if self.layers.len() > 1 {
            compose_into(&top.from_first, &self.from_top, out);
        } else {
            out.copy_from(&self.from_top);
        }
        let zero_id = self.layers[0].id;
        let matched =
            Matched { reference_id: top.id, zero_id, reference_count: self.layers.len(), photometric_error: error };
        if error > self.params.push_error && self.layers.len() < self.params.max_references {
            self.push(estimator, current, out.clone());
            self.history.restart();
        }
        matched
    }

    /// Drops all layers above the oldest one to which the frame returns; returns the error against the top.
    fn close_loop(&mut self) -> f32 {
        for k in 0..self.layers.len() - 1 {
            let error = self.coarse_error(k);
            if error < self.params.loop_error {
                self.layers.truncate(k + 1);
                // The frame matches as well as the reference to which it returned.
                self.history.restart();
                return error;
            }
        }
        self.coarse_error(self.layers.len() - 1)
    }

    /// Largest photometric error between a layer and the current image warped back with the coarse flow, grey levels.
    fn coarse_error(&mut self, layer: usize) -> f32 {
        let layer = &self.layers[layer];
        self.coarse.estimate(&layer.coarse_reference, &self.coarse_picture, Start::Search(None), &mut self.coarse_flow);
        largest_error(&layer.coarse, &self.coarse_current, &self.coarse_flow.flow)
    }

    fn push(&mut self, estimator: &FlowEstimator, current: &Picture, mut from_first: Estimate) {
        if self.layers.is_empty() {
            from_first.valid.values_mut().fill(1);
            from_first.deviation.values_mut().fill(0.0);
        }
        let mut reference = estimator.reference();
        estimator.prepare(current, &mut reference);
        let mut coarse_reference = self.coarse.reference();
        self.coarse.prepare(&self.coarse_picture, &mut coarse_reference);
        let coarse = self.coarse_current.clone();
        self.layers.push(Layer { id: self.pushed, reference, coarse, coarse_reference, from_first });
        self.pushed += 1;
    }

    /// The first reference.
    pub(crate) fn first(&self) -> Option<&Reference> {
        self.layers.first().map(|layer| &layer.reference)
    }

    /// The number of the first reference.
    pub(crate) fn first_id(&self) -> Option<u64> {
        self.layers.first().map(|layer| layer.id)
    }
}

/// Largest `|current(x + flow(x)) − reference(x)|` over the pixels for which `x + flow(x)` is in the image.
fn largest_error(reference: &Image<f32>, current: &Image<f32>, flow: &FlowField) -> f32 {
    let (width, height) = reference.size();
    let (mut largest, mut compared) = (0.0_f32, 0);
    for y in 0..height {
        for x in 0..width {
            let (px, py) = (x as f32 + flow.u.at(x, y), y as f32 + flow.v.at(x, y));
            let is_inside = px >= 0.0 && py >= 0.0 && px <= (width - 1) as f32 && py <= (height - 1) as f32;
            if is_inside {
                let (left, top) = ((px as usize).min(width - 2), (py as usize).min(height - 2));
                let (fx, fy) = (px - left as f32, py - top as f32);
                let across = |y: usize| current.at(left, y) + fx * (current.at(left + 1, y) - current.at(left, y));
                let sample = across(top) + fy * (across(top + 1) - across(top));
                largest = largest.max((sample - reference.at(x, y)).abs());
                compared += 1;
            }
        }
    }
    // If the flow leads out of the image, too few pixels are compared.
    if 2 * compared >= width * height { largest } else { f32::INFINITY }
}
