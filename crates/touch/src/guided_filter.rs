//! The fast guided filter: smooths noise away and keeps edges.
//!
//! In every square window the output is a line of the input, `a · I + b`, fitted to the input itself under a penalty
//! `ε a²`: with the window's mean μ and variance s², `a = s² / (s² + ε)` and `b = (1 − a) μ`. Where the input varies by
//! much more than √ε it is kept, where by much less it becomes the mean. A pixel takes the mean line of the windows
//! around it. He, Sun, Tang, "Guided Image Filtering", ECCV 2010; the lines vary slowly, so the fast form fits them on
//! an image subsampled by the mean of cells: He, Sun, "Fast Guided Filter", arXiv 1505.00996, 2015.
//!
//! The radius is one of the full-size image and is divided by the subsampling here; `OpenCV` takes it as one of the
//! subsampled image. Invalid pixels have no weight in any window: their values, even if not a number, affect no other
//! pixel.

use fearless_simd::{Level, dispatch, prelude::*};
use fearless_simd_macros::simd;
use fingervision_image::Image;
use serde::{Deserialize, Serialize};
use std::ops::Range;

use crate::ParameterError;

#[cfg(test)]
mod tests;

/// Values that are written at the same time; most cells have fewer pixels along a side.
const STEP: usize = 8;

/// Parameters of the guided filter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GuidedFilterParams {
    /// A window reaches this far from its centre, in px of the full-size image.
    pub radius_px: usize,
    /// Penalty ε on the slope, in squares of the input's unit: its root is the contrast that counts as an edge.
    pub epsilon: f64,
    /// Side of the cells on which windows are fitted, px; 1 fits them on every pixel.
    pub subsample: usize,
}

impl Default for GuidedFilterParams {
    /// Windows of 17 px, edges from a contrast of 0.01, cells of 4 px.
    fn default() -> Self {
        Self { radius_px: 8, epsilon: 1e-4, subsample: 4 }
    }
}

impl GuidedFilterParams {
    /// Checks every value against its range.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] names the first value out of range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let Self { radius_px, epsilon, subsample } = *self;
        let key = "density.filter.radius_px";
        ParameterError::unless((1..=256).contains(&radius_px), key, radius_px as f64, "1 to 256 px")?;
        let is_allowed = epsilon.is_finite() && epsilon > 0.0;
        ParameterError::unless(is_allowed, "density.filter.epsilon", epsilon, "above 0, finite")?;
        let is_allowed = (1..=radius_px).contains(&subsample);
        ParameterError::unless(is_allowed, "density.filter.subsample", subsample as f64, "1 to radius_px, px")
    }
}

/// Filters images of one size.
///
/// Owns its scratch memory: nothing is allocated per frame. The same image gives the same bits on every instruction set.
#[derive(Debug, Clone)]
pub struct GuidedFilter {
    /// Side of a cell, px.
    cell: usize,
    /// A window reaches this many cells from its centre.
    radius: usize,
    epsilon: f64,
    level: Level,
    /// Cells along a row, and rows of cells.
    size: (usize, usize),
    /// Number and sum of the valid pixels in each column of a row of cells.
    counts: Vec<f32>,
    sums: Vec<f32>,
    /// First `[n, n m, n m², 0]` of cells with `n` valid pixels of mean `m`, then `[1, a, b, 0]` of their windows' lines.
    cells: Vec<[f64; 4]>,
    windows: Vec<[f64; 4]>,
    window_columns: Vec<[f64; 4]>,
    /// For every pixel of a row, the distance from the centre of the cell before it, as a fraction.
    shares: Vec<f32>,
    /// Where every row lies between the centres of cells.
    down: Vec<Between>,
    /// The lines at every pixel of two rows through the centres of cells.
    lines: [LineRow; 2],
}

/// A position between the centres of two neighbouring cells, and its distance from the first as a fraction.
#[derive(Debug, Clone, Copy)]
struct Between {
    first: usize,
    second: usize,
    share: f32,
}

/// The mean lines of a row of cells, at its pixels.
#[derive(Debug, Clone)]
struct LineRow {
    slope: Interpolated,
    offset: Interpolated,
}

/// A number of the cells of a row, interpolated to its pixels.
#[derive(Debug, Clone)]
struct Interpolated {
    /// Half a cell of the first cell's number, then a cell of each number, to one cell behind the row: a pixel lies between the number
    /// at its place and that a cell farther. [`STEP`] more numbers are not used.
    steps: Vec<f32>,
    pixels: Vec<f32>,
}

impl GuidedFilter {
    /// A filter for images of this size, px.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] if a parameter is out of range.
    pub fn new(width: usize, height: usize, params: &GuidedFilterParams) -> Result<Self, ParameterError> {
        Self::with_level(width, height, params, Level::new())
    }

