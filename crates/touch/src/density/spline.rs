//! Cubic B-splines on the pixel grid: they spread a moved point over 4×4 nodes and interpolate a field between its nodes.
//!
//! Neighbours have similar flow. Sixteen points in a row whose flow differs by less than about a pixel share a block of
//! 5×5 offsets, which contains the 4×4 nodes of each: whole registers are then processed along the rows of the grid.
//! Where the flow varies more, at the rim of a contact, points are processed one by one.

#![expect(clippy::inline_always, reason = "lanes passed between functions that are not inlined go through memory")]

use fearless_simd::{f32x4, f32x16, i32x16, prelude::*};
use fearless_simd_macros::simd;

/// Nodes along each axis in the block of one point.
pub(super) const SUPPORT: usize = 5;

/// Nodes along each axis of a point that shares no block.
const OWN_SUPPORT: usize = 4;

/// Points in a group, whatever the width of the registers, so that the order of sums is always the same.
const GROUP: usize = 16;

/// Nodes along a row that a group touches.
const REACH: usize = GROUP + SUPPORT - 1;

/// Groups whose weights are computed before the first of them is used: a load that overlaps a recent store waits for it.
const BATCH: usize = 8;

/// A grid of nodes a pixel apart that reaches beyond the image on every side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    /// Nodes along a row.
    pub(super) columns: usize,
    /// Rows of nodes.
    pub(super) rows: usize,
    /// Nodes before the image's first pixel, along each axis.
    pub(super) margin: usize,
}

/// The blocks of nodes that sixteen neighbours of one row touch.
///
/// Node `(i, j)` of a point is node `first + i + j · columns` of the grid and weighs `across[i] · down[j]`. The weights of
/// a point sum to 1; they are 0 if its block does not lie on the grid or its flow is not finite.
struct Blocks<S: Simd, F> {
    first: F,
    across: [f32x16<S>; SUPPORT],
    down: [f32x16<S>; SUPPORT],
}

/// Blocks whose first nodes follow each other; `first` is that of the first point.
type SharedBlocks<S> = Blocks<S, usize>;

/// Blocks at the individual position of each point.
type OwnBlocks<S> = Blocks<S, i32x16<S>>;

impl Grid {
    /// The blocks of the points from `(x, y)` on, which move by `(u, v)` px, if their flows lie close together.
    #[inline(always)]
    fn shared_blocks<S: Simd>(
        self,
        simd: S,
        (x, y): (usize, usize),
        (u, v): (f32x16<S>, f32x16<S>),
    ) -> Option<SharedBlocks<S>> {
        let (passed_u, passed_v) = (shared_node(simd, u), shared_node(simd, v));
        if !(is_within_two(u, passed_u) && is_within_two(v, passed_v)) {
            return None;
        }
        let (column, row) = (passed_u[0] + self.origin(x), passed_v[0] + self.origin(y));
        let is_on_grid = (0.0..=(self.columns - REACH) as f32).contains(&column)
            && (0.0..=(self.rows - SUPPORT) as f32).contains(&row);
        if !is_on_grid {
            return None;
        }
        let first = row as usize * self.columns + column as usize;
        Some(Blocks { first, across: weights(simd, u - passed_u), down: weights(simd, v - passed_v) })
    }

    /// The blocks of the points from `(x, y)` on, which move by `(u, v)` px.
    #[inline(always)]
    fn own_blocks<S: Simd>(self, simd: S, (x, y): (usize, usize), (u, v): (f32x16<S>, f32x16<S>)) -> OwnBlocks<S> {
        let column = u.floor() + f32x16::from_slice(simd, &LANES) + self.origin(x);
        let row = v.floor() + self.origin(y);
        let (last_column, last_row) = ((self.columns - SUPPORT) as f32, (self.rows - SUPPORT) as f32);
        let is_on_grid = column.simd_ge(0.0) & column.simd_le(last_column) & row.simd_ge(0.0) & row.simd_le(last_row);
        let zero = f32x16::splat(simd, 0.0);
        #[expect(clippy::cast_possible_wrap, reason = "a row has far fewer than 2³¹ nodes")]
        let columns = self.columns as i32;
        let column: i32x16<S> = is_on_grid.select(column, zero).to_int();
        let row: i32x16<S> = is_on_grid.select(row, zero).to_int();
        let mut down = weights(simd, is_on_grid.select(v - v.floor(), zero));
        for weight in &mut down {
            *weight = is_on_grid.select(*weight, zero);
        }
        let across = weights(simd, is_on_grid.select(u - u.floor(), zero));
        Blocks { first: row * columns + column, across, down }
    }

