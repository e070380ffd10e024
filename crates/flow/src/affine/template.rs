//! Quantities computed once per reference: its pixels, gradients and normal matrices.

mod blurred;

pub(crate) use self::blurred::BlurredTemplate;

use super::coarse_grids::CoarseBlocks;
use super::grid::{LANES, MARGIN, PatchGrid, STRIDE};
use super::moments::{Band, Window, sum_columns, sum_rows};
use super::nodes::UNKNOWNS;
use super::noise::Noise;
use super::own_variance::noise_gradient;
use super::products::{MID_LEVEL, TemplateBlock};
use super::symmetric::{PACKED, packed};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use fingervision_image::Image;
use std::ops::Range;
use std::sync::Arc;

/// A reference picture prepared for matching.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    pub(crate) grid: PatchGrid,
    channels: usize,
    /// Every `row_step`-th row is matched, counted from the padded top: 1, 2, 4 or 8.
    pub(crate) row_step: usize,
    /// Values filtered by the spline at whole pixels, their x gradient and their y gradient, row by row and in a row
    /// channel by channel: values that a kernel reads together are adjacent. Padded by the grid's margin; zero outside
    /// the image.
    lines: Arc<Vec<f32>>,
    /// Every so many rows are stored.
    stored: usize,
    /// `Σ w J Jᵀ` of every node with the change of light eliminated, packed, in grey levels² per px².
    pub(crate) normal: [Vec<f32>; PACKED],
    /// Inverse blocks of the nodes of coarser grids; see [`super::coarse_grids`].
    pub(crate) coarse: CoarseBlocks,
    /// Regression of the six gradient sums on the two light sums: `b ← b − light_gain · l`.
    pub(crate) light_gain: [[Vec<f32>; 2]; UNKNOWNS],
    /// Inverse of the light block: entries `(0,0)`, `(0,1)`, `(1,1)`.
    pub(crate) light_inverse: [Vec<f32>; 3],
    /// Sum of the weights of the pixels in the image, times the number of channels.
    pub(crate) samples: Vec<f32>,
    /// Variance of the levels in the window, grey levels².
    pub(crate) variance: Vec<f32>,
    /// The part of the squared gradient that noise does not explain, 0 to 1.
    pub(crate) signal: Vec<f32>,
    /// Variance of the displacement from the node's own patch, px²; see [`super::judge`].
    pub(crate) own_variance: Vec<f32>,
    /// The noise that the two above and the blocks are computed for.
    pub(crate) noise: Noise,
}

impl Template {
    /// An empty template for pictures of this size and number of channels, matched on every `row_step`-th row.
    pub(crate) fn new(grid: PatchGrid, channels: usize, row_step: usize) -> Self {
        Self::storing(grid, channels, row_step, 1)
    }

    /// As [`Template::new`], but only the rows that are matched are stored.
    pub(crate) fn sparse(grid: PatchGrid, channels: usize, row_step: usize) -> Self {
        Self::storing(grid, channels, row_step, row_step)
    }

    fn storing(grid: PatchGrid, channels: usize, row_step: usize, stored: usize) -> Self {
        let rows = grid.padded_height().div_ceil(stored);
        let lines = Arc::new(vec![0.0; 3 * channels * grid.padded_width() * rows]);
        Self { lines, stored, ..Self::sharing(grid, channels, row_step) }
    }

    /// As [`Template::new`], without pixels of its own: see [`Template::prepare_from`].
    pub(crate) fn sharing(grid: PatchGrid, channels: usize, row_step: usize) -> Self {
        let plane = || vec![0.0; grid.plane_len()];
        Self {
            grid,
            channels,
            row_step,
            lines: Arc::default(),
            stored: 1,
            normal: std::array::from_fn(|_| plane()),
            coarse: CoarseBlocks::new(),
            light_gain: std::array::from_fn(|_| std::array::from_fn(|_| plane())),
            light_inverse: std::array::from_fn(|_| plane()),
            samples: plane(),
            variance: plane(),
            signal: plane(),
            own_variance: plane(),
            noise: Noise::of(1.0),
        }
    }