    fn with_level(
        width: usize,
        height: usize,
        params: &GuidedFilterParams,
        level: Level,
    ) -> Result<Self, ParameterError> {
        params.validate()?;
        let cell = params.subsample;
        let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));
        let interpolated = Interpolated { steps: vec![0.0; width + cell + STEP], pixels: vec![0.0; width] };
        let line_row = LineRow { slope: interpolated.clone(), offset: interpolated };
        Ok(Self {
            cell,
            radius: (params.radius_px + cell / 2) / cell,
            epsilon: params.epsilon,
            level,
            size: (columns, rows),
            counts: vec![0.0; width],
            sums: vec![0.0; width],
            cells: vec![[0.0; 4]; columns * rows],
            windows: vec![[0.0; 4]; columns * rows],
            window_columns: vec![[0.0; 4]; columns],
            shares: between_cells(width, cell).into_iter().map(|between| between.share).collect(),
            down: between_cells(height, cell),
            lines: [line_row.clone(), line_row],
        })
    }

    /// Writes the filtered image: `a · I + b` where `valid` is 1, and 0 where it is 0.
    ///
    /// # Panics
    ///
    /// If the images differ in size from the filter.
    pub fn filter_into(&mut self, image: &Image<f32>, valid: &Image<u8>, filtered: &mut Image<f32>) {
        let size = (self.shares.len(), self.down.len());
        assert_eq!((image.size(), valid.size(), filtered.size()), (size, size, size), "sizes of the images");
        if size.0 > 0 {
            dispatch!(self.level, simd => self.filter(simd, image, valid, filtered));
        }
    }

    #[simd]
    fn filter<S: Simd>(&mut self, simd: S, image: &Image<f32>, valid: &Image<u8>, filtered: &mut Image<f32>) {
        self.collect_cells(simd, image, valid);
        sum_windows(simd, &self.cells, self.radius, &mut self.window_columns, &mut self.windows);
        for (line, &[n, sum, squares, _]) in self.cells.iter_mut().zip(&self.windows) {
            *line = if n > 0.0 { fit_line(sum / n, squares / n, self.epsilon) } else { [0.0; 4] };
        }
        sum_windows(simd, &self.cells, self.radius, &mut self.window_columns, &mut self.windows);
        let mut next_row = 0;
        for (y, filtered) in filtered.rows_mut().enumerate() {
            let Between { first, second, share } = self.down[y];
            while next_row <= second {
                let windows = &self.windows[next_row * self.size.0..][..self.size.0];
                self.lines[next_row % 2].interpolate(simd, windows, self.cell, &self.shares);
                next_row += 1;
            }
            let (above, below) = (&self.lines[first % 2], &self.lines[second % 2]);
            apply_lines(simd, above, below, share, (image.row(y), valid.row(y)), filtered);
        }
    }

    /// Gathers the valid pixels of every cell. A cell at the right or lower edge may have fewer.
    #[simd]
    fn collect_cells<S: Simd>(&mut self, simd: S, image: &Image<f32>, valid: &Image<u8>) {
        for (row, cells) in self.cells.chunks_exact_mut(self.size.0).enumerate() {
            self.counts.fill(0.0);
            self.sums.fill(0.0);
            for y in row * self.cell..((row + 1) * self.cell).min(image.height()) {
                add_row(simd, image.row(y), valid.row(y), &mut self.counts, &mut self.sums);
            }
            let columns = self.counts.chunks(self.cell).zip(self.sums.chunks(self.cell));
            for (cell, (counts, sums)) in cells.iter_mut().zip(columns) {
                let (n, sum) = (f64::from(sum_of(counts)), f64::from(sum_of(sums)));
                *cell = if n > 0.0 { [n, sum, sum * sum / n, 0.0] } else { [0.0; 4] };
            }
        }
    }
}

impl LineRow {
    /// Interpolates the mean lines `[n, Σ a, Σ b, 0] / n` of a row of cells to its pixels.
    #[simd]
    fn interpolate<S: Simd>(&mut self, simd: S, windows: &[[f64; 4]], cell: usize, shares: &[f32]) {
        let Self { slope, offset } = self;
        let (mut from, mut to) = (0, cell / 2);
        for (column, &[n, slopes, offsets, _]) in windows.iter().enumerate() {
            let (a, b) = if n > 0.0 { ((slopes / n) as f32, (offsets / n) as f32) } else { (0.0, 0.0) };
            to = if column + 1 == windows.len() { shares.len() + cell } else { to + cell };
            slope.step(from..to, a);
            offset.step(from..to, b);
            from = to;
        }
        slope.interpolate(simd, cell, shares);
        offset.interpolate(simd, cell, shares);
    }
}

