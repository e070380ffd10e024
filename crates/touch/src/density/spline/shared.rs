//! Points of a row whose flow is similar: they share the position of their block, so whole registers are processed.

use fearless_simd::prelude::*;

use super::{Grid, SUPPORT};

/// Nodes along an axis if all points lie between the same two nodes.
pub(super) const FEW: usize = 4;

/// The blocks of as many points of a row as a register has lanes.
///
/// Node `(i, j)` of point `x` is node `first + x + i + j · columns` of the grid. Its weight is that of node `i` across
/// times that of node `j` down.
pub(super) struct SharedBlocks<F> {
    pub(super) first: usize,
    /// Distance of the points behind the second node, across and down, px.
    behind: [F; 2],
    /// Number of nodes across and down, [`FEW`] or [`SUPPORT`].
    pub(super) counts: [usize; 2],
}

impl<F> SharedBlocks<F> {
    /// The blocks of the points from `(x, y)` on, which move by `(u, v)` px, if their flows lie close together and all
    /// nodes are on the grid.
    #[inline(always)]
    pub(super) fn find<S: Simd>(simd: S, grid: Grid, (x, y): (usize, usize), (u, v): (F, F)) -> Option<Self>
    where
        F: SimdFloat<S, Element = f32>,
    {
        let (passed_u, across) = shared_node(simd, u);
        let (passed_v, down) = shared_node(simd, v);
        if across.max(down) > SUPPORT {
            return None;
        }
        let (column, row) = (passed_u.as_slice()[0] + grid.origin(x), passed_v.as_slice()[0] + grid.origin(y));
        let is_on_grid = (0.0..=(grid.columns - (F::LEN + SUPPORT - 1)) as f32).contains(&column)
            && (0.0..=(grid.rows - SUPPORT) as f32).contains(&row);
        if !is_on_grid {
            return None;
        }
        // Fewer instructions than a conversion to 64 bits; both are small and not negative.
        let [column, row] = [column, row].map(|at| (at as i32).cast_unsigned() as usize);
        let first = row * grid.columns + column;
        Some(Self { first, behind: [u - passed_u, v - passed_v], counts: [across, down] })
    }

    /// The weights of the nodes across and down; those of a fifth node are 0 if there are four.
    #[inline(always)]
    pub(super) fn weights<S: Simd, const ACROSS: usize, const DOWN: usize>(&self, simd: S) -> [[F; SUPPORT]; 2]
    where
        F: SimdFloat<S, Element = f32>,
    {
        let [across, down] = self.behind;
        [weights_of::<S, F, ACROSS>(simd, across), weights_of::<S, F, DOWN>(simd, down)]
    }

    /// The field at the points.
    #[inline(always)]
    pub(super) fn read<S: Simd>(&self, simd: S, columns: usize, nodes: &[f32]) -> F
    where
        F: SimdFloat<S, Element = f32>,
    {
        match self.counts {
            [FEW, FEW] => self.read_nodes::<S, FEW, FEW>(simd, columns, nodes),
            [FEW, _] => self.read_nodes::<S, FEW, SUPPORT>(simd, columns, nodes),
            [_, FEW] => self.read_nodes::<S, SUPPORT, FEW>(simd, columns, nodes),
            _ => self.read_nodes::<S, SUPPORT, SUPPORT>(simd, columns, nodes),
        }
    }

    #[inline(always)]
    fn read_nodes<S: Simd, const ACROSS: usize, const DOWN: usize>(&self, simd: S, columns: usize, nodes: &[f32]) -> F
    where
        F: SimdFloat<S, Element = f32>,
    {
        let [across, down] = self.weights::<S, ACROSS, DOWN>(simd);
        let mut sum = F::splat(simd, 0.0);
        for j in 0..DOWN {
            let row = &nodes[self.first + j * columns..][..F::LEN + ACROSS - 1];
            let mut along = F::from_slice(simd, &row[..F::LEN]) * across[0];
            for i in 1..ACROSS {
                along = F::from_slice(simd, &row[i..][..F::LEN]).mul_add(across[i], along);
            }
            sum = along.mul_add(down[j], sum);
        }
        sum
    }
}

/// The node that all points have passed, as a flow, px, and the number of nodes in the block from the one before it on;
/// more than [`SUPPORT`] if the flows differ too much or one of them is not a number.
#[inline(always)]
fn shared_node<S: Simd, F: SimdFloat<S, Element = f32>>(simd: S, flow: F) -> (F, usize) {
    let middle = F::splat(simd, flow.as_slice()[F::LEN / 2]);
    let passed = middle.floor();
    if is_behind(flow, passed, 1.0) {
        return (passed, FEW);
    }
    let passed = (middle - 0.5).floor();
    (passed, if is_behind(flow, passed, 2.0) { SUPPORT } else { usize::MAX })
}

/// Whether every flow is less than `most` px behind a node. False for a flow that is not a number.
#[inline(always)]
fn is_behind<S: Simd, F: SimdFloat<S, Element = f32>>(flow: F, node: F, most: f32) -> bool {
    (flow.simd_ge(node) & flow.simd_lt(node + most)).all_true()
}

/// The weights of [`FEW`] or [`SUPPORT`] nodes.
#[inline(always)]
fn weights_of<S: Simd, F: SimdFloat<S, Element = f32>, const COUNT: usize>(simd: S, t: F) -> [F; SUPPORT] {
    if COUNT == FEW {
        let [first, second, third, last] = weights(t);
        return [first, second, third, last, F::splat(simd, 0.0)];
    }
    wide_weights(simd, t)
}

/// The cubic B-spline's weights of the nodes at −1, 0, 1 and 2 for a point at `t` in `[0, 1)`. They sum to 1.
#[inline(always)]
pub(super) fn weights<S: Simd, F: SimdFloat<S, Element = f32>>(t: F) -> [F; FEW] {
    let rest = -t + 1.0;
    let first = rest * rest * rest * (1.0 / 6.0);
    let second = (t * t).mul_add(t * 0.5 - 1.0, 2.0 / 3.0);
    let last = t * t * t * (1.0 / 6.0);
    let third = -(first + second + last) + 1.0;
    [first, second, third, last]
}

/// The same of the nodes at −1, 0, 1, 2 and 3 for a point at `t` in `[0, 2)`.
#[inline(always)]
fn wide_weights<S: Simd, F: SimdFloat<S, Element = f32>>(simd: S, t: F) -> [F; SUPPORT] {
    let zero = F::splat(simd, 0.0);
    let is_second = t.simd_ge(1.0);
    let [first, second, third, last] = weights(is_second.select(t - 1.0, t));
    [
        is_second.select(zero, first),
        is_second.select(first, second),
        is_second.select(second, third),
        is_second.select(third, last),
        is_second.select(last, zero),
    ]
}
