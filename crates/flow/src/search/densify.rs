//! Turns sparse patch displacements into a dense field.
//!
//! Every pixel averages the displacements of the patches that cover it, each weighted by the inverse of its photometric
//! error there, `1/max(1, |I(x + u) − T(x)|)`: a patch that explains a pixel well has more weight. [Kroeger2016], eq.
//! (3).
//!
//! Patches that were not found have almost no weight: a pixel takes their displacement only where no other patch covers
//! it.

use super::patches::{Match, PATCH, PatchTemplate};
use crate::FlowField;
use fearless_simd::{Simd, f32x8, prelude::*};
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// Averages patch displacements; contains the sum of the weights at every pixel.
#[derive(Debug, Clone)]
pub(crate) struct Densifier {
    weight: Image<f32>,
}

impl Densifier {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { weight: Image::filled(width, height, 0.0) }
    }

    /// Writes the mean of the matches into `flow`.
    #[simd]
    pub(crate) fn densify<S: Simd>(
        &mut self,
        simd: S,
        template: &PatchTemplate,
        current: &Image<f32>,
        matches: &[Match],
        flow: &mut FlowField,
    ) {
        self.weight.values_mut().fill(0.0);
        flow.fill(0.0);
        for j in 0..template.layout.rows {
            for i in 0..template.layout.columns {
                let found = matches[j * template.layout.columns + i];
                self.add_patch(simd, template, current, template.layout.corner(i, j), found, flow);
            }
        }
        let weights = self.weight.values();
        for plane in [&mut flow.u, &mut flow.v] {
            for (value, weight) in plane.values_mut().iter_mut().zip(weights) {
                *value /= weight;
            }
        }
    }

    #[inline(always)]
    fn add_patch<S: Simd>(
        &mut self,
        simd: S,
        template: &PatchTemplate,
        current: &Image<f32>,
        (left, top): (usize, usize),
        found: Match,
        flow: &mut FlowField,
    ) {
        let patch_weight = if found.is_found() { 1.0 } else { 1e-6 };
        let (width, height) = current.size();
        let x = (left as f32 + found.u).clamp(0.0, (width - PATCH - 1) as f32);
        let y = (top as f32 + found.v).clamp(0.0, (height - PATCH - 1) as f32);
        let (column, row) = (x as usize, y as usize);
        let (fx, fy) = (x - column as f32, y - row as f32);
        for k in 0..PATCH {
            let load = |row: usize, shift: usize| f32x8::from_slice(simd, &current.row(row)[column + shift..][..PATCH]);
            let above = (load(row + k, 1) - load(row + k, 0)).mul_add(fx, load(row + k, 0));
            let below = (load(row + k + 1, 1) - load(row + k + 1, 0)).mul_add(fx, load(row + k + 1, 0));
            let sample = (below - above).mul_add(fy, above);
            let residual = sample - f32x8::from_slice(simd, &template.grey.row(top + k)[left..][..PATCH]);
            let weight = f32x8::splat(simd, patch_weight) / residual.abs().max(1.0);
            let add = |image: &mut Image<f32>, value: f32| {
                let target = &mut image.row_mut(top + k)[left..][..PATCH];
                weight.mul_add(value, f32x8::from_slice(simd, target)).store_slice(target);
            };
            add(&mut self.weight, 1.0);
            add(&mut flow.u, found.u);
            add(&mut flow.v, found.v);
        }
    }
}
