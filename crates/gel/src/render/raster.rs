//! The surface point at every part corner of the image: the nearest intersection of its ray.

use super::lattice::{Bounds, LANES, Lattice, Rays};
use super::patch::{Patch, SLACK};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use fearless_simd_macros::simd;

/// Points beyond the gel's border count as this much farther away, mm: they never occlude the gel.
const BEYOND_MM: f32 = 1e4;

/// A picture of the surface at the part corners.
#[derive(Debug, Clone)]
pub(crate) struct Planes {
    /// Distance down from the camera, mm; infinite where there is no surface.
    pub(crate) down: Vec<f32>,
    /// The visible point of the surface, at rest, mm; NaN where there is none. It may lie a little beyond the gel's
    /// border.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    /// Gain of the light.
    pub(crate) gain: Vec<f32>,
}

/// A patch prepared for rays near its middle, in single precision.
///
/// Slopes are taken relative to the middle's, so that only small values are subtracted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Target {
    middle: [f32; 2],
    /// The terms a, b, c and e, x and y minus the middle's slope times the distance down.
    terms: [[f32; 3]; 4],
    rest: [[f32; 2]; 3],
    gain: [f32; 4],
    /// Least and greatest valid s and t.
    range: [[f32; 2]; 2],
    is_mild: bool,
}

/// Intersections of eight rays with a patch.
#[derive(Clone, Copy)]
struct Hit<S: Simd> {
    hits: mask32x8<S>,
    s: f32x8<S>,
    t: f32x8<S>,
}

/// The nearest intersections of eight rays so far.
#[derive(Clone, Copy)]
pub(crate) struct Seen<S: Simd> {
    pub(crate) down: f32x8<S>,
    pub(crate) x: f32x8<S>,
    pub(crate) y: f32x8<S>,
    pub(crate) gain: f32x8<S>,
}

impl Planes {
    pub(crate) fn new(lattice: Lattice) -> Self {
        let plane = |value| vec![value; lattice.stride * lattice.rows];
        Self { down: plane(f32::INFINITY), x: plane(f32::NAN), y: plane(f32::NAN), gain: plane(1.0) }
    }

    /// No surface.
    pub(crate) fn clear(&mut self) {
        self.down.fill(f32::INFINITY);
        self.x.fill(f32::NAN);
    }

    /// Rasters a patch over the corners in its bounds.
    #[simd]
    pub(crate) fn draw<S: Simd>(&mut self, simd: S, lattice: Lattice, rays: &Rays, target: &Target, bounds: Bounds) {
        let [columns, rows] = bounds.corners();
        for row in rows {
            for column in columns.clone().step_by(LANES) {
                let from = row * lattice.stride + column;
                let load = |plane: &[f32]| f32x8::from_slice(simd, &plane[from..from + LANES]);
                let slope = [load(&rays.x), load(&rays.y)];
                let mut seen =
                    Seen { down: load(&self.down), x: load(&self.x), y: load(&self.y), gain: load(&self.gain) };
                if target.meet(simd, slope, &mut seen) {
                    seen.down.store_slice(&mut self.down[from..from + LANES]);
                    seen.x.store_slice(&mut self.x[from..from + LANES]);
                    seen.y.store_slice(&mut self.y[from..from + LANES]);
                    seen.gain.store_slice(&mut self.gain[from..from + LANES]);
                }
            }
        }
    }
}

impl<S: Simd> Seen<S> {
    /// No intersection.
    pub(crate) fn nothing(simd: S) -> Self {
        let x = splat(simd, f32::NAN);
        Self { down: splat(simd, f32::INFINITY), x, y: x, gain: splat(simd, 1.0) }
    }
}