    /// The node at which the block of a point at rest begins, along one axis: one before the point.
    #[inline(always)]
    fn origin(self, pixel: usize) -> f32 {
        (self.margin + pixel) as f32 - 1.0
    }
}

impl<S: Simd> SharedBlocks<S> {
    /// The field at the points.
    #[inline(always)]
    fn read(&self, simd: S, columns: usize, nodes: &[f32]) -> f32x16<S> {
        let mut sum = f32x16::splat(simd, 0.0);
        for (j, &down) in self.down.iter().enumerate() {
            let row = &nodes[self.first + j * columns..][..REACH];
            let mut along = f32x16::splat(simd, 0.0);
            for (i, &across) in self.across.iter().enumerate() {
                along += f32x16::from_slice(simd, &row[i..][..GROUP]) * across;
            }
            sum += along * down;
        }
        sum
    }
}

/// [`Blocks`] in memory.
#[derive(Debug, Clone, Copy)]
struct StoredBlocks {
    first: First,
    /// Five rows of weights across, five down, with zeros before, between and after them: a register may begin before its
    /// row or end after it.
    weights: [f32; 2 * SUPPORT * REACH + SUPPORT - 1],
}

/// First nodes of [`Blocks`].
#[derive(Debug, Clone, Copy)]
enum First {
    Shared(usize),
    Own([i32; GROUP]),
}

/// Where [`spread_row`] and [`read_row`] keep weights; no value is kept between calls.
#[derive(Debug, Clone)]
pub(super) struct Scratch(Vec<StoredBlocks>);

impl Scratch {
    pub(super) fn new() -> Self {
        let weights = [0.0; 2 * SUPPORT * REACH + SUPPORT - 1];
        Self(vec![StoredBlocks { first: First::Shared(0), weights }; BATCH])
    }
}

impl StoredBlocks {
    #[inline(always)]
    fn store<S: Simd, F>(&mut self, first: First, blocks: &Blocks<S, F>) {
        self.first = first;
        for (row, weight) in blocks.across.iter().chain(&blocks.down).enumerate() {
            weight.store_slice(&mut self.weights[row * REACH + SUPPORT - 1..][..GROUP]);
        }
    }

    #[inline(always)]
    fn store_own<S: Simd>(&mut self, blocks: &OwnBlocks<S>) -> [i32; GROUP] {
        let mut first = [0; GROUP];
        blocks.first.store_slice(&mut first);
        self.store(First::Own(first), blocks);
        first
    }

