//! What follows the sums of a layer: the activation, and writing them.

use fearless_simd::{Simd, f32x16, prelude::*};

use super::plane::{Plane, Rows};
use super::shape::LANES;

/// The operation on the sums of a layer.
#[derive(Debug, Clone, Copy)]
pub(super) enum Activation<'a> {
    /// Nothing.
    Keep,
    /// Negative values become zero.
    Rectify,
    /// Negative values become zero, and the input is added: the layer learns a change.
    RectifyAndAdd,
    /// A plane of half the resolution is added, each of its cells to 2×2, then negative values become zero.
    AddGrownAndRectify(&'a Plane),
}

/// Writes the cells of some rows, given their sums.
#[derive(Debug)]
pub(super) struct Finish<'a> {
    /// The layer's input.
    pub(super) from: &'a Plane,
    pub(super) to: Rows<'a>,
    pub(super) then: Activation<'a>,
}

impl Finish<'_> {
    /// Writes a cell's channels of one block of [`LANES`] outputs.
    #[inline(always)]
    pub(super) fn cell<S: Simd>(&mut self, simd: S, (block, column, row): (usize, usize, usize), sums: f32x16<S>) {
        let (place, first) = ((column, row), block * LANES);
        let zero = f32x16::splat(simd, 0.0);
        let values = match self.then {
            Activation::Keep => sums,
            Activation::Rectify => sums.max(zero),
            Activation::RectifyAndAdd => sums.max(zero) + f32x16::from_slice(simd, self.from.cell(place, first)),
            Activation::AddGrownAndRectify(coarse) => {
                (sums + f32x16::from_slice(simd, coarse.cell((column / 2, row / 2), first))).max(zero)
            }
        };
        values.store_slice(self.to.cell_mut(place, first));
    }
}
