//! Numbers that summarise the fields of a reading.

use fearless_simd::{Level, dispatch, f32x16, prelude::*};
use fearless_simd_macros::simd;
use fingervision_image::Image;

/// Values that are compared at the same time.
const LANES: usize = 16;

/// Number of ones among zeros and ones.
pub(super) fn count_ones(values: &[u8]) -> u32 {
    dispatch!(Level::new(), simd => sum(simd, values))
}

/// Largest value where `valid` is 1 and not 0; none if no pixel is valid or the largest value is infinite. Values that are not numbers
/// are skipped.
pub(super) fn largest_valid(values: &Image<f32>, valid: &Image<u8>) -> Option<f32> {
    let largest = dispatch!(Level::new(), simd => largest(simd, values.values(), valid.values()));
    Some(largest).filter(|largest| largest.is_finite())
}

#[simd]
fn sum<S: Simd>(_: S, values: &[u8]) -> u32 {
    let (parts, rest) = values.as_chunks::<128>();
    let mut total = 0;
    for part in parts {
        // The sum of a short part fits into a byte, so a register adds many at a time.
        let mut ones = 0_u8;
        for &value in part {
            ones += value;
        }
        total += u32::from(ones);
    }
    for &value in rest {
        total += u32::from(value);
    }
    total
}

#[simd]
fn largest<S: Simd>(simd: S, values: &[f32], valid: &[u8]) -> f32 {
    let ((chunks, rest), (marks, rest_marks)) = (values.as_chunks::<LANES>(), valid.as_chunks::<LANES>());
    let least = f32x16::splat(simd, f32::NEG_INFINITY);
    let mut lanes = least;
    for (values, marks) in chunks.iter().zip(marks) {
        let mut is_valid = [0.0; LANES];
        for k in 0..LANES {
            is_valid[k] = f32::from(marks[k]);
        }
        let values = f32x16::load_array_ref(simd, values);
        let values = f32x16::load_array(simd, is_valid).simd_gt(0.5).select(values, least);
        lanes = values.simd_gt(lanes).select(values, lanes); // false for what is not a number
    }
    let mut largest = f32::NEG_INFINITY;
    for value in lanes.to_array() {
        largest = largest.max(value);
    }
    for (&value, &mark) in rest.iter().zip(rest_marks) {
        largest = if mark == 1 { largest.max(value) } else { largest };
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ones_are_counted_in_parts_of_any_length() {
        for length in [0, 1, 127, 128, 129, 1000] {
            let values: Vec<u8> = (0..length).map(|i| u8::from(i * i % 7 == 2)).collect();
            let expected: u32 = values.iter().copied().map(u32::from).sum();
            assert_eq!(count_ones(&values), expected, "{length}");
            assert_eq!(count_ones(&vec![1; length]) as usize, length);
        }
    }

    #[test]
    fn the_largest_valid_value_is_found_wherever_it_is() {
        let (width, height) = (7, 5);
        for place in 0..width * height {
            let mut values = Image::from_fn(width, height, |x, y| if (x + y) % 2 == 0 { f32::NAN } else { -2.0 });
            let mut valid = Image::from_fn(width, height, |x, y| ((x + y) % 2) as u8);
            values.values_mut()[place] = -1.0;
            valid.values_mut()[place] = 1;
            assert_eq!(largest_valid(&values, &valid), Some(-1.0), "at {place}");
            valid.values_mut().fill(0);
            assert_eq!(largest_valid(&values, &valid), None);
        }
    }
}
