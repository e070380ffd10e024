//! The Fourier transform of fields on a grid, padded with zeros.

use std::sync::Arc;

use fingervision_fourier::{Complex, ComplexToReal, Fft, FftNum, Planned, RealToComplex};

/// Rows that are transposed to columns at a time: their neighbours in a column then share a cache line.
const BAND: usize = 8;

/// Plans for one size, with their scratch memory. A spectrum contains the frequencies `0 ..= width / 2` along x, each
/// with all `height` frequencies along y next to each other.
pub(super) struct Transform<T: FftNum> {
    width: usize,
    height: usize,
    forward_rows: Arc<dyn RealToComplex<T>>,
    inverse_rows: Arc<dyn ComplexToReal<T>>,
    forward_columns: Arc<dyn Fft<T>>,
    inverse_columns: Arc<dyn Fft<T>>,
    row: Vec<T>,
    /// Spectra of the rows of a band, row by row.
    band: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
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

impl<T: Planned> Transform<T> {
    /// A transform of `width` by `height` values.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let (forward_rows, inverse_rows) = T::real(width);
        let (forward_columns, inverse_columns) = T::complex(height);
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
            band: vec![zero(); BAND * (width / 2 + 1)],
            scratch: vec![zero(); needs.into_iter().max().unwrap_or(0)],
            forward_rows,
            inverse_rows,
            forward_columns,
            inverse_columns,
        }
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

    pub(super) fn spectrum(&self) -> Vec<Complex<T>> {
        vec![zero(); self.columns() * self.height]
    }

    /// The spectrum of a field of `rows` rows, which `value` gives by column and row; zero beyond `columns` and `rows`.
    pub(super) fn forward_into(
        &mut self,
        (columns, rows): (usize, usize),
        value: impl Fn(usize, usize) -> T,
        spectrum: &mut [Complex<T>],
    ) {
        let (height, width) = (self.height, self.columns());
        for first in (0..rows).step_by(BAND) {
            let count = BAND.min(rows - first);
            for (row, target) in (first..first + count).zip(self.band.chunks_exact_mut(width)) {
                for (column, target) in self.row[..columns].iter_mut().enumerate() {
                    *target = value(column, row);
                }
                if self.row[..columns].iter().all(T::is_zero) {
                    target.fill(zero());
                    continue;
                }
                self.row[columns..].fill(T::zero());
                self.forward_rows
                    .process_with_scratch(&mut self.row, target, &mut self.scratch)
                    .expect("buffers are made for the plan");
            }
            for (column, target) in spectrum.chunks_exact_mut(height).enumerate() {
                for (row, target) in target[first..first + count].iter_mut().enumerate() {
                    *target = self.band[row * width + column];
                }
            }
        }
        spectrum.chunks_exact_mut(height).for_each(|column| column[rows..].fill(zero()));
        self.forward_columns.process_with_scratch(spectrum, &mut self.scratch);
    }

    /// Passes the first `rows` rows of the field of a spectrum to `write`, times `width · height`. The spectrum is
    /// overwritten.
    pub(super) fn inverse_into(
        &mut self,
        rows: usize,
        spectrum: &mut [Complex<T>],
        mut write: impl FnMut(usize, &[T]),
    ) {
        let (height, width) = (self.height, self.columns());
        self.inverse_columns.process_with_scratch(spectrum, &mut self.scratch);
        for first in (0..rows).step_by(BAND) {
            let count = BAND.min(rows - first);
            for (column, values) in spectrum.chunks_exact(height).enumerate() {
                for (row, value) in values[first..first + count].iter().enumerate() {
                    self.band[row * width + column] = *value;
                }
            }
            for (row, values) in (first..first + count).zip(self.band.chunks_exact_mut(width)) {
                // The first and last values of a real field's spectrum are real, except for rounding.
                values[0].im = T::zero();
                if self.width.is_multiple_of(2) {
                    values[width - 1].im = T::zero();
                }
                self.inverse_rows
                    .process_with_scratch(values, &mut self.row, &mut self.scratch)
                    .expect("buffers are made for the plan");
                write(row, &self.row);
            }
        }
    }
}

fn zero<T: FftNum>() -> Complex<T> {
    Complex::new(T::zero(), T::zero())
}

impl<T: FftNum> std::fmt::Debug for Transform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Transform({}x{})", self.width, self.height)
    }
}
