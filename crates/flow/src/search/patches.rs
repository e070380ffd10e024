//! The patches of one pyramid level, and the inverse search for their displacements.
//!
//! The displacement `u` of an 8×8 patch of the reference minimises `Σ (I(x + u) − T(x) − mean)²`. It is found by
//! Gauss–Newton in the inverse-compositional form ([Kroeger2016] §3.1, [Baker2004]): the gradient and the 2×2 matrix
//! belong to the template and are computed once per reference. The gradient is a derivative per px, so a step has the
//! full Gauss–Newton length.

use super::differences::differentiate_row;
pub(crate) use super::residual::PATCH;
use super::residual::{PatchGradient, compare};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// A level of the reference prepared for the search.
#[derive(Debug, Clone)]
pub(crate) struct PatchTemplate {
    pub(crate) layout: PatchLayout,
    pub(crate) grey: Image<f32>,
    /// A patch has no texture if its mean structure tensor has an eigenvalue below this, grey levels² per px².
    min_texture: f32,
}

/// Inverse structure tensor of a patch, and the gradient sums that eliminate a change of the mean.
#[derive(Debug, Clone, Copy, Default)]
struct PatchNormal {
    inverse: [f32; 3],
    sum_x: f32,
    sum_y: f32,
    is_textured: bool,
}

/// The positions of the patches of a level: every `stride` px, the last ones at the border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PatchLayout {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) stride: usize,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl PatchLayout {
    /// The layout on a level of this size, which must be at least as large as a patch.
    pub(crate) fn over(width: usize, height: usize, stride: usize) -> Self {
        let count = |size: usize| (size - PATCH).div_ceil(stride) + 1;
        Self { width, height, stride, columns: count(width), rows: count(height) }
    }

    /// Upper left pixel of patch `(i, j)`.
    pub(crate) fn corner(&self, i: usize, j: usize) -> (usize, usize) {
        ((i * self.stride).min(self.width - PATCH), (j * self.stride).min(self.height - PATCH))
    }

    /// Number of patches.
    pub(crate) fn len(&self) -> usize {
        self.columns * self.rows
    }
}

/// A patch's displacement and how well it matches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Match {
    pub(crate) u: f32,
    pub(crate) v: f32,
    /// Mean squared residual without the change of the mean, grey levels²; infinite if the patch was not found.
    pub(crate) error: f32,
}

impl Match {
    /// Whether the patch was found in the current image.
    pub(crate) fn is_found(&self) -> bool {
        self.error.is_finite()
    }
}

/// Gives every patch that was not found the displacement of a neighbour, which may itself have been filled.
pub(crate) fn fill_unfound(layout: &PatchLayout, matches: &mut [Match], filled: &mut [bool]) {
    for (filled, found) in filled.iter_mut().zip(matches.iter()) {
        *filled = found.is_found();
    }
    let mut take = |node: usize, neighbours: [Option<usize>; 2]| {
        if !filled[node]
            && let Some(from) = neighbours.into_iter().flatten().find(|&from| filled[from])
        {
            (matches[node].u, matches[node].v) = (matches[from].u, matches[from].v);
            filled[node] = true;
        }
    };
    let columns = layout.columns;
    for node in 0..layout.len() {
        take(node, [(node % columns > 0).then(|| node - 1), node.checked_sub(columns)]);
    }
    for node in (0..layout.len()).rev() {
        let below = node + columns;
        take(node, [((node + 1) % columns > 0).then_some(node + 1), (below < layout.len()).then_some(below)]);
    }
}

impl PatchTemplate {
    /// An empty template over a level.
    pub(crate) fn new(layout: PatchLayout) -> Self {
        Self { layout, grey: Image::filled(layout.width, layout.height, 0.0), min_texture: 0.0 }
    }

    /// Prepares a new reference.
    pub(crate) fn prepare(&mut self, grey: &Image<f32>, min_texture: f32) {
        self.grey.copy_from(grey);
        self.min_texture = min_texture;
    }

