//! Distances between neighbouring points after their motion, and where these leave gaps between their Gaussians.
//!
//! [Du2021] calls the density valid while 3σ > M, where M is "the largest length of the flow's first differences".
//! Taken literally that is the *change* of spacing. What must not exceed the reach of a Gaussian is the spacing
//! itself, `|x'(i + 1) − x'(i)|`, the first difference of the moved points: it is 1 at rest and differs from the
//! literal length by at most 1 px. The spacing is used here, pixel by pixel, and its largest value is M.
//!
//! [Du2021]: https://doi.org/10.1109/LRA.2021.3061306

use fearless_simd::prelude::*;
use fearless_simd_macros::simd;
use fingervision_flow::FlowField;

/// Squared spacings of the points of one row and of the adjacent rows, px², and the largest of them so far.
#[derive(Debug, Clone)]
pub(super) struct Spacings {
    /// Entry `x` lies between points `x − 1` and `x`; zero at both ends, where a neighbour is missing.
    across: Vec<f32>,
    /// From the row above; zero in the first row.
    above: Vec<f32>,
    /// To the row below; zero in the last row.
    below: Vec<f32>,
    largest: Vec<f32>,
}

impl Spacings {
    /// Spacings of rows of `width` points.
    pub(super) fn new(width: usize) -> Self {
        Self {
            across: vec![0.0; width + 1],
            above: vec![0.0; width],
            below: vec![0.0; width],
            largest: vec![0.0; width],
        }
    }

    /// Measures row `y` of the flow. Rows must come in order from the first, which resets the state of the previous flow.
    #[simd]
    pub(super) fn measure<S: Simd>(&mut self, simd: S, flow: &FlowField, y: usize) {
        if y == 0 {
            self.below.fill(0.0);
            self.largest.fill(0.0);
        }
        std::mem::swap(&mut self.above, &mut self.below);
        let (u, v) = (flow.u.row(y), flow.v.row(y));
        let inner = self.across.len() - 1;
        let across = &mut self.across[1..inner];
        squared_spacings(simd, across, (u, v), (&u[1..], &v[1..]), (1.0, 0.0));
        keep_largest(simd, &mut self.largest, across);
        if y + 1 < flow.u.height() {
            squared_spacings(simd, &mut self.below, (u, v), (flow.u.row(y + 1), flow.v.row(y + 1)), (0.0, 1.0));
            keep_largest(simd, &mut self.largest, &self.below);
        } else {
            self.below.fill(0.0);
        }
    }

    /// Marks with 1 the points of the row that lie in the current image and closer than `limit` px to their four neighbours, with 0
    /// all others and those whose place is not finite.
    #[simd]
    #[expect(clippy::needless_bitwise_bool, reason = "without branches the loop is vectorised")]
    pub(super) fn mark_valid<S: Simd>(&self, _: S, limit: f32, in_sight: &[f32], valid: &mut [u8]) {
        let (left, right) = (&self.across[..valid.len()], &self.across[1..]);
        let sides = left.iter().zip(right).zip(self.above.iter().zip(&self.below));
        for ((valid, in_sight), ((left, right), (above, below))) in valid.iter_mut().zip(in_sight).zip(sides) {
            let widest = larger(larger(*left, *right), larger(*above, *below));
            *valid = u8::from((widest < limit * limit) & (*in_sight > 0.0));
        }
    }

    /// M: the largest finite spacing since row 0, px.
    pub(super) fn largest_px(&self) -> f32 {
        self.largest.iter().fold(0.0f32, |largest, &spacing| largest.max(spacing)).sqrt()
    }
}

#[simd]
fn squared_spacings<S: Simd>(_: S, to: &mut [f32], here: (&[f32], &[f32]), there: (&[f32], &[f32]), step: (f32, f32)) {
    let (here, there) = (here.0.iter().zip(here.1), there.0.iter().zip(there.1));
    for ((to, (u, v)), (u_there, v_there)) in to.iter_mut().zip(here).zip(there) {
        let (dx, dy) = (u_there - u + step.0, v_there - v + step.1);
        let squared = dx * dx + dy * dy;
        // A value that is not a number is a gap, too, and must not get lost in a comparison.
        *to = if squared < f32::INFINITY { squared } else { f32::INFINITY };
    }
}

#[simd]
fn keep_largest<S: Simd>(_: S, largest: &mut [f32], spacings: &[f32]) {
    for (largest, &spacing) in largest.iter_mut().zip(spacings) {
        *largest = if spacing < f32::INFINITY { larger(spacing, *largest) } else { *largest };
    }
}

/// The larger of two numbers: one instruction, whereas `f32::max` also tests for NaN.
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