impl Target {
    /// The patch, extended beyond its borders by shares of its width: `beyond` are those at the least and the greatest s
    /// and t.
    pub(crate) fn new(patch: &Patch, beyond: [[f64; 2]; 2]) -> Self {
        let [a, b, c, _] = patch.terms;
        let middle = [0, 1].map(|axis| (a[axis] + 0.5 * (b[axis] + c[axis])) / (a[2] + 0.5 * (b[2] + c[2])));
        let single = |value: f64| value as f32;
        Self {
            middle: middle.map(single),
            terms: patch.terms.map(|term| {
                // The middle as stored: what rounding removed from it must be kept.
                let [x, y] = [0, 1].map(|axis| term[axis] - f64::from(middle[axis] as f32) * term[2]);
                [x, y, term[2]].map(single)
            }),
            rest: patch.rest_mm.map(|point| point.map(single)),
            gain: patch.gain.map(single),
            range: beyond.map(|[least, most]| [-SLACK - least, 1.0 + SLACK + most].map(single)),
            is_mild: patch.is_mild,
        }
    }

    /// Takes the patch where it is nearer than the previous result; returns whether it was anywhere.
    #[inline(always)]
    pub(crate) fn meet<S: Simd>(&self, simd: S, slope: [f32x8<S>; 2], seen: &mut Seen<S>) -> bool {
        let [dx, dy] = [slope[0] - self.middle[0], slope[1] - self.middle[1]];
        // Not by `map`: code in the standard library is not compiled for the instruction set.
        let seen_from = |[x, y, down]: [f32; 3]| [dx.mul_add(-down, splat(simd, x)), dy.mul_add(-down, splat(simd, y))];
        let [a, b, c, e] = self.terms;
        let [a, b, c, e] = [seen_from(a), seen_from(b), seen_from(c), seen_from(e)];
        let quadratic = cross(b, e);
        let linear = cross(b, c) + cross(a, e);
        let constant = cross(a, c);
        let root = (linear * linear - quadratic * constant * 4.0).sqrt();
        if self.is_mild {
            let s = (constant * -2.0) / (linear + root);
            return self.take(simd, self.hit(simd, [a, b, c, e], s), seen);
        }
        let sum = (linear + root.copysign(linear)) * -0.5;
        let first = self.take(simd, self.hit(simd, [a, b, c, e], constant / sum), seen);
        let second = self.take(simd, self.hit(simd, [a, b, c, e], sum / quadratic), seen);
        first || second
    }

    #[inline(always)]
    fn hit<S: Simd>(&self, _: S, [a, b, c, e]: [[f32x8<S>; 2]; 4], s: f32x8<S>) -> Hit<S> {
        let from = [s.mul_add(b[0], a[0]), s.mul_add(b[1], a[1])];
        let along = [s.mul_add(e[0], c[0]), s.mul_add(e[1], c[1])];
        let dot = |p: [f32x8<S>; 2], q: [f32x8<S>; 2]| p[0].mul_add(q[0], p[1] * q[1]);
        let t = -dot(from, along) / dot(along, along);
        let [range_s, range_t] = self.range;
        let within = |value: f32x8<S>, range: [f32; 2]| value.simd_ge(range[0]) & value.simd_le(range[1]);
        Hit { hits: within(s, range_s) & within(t, range_t), s, t }
    }

