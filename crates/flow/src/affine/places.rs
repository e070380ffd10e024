//! Sixteen points between the pixels of a picture, and the taps of cubic B-splines on 4×4 px around them.

use super::grid::LANES;
use fearless_simd::{Simd, f32x8, f32x16, mask32x16, prelude::*};

/// Largest distance of a point from the part of the picture that has all taps, px, at which it still counts as inside.
const BORDER_PX: f32 = 1.0 / 64.0;

/// Pixels along each axis of which points that share their taps use four each: their motions differ by less than two pixels.
pub(super) const SHARED: usize = 5;

/// Points of half a register.
const HALF: usize = LANES / 2;

/// The lanes' numbers.
const LANE: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// Sixteen points relative to the pixels of a picture.
pub(crate) struct Places<S: Simd> {
    /// The pixel to the upper left of each point: column and row.
    corner: [f32x16<S>; 2],
    /// Distance of each point from there.
    fraction: [f32x16<S>; 2],
    /// Whether the point and its taps lie in the picture. The places of other points are moved into it.
    inside: mask32x16<S>,
}

/// The taps of any sixteen points.
pub(super) struct Taps<S: Simd> {
    /// Index of every point's upper left pixel.
    pub(super) base: [u32; LANES],
    pub(super) weights_x: [f32x16<S>; 4],
    pub(super) weights_y: [f32x16<S>; 4],
}

/// The taps of as many neighbours in a row as a register has lanes, most of which are the same.
pub(super) struct SharedTaps<F> {
    /// Index of the upper left pixel of the first point.
    pub(super) start: usize,
    pub(super) weights_x: [F; SHARED],
    pub(super) weights_y: [F; SHARED],
}

impl<S: Simd> Places<S> {
    /// Any points of a picture of this size.
    #[inline(always)]
    pub(super) fn of(x: f32x16<S>, y: f32x16<S>, (width, height): (usize, usize)) -> Self {
        // NaN is clamped to the lower bound. Its distance from there is NaN, so it counts as outside.
        let (clamped_x, clamped_y) = (clamp(x, width), clamp(y, height));
        let corner = [clamped_x.floor(), clamped_y.floor()];
        let inside = (x - clamped_x).abs().simd_le(BORDER_PX) & (y - clamped_y).abs().simd_le(BORDER_PX);
        Self { corner, fraction: [clamped_x - corner[0], clamped_y - corner[1]], inside }
    }

    /// 1 for every point that lies in the picture with its taps, else 0.
    #[inline(always)]
    pub(super) fn inside(&self, simd: S) -> f32x16<S> {
        self.inside.select(f32x16::splat(simd, 1.0), f32x16::splat(simd, 0.0))
    }

    /// The taps of every point, in a picture of this width.
    #[inline(always)]
    pub(super) fn taps(&self, width: usize) -> Taps<S> {
        let [left, top] = self.corner;
        let base = (top - 1.0) * width as f32 + (left - 1.0);
        Taps {
            base: base.to_int::<fearless_simd::u32x16<S>>().to_array(),
            weights_x: spline_weights(self.fraction[0]),
            weights_y: spline_weights(self.fraction[1]),
        }
    }

    /// The taps of neighbours in a row, displaced pixels one after another, in a picture of this size, if they move alike but for one
    /// column and one row.
    #[inline(always)]
    pub(super) fn shared_taps(&self, simd: S, size: (usize, usize)) -> Option<SharedTaps<f32x16<S>>> {
        let lanes = f32x16::load_array(simd, LANE);
        SharedTaps::find(simd, (lanes, self.corner, self.fraction), self.inside, size)
    }

    /// The same for the first half of the neighbours and for the second.
    #[inline(always)]
    pub(super) fn taps_of_halves(&self, simd: S, size: (usize, usize)) -> Option<[SharedTaps<f32x8<S>>; 2]> {
        let lanes = f32x8::from_slice(simd, &LANE[..HALF]);
        let [(left, other_left), (top, other_top)] = self.corner.map(|corner| simd.split_f32x16(corner));
        let [(x, other_x), (y, other_y)] = self.fraction.map(|fraction| simd.split_f32x16(fraction));
        let (inside, other_inside) = simd.split_mask32x16(self.inside);
        Some([
            SharedTaps::find(simd, (lanes, [left, top], [x, y]), inside, size)?,
            SharedTaps::find(simd, (lanes, [other_left, other_top], [other_x, other_y]), other_inside, size)?,
        ])
    }
}

impl<F> SharedTaps<F> {
    /// The taps of neighbours with these numbers, corners and fractions.
    #[inline(always)]
    fn find<S: Simd>(
        simd: S,
        (lanes, corner, fraction): (F, [F; 2], [F; 2]),
        inside: F::Mask,
        (width, height): (usize, usize),
    ) -> Option<Self>
    where
        F: SimdFloat<S, Element = f32>,
    {
        const FAR: f32 = 1e9;
        let far = F::splat(simd, FAR);
        let along = corner[0] - lanes;
        let [left, top] = [inside.select(along, far).reduce_min(), inside.select(corner[1], far).reduce_min()];
        let shift = [along - left, corner[1] - top];
        let is_shared = shift[0].simd_le(1.0) & shift[1].simd_le(1.0) | !inside;
        if !is_shared.all_true() || left >= FAR {
            return None;
        }
        // Exact: the number of pixels is limited.
        let start = (top - 1.0) * width as f32 + (left - 1.0);
        let end = start + ((SHARED - 1) * width + F::LEN + SHARED - 1) as f32;
        if start < 0.0 || end > (width * height) as f32 {
            return None;
        }
        let weights_x = shifted_weights(simd, fraction[0], shift[0]);
        let weights_y = shifted_weights(simd, fraction[1], shift[1]);
        Some(Self { start: start as u32 as usize, weights_x, weights_y })
    }
}

/// Moves a coordinate to where the taps lie in a picture of this size.
#[inline(always)]
fn clamp<S: Simd>(place: f32x16<S>, size: usize) -> f32x16<S> {
    place.max_precise(1.0).min(size as f32 - 2.0 - BORDER_PX)
}

/// The weights of five taps: four from the first one on, or from the second one where `shift` is 1.
#[inline(always)]
fn shifted_weights<S: Simd, F: SimdFloat<S, Element = f32>>(simd: S, fraction: F, shift: F) -> [F; SHARED] {
    let is_shifted = shift.simd_ge(1.0);
    let [a, b, c, d] = spline_weights(fraction);
    let zero = F::splat(simd, 0.0);
    [
        is_shifted.select(zero, a),
        is_shifted.select(a, b),
        is_shifted.select(b, c),
        is_shifted.select(c, d),
        is_shifted.select(d, zero),
    ]
}

/// Cubic B-spline weights of the taps at −1, 0, 1 and 2 for a fraction `t`.
#[inline(always)]
fn spline_weights<S: Simd, F: SimdFloat<S, Element = f32>>(t: F) -> [F; 4] {
    let s = t * -1.0 + 1.0;
    let (t_squared, s_squared) = (t * t, s * s);
    [
        s_squared * (s * (1.0 / 6.0)),
        t_squared.mul_add(t.mul_add(0.5, -1.0), 2.0 / 3.0),
        s_squared.mul_add(s.mul_add(0.5, -1.0), 2.0 / 3.0),
        t_squared * (t * (1.0 / 6.0)),
    ]
}
