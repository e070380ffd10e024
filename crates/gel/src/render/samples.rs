//! A part of the image by many rays, where the surface occludes some of itself.

use super::cells::Place;
use super::lattice::{LANES, Lattice, Rays};
use super::raster::{Seen, Target};
use super::sight::ColourInputs;
use fearless_simd::{Simd, f32x8, prelude::*};
use fearless_simd_macros::simd;

/// Rays per part: an edge in any direction is located to about 1/64 of a part.
const RAYS: usize = LANES * LANES;

/// A number that spreads `k · SPREAD mod RAYS` evenly: no two rays share a column or a row of the part.
const SPREAD: usize = 27;

/// Positions of the rays within a part.
#[derive(Debug, Clone)]
pub(crate) struct Samples {
    x: [[f32; LANES]; LANES],
    y: [[f32; LANES]; LANES],
}

/// The surface for the rays.
pub(crate) struct Scene<'a> {
    /// Every patch.
    pub(crate) targets: &'a [Target],
    pub(crate) rays: &'a Rays,
}

impl Samples {
    pub(crate) fn new() -> Self {
        let share = |k: usize| (k as f32 + 0.5) / RAYS as f32;
        let ray = |block: usize, lane: usize| block * LANES + lane;
        Self {
            x: std::array::from_fn(|block| std::array::from_fn(|lane| share(ray(block, lane)))),
            y: std::array::from_fn(|block| std::array::from_fn(|lane| share(ray(block, lane) * SPREAD % RAYS))),
        }
    }

    /// Mean colour of the first intersections of a part's rays.
    #[simd]
    pub(crate) fn colour<S: Simd>(
        &self,
        simd: S,
        inputs: &ColourInputs,
        scene: &Scene,
        part: (usize, usize),
    ) -> [f32; 4] {
        let mut seen = [Seen::nothing(simd); LANES];
        let mut slopes = [[f32x8::splat(simd, 0.0); 2]; LANES];
        for (block, slopes) in slopes.iter_mut().enumerate() {
            let corner = part.1 * inputs.lattice.stride + part.0;
            let (x, y) = (f32x8::load_array(simd, self.x[block]), f32x8::load_array(simd, self.y[block]));
            *slopes = [
                mix(simd, x, y, square(&scene.rays.x, corner, inputs.lattice)),
                mix(simd, x, y, square(&scene.rays.y, corner, inputs.lattice)),
            ];
        }
        for patch in inputs.patches.around(part) {
            for (seen, &slope) in seen.iter_mut().zip(&slopes) {
                scene.targets[patch].meet(simd, slope, seen);
            }
        }
        let mut sum = [0.0; 4];
        for seen in &seen {
            for lane in 0..LANES {
                let colour = shade(inputs, [seen.x[lane], seen.y[lane]], seen.gain[lane]);
                sum.iter_mut().zip(colour).for_each(|(sum, level)| *sum += level);
            }
        }
        let [red, green, blue, _] = sum.map(|sum| sum / RAYS as f32);
        [red, green, blue, 0.0]
    }
}

/// The values at a part's corners: upper left, upper right, lower left, lower right.
fn square(values: &[f32], corner: usize, lattice: Lattice) -> [f32; 4] {
    let below = corner + lattice.stride;
    [values[corner], values[corner + 1], values[below], values[below + 1]]
}

/// Bilinear between the corners of a part.
#[inline(always)]
fn mix<S: Simd>(simd: S, x: f32x8<S>, y: f32x8<S>, [a, b, c, d]: [f32; 4]) -> f32x8<S> {
    let above = x.mul_add(b - a, f32x8::splat(simd, a));
    let below = x.mul_add(d - c, f32x8::splat(simd, c));
    y.mul_add(below - above, above)
}

/// The colour of a point at rest, mm, in its light.
fn shade(inputs: &ColourInputs, [x, y]: [f32; 2], gain: f32) -> [f32; 3] {
    let [[left, right], [top, bottom]] = inputs.cells.borders_mm();
    if (left..=right).contains(&f64::from(x)) && (top..=bottom).contains(&f64::from(y)) {
        let [u, v] = inputs.cells.by_mm();
        let place = Place::new(u[0] * x + u[1] * y + u[2], v[0] * x + v[1] * y + v[2]);
        inputs.cells.colour(place).map(|level| level * gain)
    } else {
        inputs.background
    }
}