    #[inline(always)]
    fn take<S: Simd>(&self, simd: S, hit: Hit<S>, seen: &mut Seen<S>) -> bool {
        if !hit.hits.any_true() {
            return false;
        }
        let Hit { hits, s, t } = hit;
        let mix = |[one, by_s, by_t, by_both]: [f32; 4]| {
            let rest = s.mul_add(by_both, splat(simd, by_t));
            t.mul_add(rest, s.mul_add(by_s, splat(simd, one)))
        };
        let far = SLACK as f32;
        let beyond = s.simd_lt(-far) | s.simd_gt(1.0 + far) | t.simd_lt(-far) | t.simd_gt(1.0 + far);
        let [a, b, c, e] = self.terms;
        let down = mix([a[2], b[2], c[2], e[2]]);
        let down = beyond.select(down + BEYOND_MM, down);
        // Points behind the camera are not visible.
        let nearer = hits & down.simd_lt(seen.down) & down.simd_gt(0.0);
        let [corner, along_s, along_t] = self.rest;
        let rest = |axis: usize| s.mul_add(along_s[axis], t.mul_add(along_t[axis], splat(simd, corner[axis])));
        seen.down = nearer.select(down, seen.down);
        seen.x = nearer.select(rest(0), seen.x);
        seen.y = nearer.select(rest(1), seen.y);
        seen.gain = nearer.select(mix(self.gain), seen.gain);
        true
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

#[inline(always)]
fn cross<S: Simd>(p: [f32x8<S>; 2], q: [f32x8<S>; 2]) -> f32x8<S> {
    p[0] * q[1] - p[1] * q[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::node::Node;
    use fearless_simd::{Level, dispatch};
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::SeedableRng;

    /// A patch of 0.3 mm, 25 mm below the camera and 10 mm off its axis, with its corners thrown about.
    fn patch(disorder_mm: f64, rng: &mut Pcg64Mcg) -> Patch {
        let corners = [[0.0, 0.0], [0.3, 0.0], [0.0, 0.3], [0.3, 0.3]].map(|[x, y]| {
            let thrown: [f64; 3] =
                std::array::from_fn(|_| disorder_mm * Distribution::<f64>::sample(&StandardNormal, rng));
            let place = [10.0 + x + thrown[0], 5.0 + y + thrown[1], 25.0 + thrown[2]];
            Node { place, px: [0.0; 2], gain: 1.0 + x }
        });
        let [a, b, c, d] = &corners;
        Patch::new([a, b, c, d], [[10.0, 5.0], [10.3, 5.3]])
    }

    #[test]
    fn eight_rays_meet_what_each_of_them_meets() {
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let [mut met, mut folded] = [0; 2];
        for trial in 0..400 {
            let patch = patch([0.0, 0.03, 0.2, 1.0][trial % 4], &mut rng);
            folded += u32::from(!patch.is_regular);
            let [x, y] = [0, 1].map(|axis| {
                std::array::from_fn::<f32, LANES, _>(|lane| {
                    let place = patch.terms[0][axis] + 0.3 * ((lane * [1, 3][axis]) as f64 % 8.0) / 8.0;
                    (place / patch.terms[0][2]) as f32
                })
            });
            let seen = dispatch!(Level::new(), simd => {
                let mut seen = Seen::nothing(simd);
                let slope = [f32x8::load_array(simd, x), f32x8::load_array(simd, y)];
                Target::new(&patch, [[0.0; 2]; 2]).meet(simd, slope, &mut seen);
                [seen.down.to_array(), seen.x.to_array(), seen.y.to_array(), seen.gain.to_array()]
            });
            for lane in 0..LANES {
                let meetings = patch.meetings([x[lane], y[lane]].map(f64::from));
                let nearest = meetings.min_by(|a, b| a.down_mm.total_cmp(&b.down_mm));
                let [down, x, y, gain] = seen.map(|values| f64::from(values[lane]));
                let Some(nearest) = nearest else { continue };
                // At a patch's very border one may meet it and the other not.
                if down.is_infinite() {
                    let [s, t] = [0, 1].map(|axis| (nearest.rest_mm[axis] - [10.0, 5.0][axis]) / 0.3);
                    let inside = |share: f64| (1e-3..1.0 - 1e-3).contains(&share);
                    assert!(!(inside(s) && inside(t)), "trial {trial}: nothing, expected {nearest:?}");
                    continue;
                }
                met += 1;
                let miss = (x - nearest.rest_mm[0]).hypot(y - nearest.rest_mm[1]);
                // Where a ray grazes a fold, single precision moves the point along it.
                let tolerance = if patch.is_mild { 2e-5 } else { 5e-3 };
                assert!(miss < tolerance, "trial {trial}: ({x}, {y}), expected {nearest:?}");
                assert!(
                    (down - nearest.down_mm).abs() < 10.0 * tolerance && (gain - nearest.gain).abs() < 5.0 * tolerance
                );
            }
        }
        assert!(met > 1000 && folded > 50, "{met} meetings, {folded} folded patches");
    }
}
