//! Searches the areas of the picture that were lost.
//!
//! The patches that cover a lost cell are searched on every level, from the coarsest to the finest. Each starts from
//! the best of: the matches of the nearest patches on the next coarser level, the guess, its neighbours' matches and,
//! on one level, the result of an exhaustive search. No dense field is computed between the levels, so a motion
//! boundary stays sharp ([Hu2016]). The computing time grows with the number of lost cells, not with the size of the
//! picture.

use super::patches::{Match, PATCH, PatchLayout, PatchTemplate, SearchRules};
use super::sweep::sweep;
use super::{InverseSearch, SearchLevel, SearchReference};
use crate::{FlowField, Picture};
use fearless_simd::{Simd, dispatch};
use fingervision_image::Image;

/// The level of the exhaustive search, and its reach, px on that level: 40 px at full size. In a random pattern only
/// the true displacement matches, and Gauss–Newton steps find it from one or two px away.
const EXHAUSTIVE_LEVEL: usize = 2;
const EXHAUSTIVE_REACH_PX: i32 = 10;

/// Two matches belong to one motion if their displacements differ by less than this, px.
const SAME_MOTION_PX: f32 = 1.5;

/// The matches within this distance from a cell's centre, in cells, give the motion of the cell.
const CELL_REACH: f32 = 1.25;

/// Least number of matches that must agree on a motion.
const LEAST_MATCHES: usize = 4;

/// Square cells over a picture, some of which are lost.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    size_px: usize,
    columns: usize,
    rows: usize,
    is_lost: Vec<bool>,
    /// Summed-area table: number of lost cells above and to the left. The first row and column are zero.
    counts: Vec<u32>,
}

/// The motion in a cell: displacement at its centre, px, and its gradient, dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellMotion {
    pub(crate) displacement: [f32; 2],
    /// `[∂u/∂x, ∂u/∂y]` and the same of v.
    pub(crate) gradient: [[f32; 2]; 2],
}

impl Cells {
    /// Cells of this size, none lost.
    pub(crate) fn new(size_px: usize, columns: usize, rows: usize) -> Self {
        let counts = vec![0; (columns + 1) * (rows + 1)];
        Self { size_px, columns, rows, is_lost: vec![false; columns * rows], counts }
    }

    /// Row by row, which cells are lost.
    pub(crate) fn is_lost(&self) -> &[bool] {
        &self.is_lost
    }

    /// Sets which cells are lost.
    pub(crate) fn mark(&mut self, is_lost: impl Fn(usize) -> bool) {
        for (cell, lost) in self.is_lost.iter_mut().enumerate() {
            *lost = is_lost(cell);
        }
        let width = self.columns + 1;
        for j in 0..self.rows {
            for i in 0..self.columns {
                let at = (j + 1) * width + i + 1;
                let own = u32::from(self.is_lost[j * self.columns + i]);
                self.counts[at] = own + self.counts[at - 1] + self.counts[at - width] - self.counts[at - width - 1];
            }
        }
    }

    /// Whether a square of the picture, extended by a cell on every side, contains a lost cell.
    fn has_lost_near(&self, left: usize, top: usize, size: usize) -> bool {
        let span = |start: usize, cells: usize| {
            let first = (start / self.size_px).saturating_sub(1).min(cells);
            (first, ((start + size).div_ceil(self.size_px) + 1).min(cells))
        };
        let ((left, right), (top, bottom)) = (span(left, self.columns), span(top, self.rows));
        let at = |column: usize, row: usize| self.counts[row * (self.columns + 1) + column];
        at(right, bottom) + at(left, top) > at(left, bottom) + at(right, top)
    }
}

impl InverseSearch {
    /// Searches the patches at the lost cells; read the result with [`InverseSearch::motion_at`]. `guess` is a flow at
    /// full size from before the motion.
    pub(crate) fn search_lost(
        &mut self,
        reference: &SearchReference,
        current: &Picture,
        lost: &Cells,
        guess: &FlowField,
    ) {
        let finest = self.finest_level(current);
        let simd = self.simd;
        for k in (0..self.levels.len()).rev() {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let rules = SearchRules {
                reach: if finest + k == EXHAUSTIVE_LEVEL { EXHAUSTIVE_REACH_PX } else { 0 },
                ..self.params.rules(false)
            };
            let area = Area { lost, guess, level: finest + k };
            let (template, image) = (&reference.templates[k], current.grey.level(finest + k));
            let level = &mut fine[k];
            dispatch!(simd, simd => level.run_lost(simd, template, image, &area, coarse.first(), rules));
        }
    }

