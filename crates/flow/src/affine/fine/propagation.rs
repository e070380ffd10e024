//! Failed patches take the motions of matched ones.
//!
//! Where the flow jumps, a patch that starts between the motions of both sides finds neither. After a search every failed patch
//! tries the motions of the matched patches around it, fine and coarse ones, each continued to its place by its gradient, and
//! takes the one that leaves the smallest residual. The patches beside it can then take that motion, too ([Hu2016]).

use super::cell::residuals;
use super::field::FineField;
use super::grid::{CELL, CORNERS, CornerWeights, FineGrid, STRIDE};
use super::node::{FineNode, Motion};
use super::template::FineTemplate;
use crate::ValidityParams;
use crate::affine::grid::{self, PatchGrid, around};
use crate::affine::measurement::Current;
use crate::affine::nodes::NodeField;
use crate::affine::template::Template;
use crate::affine::texel::Texel;
use fearless_simd::Simd;

/// Distance in coarse patches up to which their motions are tried.
const REACH: usize = 2;

/// Most motions that a patch tries. Around a rim there are two or three.
const MOST_TRIED: usize = 12;

/// Motions whose displacements differ by less than this are not tried again, px.
const SAME_PX: f32 = 0.5;

/// A motion is taken if it leaves at most this part of the residual of the patch.
const IMPROVEMENT: f32 = 0.7;

/// Largest residual of a motion that is taken, relative to that of a valid patch. A patch across a rim contains a second motion,
/// which the next steps must explain. Without a limit, walls that no motion explains match by chance.
const MOST_UNEXPLAINED: f32 = 2.0;

/// The coarse patches: their motions, and 1 for each that matched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CoarseMotions<'a> {
    pub(crate) field: &'a NodeField,
    pub(crate) trust: &'a [f32],
}

impl CoarseMotions<'_> {
    /// The motions of the matched patches around a fine node, continued to it.
    fn around(&self, grid: FineGrid, place: usize) -> impl Iterator<Item = Motion> {
        let PatchGrid { columns, rows, .. } = self.field.grid;
        let (i, j) = (place % grid.columns, place / grid.columns);
        let nearest = (j / 2).min(rows - 1) * columns + (i / 2).min(columns - 1);
        let matched = around((columns, rows), nearest, REACH).filter(|&node| self.trust[node] > 0.0);
        matched.map(move |node| {
            let (x, y) = (PatchGrid::centre(node % columns), PatchGrid::centre(node / columns));
            let along = |to: f32, from: f32| (to - from) / grid::STRIDE as f32;
            let motion = std::array::from_fn(|plane| self.field.planes[plane][node]);
            let [u, ux, uy, v, vx, vy] = continued(motion, along(centre(i), x), along(centre(j), y));
            // From slopes per coarse stride to slopes per fine one.
            let [ux, uy, vx, vy] = [ux, uy, vx, vy].map(|slope| slope * (STRIDE as f32 / grid::STRIDE as f32));
            [u, ux, uy, v, vx, vy]
        })
    }
}

/// Image coordinate of fine node `i` along either axis, px.
fn centre(i: usize) -> f32 {
    (STRIDE * i) as f32 + 0.5 * (STRIDE - 1) as f32
}

/// A motion at a point some strides away.
fn continued(mut motion: Motion, dx: f32, dy: f32) -> Motion {
    for first in [0, 3] {
        motion[first] += motion[first + 1] * dx + motion[first + 2] * dy;
    }
    motion
}

/// The motions that a patch has tried, and the best of them.
struct Trials {
    displacements: [[f32; 2]; MOST_TRIED],
    count: usize,
    least: f32,
    best: Option<Motion>,
}

impl Trials {
    /// Takes motions with a residual below this.
    fn below(least: f32) -> Self {
        Self { displacements: [[0.0; 2]; MOST_TRIED], count: 0, least, best: None }
    }

    /// Whether a motion is to be tried; it then counts as tried.
    fn is_new(&mut self, [u, _, _, v, ..]: &Motion) -> bool {
        let is_same = |[tried_u, tried_v]: &[f32; 2]| (u - tried_u).abs().max((v - tried_v).abs()) < SAME_PX;
        if self.count == MOST_TRIED || self.displacements[..self.count].iter().any(is_same) {
            return false;
        }
        self.displacements[self.count] = [*u, *v];
        self.count += 1;
        true
    }

    fn add(&mut self, motion: Motion, residual: f32) {
        if residual < self.least {
            (self.least, self.best) = (residual, Some(motion));
        }
    }
}

/// What the patches are compared with.
pub(super) struct Propagation<'a, T: Texel> {
    pub(super) grid: FineGrid,
    pub(super) weights: &'a CornerWeights<6>,
    pub(super) templates: (&'a Template, &'a FineTemplate),
    pub(super) current: Current<'a, T>,
    pub(super) rules: &'a ValidityParams,
    pub(super) noise_variance: f32,
    pub(super) coarse: CoarseMotions<'a>,
    /// For every node of the grid, its index in the list of nodes.
    pub(super) index: &'a [u32],
}

