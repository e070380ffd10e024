//! The residual of a patch at a displacement.

use fearless_simd::{Simd, f32x8, prelude::*};
use fingervision_image::Image;

/// Width and height of a patch, px.
pub(crate) const PATCH: usize = 8;

/// The gradient of the pixels of a patch, row by row.
pub(super) struct PatchGradient {
    pub(super) x: [[f32; PATCH]; PATCH],
    pub(super) y: [[f32; PATCH]; PATCH],
}

/// Sums over a patch of the residual `I(x + u) − T(x)`.
pub(super) struct Sums {
    pub(super) residual: f32,
    squared: f32,
    pub(super) gradient_x: f32,
    pub(super) gradient_y: f32,
}

impl Sums {
    pub(super) fn error(&self) -> f32 {
        let n = (PATCH * PATCH) as f32;
        ((self.squared - self.residual * self.residual / n) / n).max(0.0)
    }
}

/// The sums at a displacement, by bilinear sampling, without a gradient those of the residual alone; none if the patch is not
/// completely in the current image.
#[inline(always)]
pub(super) fn compare<S: Simd>(
    simd: S,
    reference: &Image<f32>,
    current: &Image<f32>,
    (left, top): (usize, usize),
    (u, v): (f32, f32),
    gradient: Option<&PatchGradient>,
) -> Option<Sums> {
    let (x, y) = (left as f32 + u, top as f32 + v);
    let (width, height) = current.size();
    let is_inside = x >= 0.0 && y >= 0.0 && x < (width - PATCH) as f32 && y < (height - PATCH) as f32;
    if !is_inside {
        return None;
    }
    let (column, row) = (x as usize, y as usize);
    let (fx, fy) = (x - column as f32, y - row as f32);
    let zero = f32x8::splat(simd, 0.0);
    let (mut residual, mut squared, mut gradient_x, mut gradient_y) = (zero, zero, zero, zero);
    let mut above = between(simd, &current.row(row)[column..], fx);
    for k in 0..PATCH {
        let below = between(simd, &current.row(row + k + 1)[column..], fx);
        let r = (below - above).mul_add(fy, above) - first(simd, &reference.row(top + k)[left..]);
        residual += r;
        squared = r.mul_add(r, squared);
        if let Some(gradient) = gradient {
            gradient_x = r.mul_add(first(simd, &gradient.x[k]), gradient_x);
            gradient_y = r.mul_add(first(simd, &gradient.y[k]), gradient_y);
        }
        above = below;
    }
    Some(Sums {
        residual: residual.reduce_sum(),
        squared: squared.reduce_sum(),
        gradient_x: gradient_x.reduce_sum(),
        gradient_y: gradient_y.reduce_sum(),
    })
}

/// The first values of a row. A function, because a closure lacks the instruction set unless it is inlined.
#[inline(always)]
fn first<S: Simd>(simd: S, row: &[f32]) -> f32x8<S> {
    f32x8::from_slice(simd, &row[..PATCH])
}

/// The first values of a row, sampled at a fraction of a pixel to their right.
#[inline(always)]
fn between<S: Simd>(simd: S, row: &[f32], fraction: f32) -> f32x8<S> {
    let row = &row[..=PATCH];
    let (near, far) = (first(simd, row), first(simd, &row[1..]));
    (far - near).mul_add(fraction, near)
}
