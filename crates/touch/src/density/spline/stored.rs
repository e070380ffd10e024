//! Blocks in memory, where weights can be read at other lanes than those that they were written to.

use fearless_simd::{f32x4, f32x8, f32x16, i32x8, prelude::*};

use super::shared::{FEW, SharedBlocks, weights};
use super::{GROUP, Grid, HALF, SUPPORT};

/// Nodes along a row that a group touches.
const REACH: usize = GROUP + SUPPORT - 1;

/// The blocks of sixteen or eight points of a row.
#[derive(Debug, Clone)]
pub(super) struct StoredBlocks {
    first: First,
    /// Number of nodes across and down.
    counts: [usize; 2],
    /// Rows of weights across, then down, with zeros before, between and after them: a register may begin before its
    /// row or end after it.
    weights: [f32; 2 * SUPPORT * REACH + SUPPORT - 1],
}

/// First nodes of the blocks.
#[derive(Debug, Clone)]
enum First {
    /// Of sixteen points, one node after the other.
    Group(usize),
    /// Of eight points, one node after the other.
    Half(usize),
    /// Of eight points, anywhere.
    Own([i32; HALF]),
}

impl StoredBlocks {
    /// Blocks without weight.
    pub(super) fn empty() -> Self {
        Self { first: First::Group(0), counts: [FEW; 2], weights: [0.0; 2 * SUPPORT * REACH + SUPPORT - 1] }
    }

    /// Stores the blocks of sixteen points.
    #[inline(always)]
    pub(super) fn store_group<S: Simd>(&mut self, simd: S, blocks: &SharedBlocks<f32x16<S>>) {
        (self.first, self.counts) = (First::Group(blocks.first), blocks.counts);
        match blocks.counts {
            [FEW, FEW] => self.store_sixteen::<S, FEW, FEW>(simd, blocks),
            _ => self.store_sixteen::<S, SUPPORT, SUPPORT>(simd, blocks),
        }
    }

    /// Stores the blocks of eight points.
    #[inline(always)]
    pub(super) fn store_half<S: Simd>(&mut self, simd: S, blocks: &SharedBlocks<f32x8<S>>) {
        (self.first, self.counts) = (First::Half(blocks.first), blocks.counts);
        for (row, weight) in blocks.weights::<S, SUPPORT, SUPPORT>(simd).as_flattened().iter().enumerate() {
            self.store_eight(simd, row, *weight);
        }
    }

    #[inline(always)]
    fn store_sixteen<S: Simd, const ACROSS: usize, const DOWN: usize>(
        &mut self,
        simd: S,
        blocks: &SharedBlocks<f32x16<S>>,
    ) {
        let [across, down] = blocks.weights::<S, ACROSS, DOWN>(simd);
        for i in 0..ACROSS {
            across[i].store_slice(&mut self.row_mut(i)[..GROUP]);
        }
        for j in 0..DOWN {
            down[j].store_slice(&mut self.row_mut(SUPPORT + j)[..GROUP]);
        }
    }

    /// Stores the blocks of the eight points from `(x, y)` on, which move by `(u, v)` px, wherever they are. The weights are
    /// 0 if a block does not lie on the grid or its flow is not finite.
    #[inline(always)]
    pub(super) fn store_own<S: Simd>(
        &mut self,
        simd: S,
        grid: Grid,
        (x, y): (usize, usize),
        (u, v): (f32x8<S>, f32x8<S>),
    ) {
        let column = u.floor() + f32x8::from_slice(simd, &LANES) + grid.origin(x);
        let row = v.floor() + grid.origin(y);
        let (last_column, last_row) = ((grid.columns - SUPPORT) as f32, (grid.rows - SUPPORT) as f32);
        let is_on_grid = column.simd_ge(0.0) & column.simd_le(last_column) & row.simd_ge(0.0) & row.simd_le(last_row);
        let zero = f32x8::splat(simd, 0.0);
        #[expect(clippy::cast_possible_wrap, reason = "a row has far fewer than 2³¹ nodes")]
        let columns = grid.columns as i32;
        let column: i32x8<S> = is_on_grid.select(column, zero).to_int();
        let row: i32x8<S> = is_on_grid.select(row, zero).to_int();
        let mut first = [0; HALF];
        (row * columns + column).store_slice(&mut first);
        (self.first, self.counts) = (First::Own(first), [FEW; 2]);
        for (node, weight) in weights(is_on_grid.select(u - u.floor(), zero)).into_iter().enumerate() {
            self.store_eight(simd, node, weight);
        }
        for (node, weight) in weights(is_on_grid.select(v - v.floor(), zero)).into_iter().enumerate() {
            self.store_eight(simd, SUPPORT + node, is_on_grid.select(weight, zero));
        }
    }

