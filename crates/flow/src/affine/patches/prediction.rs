//! The start of a frame that follows others: every point continues its last motion.
//!
//! Without it a steady motion needs one more step at full size in every frame, and a fast motion needs the coarse
//! levels. A motion that begins, stops or changes direction is detected by its residual; then the coarse levels follow
//! it.

use super::{AffinePatches, AffineReference, LevelState};
use crate::affine::products::Current;
use crate::{FlowField, FlowHistory, Picture};

/// Pyramid level on which a prediction is compared with the flow of the last frame.
const PREDICTION_LEVEL: usize = 2;

impl AffinePatches {
    /// Sets the flow of the last frame as the current flow. Where it changes fast, its last change is added, unless the
    /// picture then matches clearly worse. Returns whether the prediction holds everywhere.
    pub(crate) fn predict(&mut self, reference: &AffineReference, current: &Picture, history: &FlowHistory) -> bool {
        self.blur.begin();
        self.is_searched = false;
        let LevelState { field, before, .. } = &mut self.levels[0];
        field.copy_from(history.last_nodes());
        let Some(earlier) = history.earlier_nodes() else { return false };
        before.copy_from(earlier);
        if !before.extrapolate(field) {
            return true;
        }
        let judged = PREDICTION_LEVEL.min(self.levels.len() - 1);
        if judged == 0 {
            return false;
        }
        for level in 1..=judged {
            let (fine, coarse) = self.levels.split_at_mut(level);
            coarse[0].field.coarsen(&fine[level - 1].field);
            coarse[0].before.coarsen(&fine[level - 1].before);
        }
        let picture = Current::grey(current.grey.level(judged), reference.gain(current));
        let (fine, coarse) = self.levels.split_at_mut(judged);
        let LevelState { refinement, field, before, .. } = &mut coarse[0];
        let is_worse = refinement.is_worse_at(&reference.grey[judged], picture, before, field);
        let (columns, rows) = (field.grid.columns, field.grid.rows);
        let goes_on = !(0..columns * rows).any(&is_worse);
        let above = |i: usize, j: usize| (j >> judged).min(rows - 1) * columns + (i >> judged).min(columns - 1);
        let LevelState { field, before, .. } = &mut fine[0];
        field.take(before, |i, j| !is_worse(above(i, j)));
        goes_on
    }

    /// Writes the last flow of a history at every pixel.
    pub(crate) fn expand_last(&mut self, history: &FlowHistory, flow: &mut FlowField) {
        self.levels[0].refinement.expand(history.last_nodes(), flow);
    }

    /// Finds the motion since a start that was predicted. The coarse levels are needed only if an area is lost without them.
    pub(crate) fn follow_prediction(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        is_area_lost: impl FnOnce(&Self) -> bool,
    ) {
        let (coarsest, steps) = (self.params.affine.coarsest_level, self.params.affine.steps);
        let LevelState { field, before, .. } = &mut self.levels[0];
        before.copy_from(field);
        self.take_first_step(reference, current, steps);
        if is_area_lost(self) {
            let LevelState { field, before, .. } = &mut self.levels[0];
            field.copy_from(before);
            self.descend(reference, current, coarsest);
            self.take_first_step(reference, current, steps);
        }
        if steps > 1 {
            self.take_full_steps(reference, current, steps - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FlowParams;
    use fearless_simd::Level;
    use fingervision_image::Image;

    const SIZE: (usize, usize) = (160, 128);

    /// A random pattern with cells of about 4 px, displaced to the right.
    fn picture(estimator: &crate::FlowEstimator, right: f32) -> Picture {
        let wave = |x: f32, y: f32, k: f32| (x * (0.31 + 0.11 * k) + y * (0.83 - 0.17 * k) + 7.0 * k * k).sin();
        let level = |x: usize, y: usize| {
            let x = x as f32 - right;
            128.0 + 30.0 * (0..5).map(|k| wave(x, y as f32, k as f32) * wave(y as f32, x, 0.7 * k as f32)).sum::<f32>()
        };
        let mut picture = estimator.picture();
        picture.load_grey(&Image::from_fn(SIZE.0, SIZE.1, level));
        picture
    }

    /// The displacement to the right, px, with which a frame starts that shows `now`, after `earlier` and `last`.
    fn predicted(earlier: f32, last: f32, now: f32) -> f32 {
        let params = FlowParams { colour: false, ..FlowParams::default() };
        let estimator = crate::FlowEstimator::new(SIZE.0, SIZE.1, &params).unwrap();
        let mut patches = AffinePatches::new(SIZE.0, SIZE.1, &params, Level::new());
        let mut reference = patches.reference();
        patches.prepare(&picture(&estimator, 0.0), &mut reference);
        let mut history = FlowHistory::at_rest(SIZE.0, SIZE.1);
        for right in [earlier, last] {
            let mut flow = FlowField::zero(SIZE.0, SIZE.1);
            flow.u.values_mut().fill(right);
            history.push(&flow);
        }
        patches.predict(&reference, &picture(&estimator, now), &history);
        let field = &patches.levels[0].field;
        field.planes[0][field.grid.columns * field.grid.rows / 2 + field.grid.columns / 2]
    }

    #[test]
    fn a_motion_goes_on() {
        assert!((predicted(2.0, 5.0, 8.3) - 8.0).abs() < 1e-3);
        assert!((predicted(12.0, 6.0, 0.4) - 0.0).abs() < 1e-3);
    }

    #[test]
    fn a_motion_that_stopped_or_turned_does_not_go_on() {
        assert!((predicted(2.0, 5.0, 5.0) - 5.0).abs() < 1e-3);
        assert!((predicted(2.0, 5.0, 3.0) - 5.0).abs() < 1e-3);
    }

    #[test]
    fn what_hardly_moves_does_not_go_on() {
        assert!((predicted(5.0, 5.02, 5.02) - 5.02).abs() < 1e-3);
    }
}