impl<T: Texel> Propagation<'_, T> {
    /// Sets failed patches to the best motions around them, forwards and backwards through the list of nodes. Returns whether
    /// any was set.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&self, simd: S, field: &mut FineField, nodes: &mut [FineNode]) -> bool {
        let mut is_any_set = false;
        for step in 0..2 * nodes.len() {
            let node = step.min(2 * nodes.len() - 1 - step);
            if nodes[node].is_trusted {
                continue;
            }
            let place = nodes[node].place;
            let own = self.unexplained(simd, place, &field.motions()[place]);
            let mut trials = Trials::below((IMPROVEMENT * own).min(MOST_UNEXPLAINED));
            for near in around((self.grid.columns, self.grid.rows), place, 1) {
                if nodes.get(self.index[near] as usize).is_some_and(|node| node.is_trusted) {
                    let along = |to: usize, from: usize| to as f32 - from as f32;
                    let dx = along(place % self.grid.columns, near % self.grid.columns);
                    let dy = along(place / self.grid.columns, near / self.grid.columns);
                    let motion = continued(field.motions()[near], dx, dy);
                    if trials.is_new(&motion) {
                        trials.add(motion, self.unexplained(simd, place, &motion));
                    }
                }
            }
            for motion in self.coarse.around(self.grid, place) {
                if trials.is_new(&motion) {
                    trials.add(motion, self.unexplained(simd, place, &motion));
                }
            }
            if let Some(motion) = trials.best {
                field.restart(&mut nodes[node], motion);
                is_any_set = true;
            }
        }
        is_any_set
    }

    /// The residual of a patch that moves like this, relative to the largest of a valid patch.
    #[inline(always)]
    fn unexplained<S: Simd>(&self, simd: S, place: usize, motion: &Motion) -> f32 {
        let (template, fine) = self.templates;
        let mut node = FineNode::at(place, 0.0);
        let below = place + self.grid.columns;
        // The node is the lower right corner of the first cell, and so on.
        for (cell, corner) in [place, place + 1, below, below + 1].into_iter().zip((0..CORNERS).rev()) {
            let upper_left = self.grid.upper_left(cell);
            let flow = self.flow(place, motion, upper_left);
            let sums = residuals(simd, template, self.current, self.weights, upper_left, flow);
            for (sum, found) in node.sums.iter_mut().zip(sums[corner]) {
                *sum += found;
            }
        }
        node.unexplained(&fine.equations[place], self.noise_variance, self.rules)
    }

    /// The displacement of a cell's pixels by the motion of a node.
    #[inline(always)]
    fn flow(&self, place: usize, motion: &Motion, (left, top): (usize, usize)) -> [[f32; CELL]; 2] {
        let (x, y) = (centre(place % self.grid.columns), centre(place / self.grid.columns));
        let mut flow = [[0.0; CELL]; 2];
        for pixel in 0..CELL {
            let dx = ((left + pixel % STRIDE) as f32 - x) / STRIDE as f32;
            let dy = ((top + pixel / STRIDE) as f32 - y) / STRIDE as f32;
            let [u, _, _, v, ..] = continued(*motion, dx, dy);
            (flow[0][pixel], flow[1][pixel]) = (u, v);
        }
        flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_motion_is_continued_to_the_fine_nodes_around_it() {
        let (grid, fine) = (PatchGrid::over(64, 48), FineGrid::over(64, 48));
        let mut field = NodeField::zero(grid);
        let node = 2 * grid.columns + 3;
        // One px per coarse stride of 8 px along x, minus two along y.
        for (plane, value) in field.planes.iter_mut().zip([5.0, 1.0, 0.0, 7.0, 0.0, -2.0]) {
            plane[node] = value;
        }
        let mut trust = vec![0.0; grid.plane_len()];
        trust[node] = 1.0;
        let coarse = CoarseMotions { field: &field, trust: &trust };
        for place in 0..fine.nodes() {
            let (i, j) = (place % fine.columns, place / fine.columns);
            let is_near = (i / 2).abs_diff(3) <= REACH && (j / 2).abs_diff(2) <= REACH;
            let found: Vec<Motion> = coarse.around(fine, place).collect();
            let (dx, dy) = (centre(i) - PatchGrid::centre(3), centre(j) - PatchGrid::centre(2));
            let expected = [5.0 + dx / 8.0, 0.5, 0.0, 7.0 - 2.0 * dy / 8.0, 0.0, -1.0];
            assert_eq!(found, if is_near { vec![expected] } else { Vec::new() }, "node ({i}, {j})");
        }
    }

    #[test]
    fn a_motion_is_tried_once_and_taken_if_it_is_better() {
        let motion = |u: f32| [u, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut trials = Trials::below(1.0);
        assert!(trials.is_new(&motion(4.0)));
        trials.add(motion(4.0), 1.5);
        assert_eq!(trials.best, None);
        assert!(!trials.is_new(&motion(4.4)) && trials.is_new(&motion(9.0)));
        trials.add(motion(9.0), 0.5);
        assert_eq!(trials.best, Some(motion(9.0)));
        trials.add(motion(1.0), 0.8);
        assert_eq!(trials.best, Some(motion(9.0)));
        for more in 2..=MOST_TRIED {
            assert_eq!(trials.is_new(&motion(100.0 * more as f32)), more < MOST_TRIED);
        }
    }
}
