//! The forward–backward check of a flow.

use crate::FlowField;
use fingervision_image::{Between, Image};

/// Writes the inverse of `flow`: `inverse(y) = −flow(y + inverse(y))`, by this many fixed-point iterations.
///
/// It converges where the flow's gradient is below 1. Outside the image, the value at the border is used.
pub fn invert_into(flow: &FlowField, passes: usize, inverse: &mut FlowField) {
    let (width, height) = flow.size();
    inverse.copy_from(flow);
    for plane in [&mut inverse.u, &mut inverse.v] {
        plane.values_mut().iter_mut().for_each(|value| *value = -*value);
    }
    for _ in 0..passes {
        for y in 0..height {
            for x in 0..width {
                let (u, v) = (inverse.u.at(x, y), inverse.v.at(x, y));
                let (back_u, back_v) = sample(flow, x as f32 + u, y as f32 + v);
                inverse.u.row_mut(y)[x] = -back_u;
                inverse.v.row_mut(y)[x] = -back_v;
            }
        }
    }
}

/// Writes the length of `forward(x) + backward(x + forward(x))` at every pixel, px: the distance between the end of the
/// round trip and its start.
pub fn round_trip_error_into(forward: &FlowField, backward: &FlowField, error: &mut Image<f32>) {
    for (y, row) in error.rows_mut().enumerate() {
        for (x, error) in row.iter_mut().enumerate() {
            let (u, v) = (forward.u.at(x, y), forward.v.at(x, y));
            let (back_u, back_v) = sample(backward, x as f32 + u, y as f32 + v);
            *error = (u + back_u).hypot(v + back_v);
        }
    }
}

/// The flow between pixels: bilinear, clamped to the image.
fn sample(flow: &FlowField, x: f32, y: f32) -> (f32, f32) {
    let place = Between::clamped((x, y), flow.size());
    (place.sample(&flow.u), place.sample(&flow.v))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(s: f32) -> FlowField {
        FlowField {
            u: Image::from_fn(60, 50, |x, _| s * (x as f32 - 29.5)),
            v: Image::from_fn(60, 50, |_, y| s * (y as f32 - 24.5)),
        }
    }

    #[test]
    fn a_compression_and_its_inverse_close_the_round_trip() {
        let (compression, mut inverse) = (stretch(-0.2), FlowField::zero(60, 50));
        invert_into(&compression, 20, &mut inverse);
        let mut error = Image::filled(60, 50, f32::NAN);
        round_trip_error_into(&compression, &inverse, &mut error);
        // Near the border the inverse depends on flow from outside the image.
        let inner = error.rows().skip(4).take(42).flat_map(|row| &row[4..56]);
        let largest = inner.copied().reduce(f32::max).unwrap();
        assert!(largest < 1e-3, "the round trip is off by {largest} px");
        assert!((inverse.u.at(40, 25) - 0.25 * 10.5).abs() < 1e-3, "{}", inverse.u.at(40, 25));
    }

    #[test]
    fn a_wrong_backward_flow_has_its_error() {
        let mut error = Image::filled(60, 50, 0.0);
        let forward = FlowField { u: Image::filled(60, 50, 3.0), v: Image::filled(60, 50, 0.0) };
        let backward = FlowField { u: Image::filled(60, 50, -2.5), v: Image::filled(60, 50, 0.0) };
        round_trip_error_into(&forward, &backward, &mut error);
        assert!(error.values().iter().all(|error| (error - 0.5).abs() < 1e-6));
    }
}
