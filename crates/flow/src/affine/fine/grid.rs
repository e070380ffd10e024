//! The positions of the fine patches, and the weights of their windows.
//!
//! Fine patches are [`WINDOW`] px wide and lie every [`STRIDE`] px. Node `(i, j)` lies at image column `STRIDE·i + 1½`,
//! so 2×2 of them lie in the square around a node of the coarse grid. Four nodes surround a *cell* of `STRIDE`×`STRIDE`
//! px, which is a quarter of the window of each of them. A cell has sixteen pixels, which fit in one register.

use crate::affine::grid;
use std::f32::consts::PI;

/// Distance between neighbouring fine patches, px.
pub(crate) const STRIDE: usize = grid::STRIDE / 2;
/// Width and height of a fine patch, px.
pub(crate) const WINDOW: usize = 2 * STRIDE;
/// Pixels of a cell.
pub(crate) const CELL: usize = STRIDE * STRIDE;
/// Corners of a cell: upper left, upper right, lower left, lower right.
pub(crate) const CORNERS: usize = 4;

/// Fine nodes over an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FineGrid {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl FineGrid {
    /// The grid over an image of this size.
    pub(crate) fn over(width: usize, height: usize) -> Self {
        Self { width, height, columns: width.div_ceil(STRIDE), rows: height.div_ceil(STRIDE) }
    }

    pub(crate) fn nodes(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether a node's whole window lies in the image.
    pub(crate) fn is_inner(&self, column: usize, row: usize) -> bool {
        let is_inner = |i: usize, size: usize| i > 0 && STRIDE * (i + 1) + STRIDE / 2 <= size;
        is_inner(column, self.width) && is_inner(row, self.height)
    }

    /// All cells that lie in the image, each by the node at its lower right corner.
    pub(crate) fn cells(self) -> impl Iterator<Item = usize> {
        let inner = |size: usize| 1..(size.saturating_sub(STRIDE / 2) / STRIDE + 1).min(size.div_ceil(STRIDE));
        inner(self.height).flat_map(move |row| inner(self.width).map(move |column| row * self.columns + column))
    }

    /// The corners of a cell.
    pub(crate) fn corners(self, cell: usize) -> [usize; CORNERS] {
        [cell - self.columns - 1, cell - self.columns, cell - 1, cell]
    }

    /// The pixel at the upper left of a cell.
    pub(crate) fn upper_left(self, cell: usize) -> (usize, usize) {
        let of = |i: usize| STRIDE * i - STRIDE / 2;
        (of(cell % self.columns), of(cell / self.columns))
    }

    /// Those of the four fine nodes in the square around node `(i, j)` of the coarse grid whose windows lie in the
    /// image.
    pub(crate) fn within(self, i: usize, j: usize) -> impl Iterator<Item = usize> {
        let places = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| (2 * i + di, 2 * j + dj));
        let inner = places.into_iter().filter(move |&(i, j)| self.is_inner(i, j));
        inner.map(move |(i, j)| j * self.columns + i)
    }
}

/// Weights of the sixteen pixels of a cell, for one quantity of each of its corners.
pub(crate) type CornerWeights<const N: usize> = [[[f32; CELL]; N]; CORNERS];

/// Window weights times `1, ξ, η, ξ², ξη, η²`, with the distances `ξ, η` from the corner's node in strides.
pub(crate) fn window_weights() -> CornerWeights<6> {
    each_pixel(|x, y| {
        let weight = |d: f32| (PI * d * STRIDE as f32 / (WINDOW + 1) as f32).cos().powi(2);
        let w = weight(x) * weight(y);
        [w, w * x, w * y, w * x * x, w * x * y, w * y * y]
    })
}

/// Sum of the weights of all patches at a pixel, on average, dimensionless.
pub(crate) fn overlap() -> f32 {
    window_weights().iter().map(|[weights, ..]| weights.iter().sum::<f32>()).sum::<f32>() / CELL as f32
}

/// Bicubic Hermite basis: for value, x slope, y slope and twist of each corner.
pub(crate) fn hermite_basis() -> CornerWeights<4> {
    each_pixel(|x, y| {
        // With the distance d from the node, the value's basis is (1 + 2|d|)(1 − |d|)², the slope's d (1 − |d|)².
        let value = |d: f32| (1.0 + 2.0 * d.abs()) * (1.0 - d.abs()).powi(2);
        let slope = |d: f32| d * (1.0 - d.abs()).powi(2);
        [value(x) * value(y), slope(x) * value(y), value(x) * slope(y), slope(x) * slope(y)]
    })
}

/// Values of a function of the distances from each corner, in strides.
fn each_pixel<const N: usize>(of: impl Fn(f32, f32) -> [f32; N]) -> CornerWeights<N> {
    std::array::from_fn(|corner| {
        let mut weights = [[0.0; CELL]; N];
        for pixel in 0..CELL {
            let distance = |k: usize, is_after: usize| (k as f32 + 0.5) / STRIDE as f32 - is_after as f32;
            let values = of(distance(pixel % STRIDE, corner % 2), distance(pixel / STRIDE, corner / 2));
            for (plane, value) in weights.iter_mut().zip(values) {
                plane[pixel] = value;
            }
        }
        weights
    })
}
