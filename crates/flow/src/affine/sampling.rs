//! The current picture between its pixels: cubic B-splines on 4×4 px, sixteen points at a time.
//!
//! If sixteen neighbours in a row move alike, their taps are read as whole registers; otherwise those of eight, and where the flow
//! varies still more, point by point. All ways give the same bits: a tap that a point does not need has the weight zero.

use super::grid::LANES;
use super::places::{Places, SHARED, SharedTaps, Taps};
use fearless_simd::{Simd, f32x4, f32x16, prelude::*};
use fingervision_image::Image;

/// The channels of a picture at neighbours in a row.
#[inline(always)]
pub(super) fn sample_row<S: Simd, const CHANNELS: usize>(
    simd: S,
    channels: [&Image<f32>; CHANNELS],
    places: &Places<S>,
) -> [f32x16<S>; CHANNELS] {
    let size = channels[0].size();
    let mut samples = [f32x16::splat(simd, 0.0); CHANNELS];
    if let Some(taps) = places.shared_taps(simd, size) {
        for channel in 0..CHANNELS {
            samples[channel] = taps.sample(simd, channels[channel]);
        }
        return samples;
    }
    if let Some([left, right]) = places.taps_of_halves(simd, size) {
        for channel in 0..CHANNELS {
            let halves = (left.sample(simd, channels[channel]), right.sample(simd, channels[channel]));
            samples[channel] = simd.combine_f32x8(halves.0, halves.1);
        }
        return samples;
    }
    sample(simd, channels, places)
}

/// The channels of a picture at any points.
#[inline(always)]
pub(super) fn sample<S: Simd, const CHANNELS: usize>(
    simd: S,
    channels: [&Image<f32>; CHANNELS],
    places: &Places<S>,
) -> [f32x16<S>; CHANNELS] {
    let stride = channels[0].width();
    let Taps { base, weights_x, weights_y } = places.taps(stride);
    let weights_y: [[f32; LANES]; 4] = weights_y.map(SimdBase::to_array);
    let mut columns = [[[0.0f32; 4]; LANES]; CHANNELS];
    for k in 0..LANES {
        let first = base[k] as usize;
        for channel in 0..CHANNELS {
            let rows = &channels[channel].values()[first..][..3 * stride + 4];
            let mut sum = f32x4::from_slice(simd, &rows[..4]) * weights_y[0][k];
            for j in 1..4 {
                sum = f32x4::from_slice(simd, &rows[j * stride..][..4]).mul_add(weights_y[j][k], sum);
            }
            columns[channel][k] = sum.to_array();
        }
    }
    let mut samples = [f32x16::splat(simd, 0.0); CHANNELS];
    for channel in 0..CHANNELS {
        let columns = transpose(simd, &columns[channel]);
        let mut sum = columns[0] * weights_x[0];
        for i in 1..4 {
            sum = columns[i].mul_add(weights_x[i], sum);
        }
        samples[channel] = sum;
    }
    samples
}

impl<F> SharedTaps<F> {
    /// A channel of the picture at the points.
    #[inline(always)]
    fn sample<S: Simd>(&self, simd: S, channel: &Image<f32>) -> F
    where
        F: SimdFloat<S, Element = f32>,
    {
        let (stride, values) = (channel.width(), &channel.values()[self.start..]);
        let mut rows = [values; SHARED];
        for (row, values) in rows.iter_mut().enumerate() {
            *values = &values[row * stride..][..F::LEN + SHARED - 1];
        }
        let mut sum = F::splat(simd, 0.0);
        for (column, &weight) in self.weights_x.iter().enumerate() {
            let mut down = F::from_slice(simd, &rows[0][column..][..F::LEN]) * self.weights_y[0];
            for row in 1..SHARED {
                down = F::from_slice(simd, &rows[row][column..][..F::LEN]).mul_add(self.weights_y[row], down);
            }
            sum = down.mul_add(weight, sum);
        }
        sum
    }
}

