//! Plans for single and double precision.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftDirection, FftNum, FftPlanner};

use crate::composed::composed;
use crate::widened::Widened;

/// A floating-point type for which plans exist.
pub trait Planned: FftNum {
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
        (composed(length, FftDirection::Forward), composed(length, FftDirection::Inverse))
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
