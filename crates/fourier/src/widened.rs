//! Transforms of real values, computed by complex ones.

use std::sync::Arc;

use realfft::{ComplexToReal, FftError, RealToComplex};
use rustfft::Fft;
use rustfft::num_complex::{Complex, Complex64};

/// A transform of real values by a complex transform of the same length, at twice the cost.
pub(crate) struct Widened(pub(crate) Arc<dyn Fft<f64>>);

impl Widened {
    fn length(&self) -> usize {
        self.0.len()
    }

    /// The complex values of the whole length, then the plan's own scratch memory.
    fn scratch_length(&self) -> usize {
        self.length() + self.0.get_inplace_scratch_len()
    }

    fn zeros(length: usize) -> Vec<Complex64> {
        vec![Complex::new(0.0, 0.0); length]
    }
}

impl RealToComplex<f64> for Widened {
    fn process(&self, input: &mut [f64], output: &mut [Complex64]) -> Result<(), FftError> {
        RealToComplex::process_with_scratch(self, input, output, &mut Self::zeros(self.scratch_length()))
    }

    fn process_with_scratch(
        &self,
        input: &mut [f64],
        output: &mut [Complex64],
        scratch: &mut [Complex64],
    ) -> Result<(), FftError> {
        let (whole, scratch) = scratch.split_at_mut(self.length());
        for (value, input) in whole.iter_mut().zip(input) {
            *value = Complex::new(*input, 0.0);
        }
        self.0.process_with_scratch(whole, scratch);
        output.copy_from_slice(&whole[..output.len()]);
        Ok(())
    }

    fn get_scratch_len(&self) -> usize {
        self.scratch_length()
    }

    fn len(&self) -> usize {
        self.length()
    }

    fn make_input_vec(&self) -> Vec<f64> {
        vec![0.0; self.length()]
    }

    fn make_output_vec(&self) -> Vec<Complex64> {
        Self::zeros(self.length() / 2 + 1)
    }

    fn make_scratch_vec(&self) -> Vec<Complex64> {
        Self::zeros(self.scratch_length())
    }
}

impl ComplexToReal<f64> for Widened {
    fn process(&self, input: &mut [Complex64], output: &mut [f64]) -> Result<(), FftError> {
        ComplexToReal::process_with_scratch(self, input, output, &mut Self::zeros(self.scratch_length()))
    }

    fn process_with_scratch(
        &self,
        input: &mut [Complex64],
        output: &mut [f64],
        scratch: &mut [Complex64],
    ) -> Result<(), FftError> {
        let length = self.length();
        let (whole, scratch) = scratch.split_at_mut(length);
        whole[..input.len()].copy_from_slice(input);
        for frequency in input.len()..length {
            whole[frequency] = input[length - frequency].conj();
        }
        self.0.process_with_scratch(whole, scratch);
        for (output, value) in output.iter_mut().zip(whole) {
            *output = value.re;
        }
        Ok(())
    }

    fn get_scratch_len(&self) -> usize {
        self.scratch_length()
    }

    fn len(&self) -> usize {
        self.length()
    }

    fn make_input_vec(&self) -> Vec<Complex64> {
        Self::zeros(self.length() / 2 + 1)
    }

    fn make_output_vec(&self) -> Vec<f64> {
        vec![0.0; self.length()]
    }

    fn make_scratch_vec(&self) -> Vec<Complex64> {
        Self::zeros(self.scratch_length())
    }
}