/// Sixteen quadruples as four registers, one of all their first values, one of all their second, and so on.
#[inline(always)]
fn transpose<S: Simd>(simd: S, quadruples: &[[f32; 4]; LANES]) -> [f32x16<S>; 4] {
    let values = quadruples.as_flattened();
    let load = |k: usize| f32x16::from_slice(simd, &values[LANES * k..][..LANES]);
    let (even_low, odd_low) = load(0).deinterleave(load(1));
    let (even_high, odd_high) = load(2).deinterleave(load(3));
    let (first, third) = even_low.deinterleave(even_high);
    let (second, fourth) = odd_low.deinterleave(odd_high);
    [first, second, third, fourth]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    const SIZE: (usize, usize) = (40, 12);

    /// How the taps of neighbours are read.
    #[derive(Debug, PartialEq)]
    enum TapsRead {
        Together,
        InHalves,
        Singly,
    }

    /// Samples neighbours from a column on, displaced by `motion`; returns how their taps are read.
    fn check(row: f32, first: f32, motion: impl Fn(usize) -> [f32; 2]) -> TapsRead {
        let picture =
            |seed: usize| Image::from_fn(SIZE.0, SIZE.1, move |x, y| ((37 * x + seed * y + 5 * x * y) % 251) as f32);
        let pictures = [picture(101), picture(59), picture(7)];
        let x: [f32; LANES] = std::array::from_fn(|k| first + k as f32 + motion(k)[0]);
        let y: [f32; LANES] = std::array::from_fn(|k| row + motion(k)[1]);
        dispatch!(Level::new(), simd => {
            let places = Places::of(f32x16::load_array(simd, x), f32x16::load_array(simd, y), SIZE);
            let inside = places.inside(simd).to_array();
            let single = sample(simd, pictures.each_ref(), &places).map(SimdBase::to_array);
            let found = sample_row(simd, pictures.each_ref(), &places).map(SimdBase::to_array);
            for k in 0..LANES {
                let is_inside = (1.0..=SIZE.0 as f32 - 2.0).contains(&x[k]) && (1.0..=SIZE.1 as f32 - 2.0).contains(&y[k]);
                assert_eq!(inside[k].to_bits(), f32::from(u8::from(is_inside)).to_bits(), "at {} {}", x[k], y[k]);
                for channel in 0..3 {
                    let [found, single] = [found[channel][k], single[channel][k]];
                    assert!(!is_inside || found.to_bits() == single.to_bits(), "at {} {}: {found}, {single}", x[k], y[k]);
                }
            }
            match (places.shared_taps(simd, SIZE), places.taps_of_halves(simd, SIZE)) {
                (Some(_), _) => TapsRead::Together,
                (None, Some(_)) => TapsRead::InHalves,
                (None, None) => TapsRead::Singly,
            }
        })
    }

    #[test]
    fn neighbours_that_move_alike_share_their_taps_and_have_the_same_bits() {
        // A small motion to both sides of a pixel, as at rest.
        let around = |k: usize| if k.is_multiple_of(3) { [0.003, -0.002] } else { [-0.004, 0.001] };
        assert_eq!(check(5.0, 9.0, around), TapsRead::Together);
        assert_eq!(check(5.0, 9.0, |k| [3.7 + 0.05 * k as f32, -2.2 + 0.04 * k as f32]), TapsRead::Together);
        assert_eq!(check(5.0, 9.0, |_| [-6.25, 2.5]), TapsRead::Together);
    }

    #[test]
    fn neighbours_whose_motions_differ_are_read_in_halves_or_singly() {
        assert_eq!(check(5.0, 9.0, |k| [0.15 * k as f32, 0.0]), TapsRead::InHalves);
        assert_eq!(check(4.0, 9.0, |k| [0.0, 2.0 - 0.12 * k as f32]), TapsRead::InHalves);
        assert_eq!(check(5.0, 9.0, |k| [0.4 * k as f32, 0.0]), TapsRead::Singly);
        assert_eq!(check(3.0, 9.0, |k| [0.0, 0.3 * k as f32]), TapsRead::Singly);
    }

    #[test]
    fn points_beyond_the_border_are_outside_and_those_beside_them_are_right() {
        assert_eq!(check(5.0, -4.0, |_| [0.25, 0.25]), TapsRead::Together);
        assert_eq!(check(5.0, 30.0, |_| [0.25, 0.25]), TapsRead::Together);
        // No pixel before the first row, none after the last one.
        assert_eq!(check(1.0, -4.0, |_| [0.25, 0.25]), TapsRead::Singly);
        assert_eq!(check(8.0, 9.0, |_| [0.25, 1.25]), TapsRead::Singly);
        assert_eq!(check(-9.0, 9.0, |_| [0.0, 0.0]), TapsRead::Singly);
        check(5.0, 9.0, |k| if k == 3 { [f32::NAN, 0.0] } else { [0.5, 0.5] });
    }
}
