//! A bilinear patch of the surface and its exact intersection with a camera's ray.
//!
//! Relative to the camera the patch is `P = a + s b + t c + s t e` with s and t from 0 to 1. A ray consists of the points
//! whose x and y are `m` times their distance down, so `r(P) = P_xy − m P_z` vanishes at the intersection. The cross
//! product of `r(a) + s r(b) + t (r(c) + s r(e)) = 0` with the last bracket gives a quadratic equation in s alone; t
//! follows. The patch is not approximated by triangles, and perspective needs no correction.
//!
//! The sign of the determinant `det(P, ∂P/∂s, ∂P/∂t)` shows which side faces the camera. It is bilinear in s and t too,
//! so a patch whose four corners face the camera does so everywhere and intersects a ray at most once. Where the surface
//! folds back, a patch does not.

use super::node::{Node, cross};

/// Distance beyond its border up to which a patch still counts, as a share of its width: so no ray passes between two
/// patches.
pub(crate) const SLACK: f64 = 1e-4;

/// A patch is regular if its determinant varies by less than this factor.
const MILD: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patch {
    /// a, b, c and e: along x, along y and down from the camera, mm.
    pub(crate) terms: [[f64; 3]; 4],
    /// At rest: the corner, the vector along s and the vector along t, mm.
    pub(crate) rest_mm: [[f64; 2]; 3],
    /// Gain of the light, by 1, s, t and s t.
    pub(crate) gain: [f64; 4],
    /// Whether every point of it faces the camera.
    pub(crate) is_regular: bool,
    /// Whether it is regular and nearly uniform: then it is always the same one of the two roots that counts.
    pub(crate) is_mild: bool,
}

/// An intersection of a ray and a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    /// Distance down from the camera, mm.
    pub(crate) down_mm: f64,
    /// The surface point, at rest, mm.
    pub(crate) rest_mm: [f64; 2],
    /// Gain of the light there.
    pub(crate) gain: f64,
}

impl Patch {
    /// The patch between four nodes (upper left, upper right, lower left, lower right) and its least and greatest
    /// place at rest.
    pub(crate) fn new(corners: [&Node; 4], [least, most]: [[f64; 2]; 2]) -> Self {
        let terms = bilinear(corners.map(|node| node.place));
        let gain = bilinear(corners.map(|node| [node.gain])).map(|[gain]| gain);
        let determinants = determinants(&terms);
        let (low, high) =
            determinants.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &d| (low.min(d), high.max(d)));
        let rest_mm = [least, [most[0] - least[0], 0.0], [0.0, most[1] - least[1]]];
        let patch = Self { terms, rest_mm, gain, is_regular: low > 0.0, is_mild: low > 0.0 && high < MILD * low };
        if patch.is_mild || !patch.is_narrow_along_t() { patch } else { patch.transposed() }
    }

    /// All intersections with the ray of slope `m`.
    pub(crate) fn meetings(&self, slope: [f64; 2]) -> impl Iterator<Item = Meeting> + use<> {
        let [a, b, c, e] = self.terms.map(|term| [term[0] - slope[0] * term[2], term[1] - slope[1] * term[2]]);
        let (quadratic, linear, constant) = (cross_2(b, e), cross_2(b, c) + cross_2(a, e), cross_2(a, c));
        let root = (linear * linear - 4.0 * quadratic * constant).sqrt();
        let sum = -0.5 * (linear + root.copysign(linear));
        let [first, second] = [constant / sum, sum / quadratic];
        let patch = *self;
        [first, second].into_iter().filter_map(move |s| {
            let (from, along) = ([a[0] + s * b[0], a[1] + s * b[1]], [c[0] + s * e[0], c[1] + s * e[1]]);
            let t = -(from[0] * along[0] + from[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]);
            let range = -SLACK..=1.0 + SLACK;
            let is_met = range.contains(&s) && range.contains(&t);
            // Points behind the camera do not count.
            is_met.then(|| patch.at(s, t)).filter(|meeting| meeting.down_mm > 0.0)
        })
    }

    fn at(&self, s: f64, t: f64) -> Meeting {
        let mix = |terms: [f64; 4]| terms[0] + s * terms[1] + t * (terms[2] + s * terms[3]);
        let [corner, along_s, along_t] = self.rest_mm;
        Meeting {
            down_mm: mix(self.terms.map(|term| term[2])),
            rest_mm: [0, 1].map(|axis| corner[axis] + s * along_s[axis] + t * along_t[axis]),
            gain: mix(self.gain),
        }
    }

    /// Whether the patch, as seen by the camera, is narrower along t than along s.
    ///
    /// t results from a division by its own width, so the narrow direction should be s.
    fn is_narrow_along_t(&self) -> bool {
        let [a, b, c, e] = self.terms;
        let slope = [0, 1].map(|axis| (a[axis] + 0.5 * (b[axis] + c[axis])) / (a[2] + 0.5 * (b[2] + c[2])));
        let squared = |term: [f64; 3], other: f64| {
            let seen = [0, 1].map(|axis| term[axis] + other * e[axis] - slope[axis] * (term[2] + other * e[2]));
            seen[0] * seen[0] + seen[1] * seen[1]
        };
        squared(c, 0.0).min(squared(c, 1.0)) < squared(b, 0.0).min(squared(b, 1.0))
    }

    /// The same patch with s and t exchanged.
    fn transposed(self) -> Self {
        let ([a, b, c, e], [corner, s, t], [g, gs, gt, gst]) = (self.terms, self.rest_mm, self.gain);
        Self { terms: [a, c, b, e], rest_mm: [corner, t, s], gain: [g, gt, gs, gst], ..self }
    }
}

/// Coefficients of 1, s, t and s t from the values at the corners.
fn bilinear<const N: usize>([a, b, c, d]: [[f64; N]; 4]) -> [[f64; N]; 4] {
    let minus = |p: [f64; N], q: [f64; N]| std::array::from_fn(|k| p[k] - q[k]);
    let (along_s, along_t): ([f64; N], [f64; N]) = (minus(b, a), minus(c, a));
    [a, along_s, along_t, minus(minus(d, c), along_s)]
}

/// `det(P, ∂P/∂s, ∂P/∂t)` at the corners; positive where the surface faces the camera.
fn determinants(&[a, b, c, e]: &[[f64; 3]; 4]) -> [f64; 4] {
    let plus = |p: [f64; 3], q: [f64; 3]| [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
    let determinant = |p: [f64; 3], s: [f64; 3], t: [f64; 3]| {
        let normal = cross(s, t);
        p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2]
    };
    let (far_b, far_c) = (plus(b, e), plus(c, e));
    [determinant(a, b, c), determinant(a, b, far_c), determinant(a, far_b, c), determinant(plus(a, b), far_b, far_c)]
}

fn cross_2(p: [f64; 2], q: [f64; 2]) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}