    /// The gradient of a patch.
    #[inline(always)]
    fn gradient(&self, (left, top): (usize, usize)) -> PatchGradient {
        let mut gradient = PatchGradient { x: [[0.0; PATCH]; PATCH], y: [[0.0; PATCH]; PATCH] };
        for (k, (x, y)) in gradient.x.iter_mut().zip(&mut gradient.y).enumerate() {
            differentiate_row(&self.grey, top + k, left, x, y);
        }
        gradient
    }
}

impl PatchNormal {
    /// That of a patch with this gradient.
    #[inline(always)]
    fn of(PatchGradient { x, y }: &PatchGradient, min_texture: f32) -> Self {
        let (mut xx, mut xy, mut yy, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (row_x, row_y) in x.iter().zip(y) {
            for (gx, gy) in row_x.iter().zip(row_y) {
                xx += gx * gx;
                xy += gx * gy;
                yy += gy * gy;
                sum_x += gx;
                sum_y += gy;
            }
        }
        let n = (PATCH * PATCH) as f32;
        let (xx, xy, yy) = (xx - sum_x * sum_x / n, xy - sum_x * sum_y / n, yy - sum_y * sum_y / n);
        let determinant = xx * yy - xy * xy;
        let smallest = 0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        if smallest <= n * min_texture || determinant <= 0.0 {
            return Self { is_textured: false, ..Self::default() };
        }
        let inverse = [yy / determinant, -xy / determinant, xx / determinant];
        Self { inverse, sum_x, sum_y, is_textured: true }
    }
}

/// The parameters of the search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchRules {
    /// Largest number of Gauss–Newton steps.
    pub(crate) iterations: usize,
    /// The search ends when a step is shorter than this, px.
    pub(crate) tolerance: f32,
    /// Reach of the exhaustive search, px; 0 for none.
    pub(crate) reach: i32,
}

/// Searches one patch from the best of several starts.
///
/// If the steps do not converge, if the patch moves farther than its own width from the start, or if it leaves the
/// image, the result is the best displacement so far. A patch without texture keeps the best start.
#[simd]
pub(crate) fn search<S: Simd>(
    simd: S,
    template: &PatchTemplate,
    current: &Image<f32>,
    (i, j): (usize, usize),
    starts: &[(f32, f32)],
    rules: SearchRules,
) -> Match {
    let corner = template.layout.corner(i, j);
    let gradient = template.gradient(corner);
    let normal = PatchNormal::of(&gradient, template.min_texture);
    let mut start = Match { u: starts[0].0, v: starts[0].1, error: f32::INFINITY };
    for &(u, v) in starts {
        let error =
            compare(simd, &template.grey, current, corner, (u, v), None).map_or(f32::INFINITY, |sums| sums.error());
        if error < start.error {
            start = Match { u, v, error };
        }
    }
    if !normal.is_textured {
        return start;
    }
    let mut best = start;
    let (mut u, mut v) = (start.u, start.v);
    for _ in 0..rules.iterations {
        let Some(sums) = compare(simd, &template.grey, current, corner, (u, v), Some(&gradient)) else { break };
        let error = sums.error();
        if error < best.error {
            best = Match { u, v, error };
        }
        let mean = sums.residual / (PATCH * PATCH) as f32;
        let (bx, by) = (sums.gradient_x - mean * normal.sum_x, sums.gradient_y - mean * normal.sum_y);
        let [xx, xy, yy] = normal.inverse;
        let (du, dv) = (xx * bx + xy * by, xy * bx + yy * by);
        u -= du;
        v -= dv;
        let is_too_far = (u - start.u).abs().max((v - start.v).abs()) > PATCH as f32;
        if is_too_far || !(u.is_finite() && v.is_finite()) {
            break;
        }
        if du.abs().max(dv.abs()) < rules.tolerance {
            // Converged: this displacement is the right one, although bilinear sampling may have less error at a whole
            // pixel.
            (best.u, best.v) = (u, v);
            break;
        }
    }
    best
}

