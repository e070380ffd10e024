//! Failed patches take the motions of matched ones.
//!
//! Where the flow jumps, a patch that starts between the motions of both sides finds neither. After a search every failed patch
//! tries the motions of the matched patches around it, fine and coarse ones, each continued to its place by its gradient, and
//! takes the one that leaves the smallest residual. The patches beside it can then take that motion, too ([Hu2016]).

use super::cell::residuals;
use super::field::FineField;
use super::grid::{CELL, CORNERS, CornerWeights, FineGrid, STRIDE, WINDOW};
use super::node::{FineNode, Motion};
use super::template::FineTemplate;
use crate::ValidityParams;
use crate::affine::grid::{self, PatchGrid, around};
use crate::affine::nodes::NodeField;
use crate::affine::products::Current;
use crate::affine::template::Template;
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

/// Whether a part of a patch that moves like this has left the picture.
fn leaves(grid: FineGrid, place: usize, motion: &Motion) -> bool {
    const REACH: f32 = 0.5 * (WINDOW - 1) as f32 / STRIDE as f32;
    let (x, y) = (centre(place % grid.columns), centre(place / grid.columns));
    let (right, bottom) = (grid.width as f32 - 1.0, grid.height as f32 - 1.0);
    [(-REACH, -REACH), (REACH, -REACH), (-REACH, REACH), (REACH, REACH)].into_iter().any(|(dx, dy)| {
        let [u, _, _, v, ..] = continued(*motion, dx, dy);
        let (x, y) = (x + dx * STRIDE as f32 + u, y + dy * STRIDE as f32 + v);
        !(x >= 0.0 && y >= 0.0 && x <= right && y <= bottom)
    })
}

/// The motions that a patch tries.
#[derive(Default)]
struct Candidates {
    motions: [Motion; MOST_TRIED],
    count: usize,
}

impl Candidates {
    /// Adds a motion unless there is a similar one, or there are enough.
    fn add(&mut self, motion: Motion) {
        let [u, _, _, v, ..] = motion;
        let is_same = |[other_u, _, _, other_v, ..]: &Motion| (u - other_u).abs().max((v - other_v).abs()) < SAME_PX;
        if self.count < self.motions.len() && !self.motions[..self.count].iter().any(is_same) {
            self.motions[self.count] = motion;
            self.count += 1;
        }
    }

    fn all(&self) -> &[Motion] {
        &self.motions[..self.count]
    }
}

/// What the patches are compared with.
pub(super) struct Propagation<'a, const CHANNELS: usize> {
    pub(super) grid: FineGrid,
    pub(super) weights: &'a CornerWeights<6>,
    pub(super) templates: (&'a Template, &'a FineTemplate),
    pub(super) current: Current<'a, CHANNELS>,
    pub(super) rules: &'a ValidityParams,
    pub(super) coarse: CoarseMotions<'a>,
    /// For every node of the grid, its index in the list of nodes.
    pub(super) index: &'a [u32],
}

impl<const CHANNELS: usize> Propagation<'_, CHANNELS> {
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
            let own = field.motions()[place];
            let candidates = self.candidates(field, nodes, place);
            if candidates.all().is_empty() {
                continue;
            }
            let mut least = (IMPROVEMENT * self.unexplained(simd, place, &own)).min(MOST_UNEXPLAINED);
            let mut best = None;
            for motion in candidates.all() {
                let unexplained = self.unexplained(simd, place, motion);
                if unexplained < least {
                    (least, best) = (unexplained, Some(*motion));
                }
            }
            if let Some(motion) = best {
                field.restart(&mut nodes[node], motion);
                is_any_set = true;
            }
        }
        is_any_set
    }

    /// The motions of the matched patches around a node, continued to it.
    fn candidates(&self, field: &FineField, nodes: &[FineNode], place: usize) -> Candidates {
        let columns = self.grid.columns;
        let mut candidates = Candidates::default();
        for near in around((columns, self.grid.rows), place, 1) {
            if nodes.get(self.index[near] as usize).is_some_and(|node| node.is_trusted) {
                let along = |to: usize, from: usize| to as f32 - from as f32;
                let (dx, dy) = (along(place % columns, near % columns), along(place / columns, near / columns));
                candidates.add(continued(field.motions()[near], dx, dy));
            }
        }
        for motion in self.coarse.around(self.grid, place) {
            candidates.add(motion);
        }
        candidates
    }

    /// The residual of a patch that moves like this, relative to the largest of a valid patch; infinite if it leaves the picture,
    /// where nothing contradicts it.
    #[inline(always)]
    fn unexplained<S: Simd>(&self, simd: S, place: usize, motion: &Motion) -> f32 {
        if leaves(self.grid, place, motion) {
            return f32::INFINITY;
        }
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
        node.unexplained(&fine.equations[place], fine.noise, self.rules)
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
    fn a_motion_is_tried_once() {
        let motion = |u: f32| [u, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut candidates = Candidates::default();
        for u in [4.0, 4.4, 9.0, 1.0] {
            candidates.add(motion(u));
        }
        assert_eq!(candidates.all(), [motion(4.0), motion(9.0), motion(1.0)]);
        for more in 1..=MOST_TRIED {
            candidates.add(motion(100.0 * more as f32));
        }
        assert_eq!(candidates.all().len(), MOST_TRIED);
    }

    #[test]
    fn a_motion_out_of_the_picture_leaves_it() {
        let grid = FineGrid::over(64, 48);
        // At column 57.5, half a window of 3.5 px from column 61.
        let place = 5 * grid.columns + 14;
        let right = |u: f32| [u, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert!(
            !leaves(grid, place, &right(1.9)) && leaves(grid, place, &right(2.1)) && leaves(grid, place, &right(30.0))
        );
        // A part of it, because it stretches by half.
        assert!(leaves(grid, place, &[1.0, 2.0, 0.0, 0.0, 0.0, 0.0]));
        assert!(leaves(grid, place, &right(f32::NAN)));
    }
}