    /// Squared gradient in each patch that has more of it than noise, mean of both axes, grey levels² per px².
    pub(crate) fn squared_gradients(&self, noise_levels: f32) -> impl Iterator<Item = f32> {
        let square = |node: usize| 0.5 * (self.normal[packed(0, 0)][node] + self.normal[packed(3, 3)][node]);
        let noise = move |node: usize| noise_gradient(self.samples[node], noise_levels.powi(2));
        (0..self.grid.nodes())
            .map(move |node| (square(node), noise(node)))
            .filter(|(square, noise)| square > noise)
            .map(|(square, _)| square)
    }

    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// Sixteen pixels of a channel in padded row `row` from padded column `column` on.
    #[inline(always)]
    pub(crate) fn block(&self, channel: usize, column: usize, row: usize) -> TemplateBlock<'_> {
        let width = self.grid.padded_width();
        let start = self.line(row, channel) + column;
        let lines = &self.lines[start..start + 2 * width + LANES];
        TemplateBlock {
            values: &lines[..LANES],
            gradient_x: &lines[width..][..LANES],
            gradient_y: &lines[2 * width..][..LANES],
        }
    }

    /// Where the three lines of a channel begin for a padded row.
    #[inline(always)]
    fn line(&self, row: usize, channel: usize) -> usize {
        3 * (row / self.stored * self.channels + channel) * self.grid.padded_width()
    }

    /// Prepares a new reference of the grid's size, with as many channels as the template has.
    pub(crate) fn prepare(&mut self, level: Level, channels: &[Image<f32>]) {
        assert_eq!(channels.len(), self.channels, "channels of the template");
        self.smooth(channels);
        self.sum(level);
    }

    /// Prepares the reference that another template was prepared for, whose pixels are then shared.
    pub(crate) fn prepare_from(&mut self, level: Level, other: &Self) {
        self.lines = Arc::clone(&other.lines);
        self.sum(level);
    }

    /// Gives up pixels that are shared, so that the other template can be prepared again without a copy of them.
    pub(crate) fn release(&mut self) {
        self.lines = Arc::default();
    }

    /// Sums the moments of all patches and sets their equations.
    fn sum(&mut self, level: Level) {
        let mut sums = PatchSums::new(self.grid);
        let rows = 0..self.grid.rows;
        dispatch!(level, simd => sums.fill(simd, self, rows));
        for node in 0..self.grid.nodes() {
            self.assemble(node, &sums.planes);
        }
    }

    /// Sets the channels, filtered by the cubic B-splines at whole pixels, with their gradients.
    fn smooth(&mut self, channels: &[Image<f32>]) {
        const VALUE: [f32; 3] = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
        const SLOPE: [f32; 3] = [-0.5, 0.0, 0.5];
        let padded = self.grid.padded_width();
        let mut pixels = std::mem::take(&mut self.lines);
        let lines = Arc::make_mut(&mut pixels);
        for (channel, image) in channels.iter().enumerate() {
            let (width, height) = image.size();
            for y in (0..height).filter(|y| (y + MARGIN).is_multiple_of(self.stored)) {
                let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| image.row(y));
                let start = self.line(y + MARGIN, channel) + MARGIN;
                for x in 0..width {
                    let columns = [x.saturating_sub(1), x, (x + 1).min(width - 1)];
                    let levels = rows.map(|row| columns.map(|x| row[x]));
                    lines[start + x] = weigh(&levels, VALUE, VALUE);
                    lines[start + x + padded] = weigh(&levels, SLOPE, VALUE);
                    lines[start + x + 2 * padded] = weigh(&levels, VALUE, SLOPE);
                }
            }
        }
        self.lines = pixels;
    }

    /// Sets a node's normal equations from its moments.
    fn assemble(&mut self, node: usize, planes: &[Vec<f32>; MOMENTS]) {
        let patch = PatchEquations::new(|moment| planes[moment][node]);
        for (plane, value) in self.normal.iter_mut().zip(patch.normal) {
            plane[node] = value;
        }
        for (planes, values) in self.light_gain.iter_mut().zip(patch.light_gain) {
            for (plane, value) in planes.iter_mut().zip(values) {
                plane[node] = value;
            }
        }
        for (plane, value) in self.light_inverse.iter_mut().zip(patch.light_inverse) {
            plane[node] = value;
        }
        (self.samples[node], self.variance[node]) = (patch.samples, patch.variance);
    }
}

