//! Plans of Fourier transforms.
//!
//! Single precision is for every frame and uses the processor's best instructions. Double precision is for preparation
//! and is composed of few kernels. The plans are a crate of their own because their kernels are compiled where they are
//! chosen, and take longer to compile than all mechanics: this way only once, not again for the tests of the mechanics.

mod composed;
mod planned;
mod widened;

pub use planned::Planned;
pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::num_complex::{Complex, Complex32, Complex64};
pub use rustfft::{Fft, FftNum};
