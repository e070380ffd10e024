//! Warps the current picture onto the reference and sums the products of residual and template over every patch.
//!
//! Rows are processed in bands of one stride, so that a patch's data are still in the cache when its window is complete. The
//! upper and the lower half of the picture can be processed at the same time; the sums do not depend on it.

use super::expander::{Expander, Line};
use super::grid::{LANES, MARGIN, PatchGrid, STRIDE};
use super::moments::{Band, Window, sum_columns, sum_rows, sum_rows_twice};
use super::nodes::{NodeField, UNKNOWNS};
use super::places::Places;
use super::products::{Current, products};
use super::sampling::sample_row;
use super::template::Template;
use crate::Team;
use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;
use std::ops::Range;

/// Number of products that are summed over every patch: two for the gradient, two for light, one for the energy.
const PRODUCTS: usize = 5;

/// Memory to process a part of the picture's rows.
#[derive(Debug, Clone)]
pub(super) struct Strip {
    bands: [[Vec<f32>; PRODUCTS]; 2],
    line: Line,
    positions: [Vec<f32>; 2],
    row_sums: [Vec<f32>; 2],
}

/// Sums over patches: row by row of the grid, at every node.
pub(super) struct Sums<'a> {
    /// Gradient of the residual's energy for the six unknowns.
    pub(super) gradient: [&'a mut [f32]; UNKNOWNS],
    /// Gain and offset.
    pub(super) light: [&'a mut [f32]; 2],
    /// Squared residuals.
    pub(super) energy: &'a mut [f32],
}

/// What is measured: a picture at a field, against a template.
pub(super) struct Measurement<'a, const CHANNELS: usize> {
    pub(super) window: &'a Window,
    /// Prepared for the field.
    pub(super) expander: &'a Expander,
    pub(super) template: &'a Template,
    pub(super) current: Current<'a, CHANNELS>,
    pub(super) field: &'a NodeField,
}

impl Strip {
    pub(super) fn new(grid: PatchGrid) -> Self {
        let line = || vec![0.0; grid.padded_width()];
        let band = || std::array::from_fn(|_| vec![0.0; STRIDE * grid.padded_width()]);
        Self { bands: [band(), band()], line: Line::new(grid), positions: [line(), line()], row_sums: [line(), line()] }
    }

    /// Writes the flow of a field at the pixels of some rows.
    pub(super) fn expand(
        &mut self,
        level: Level,
        of: (&Expander, &NodeField),
        rows: Range<usize>,
        flow: [&mut [f32]; 2],
    ) {
        dispatch!(level, simd => self.expand_simd(simd, of, rows, flow));
    }

    #[inline(always)]
    fn expand_simd<S: Simd>(
        &mut self,
        simd: S,
        (expander, field): (&Expander, &NodeField),
        rows: Range<usize>,
        [flow_u, flow_v]: [&mut [f32]; 2],
    ) {
        let width = field.grid.width;
        let [u, v] = &mut self.positions;
        for (k, y) in rows.enumerate() {
            expander.row(simd, &mut self.line, field, y + MARGIN, [u, v]);
            flow_u[k * width..][..width].copy_from_slice(&u[MARGIN..][..width]);
            flow_v[k * width..][..width].copy_from_slice(&v[MARGIN..][..width]);
        }
    }
}

impl Sums<'_> {
    /// The sums of the nodes before a node, and those from it on.
    fn split_at(self, node: usize) -> (Self, Self) {
        let [[a, g], [b, h], [c, i], [d, j], [e, k], [f, l]] = self.gradient.map(|plane| split(plane, node));
        let [[gain, lower_gain], [offset, lower_offset]] = self.light.map(|plane| split(plane, node));
        let [energy, lower_energy] = split(self.energy, node);
        let upper = Self { gradient: [a, b, c, d, e, f], light: [gain, offset], energy };
        (upper, Self { gradient: [g, h, i, j, k, l], light: [lower_gain, lower_offset], energy: lower_energy })
    }
}

