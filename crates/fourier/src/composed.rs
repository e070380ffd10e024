//! Transforms of any length in double precision, composed of short transforms.
//!
//! A length that is not prime is split into two factors that are as equal as possible. A short prime length is summed
//! by the definition, a long one uses Bluestein's algorithm. The planners of `rustfft` have faster transforms for many
//! lengths. All of these would be compiled, several times the machine code of this file, for transforms that are needed
//! only once.

use std::sync::Arc;

use rustfft::algorithm::butterflies::{Butterfly2, Butterfly3, Butterfly4, Butterfly5, Butterfly8};
use rustfft::algorithm::{BluesteinsAlgorithm, Dft, MixedRadix};
use rustfft::{Fft, FftDirection};

/// The longest prime length that is summed by definition.
const LONGEST_SUM: usize = 31;

/// A transform of `length` values.
pub(crate) fn composed(length: usize, direction: FftDirection) -> Arc<dyn Fft<f64>> {
    match length {
        2 => Arc::new(Butterfly2::new(direction)),
        3 => Arc::new(Butterfly3::new(direction)),
        4 => Arc::new(Butterfly4::new(direction)),
        5 => Arc::new(Butterfly5::new(direction)),
        8 => Arc::new(Butterfly8::new(direction)),
        _ => match balanced_factors(length) {
            Some(factors) => {
                let [width, height] = factors.map(|factor| composed(factor, direction));
                Arc::new(MixedRadix::new(width, height))
            }
            None if length <= LONGEST_SUM => Arc::new(Dft::new(length, direction)),
            None => {
                let inner = (2 * length - 1).next_power_of_two();
                Arc::new(BluesteinsAlgorithm::new(length, composed(inner, direction)))
            }
        },
    }
}

/// Two factors above 1 that are as equal as possible; `None` for a prime.
fn balanced_factors(length: usize) -> Option<[usize; 2]> {
    let factor = (2..=length.isqrt()).rev().find(|factor| length.is_multiple_of(*factor))?;
    Some([factor, length / factor])
}
