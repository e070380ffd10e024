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