impl<const CHANNELS: usize> Measurement<'_, CHANNELS> {
    /// Measures all patches.
    pub(super) fn run(&self, level: Level, team: &Team, [first, second]: &mut [Strip; 2], sums: Sums<'_>) {
        let PatchGrid { columns, rows, .. } = self.template.grid;
        if !team.is_shared() {
            dispatch!(level, simd => self.fill(simd, first, 0..rows, sums));
            return;
        }
        let middle = rows / 2;
        let (upper, lower) = sums.split_at(middle * columns);
        team.join(
            || dispatch!(level, simd => self.fill(simd, first, 0..middle, upper)),
            || dispatch!(level, simd => self.fill(simd, second, middle..rows, lower)),
        );
    }

    /// Measures some rows of patches; `sums` are those of these rows.
    #[inline(always)]
    fn fill<S: Simd>(&self, simd: S, strip: &mut Strip, rows: Range<usize>, mut sums: Sums<'_>) {
        let columns = self.template.grid.columns;
        self.fill_band(simd, strip, rows.start);
        for (k, j) in rows.enumerate() {
            self.fill_band(simd, strip, j + 1);
            let nodes = k * columns..(k + 1) * columns;
            let step = self.template.row_step;
            let upper = &strip.bands[j % 2];
            let lower = &strip.bands[(j + 1) % 2];
            for component in 0..2 {
                let [plain, first] = &mut strip.row_sums;
                let band = Band { halves: [&upper[component], &lower[component]], step };
                sum_rows_twice(simd, self.window, band, [plain, first]);
                let gradient = &mut sums.gradient[3 * component..];
                sum_columns(simd, self.window, 0, plain, &mut gradient[0][nodes.clone()]);
                sum_columns(simd, self.window, 1, plain, &mut gradient[1][nodes.clone()]);
                sum_columns(simd, self.window, 0, first, &mut gradient[2][nodes.clone()]);
            }
            let [gain, offset] = &mut sums.light;
            let [row_sums, _] = &mut strip.row_sums;
            for (k, plane) in [gain, offset, &mut sums.energy].into_iter().enumerate() {
                let band = Band { halves: [&upper[2 + k], &lower[2 + k]], step };
                sum_rows(simd, self.window, 0, band, row_sums);
                sum_columns(simd, self.window, 0, row_sums, &mut plane[nodes.clone()]);
            }
        }
    }

    /// Warps the current picture onto one row of cells and multiplies the residual with the template.
    #[inline(always)]
    fn fill_band<S: Simd>(&self, simd: S, strip: &mut Strip, cell_row: usize) {
        let grid = self.template.grid;
        for k in (0..STRIDE).step_by(self.template.row_step) {
            let row = cell_row * STRIDE + k;
            let band = &mut strip.bands[cell_row % 2];
            let start = k * grid.padded_width();
            if !(MARGIN..MARGIN + grid.height).contains(&row) {
                for plane in band {
                    plane[start..][..grid.padded_width()].fill(0.0);
                }
                continue;
            }
            let [xs, ys] = &mut strip.positions;
            self.expander.row(simd, &mut strip.line, self.field, row, [xs, ys]);
            to_positions(grid, row, xs, ys);
            multiply_row(simd, self.template, self.current, row, [xs, ys], band, start);
        }
    }
}

fn split(plane: &mut [f32], node: usize) -> [&mut [f32]; 2] {
    plane.split_at_mut(node).into()
}

/// Converts displacements along padded row `row` to positions in the current picture. Padding gets a position outside
/// it.
#[inline(always)]
#[expect(clippy::cast_possible_wrap, reason = "the columns of an image")]
fn to_positions(grid: PatchGrid, row: usize, xs: &mut [f32], ys: &mut [f32]) {
    let y = row as f32 - MARGIN as f32;
    for (column, (x, v)) in xs.iter_mut().zip(ys.iter_mut()).enumerate() {
        *x += (column as i32 - MARGIN as i32) as f32; // integers of 32 bits are converted in one instruction
        *v += y;
    }
    xs[..MARGIN].fill(-1.0);
    xs[MARGIN + grid.width..].fill(-1.0);
    ys[MARGIN + grid.width..].fill(0.0);
}

#[simd]
fn multiply_row<S: Simd, const CHANNELS: usize>(
    simd: S,
    template: &Template,
    current: Current<'_, CHANNELS>,
    row: usize,
    [xs, ys]: [&[f32]; 2],
    band: &mut [Vec<f32>; PRODUCTS],
    start: usize,
) {
    for column in (0..xs.len()).step_by(LANES) {
        let x = f32x16::from_slice(simd, &xs[column..][..LANES]);
        let y = f32x16::from_slice(simd, &ys[column..][..LANES]);
        let places = Places::of(x, y, current.size());
        let inside = places.inside(simd);
        let samples = sample_row(simd, current.channels, &places);
        let products = products(simd, samples, current.gain, |channel| template.block(channel, column, row));
        let [gx, gy] = products.gradient;
        let [gain, offset] = products.light;
        for (plane, product) in band.iter_mut().zip([gx, gy, gain, offset, products.energy]) {
            (product * inside).store_slice(&mut plane[start + column..][..LANES]);
        }
    }
}
