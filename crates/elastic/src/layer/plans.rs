//! Plans of Fourier transforms by precision.
//!
//! Single precision is for every frame and uses the processor's best instructions. Double precision is for preparation:
//! it has the plain kernels only, because the planner that selects by instruction set contains all kernels of both
//! precisions, half of this crate's machine code and build time.

use std::sync::Arc;

use realfft::{ComplexToReal, FftError, RealFftPlanner, RealToComplex};
use rustfft::num_complex::{Complex, Complex64};
use rustfft::{Fft, FftNum, FftPlanner, FftPlannerScalar};

/// A precision that has plans.
pub(super) trait Planned: FftNum {
    /// Transforms of `length` real values, forward and inverse.
    fn real(length: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>);

    /// Transforms of `length` complex values, forward and inverse.
    fn complex(length: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>);
}

impl Planned for f32 {
    fn real(length: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>) {
        let mut planner = RealFftPlanner::new();
        (planner.plan_fft_forward(length), planner.plan_fft_inverse(length))
    }

    fn complex(length: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>) {
        let mut planner = FftPlanner::new();
        (planner.plan_fft_forward(length), planner.plan_fft_inverse(length))
    }
}

impl Planned for f64 {
    fn real(length: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>) {
        let (forward, inverse) = Self::complex(length);
        (Arc::new(Widened(forward)), Arc::new(Widened(inverse)))
    }

    fn complex(length: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>) {
        let mut planner = FftPlannerScalar::new();
        (planner.plan_fft_forward(length), planner.plan_fft_inverse(length))
    }
}

/// A transform of real values by a complex transform of the same length, at twice the cost.
struct Widened(Arc<dyn Fft<f64>>);

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_precisions_give_the_same_spectrum_and_return_the_values() {
        for length in [1, 2, 9, 10, 24] {
            let values: Vec<f64> = (0..length).map(|index| (1.0 + 3.7 * index as f64).sin()).collect();
            let (forward, inverse) = f64::real(length);
            let mut spectrum = forward.make_output_vec();
            forward.process(&mut values.clone(), &mut spectrum).unwrap();
            let (narrow, _) = f32::real(length);
            let mut expected = narrow.make_output_vec();
            let mut single: Vec<f32> = values.iter().map(|&value| value as f32).collect();
            narrow.process(&mut single, &mut expected).unwrap();
            for (value, expected) in spectrum.iter().zip(&expected) {
                let difference = (value.re - f64::from(expected.re)).hypot(value.im - f64::from(expected.im));
                assert!(difference < 1e-5, "length {length}: {value} and {expected}");
            }
            let mut returned = inverse.make_output_vec();
            inverse.process(&mut spectrum, &mut returned).unwrap();
            for (value, expected) in returned.iter().zip(&values) {
                assert!((value / length as f64 - expected).abs() < 1e-12, "length {length}: {value} and {expected}");
            }
        }
    }
}