/// A patch's normal equations, from which the change of light is eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PatchEquations {
    /// As [`Template::normal`].
    pub(crate) normal: [f32; PACKED],
    /// As [`Template::light_gain`].
    pub(crate) light_gain: [[f32; 2]; UNKNOWNS],
    /// As [`Template::light_inverse`].
    pub(crate) light_inverse: [f32; 3],
    /// As [`Template::samples`].
    pub(crate) samples: f32,
    /// As [`Template::variance`].
    pub(crate) variance: f32,
}

impl PatchEquations {
    /// The equations of a patch with these moments, in the order of [`MOMENTS`].
    pub(crate) fn new(moment: impl Fn(usize) -> f32) -> Self {
        let at = |place: usize| f64::from(moment(place));
        // Powers (x, y) of unknowns 1, ξ, η and the indices of the moments of their products.
        let product = |p: usize, q: usize| [[0, 1, 2], [1, 3, 4], [2, 4, 5]][p][q];
        let mut normal = [[0.0; UNKNOWNS]; UNKNOWNS];
        let mut cross = [[0.0; 2]; UNKNOWNS];
        for (i, (row, cross)) in normal.iter_mut().zip(&mut cross).enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = at(6 * (i / 3 + j / 3) + product(i % 3, j % 3));
            }
            *cross = [at(LIGHT + 6 * (i / 3) + i % 3), at(LIGHT + 6 * (i / 3) + 3 + i % 3)];
        }
        let (tt, t1, n) = (at(LIGHT + 12), at(LIGHT + 13), at(LIGHT + 14));
        // Regularisation by one grey level² keeps the matrix of a uniform window invertible.
        let (tt, n_regularised) = (tt + n + 1.0, n + 1.0);
        let determinant = tt * n_regularised - t1 * t1;
        let inverse = [n_regularised / determinant, -t1 / determinant, tt / determinant];
        let mut equations = Self { light_inverse: inverse.map(|value| value as f32), ..Self::default() };
        for i in 0..UNKNOWNS {
            let gain = [
                cross[i][0] * inverse[0] + cross[i][1] * inverse[1],
                cross[i][0] * inverse[1] + cross[i][1] * inverse[2],
            ];
            for j in 0..=i {
                let explained = gain[0] * cross[j][0] + gain[1] * cross[j][1];
                equations.normal[packed(i, j)] = (normal[i][j] - explained) as f32;
            }
            equations.light_gain[i] = gain.map(|gain| gain as f32);
        }
        equations.samples = n as f32;
        if n > 0.0 {
            equations.variance = ((tt - n - 1.0) / n - (t1 / n).powi(2)).max(0.0) as f32;
        }
        equations
    }
}

/// The sum of 3×3 levels with separable weights.
fn weigh(levels: &[[f32; 3]; 3], across: [f32; 3], down: [f32; 3]) -> f32 {
    let mut sum = 0.0;
    for (row, down) in levels.iter().zip(down) {
        for (level, across) in row.iter().zip(across) {
            sum += down * across * level;
        }
    }
    sum
}

/// Number of moments of the template, over its window, in a patch's equations.
///
/// Six moments (1, ξ, η, ξ², ξη, η²) of each of `gx gx`, `gx gy`, `gy gy`; then (1, ξ, η) of `gx t`, `gx`, `gy t`,
/// `gy`; then the sums of `t²`, `t` and 1, where `t` is the level minus [`MID_LEVEL`].
pub(crate) const MOMENTS: usize = LIGHT + 15;
/// The first moment that describes the change of light.
const LIGHT: usize = 18;