    /// Adds the points to the grid.
    #[inline(always)]
    pub(super) fn spread<S: Simd>(&self, simd: S, columns: usize, nodes: &mut [f32]) {
        match (&self.first, self.counts[0]) {
            (First::Group(first), FEW) => self.spread_shared::<S, f32x16<S>, FEW>(simd, *first, columns, nodes),
            (First::Group(first), _) => self.spread_shared::<S, f32x16<S>, SUPPORT>(simd, *first, columns, nodes),
            (First::Half(first), FEW) => self.spread_shared::<S, f32x8<S>, FEW>(simd, *first, columns, nodes),
            (First::Half(first), _) => self.spread_shared::<S, f32x8<S>, SUPPORT>(simd, *first, columns, nodes),
            (First::Own(first), _) => self.spread_each(simd, first, columns, nodes),
        }
    }

    /// Writes the field at points stored by [`Self::store_own`], or at as many as there are values.
    #[inline(always)]
    pub(super) fn read_own<S: Simd>(&self, simd: S, columns: usize, nodes: &[f32], values: &mut [f32]) {
        let First::Own(first) = &self.first else { return };
        for (x, (value, &first)) in values.iter_mut().zip(first).enumerate() {
            let mut sum = f32x4::splat(simd, 0.0);
            for j in 0..FEW {
                let row = &nodes[first as usize + j * columns..][..FEW];
                sum = f32x4::from_slice(simd, row).mul_add(self.weight(SUPPORT + j, x), sum);
            }
            *value = (sum * f32x4::from_fn(simd, |i| self.weight(i, x))).reduce_sum();
        }
    }

    /// Adds points that share the position of their block.
    #[inline(always)]
    fn spread_shared<S: Simd, F: SimdFloat<S, Element = f32>, const COUNT: usize>(
        &self,
        simd: S,
        first: usize,
        columns: usize,
        nodes: &mut [f32],
    ) {
        // Node `k` of the group takes weight `i` of point `k − i`: the row of weights is shifted by `i`. The nodes after
        // the group take nothing of the first weight.
        let mut across = [F::splat(simd, 0.0); COUNT];
        let mut across_tail = [f32x4::splat(simd, 0.0); COUNT];
        for (i, (across, across_tail)) in across.iter_mut().zip(&mut across_tail).enumerate() {
            *across = F::from_slice(simd, &self.shifted(i, i)[..F::LEN]);
            *across_tail = f32x4::from_slice(simd, &self.shifted(i, i)[F::LEN..][..TAIL]);
        }
        for j in 0..self.counts[1] {
            let (head, tail) = nodes[first + j * columns..][..F::LEN + TAIL].split_at_mut(F::LEN);
            let mut head_sum = F::from_slice(simd, head);
            let mut tail_sum = f32x4::from_slice(simd, tail);
            head_sum = across[0].mul_add(F::from_slice(simd, &self.shifted(SUPPORT + j, 0)[..F::LEN]), head_sum);
            for i in 1..COUNT {
                let down = self.shifted(SUPPORT + j, i);
                head_sum = across[i].mul_add(F::from_slice(simd, &down[..F::LEN]), head_sum);
                tail_sum = across_tail[i].mul_add(f32x4::from_slice(simd, &down[F::LEN..][..TAIL]), tail_sum);
            }
            head_sum.store_slice(head);
            tail_sum.store_slice(tail);
        }
    }

    /// Adds points one by one.
    #[inline(always)]
    fn spread_each<S: Simd>(&self, simd: S, first: &[i32; HALF], columns: usize, nodes: &mut [f32]) {
        for (x, &first) in first.iter().enumerate() {
            let across = f32x4::from_fn(simd, |i| self.weight(i, x));
            for j in 0..FEW {
                let nodes = &mut nodes[first as usize + j * columns..][..FEW];
                across.mul_add(self.weight(SUPPORT + j, x), f32x4::from_slice(simd, nodes)).store_slice(nodes);
            }
        }
    }

    /// Stores weights of eight points; those of eight more points are 0.
    #[inline(always)]
    fn store_eight<S: Simd>(&mut self, simd: S, row: usize, weight: f32x8<S>) {
        let row = self.row_mut(row);
        weight.store_slice(&mut row[..HALF]);
        f32x8::splat(simd, 0.0).store_slice(&mut row[HALF..GROUP]);
    }

    #[inline(always)]
    fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.weights[row * REACH + SUPPORT - 1..][..REACH]
    }

    /// A row of weights, moved `places` to the right.
    #[inline(always)]
    fn shifted(&self, row: usize, places: usize) -> &[f32] {
        &self.weights[row * REACH + SUPPORT - 1 - places..][..REACH]
    }

    /// Weight of node `i` or, from `SUPPORT` on, node `j` of point `x`.
    #[inline(always)]
    fn weight(&self, row: usize, x: usize) -> f32 {
        self.weights[row * REACH + SUPPORT - 1 + x]
    }
}

/// Nodes after those of the first weight of a group.
const TAIL: usize = SUPPORT - 1;

const LANES: [f32; HALF] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
