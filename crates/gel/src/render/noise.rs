//! The sensor's noise and its rounding to 8 bits.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

/// Adds Gaussian noise of a standard deviation, in grey levels, to a row of values and rounds them.
///
/// Each row of each frame has its own random stream, so rows may be computed in any order. Clips at 0 and 255.
pub(crate) fn round_row(levels: &[f32], deviation: f32, stream: u64, bytes: &mut [u8]) {
    // Truncation rounds down, and saturates where a sensor clips.
    if deviation == 0.0 {
        bytes.iter_mut().zip(levels).for_each(|(byte, level)| *byte = (level + 0.5) as u8);
        return;
    }
    let mut rng = Pcg64Mcg::seed_from_u64(stream);
    for (byte, level) in bytes.iter_mut().zip(levels) {
        let noise: f32 = StandardNormal.sample(&mut rng);
        *byte = (level + deviation * noise + 0.5) as u8;
    }
}

/// The stream of a row of a frame.
pub(crate) fn stream(seed: u64, frame: u64, row: u64) -> u64 {
    mixed(mixed(mixed(seed) ^ frame) ^ row)
}

/// Spreads a number over 64 bits (Steele, Lea, Flood: *Fast splittable pseudorandom number generators*, 2014).
fn mixed(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_its_deviation_and_its_stream() {
        let noisy = |stream| {
            let mut bytes = vec![0; 40_000];
            round_row(&vec![120.25; 40_000], 2.0, stream, &mut bytes);
            bytes
        };
        let bytes = noisy(stream(1, 2, 3));
        let misses = || bytes.iter().map(|&byte| f64::from(byte) - 120.25);
        let (mean, variance) = (misses().sum::<f64>() / 4e4, misses().map(|miss| miss * miss).sum::<f64>() / 4e4);
        // Rounding adds 1/12.
        assert!(mean.abs() < 0.05 && (variance - 4.083).abs() < 0.12, "mean {mean}, variance {variance}");
        assert_eq!(bytes, noisy(stream(1, 2, 3)));
        for other in [stream(2, 2, 3), stream(1, 3, 3), stream(1, 2, 4), stream(1, 3, 2)] {
            assert_ne!(bytes, noisy(other));
        }
    }

    #[test]
    fn a_sensor_clips_and_rounds() {
        let mut bytes = [9; 5];
        round_row(&[-3.0, 0.4, 0.6, 254.6, 300.0], 0.0, 1, &mut bytes);
        assert_eq!(bytes, [0, 0, 1, 255, 255]);
    }
}
