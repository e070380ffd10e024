//! Cubic B-splines on the pixel grid: they spread a moved point over 4×4 nodes and interpolate a field between its nodes.
//!
//! Neighbours have similar flow. Sixteen points in a row that lie between the same two nodes along an axis share the
//! position of their block, and whole registers are processed along the rows of the grid. If they lie on both sides of a
//! node, the block has a fifth node along this axis. Where the flow varies more, the same is tried for eight points each;
//! where it varies still more, at the rim of a contact, points are processed one by one.

#![expect(clippy::inline_always, reason = "lanes passed between functions that are not inlined go through memory")]

mod shared;
mod stored;

use fearless_simd::{f32x8, f32x16, prelude::*};
use fearless_simd_macros::simd;

use shared::SharedBlocks;
use stored::StoredBlocks;

/// Largest number of nodes along each axis in the block of one point.
pub(super) const SUPPORT: usize = 5;

/// Points in a group, whatever the width of the registers, so that the order of sums is always the same.
const GROUP: usize = 16;

/// Points in half a group.
const HALF: usize = GROUP / 2;

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

impl Grid {
    /// The node at which the block of a point at rest begins, along one axis: one before the point.
    #[inline(always)]
    fn origin(self, pixel: usize) -> f32 {
        (self.margin + pixel) as f32 - 1.0
    }
}

/// Where [`spread_row`] and [`read_row`] keep weights; no value is kept between calls.
#[derive(Debug, Clone)]
pub(super) struct Scratch(Vec<StoredBlocks>);

impl Scratch {
    pub(super) fn new() -> Self {
        Self(vec![StoredBlocks::empty(); BATCH * GROUP / HALF])
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
        let mut count = 0;
        for x in (start..u.len()).step_by(GROUP).take(BATCH) {
            let flow = (load_group(simd, &u[x..]), load_group(simd, &v[x..]));
            if let Some(blocks) = SharedBlocks::find(simd, grid, (x, y), flow) {
                scratch.0[count].store_group(simd, &blocks);
                count += 1;
                continue;
            }
            for (half, flow) in halves(simd, flow).into_iter().enumerate() {
                let place = (x + half * HALF, y);
                let stored = &mut scratch.0[count];
                match SharedBlocks::find(simd, grid, place, flow) {
                    Some(blocks) => stored.store_half(simd, &blocks),
                    None => stored.store_own(simd, grid, place, flow),
                }
                count += 1;
            }
        }
        for stored in &scratch.0[..count] {
            stored.spread(simd, grid.columns, nodes);
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
        if let Some(blocks) = SharedBlocks::find(simd, grid, (x, y), flow) {
            blocks.read(simd, grid.columns, nodes).store_slice(values);
            continue;
        }
        for (half, (values, flow)) in values.chunks_mut(HALF).zip(halves(simd, flow)).enumerate() {
            let place = (x + half * HALF, y);
            if let Some(blocks) = SharedBlocks::find(simd, grid, place, flow) {
                blocks.read(simd, grid.columns, nodes).store_slice(values);
            } else {
                stored.store_own(simd, grid, place, flow);
                stored.read_own(simd, grid.columns, nodes, values);
            }
        }
    }
}

/// The flow of the first group of a row; not a number behind the end of the row.
#[inline(always)]
fn load_group<S: Simd>(simd: S, row: &[f32]) -> f32x16<S> {
    match row.first_chunk::<GROUP>() {
        Some(group) => f32x16::from_slice(simd, group),
        None => f32x16::from_fn(simd, |i| row.get(i).copied().unwrap_or(f32::NAN)),
    }
}

/// The flows of both halves of a group.
#[inline(always)]
fn halves<S: Simd>(simd: S, (u, v): (f32x16<S>, f32x16<S>)) -> [(f32x8<S>, f32x8<S>); 2] {
    let ((u, other_u), (v, other_v)) = (simd.split_f32x16(u), simd.split_f32x16(v));
    [(u, v), (other_u, other_v)]
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
        // Even stretches: of a pixel in sixteen, which groups share, and of two, which halves of them share.
        let stretched =
            |by: f32| -> (Vec<f32>, Vec<f32>) { (0..50).map(|x| (by * x as f32, 0.3 - by * x as f32)).unzip() };
        rows.extend([stretched(0.05), stretched(0.15), stretched(-0.2)]);
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