    /// Adds points that share their block to the grid.
    #[inline(always)]
    fn spread<S: Simd>(&self, simd: S, first: usize, columns: usize, nodes: &mut [f32]) {
        // Node `k` of the group takes weight `i` of point `k − i`: the row of weights is shifted by `i`. The four nodes
        // after the group take nothing of the first weight.
        let mut across = [f32x16::splat(simd, 0.0); SUPPORT];
        let mut across_tail = [f32x4::splat(simd, 0.0); SUPPORT];
        for (i, (across, across_tail)) in across.iter_mut().zip(&mut across_tail).enumerate() {
            *across = f32x16::from_slice(simd, &self.shifted(i, i)[..GROUP]);
            *across_tail = f32x4::from_slice(simd, &self.shifted(i, i)[GROUP..]);
        }
        for j in 0..SUPPORT {
            let (head, tail) = nodes[first + j * columns..][..REACH].split_at_mut(GROUP);
            let mut head_sum = f32x16::from_slice(simd, head);
            let mut tail_sum = f32x4::from_slice(simd, tail);
            head_sum += across[0] * f32x16::from_slice(simd, &self.shifted(SUPPORT + j, 0)[..GROUP]);
            for i in 1..SUPPORT {
                let down = self.shifted(SUPPORT + j, i);
                head_sum += across[i] * f32x16::from_slice(simd, &down[..GROUP]);
                tail_sum += across_tail[i] * f32x4::from_slice(simd, &down[GROUP..]);
            }
            head_sum.store_slice(head);
            tail_sum.store_slice(tail);
        }
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

    /// Adds points to the grid one by one.
    #[inline(always)]
    fn spread_each<S: Simd>(&self, simd: S, first: &[i32; GROUP], columns: usize, nodes: &mut [f32]) {
        for (x, &first) in first.iter().enumerate() {
            let across = f32x4::from_fn(simd, |i| self.weight(i, x));
            for j in 0..OWN_SUPPORT {
                let nodes = &mut nodes[first as usize + j * columns..][..OWN_SUPPORT];
                (f32x4::from_slice(simd, nodes) + across * self.weight(SUPPORT + j, x)).store_slice(nodes);
            }
        }
    }

    /// Writes the field at the points, or as many as there are values, one by one.
    #[inline(always)]
    fn read_each<S: Simd>(&self, simd: S, first: &[i32; GROUP], columns: usize, nodes: &[f32], values: &mut [f32]) {
        for (x, (value, &first)) in values.iter_mut().zip(first).enumerate() {
            let mut sum = f32x4::splat(simd, 0.0);
            for j in 0..OWN_SUPPORT {
                let row = &nodes[first as usize + j * columns..][..OWN_SUPPORT];
                sum += f32x4::from_slice(simd, row) * self.weight(SUPPORT + j, x);
            }
            *value = (sum * f32x4::from_fn(simd, |i| self.weight(i, x))).reduce_sum();
        }
    }
}

/// Adds every point of reference row `y`, which moves by `(u, v)` px, to the grid, spread over its block.
#[simd]
pub(super) fn spread_row<S: Simd>(
    simd: S,
    scratch: &mut Scratch,
    grid: Grid,
    (y, u, v): (usize, &[f32], &[f32]),
    nodes: &mut [f32],
) {
    for start in (0..u.len()).step_by(BATCH * GROUP) {
        let groups = (start..u.len()).step_by(GROUP);
        for (stored, x) in scratch.0.iter_mut().zip(groups.clone()) {
            let flow = (load_group(simd, &u[x..]), load_group(simd, &v[x..]));
            if let Some(blocks) = grid.shared_blocks(simd, (x, y), flow) {
                stored.store(First::Shared(blocks.first), &blocks);
            } else {
                stored.store_own(&grid.own_blocks(simd, (x, y), flow));
            }
        }
        for (stored, _) in scratch.0.iter().zip(groups) {
            match &stored.first {
                First::Shared(first) => stored.spread(simd, *first, grid.columns, nodes),
                First::Own(first) => stored.spread_each(simd, first, grid.columns, nodes),
            }
        }
    }
}

/// Writes the field at every point of reference row `y`, which moves by `(u, v)` px: the weighted sum of the nodes of
/// its block.
#[simd]
pub(super) fn read_row<S: Simd>(
    simd: S,
    scratch: &mut Scratch,
    grid: Grid,
    (y, u, v): (usize, &[f32], &[f32]),
    nodes: &[f32],
    values: &mut [f32],
) {
    let stored = &mut scratch.0[0];
    for (group, values) in values.chunks_mut(GROUP).enumerate() {
        let x = group * GROUP;
        let flow = (load_group(simd, &u[x..]), load_group(simd, &v[x..]));
        if let Some(blocks) = grid.shared_blocks(simd, (x, y), flow) {
            blocks.read(simd, grid.columns, nodes).store_slice(values);
        } else {
            let first = stored.store_own(&grid.own_blocks(simd, (x, y), flow));
            stored.read_each(simd, &first, grid.columns, nodes, values);
        }
    }
}

const LANES: [f32; GROUP] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0];

/// The flow of the first group of a row; not a number behind the end of the row.
#[inline(always)]
fn load_group<S: Simd>(simd: S, row: &[f32]) -> f32x16<S> {
    match row.first_chunk::<GROUP>() {
        Some(group) => f32x16::from_slice(simd, group),
        None => f32x16::from_fn(simd, |i| row.get(i).copied().unwrap_or(f32::NAN)),
    }
}

/// The node that a group may share: it lies half a pixel to a pixel and a half before the middle of the group.
#[inline(always)]
fn shared_node<S: Simd>(simd: S, flow: f32x16<S>) -> f32x16<S> {
    f32x16::splat(simd, flow[GROUP / 2] - 0.5).floor()
}

/// Whether every flow of a group is less than 2 px after `node`. False for a flow that is not a number.
#[inline(always)]
fn is_within_two<S: Simd>(flow: f32x16<S>, node: f32x16<S>) -> bool {
    (flow.simd_ge(node) & flow.simd_lt(node + 2.0)).all_true()
}

