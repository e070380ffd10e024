//! A part of the image by many rays, where the surface hides some of itself.

use super::cells::Place;
use super::lattice::{LANES, Lattice, Rays};
use super::parts::Sight;
use super::patches::Patches;
use super::raster::{Seen, Target};
use super::surface::Surface;
use fearless_simd::{Simd, f32x8, prelude::*};

/// Rays a part: an edge in any direction is placed within about 1/64 of a part.
const RAYS: usize = LANES * LANES;

/// A number that spreads `k · SPREAD mod RAYS` evenly: no two rays share a column or a row of the part.
const SPREAD: usize = 27;

/// Where in a part its rays go through it.
#[derive(Debug, Clone)]
pub(crate) struct Samples {
    x: [[f32; LANES]; LANES],
    y: [[f32; LANES]; LANES],
}

/// What the rays may meet.
pub(crate) struct Scene<'a> {
    pub(crate) surface: &'a Surface,
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

    /// Mean colour of what a part's rays meet first.
    #[inline(never)]
    pub(crate) fn colour<S: Simd>(&self, simd: S, sight: &Sight, scene: &Scene, part: (usize, usize)) -> [f32; 4] {
        let mut seen = [Seen::nothing(simd); LANES];
        let slopes: [[f32x8<S>; 2]; LANES] =
            std::array::from_fn(|block| self.slopes(simd, sight.lattice, scene.rays, part, block));
        for (column, row) in sight.patches.around(part) {
            let beyond = Patches::beyond(scene.surface, column, row);
            let target = Target::new(&scene.surface.patch(column, row), beyond);
            for (seen, &slope) in seen.iter_mut().zip(&slopes) {
                target.meet(simd, slope, seen);
            }
        }
        let mut sum = [0.0; 4];
        for seen in &seen {
            for lane in 0..LANES {
                let colour = shade(sight, [seen.x[lane], seen.y[lane]], seen.gain[lane]);
                sum.iter_mut().zip(colour).for_each(|(sum, level)| *sum += level);
            }
        }
        let [red, green, blue, _] = sum.map(|sum| sum / RAYS as f32);
        [red, green, blue, 0.0]
    }

    #[inline(always)]
    fn slopes<S: Simd>(
        &self,
        simd: S,
        lattice: Lattice,
        rays: &Rays,
        (column, row): (usize, usize),
        block: usize,
    ) -> [f32x8<S>; 2] {
        let corner = row * lattice.stride + column;
        let (x, y) = (f32x8::load_array(simd, self.x[block]), f32x8::load_array(simd, self.y[block]));
        [&rays.x, &rays.y].map(|slopes| {
            let [a, b] = [slopes[corner], slopes[corner + 1]];
            let [c, d] = [slopes[corner + lattice.stride], slopes[corner + lattice.stride + 1]];
            let splat = |value: f32| f32x8::splat(simd, value);
            let above = x.mul_add(b - a, splat(a));
            let below = x.mul_add(d - c, splat(c));
            y.mul_add(below - above, above)
        })
    }
}

/// The colour of a point at rest, mm, in its light.
fn shade(sight: &Sight, [x, y]: [f32; 2], gain: f32) -> [f32; 3] {
    let [[left, right], [top, bottom]] = sight.cells.borders_mm();
    if (left..=right).contains(&f64::from(x)) && (top..=bottom).contains(&f64::from(y)) {
        let [u, v] = sight.cells.by_mm();
        let place = Place::new(u[0] * x + u[1] * y + u[2], v[0] * x + v[1] * y + v[2]);
        sight.cells.colour(place).map(|level| level * gain)
    } else {
        sight.background
    }
}