    /// The motion at a point of the reference, from the last search of lost cells; none if too few matches agree.
    ///
    /// It is a fit to the largest group of matches within reach that agree. Each match is weighted by how well it
    /// matches.
    pub(crate) fn motion_at(&self, finest: usize, (x, y): (f32, f32), cell_px: usize) -> Option<CellMotion> {
        let level = &self.levels[0];
        let scale = (1u32 << finest) as f32;
        let reach = (CELL_REACH * cell_px as f32).max(PATCH as f32 * scale) / scale;
        let (x, y) = ((x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5);
        let near = || level.layout.near(x, y, reach).map(|(px, py, patch)| (px, py, &level.matches[patch]));
        let found = || near().filter(|(.., found)| found.is_found());
        let apart = |a: &Match, b: &Match| (a.u - b.u).abs().max((a.v - b.v).abs());
        let weight = |found: &Match| 1.0 / (1.0 + found.error);
        // The match with the most votes: the sum of the weights of the matches that agree with it.
        let mut best: Option<(&Match, f32)> = None;
        for (.., centre) in found() {
            let agree = found().filter(|(.., other)| apart(centre, other) < SAME_MOTION_PX);
            let votes: f32 = agree.map(|(.., other)| weight(other)).sum();
            if best.is_none_or(|(_, most)| votes > most) {
                best = Some((centre, votes));
            }
        }
        let (best, _) = best?;
        let group = || found().filter(|(.., other)| apart(best, other) < SAME_MOTION_PX);
        if group().count() < LEAST_MATCHES {
            return None;
        }
        let mut fit = Plane::default();
        for (px, py, found) in group() {
            fit.add([px - x, py - y], [found.u, found.v], weight(found));
        }
        let CellMotion { displacement, gradient } = fit.solve();
        Some(CellMotion { displacement: displacement.map(|d| d * scale), gradient })
    }
}

/// The lost cells and the guess, for one level.
struct Area<'a> {
    lost: &'a Cells,
    guess: &'a FlowField,
    level: usize,
}

impl Area<'_> {
    /// The guess at a pixel of the level.
    fn guess_at(&self, x: usize, y: usize) -> (f32, f32) {
        let scale = 1.0 / (1u32 << self.level) as f32;
        let half = (1usize << self.level) / 2;
        let (x, y) = ((x << self.level) + half, (y << self.level) + half);
        let at = |plane: &Image<f32>| scale * plane.at(x.min(plane.size().0 - 1), y.min(plane.size().1 - 1));
        (at(&self.guess.u), at(&self.guess.v))
    }
}

impl SearchLevel {
    /// Searches the patches near lost cells. All other patches take the guess.
    #[inline(always)]
    fn run_lost<S: Simd>(
        &mut self,
        simd: S,
        template: &PatchTemplate,
        current: &Image<f32>,
        area: &Area<'_>,
        coarse: Option<&Self>,
        rules: SearchRules,
    ) {
        sweep(simd, template, current, rules, &mut self.matches, |(left, top), starts| {
            starts.add(area.guess_at(left + PATCH / 2, top + PATCH / 2));
            let is_near = area.lost.has_lost_near(left << area.level, top << area.level, PATCH << area.level);
            if let Some(coarse) = coarse.filter(|_| is_near) {
                for node in coarse.layout.four_around((left, top)) {
                    let found = coarse.matches[node];
                    starts.add((2.0 * found.u, 2.0 * found.v));
                }
            }
            is_near
        });
    }
}

impl PatchLayout {
    /// The four patches of this level whose centres are nearest to that of a patch on the next finer level.
    fn four_around(&self, (left, top): (usize, usize)) -> [usize; 4] {
        let pair = |corner: usize, count: usize| {
            let place = (corner / 2).saturating_sub(PATCH / 4);
            let first = (place / self.stride).min(count - 1);
            [first, (first + 1).min(count - 1)]
        };
        let ([left, right], [top, bottom]) = (pair(left, self.columns), pair(top, self.rows));
        let at = |column: usize, row: usize| row * self.columns + column;
        [at(left, top), at(right, top), at(left, bottom), at(right, bottom)]
    }

