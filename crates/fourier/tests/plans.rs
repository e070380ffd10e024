//! Transforms of all lengths, against the sum by definition and against the other precision.
//!
//! They are not unit tests because the kernels would then be compiled twice.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use fingervision_fourier::{Complex, Fft, Planned};
use rustfft::FftDirection;
use rustfft::algorithm::Dft;

#[test]
fn every_length_gives_the_sum_by_definition() {
    for length in (0..=64).chain([97, 120, 127, 243, 256, 360, 625, 1009, 1018]) {
        let (forward, inverse) = f64::complex(length);
        for (plan, direction) in [(forward, FftDirection::Forward), (inverse, FftDirection::Inverse)] {
            let value = |index: usize| Complex::new((1.0 + 3.7 * index as f64).sin(), (2.3 * index as f64).cos());
            let mut values: Vec<_> = (0..length).map(value).collect();
            let mut expected = values.clone();
            Dft::new(length, direction).process(&mut expected);
            assert_eq!((plan.len(), plan.fft_direction()), (length, direction));
            plan.process(&mut values);
            for (value, expected) in values.iter().zip(&expected) {
                let difference = (value - expected).norm();
                assert!(difference < 1e-10, "length {length}, {direction}: {value} and {expected}");
            }
        }
    }
}

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