/// The cubic B-spline's weights of the nodes at −1, 0, 1, 2 and 3 for a point at `t` in `[0, 2)`. They sum to 1.
#[inline(always)]
fn weights<S: Simd>(simd: S, t: f32x16<S>) -> [f32x16<S>; SUPPORT] {
    let zero = f32x16::splat(simd, 0.0);
    let is_second = t.simd_ge(1.0);
    let t = is_second.select(t - 1.0, t);
    let rest = -t + 1.0;
    let first = rest * rest * rest * (1.0 / 6.0);
    let second = t * t * (t * 0.5 - 1.0) + 2.0 / 3.0;
    let last = t * t * t * (1.0 / 6.0);
    let third = -(first + second + last) + 1.0;
    [
        is_second.select(zero, first),
        is_second.select(first, second),
        is_second.select(second, third),
        is_second.select(third, last),
        is_second.select(last, zero),
    ]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    const GRID: Grid = Grid { columns: 70, rows: 24, margin: 10 };
    const ROW: usize = 5;

    /// The cubic B-spline at a distance, px.
    fn spline(distance: f64) -> f64 {
        let d = distance.abs();
        if d < 1.0 { 2.0 / 3.0 - d * d + 0.5 * d.powi(3) } else { (2.0 - d).max(0.0).powi(3) / 6.0 }
    }

    /// Weight of a node for point `x` of the row; none if the point's block is not on the grid.
    fn weight(node: usize, x: usize, (u, v): (f32, f32)) -> f64 {
        let place = (f64::from(u) + (x + GRID.margin) as f64, f64::from(v) + (ROW + GRID.margin) as f64);
        let is_inside = |place: f64, nodes: usize| place >= 1.0 && place.floor() - 1.0 <= (nodes - SUPPORT) as f64;
        if !is_inside(place.0, GRID.columns) || !is_inside(place.1, GRID.rows) {
            return 0.0;
        }
        let (column, row) = ((node % GRID.columns) as f64, (node / GRID.columns) as f64);
        spline(column - place.0) * spline(row - place.1)
    }

    /// Flows that keep groups together, separate them, leave the grid and are not numbers.
    fn rows() -> Vec<(Vec<f32>, Vec<f32>)> {
        let row = |amplitude: f32, seed: f32| -> (Vec<f32>, Vec<f32>) {
            let at = |x: usize, phase: f32| amplitude * (seed * (x * x) as f32 + phase).sin();
            (0..50).map(|x| (at(x, 0.0), at(x, 1.0))).unzip()
        };
        let mut rows = vec![row(0.0, 1.0), row(0.45, 0.7), row(0.8, 0.3), row(4.0, 0.9), row(15.0, 0.2), row(1e9, 0.5)];
        (rows[0].0[3], rows[1].1[20]) = (f32::NAN, f32::INFINITY);
        rows
    }

    #[test]
    fn spreading_weighs_every_node_by_the_spline() {
        for (u, v) in rows() {
            let mut nodes = vec![0.0; GRID.columns * GRID.rows];
            let mut scratch = Scratch::new();
            dispatch!(Level::new(), simd => spread_row(simd, &mut scratch, GRID, (ROW, &u, &v), &mut nodes));
            for (node, &value) in nodes.iter().enumerate() {
                let expected: f64 = (0..u.len()).map(|x| weight(node, x, (u[x], v[x]))).sum();
                assert!((f64::from(value) - expected).abs() < 1e-5, "node {node}: {value}, not {expected}");
            }
        }
    }

    #[test]
    fn reading_weighs_every_node_by_the_spline() {
        let nodes: Vec<f32> = (0..GRID.columns * GRID.rows).map(|i| ((i * i) as f32 * 0.61).cos()).collect();
        for (u, v) in rows() {
            let mut values = vec![f32::NAN; u.len()];
            let mut scratch = Scratch::new();
            dispatch!(Level::new(), simd => {
                read_row(simd, &mut scratch, GRID, (ROW, &u, &v), &nodes, &mut values);
            });
            for (x, &value) in values.iter().enumerate() {
                let node = |(i, &node): (usize, &f32)| weight(i, x, (u[x], v[x])) * f64::from(node);
                let expected: f64 = nodes.iter().enumerate().map(node).sum();
                assert!((f64::from(value) - expected).abs() < 1e-5, "point {x}: {value}, not {expected}");
            }
        }
    }
}