    /// Centre and index of the patches whose centre is at most `reach` px away from a point along both axes.
    fn near(&self, x: f32, y: f32, reach: f32) -> impl Iterator<Item = (f32, f32, usize)> + '_ {
        let range = |place: f32, count: usize| {
            let corner = |centre: f32| (centre - 0.5 * (PATCH - 1) as f32).max(0.0) / self.stride as f32;
            corner(place - reach) as usize..((corner(place + reach) as usize) + 2).min(count)
        };
        let (columns, rows) = (range(x, self.columns), range(y, self.rows));
        rows.flat_map(move |j| columns.clone().map(move |i| (i, j))).filter_map(move |(i, j)| {
            let (left, top) = self.corner(i, j);
            let half = 0.5 * (PATCH - 1) as f32;
            let (px, py) = (left as f32 + half, top as f32 + half);
            ((px - x).abs() <= reach && (py - y).abs() <= reach).then_some((px, py, j * self.columns + i))
        })
    }
}

/// Sums of a weighted least-squares fit of a plane to displacements.
#[derive(Debug, Default)]
struct Plane {
    weight: f32,
    first: [f32; 2],
    second: [f32; 3],
    value: [f32; 2],
    moment: [[f32; 2]; 2],
}

impl Plane {
    fn add(&mut self, [x, y]: [f32; 2], displacement: [f32; 2], weight: f32) {
        self.weight += weight;
        for (sum, term) in self.first.iter_mut().zip([x, y]) {
            *sum += weight * term;
        }
        for (sum, term) in self.second.iter_mut().zip([x * x, x * y, y * y]) {
            *sum += weight * term;
        }
        for (component, d) in displacement.into_iter().enumerate() {
            self.value[component] += weight * d;
            self.moment[component][0] += weight * d * x;
            self.moment[component][1] += weight * d * y;
        }
    }

    /// The plane's value at the origin and its slopes. Slopes that the points do not determine become zero.
    fn solve(&self) -> CellMotion {
        let w = self.weight;
        let [mx, my] = self.first.map(|sum| sum / w);
        // Regularisation by 1 px²: a few points on one line must not determine a slope.
        let xx = self.second[0] / w - mx * mx + 1.0;
        let xy = self.second[1] / w - mx * my;
        let yy = self.second[2] / w - my * my + 1.0;
        let determinant = xx * yy - xy * xy;
        let mut motion = CellMotion { displacement: [0.0; 2], gradient: [[0.0; 2]; 2] };
        for component in 0..2 {
            let mean = self.value[component] / w;
            let [cx, cy] = self.moment[component];
            let (cx, cy) = (cx / w - mx * mean, cy / w - my * mean);
            let slope = [(yy * cx - xy * cy) / determinant, (xx * cy - xy * cx) / determinant];
            motion.gradient[component] = slope;
            motion.displacement[component] = mean - slope[0] * mx - slope[1] * my;
        }
        motion
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_near_the_lost_cells_that_touch_it() {
        let mut cells = Cells::new(8, 10, 7);
        cells.mark(|cell| [0, 34, 69].contains(&cell));
        for (left, top, size) in
            [(0, 0, 8), (16, 0, 8), (24, 24, 8), (40, 24, 8), (8, 30, 16), (72, 48, 8), (56, 40, 8)]
        {
            let expected = (0..70).filter(|cell| cells.is_lost[*cell]).any(|cell| {
                let (x, y) = (8 * (cell % 10), 8 * (cell / 10));
                let touches =
                    |start: usize, at: usize| at + 8 + 8 > start / 8 * 8 && at < (start + size).div_ceil(8) * 8 + 8;
                touches(left, x) && touches(top, y)
            });
            assert_eq!(cells.has_lost_near(left, top, size), expected, "({left}, {top}), {size} px");
        }
    }

    #[test]
    fn a_plane_through_displacements_has_their_slopes() {
        let mut plane = Plane::default();
        for (x, y) in [(-6.0, -6.0), (6.0, -6.0), (-6.0, 6.0), (6.0, 6.0), (20.0, 1.0), (3.0, 15.0)] {
            plane.add([x, y], [1.0 + 0.2 * x, 3.0 - 0.1 * y], 2.0);
        }
        let CellMotion { displacement: [u, v], gradient: [[ux, uy], [vx, vy]] } = plane.solve();
        // The regularisation by 1 px² reduces the slopes by a few percent.
        assert!((u - 1.0).abs() < 0.03 && (v - 3.0).abs() < 0.03, "{u}, {v}");
        assert!((ux - 0.2).abs() < 0.01 && uy.abs() < 0.01 && vx.abs() < 0.01 && (vy + 0.1).abs() < 0.01);
    }
}