/// A plane over the nodes for each moment.
#[derive(Debug, Clone)]
struct PatchSums {
    grid: PatchGrid,
    window: Window,
    planes: [Vec<f32>; MOMENTS],
    /// The ten products in the rows that a row of patches covers: upper and lower half.
    bands: [[Vec<f32>; 10]; 2],
    row_sums: Vec<f32>,
}

impl PatchSums {
    fn new(grid: PatchGrid) -> Self {
        let band = || std::array::from_fn(|_| vec![0.0; STRIDE * grid.padded_width()]);
        Self {
            grid,
            window: Window::new(),
            planes: std::array::from_fn(|_| vec![0.0; grid.plane_len()]),
            bands: [band(), band()],
            row_sums: vec![0.0; grid.padded_width()],
        }
    }

    /// Sums over the windows of some rows of patches.
    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, template: &Template, rows: Range<usize>) {
        if rows.is_empty() {
            return;
        }
        fill_band(simd, template, rows.start, &mut self.bands[1]);
        for j in rows {
            self.bands.swap(0, 1);
            fill_band(simd, template, j + 1, &mut self.bands[1]);
            for product in 0..10 {
                self.reduce(simd, j, product, template.row_step);
            }
        }
    }

    /// All moments of one product for a row of patches.
    #[inline(always)]
    fn reduce<S: Simd>(&mut self, simd: S, j: usize, product: usize, step: usize) {
        // First plane and highest total power of the product's moments.
        let (first, degree) = match product {
            0..=2 => (6 * product, 2),
            3..=6 => (LIGHT + 3 * (product - 3), 1),
            _ => (LIGHT + 12 + product - 7, 0),
        };
        let band = Band { halves: [&self.bands[0][product], &self.bands[1][product]], step };
        let nodes = j * self.grid.columns..(j + 1) * self.grid.columns;
        for power_y in 0..=degree {
            sum_rows(simd, &self.window, power_y, band, &mut self.row_sums);
            for power_x in 0..=degree - power_y {
                let place = match (power_x, power_y) {
                    (0, 0) => 0,
                    (1, 0) => 1,
                    (0, 1) => 2,
                    (2, _) => 3,
                    (1, _) => 4,
                    _ => 5,
                };
                let moments = &mut self.planes[first + place][nodes.clone()];
                sum_columns(simd, &self.window, power_x, &self.row_sums, moments);
            }
        }
    }
}

/// The ten products over the [`STRIDE`] padded rows of a cell row.
#[simd]
fn fill_band<S: Simd>(simd: S, template: &Template, cell_row: usize, band: &mut [Vec<f32>; 10]) {
    let _ = simd;
    let PatchGrid { width, height, .. } = template.grid;
    let stride = template.grid.padded_width();
    for k in (0..STRIDE).step_by(template.row_step) {
        let row = cell_row * STRIDE + k;
        let inside_y = (MARGIN..MARGIN + height).contains(&row);
        for column in 0..stride {
            let inside = inside_y && (MARGIN..MARGIN + width).contains(&column);
            let products = if inside { products(template, row, column) } else { [0.0; 10] };
            for (band, product) in band.iter_mut().zip(products) {
                band[k * stride + column] = product;
            }
        }
    }
}

#[inline(always)]
fn products(template: &Template, row: usize, column: usize) -> [f32; 10] {
    let padded = template.grid.padded_width();
    let mut sums = [0.0; 10];
    for channel in 0..template.channels {
        let place = template.line(row, channel) + column;
        let t = template.lines[place] - MID_LEVEL;
        let (gx, gy) = (template.lines[place + padded], template.lines[place + 2 * padded]);
        for (sum, product) in sums.iter_mut().zip([gx * gx, gx * gy, gy * gy, gx * t, gx, gy * t, gy, t * t, t, 1.0]) {
            *sum += product;
        }
    }
    sums
}