/// Exhaustive search: compares a patch at all displacements that differ from a start by a whole number of px, up to
/// `reach` along each axis. Returns the one that matches best; the start if the patch is outside the image at all of
/// them.
#[simd]
pub(crate) fn search_exhaustively<S: Simd>(
    simd: S,
    template: &PatchTemplate,
    current: &Image<f32>,
    (i, j): (usize, usize),
    start: (f32, f32),
    reach: i32,
) -> (f32, f32) {
    let corner = template.layout.corner(i, j);
    let mut best = (start, f32::INFINITY);
    for down in -reach..=reach {
        for right in -reach..=reach {
            let shifted = (start.0 + right as f32, start.1 + down as f32);
            let error = compare(simd, &template.grey, current, corner, shifted, None)
                .map_or(f32::INFINITY, |sums| sums.error());
            if error < best.1 {
                best = (shifted, error);
            }
        }
    }
    best.0
}

/// Searches a patch again from two starts, if one of them matches better than the result so far.
#[simd]
pub(crate) fn improve<S: Simd>(
    simd: S,
    template: &PatchTemplate,
    current: &Image<f32>,
    patch: (usize, usize),
    found: &Match,
    starts: [(f32, f32); 2],
    rules: SearchRules,
) -> Match {
    let corner = template.layout.corner(patch.0, patch.1);
    let is_better = |&start: &(f32, f32)| {
        // A neighbour with a similar displacement gives no new start.
        let differs = (start.0 - found.u).abs().max((start.1 - found.v).abs()) > 0.5;
        differs
            && compare(simd, &template.grey, current, corner, start, None)
                .is_some_and(|sums| sums.error() < found.error)
    };
    if !starts.iter().any(is_better) {
        return *found;
    }
    let new = search(simd, template, current, patch, &starts, rules);
    if new.error < found.error { new } else { *found }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    fn wave(dx: f32, dy: f32) -> Image<f32> {
        Image::from_fn(40, 40, |x, y| {
            let (x, y) = (x as f32 - dx, y as f32 - dy);
            100.0 + 40.0 * (0.5 * x + 0.2 * y).sin() + 30.0 * (0.55 * y - 0.15 * x).cos()
        })
    }

    #[test]
    fn a_patch_finds_its_displacement_in_five_steps() {
        let mut template = PatchTemplate::new(PatchLayout::over(40, 40, 4));
        template.prepare(&wave(0.0, 0.0), 0.1);
        let current = wave(1.3, -0.8);
        let rules = SearchRules { iterations: 5, tolerance: 1e-3, reach: 0 };
        let found = dispatch!(Level::new(), simd => search(simd, &template, &current, (3, 4), &[(0.0, 0.0)], rules));
        assert!((found.u - 1.3).abs() < 0.03 && (found.v + 0.8).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_patch_without_texture_stays_at_its_start() {
        let flat = Image::filled(40, 40, 77.0);
        let mut template = PatchTemplate::new(PatchLayout::over(40, 40, 4));
        template.prepare(&flat, 0.1);
        let rules = SearchRules { iterations: 5, tolerance: 1e-3, reach: 0 };
        let found = dispatch!(Level::new(), simd => search(simd, &template, &flat, (3, 4), &[(0.5, 0.25)], rules));
        assert_eq!((found.u, found.v), (0.5, 0.25));
    }

    #[test]
    fn a_patch_outside_the_image_is_not_found() {
        let mut template = PatchTemplate::new(PatchLayout::over(40, 40, 4));
        template.prepare(&wave(0.0, 0.0), 0.1);
        let current = wave(0.0, 0.0);
        let rules = SearchRules { iterations: 5, tolerance: 1e-3, reach: 0 };
        for start in [(-50.0, 0.0), (0.0, f32::NAN), (f32::INFINITY, 0.0)] {
            let found = dispatch!(Level::new(), simd => search(simd, &template, &current, (3, 4), &[start], rules));
            assert!(found.error.is_infinite(), "{start:?}: {found:?}");
        }
    }
}
