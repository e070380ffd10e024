//! Writes the flow of every pixel, its deviation and its validity.

use super::{AffinePatches, AffineReference, LevelState};
use crate::affine::fine::{CoarseMotions, Effort, Rough};
use crate::affine::judge::{mark_pixels, spread_variance};
use crate::affine::products::Current;
use crate::{Estimate, FlowField, Picture};
use fearless_simd::dispatch;

/// Finer patches replace a patch whose predicted deviation is above this, px; in smooth flow it is a tenth of this.
const ROUGH_PX: f32 = 0.1;

impl AffinePatches {
    /// Adds detail of the flow that the patches cannot represent to their error; `smooth` is scratch memory.
    pub(crate) fn add_fine_error(&mut self, flow: &FlowField, smooth: &mut FlowField) {
        self.expand(smooth);
        self.levels[0].refinement.add_fine_error(flow, smooth);
    }

    /// Writes the flow at every pixel.
    pub(crate) fn expand(&mut self, flow: &mut FlowField) {
        let LevelState { refinement, field, .. } = &mut self.levels[0];
        refinement.expand(field, flow);
    }

    /// Writes the flow, its deviation and its validity, refined where the field is rough.
    pub(crate) fn write(&mut self, reference: &AffineReference, current: &Picture, out: &mut Estimate) {
        self.recall_failed();
        self.expand(&mut out.flow);
        self.write_validity(reference, out);
        let gain = reference.gain(current);
        let Self { levels, fine, blur, variance, params, is_searched, .. } = self;
        let LevelState { refinement, field, .. } = &levels[0];
        let template = blur.template(&reference.full);
        let textured = params.validity.max_deviation_px.powi(2);
        let likelihood = blur.likelihood();
        let rough = |node: usize| {
            let is_textured = reference.full.own_variance[node] <= textured && refinement.is_inside[node];
            let variance = if refinement.trust()[node] > 0.0 { variance[node] } else { f32::MAX };
            let by_blur = refinement.blur_error(template, node);
            // A rim that cannot be blur is rough all the same.
            let variance = variance + (1.0 - likelihood) * by_blur;
            let is_rough = is_textured && variance > ROUGH_PX * ROUGH_PX && !blur.is_blurred(node);
            is_rough.then(|| Rough { variance, blur_error: likelihood * by_blur + blur.path_error(node) })
        };
        let coarse = is_searched.then(|| CoarseMotions { field, trust: refinement.trust() });
        let (templates, rules) = ((template, &reference.fine), &params.validity);
        let effort = Effort { steps: params.affine.fine_steps, coarse, blur_likelihood: likelihood };
        match &current.colour {
            Some(channels) => fine.refine(templates, Current::colour(channels, gain), rules, effort, rough, out),
            None => fine.refine(templates, Current::grey(current.grey.level(0), gain), rules, effort, rough, out),
        }
    }

    /// Writes the deviation and the validity of the flow in `out`.
    pub(crate) fn write_validity(&mut self, reference: &AffineReference, out: &mut Estimate) {
        let Self { params, levels, blur, variance, steps, ranks, .. } = self;
        let template = blur.template(&reference.full);
        let LevelState { refinement, field, .. } = &mut levels[0];
        let limit = params.validity.max_deviation_px;
        let step_variance = params.affine.continuity_px.powi(2) + params.affine.curvature_px.powi(2);
        refinement.scale_variance((template, limit.powi(2)), step_variance, variance, steps);
        spread_variance(field.grid, steps, variance);
        refinement.add_own_errors(template, blur.likelihood(), |node| blur.path_error(node), variance);
        let found = refinement.summarise(template, limit.powi(2), ranks);
        (out.matched, out.residual_levels, out.unexplained) = (found.part, found.residual_levels, found.unexplained);
        let (grid, trust) = (field.grid, refinement.trust());
        dispatch!(self.simd, simd => mark_pixels(simd, grid, (variance, trust), limit, steps, out));
    }
}