impl Interpolated {
    /// Sets the number of one cell; what is behind it has any value.
    #[inline(always)]
    fn step(&mut self, pixels: Range<usize>, value: f32) {
        let (step, rest) = self.steps[pixels.start..pixels.end + STEP].split_at_mut(STEP);
        step.copy_from_slice(&[value; STEP]);
        rest[..pixels.len().saturating_sub(STEP)].fill(value);
    }

    #[simd]
    fn interpolate<S: Simd>(&mut self, _: S, cell: usize, shares: &[f32]) {
        let between = self.steps.iter().zip(&self.steps[cell..]);
        for ((pixel, (before, behind)), share) in self.pixels.iter_mut().zip(between).zip(shares) {
            *pixel = before + share * (behind - before);
        }
    }
}

/// Places every pixel between the centres of its nearest cells; before the first and behind the last it takes theirs.
fn between_cells(length: usize, cell: usize) -> Vec<Between> {
    let last = length.div_ceil(cell).saturating_sub(1);
    let place = |x: usize| {
        let cells = ((x as f64 - 0.5 * (cell as f64 - 1.0)) / cell as f64).clamp(0.0, last as f64);
        let first = cells as usize;
        Between { first, second: (first + 1).min(last), share: (cells - first as f64) as f32 }
    };
    (0..length).map(place).collect()
}

/// `[1, a, b, 0]` of a window with this mean and this mean of squares.
#[inline]
fn fit_line(mean: f64, mean_square: f64, epsilon: f64) -> [f64; 4] {
    // Rounding may leave the variance of a constant just below zero.
    let variance = (mean_square - mean * mean).max(0.0);
    let slope = variance / (variance + epsilon);
    [1.0, slope, (1.0 - slope) * mean, 0.0]
}

/// Adds the valid pixels of a row to their columns.
#[simd]
fn add_row<S: Simd>(_: S, row: &[f32], valid: &[u8], counts: &mut [f32], sums: &mut [f32]) {
    for (((&value, &valid), count), sum) in row.iter().zip(valid).zip(counts).zip(sums) {
        *count += f32::from(valid);
        *sum += if valid == 1 { value } else { 0.0 };
    }
}

/// The sum of a few values. A loop, because the compiler does not use the instruction set in closures.
#[inline(always)]
fn sum_of(values: &[f32]) -> f32 {
    let mut sum = 0.0;
    for value in values {
        sum += value;
    }
    sum
}

/// Sums over the window of every cell, cut at the border, by running sums. In `f64` they do not drift.
#[simd]
fn sum_windows<S: Simd>(_: S, cells: &[[f64; 4]], radius: usize, columns: &mut [[f64; 4]], windows: &mut [[f64; 4]]) {
    let width = columns.len();
    let rows = cells.len() / width;
    let row = |y: usize| &cells[y * width..][..width];
    columns.fill([0.0; 4]);
    for y in 0..radius.min(rows) {
        columns.iter_mut().zip(row(y)).for_each(|(column, cell)| *column = add(*column, *cell));
    }
    for (y, windows) in windows.chunks_exact_mut(width).enumerate() {
        if y + radius < rows {
            columns.iter_mut().zip(row(y + radius)).for_each(|(column, cell)| *column = add(*column, *cell));
        }
        if y > radius {
            columns.iter_mut().zip(row(y - radius - 1)).for_each(|(column, cell)| *column = subtract(*column, *cell));
        }
        let mut sum = columns[..radius.min(width)].iter().fold([0.0; 4], |sum, &column| add(sum, column));
        for (x, window) in windows.iter_mut().enumerate() {
            if let Some(&column) = columns.get(x + radius) {
                sum = add(sum, column);
            }
            if x > radius {
                sum = subtract(sum, columns[x - radius - 1]);
            }
            *window = sum;
        }
    }
}

#[inline]
fn add(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

#[inline]
fn subtract(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

/// Applies to a row of the image the lines between two rows of lines.
#[simd]
fn apply_lines<S: Simd>(
    _: S,
    above: &LineRow,
    below: &LineRow,
    share: f32,
    (image, valid): (&[f32], &[u8]),
    filtered: &mut [f32],
) {
    let above = above.slope.pixels.iter().zip(&above.offset.pixels);
    let below = below.slope.pixels.iter().zip(&below.offset.pixels);
    let pixels = filtered.iter_mut().zip(image.iter().zip(valid));
    for ((filtered, (&value, &valid)), (above, below)) in pixels.zip(above.zip(below)) {
        let slope = above.0 + share * (below.0 - above.0);
        let offset = above.1 + share * (below.1 - above.1);
        *filtered = if valid == 1 { slope * value + offset } else { 0.0 };
    }
}
