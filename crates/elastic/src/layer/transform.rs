//! The Fourier transform of fields on a grid, padded with zeros.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

/// Plans for one size, with their scratch. A spectrum holds the frequencies `0 ..= width / 2` along x, each with all
/// `height` frequencies along y side by side.
pub(super) struct Transform {
    width: usize,
    height: usize,
    forward_rows: Arc<dyn RealToComplex<f64>>,
    inverse_rows: Arc<dyn ComplexToReal<f64>>,
    forward_columns: Arc<dyn Fft<f64>>,
    inverse_columns: Arc<dyn Fft<f64>>,
    row: Vec<f64>,
    row_spectrum: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Transform {
    /// A transform of `width` by `height` values.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let mut rows = RealFftPlanner::new();
        let mut columns = FftPlanner::new();
        let (forward_rows, inverse_rows) = (rows.plan_fft_forward(width), rows.plan_fft_inverse(width));
        let (forward_columns, inverse_columns) = (columns.plan_fft_forward(height), columns.plan_fft_inverse(height));
        let needs = [
            forward_rows.get_scratch_len(),
            inverse_rows.get_scratch_len(),
            forward_columns.get_inplace_scratch_len(),
            inverse_columns.get_inplace_scratch_len(),
        ];
        Self {
            width,
            height,
            row: forward_rows.make_input_vec(),
            row_spectrum: forward_rows.make_output_vec(),
            scratch: vec![Complex64::default(); needs.into_iter().max().unwrap_or(0)],
            forward_rows,
            inverse_rows,
            forward_columns,
            inverse_columns,
        }
    }

    /// The smallest length from `least` on that has no prime factor above 5.
    pub(super) fn good_length(least: usize) -> usize {
        let strip = |mut rest: usize, factor: usize| {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
            rest
        };
        let mut length = least.max(1);
        while [2, 3, 5].into_iter().fold(length, strip) > 1 {
            length += 1;
        }
        length
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn height(&self) -> usize {
        self.height
    }

    /// Frequencies along x in a spectrum.
    pub(super) fn columns(&self) -> usize {
        self.width / 2 + 1
    }

    pub(super) fn spectrum(&self) -> Vec<Complex64> {
        vec![Complex64::default(); self.columns() * self.height]
    }

    /// The spectrum of a field of `rows` rows, which `value` gives by column and row; zero beyond `columns` and `rows`.
    pub(super) fn forward_into(
        &mut self,
        (columns, rows): (usize, usize),
        value: impl Fn(usize, usize) -> f64,
        spectrum: &mut [Complex64],
    ) {
        let height = self.height;
        spectrum.fill(Complex64::default());
        for row in 0..rows {
            for (column, target) in self.row.iter_mut().enumerate() {
                *target = if column < columns { value(column, row) } else { 0.0 };
            }
            self.forward_rows
                .process_with_scratch(&mut self.row, &mut self.row_spectrum, &mut self.scratch)
                .expect("buffers are made for the plan");
            for (column, &value) in self.row_spectrum.iter().enumerate() {
                spectrum[column * height + row] = value;
            }
        }
        self.forward_columns.process_with_scratch(spectrum, &mut self.scratch);
    }

    /// Hands the first `rows` rows of the field of a spectrum to `write`, times `width · height`. The spectrum is spent.
    pub(super) fn inverse_into(
        &mut self,
        rows: usize,
        spectrum: &mut [Complex64],
        mut write: impl FnMut(usize, &[f64]),
    ) {
        let height = self.height;
        self.inverse_columns.process_with_scratch(spectrum, &mut self.scratch);
        let last = self.row_spectrum.len() - 1;
        for row in 0..rows {
            for (column, value) in self.row_spectrum.iter_mut().enumerate() {
                *value = spectrum[column * height + row];
            }
            // A real field has real ends; rounding leaves a trace there.
            self.row_spectrum[0].im = 0.0;
            if self.width.is_multiple_of(2) {
                self.row_spectrum[last].im = 0.0;
            }
            self.inverse_rows
                .process_with_scratch(&mut self.row_spectrum, &mut self.row, &mut self.scratch)
                .expect("buffers are made for the plan");
            write(row, &self.row);
        }
    }
}

impl std::fmt::Debug for Transform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Transform({}x{})", self.width, self.height)
    }
}
