//! A ball that is pressed, then moves on: stuck, sliding, spreading.

use super::super::rigid::tests::{show_at, surface};
use super::*;

const NOISE_MM: f64 = 0.003;
const THICKNESS_MM: f64 = 10.0;

/// Depth under a ball of radius 25 mm, 1 mm deep, mm.
fn depth_mm([x, y]: [f64; 2]) -> f64 {
    1.0 - (x * x + y * y) / 50.0
}

/// The ball's shape is taken, then contact is seen at these positions, mm, with a network that finds it this many times as
/// deep as it was. The depth of the shape where it sticks, cell by cell, and what it was.
fn depths_after(moves: impl Fn([f64; 3]) -> [f64; 3], error: f32) -> Vec<(f64, f64)> {
    let mut surface = surface();
    let ball = |[x, y]: [f64; 2]| [x, y, depth_mm([x, y]).max(0.0)];
    let cells = surface.seen.len();
    let touches: Vec<_> = (0..cells).map(|cell| depth_mm(surface.centre_mm(cell)) > 0.3).collect();
    let depths: Vec<_> = (0..cells).map(|cell| ball(surface.centre_mm(cell))[2] as f32).collect();
    show_at(&mut surface, ball);
    let mut shape = StuckShape::new(cells);
    shape.take(&surface, &touches, &depths, |_| 0.01);
    show_at(&mut surface, |rest| moves(ball(rest)));
    let inner: Vec<_> = (0..cells).filter(|&cell| touches[cell]).collect();
    let by_network: Vec<_> = depths.iter().map(|depth_mm| error * depth_mm).collect();
    let moved = shape.motion(&surface, (&inner, &by_network), NOISE_MM, THICKNESS_MM, &mut Vec::new());
    let Some(moved) = moved else { return Vec::new() };
    let depth_mm = |cell: usize| Some((f64::from(shape.depth_mm(&surface, cell, &moved)?[0]), f64::from(depths[cell])));
    (0..cells).filter_map(depth_mm).collect()
}

#[test]
fn contact_that_is_dragged_and_pressed_on_keeps_its_shape() {
    for deeper_mm in [-0.1, 0.0, 0.2] {
        let after = depths_after(|[x, y, z]| [x + 1.2, y - 0.5, z + deeper_mm], 1.3);
        assert!(after.len() > 40, "{} cells stick", after.len());
        for (found_mm, was_mm) in after {
            assert!((found_mm - was_mm - deeper_mm).abs() < 1e-3, "{found_mm} mm, and before {was_mm}");
        }
    }
}

#[test]
fn contact_that_is_twisted_keeps_its_shape() {
    let (sin, cos) = 0.2_f64.sin_cos();
    let after = depths_after(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z], 0.8);
    assert!(after.len() > 40 && after.iter().all(|(found_mm, was_mm)| (found_mm - was_mm).abs() < 1e-3));
}

#[test]
fn contact_that_slides_or_spreads_does_not_keep_it() {
    let lags = |[x, y, z]: [f64; 3]| [x + 0.5 + 0.03 * x, y + 0.02 * y * x, z];
    assert!(depths_after(lags, 1.0).is_empty(), "it slides");
    // In the image, 0.8 % looks like 0.2 mm in depth.
    assert!(depths_after(|[x, y, z]| [1.008 * x, 1.008 * y, z], 1.0).is_empty(), "it spreads");
}

#[test]
fn nothing_is_known_before_and_after_a_press() {
    let mut surface = surface();
    show_at(&mut surface, |[x, y]| [x, y, 0.5]);
    let cells = surface.seen.len();
    let inner: Vec<_> = (0..cells).collect();
    let mut shape = StuckShape::new(cells);
    let is_found = |shape: &mut StuckShape| {
        shape.motion(&surface, (&inner, &vec![0.5; cells]), NOISE_MM, THICKNESS_MM, &mut Vec::new()).is_some()
    };
    assert!(!is_found(&mut shape));
    shape.take(&surface, &vec![true; cells], &vec![0.5; cells], |_| 0.01);
    assert!(is_found(&mut shape), "contact that rests sticks");
    shape.forget();
    assert!(!is_found(&mut shape));
}
