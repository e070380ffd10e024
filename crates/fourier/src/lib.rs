//! Plans of Fourier transforms.
//!
//! Single precision is for work in every frame and uses the fastest instructions of the processor. Double precision is
//! for preparation and uses only a few kernels. The kernels are compiled in the crate that selects them, and they take
//! longer to compile than the whole crate of the mechanics. In a crate of their own they are compiled once, and not
//! again for the tests of the mechanics.

mod composed;
mod planned;
mod widened;

pub use planned::Planned;
pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::num_complex::{Complex, Complex32, Complex64};
pub use rustfft::{Fft, FftNum};
