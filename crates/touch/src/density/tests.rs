//! The density against its definition, its invariances and its border.

use fearless_simd::Level;
use fingervision_flow::FlowField;
use fingervision_image::Image;

use super::{DensityEstimator, DensityField, DensityMethod, DensityParams};

const WIDTH: usize = 96;
const HEIGHT: usize = 83;

/// A flow given by the displacement `(u, v)` in px at each reference pixel.
fn flow(width: usize, height: usize, displacement: impl Fn(f32, f32) -> (f32, f32)) -> FlowField {
    let at = |x: usize, y: usize| displacement(x as f32, y as f32);
    FlowField {
        u: Image::from_fn(width, height, |x, y| at(x, y).0),
        v: Image::from_fn(width, height, |x, y| at(x, y).1),
    }
}

/// Points pushed away from the centre, by `peak` px at most; pulled towards it where `peak` is negative.
fn bump(peak: f32) -> FlowField {
    flow(WIDTH, HEIGHT, |x, y| {
        let (dx, dy) = ((x - 47.0) / 20.0, (y - 41.0) / 20.0);
        let push = peak * 1.6487 * (-0.5 * (dx * dx + dy * dy)).exp();
        (push * dx, push * dy)
    })
}

/// A sum of waves with seeded directions, `amplitude` px each.
fn waves(seed: u64, amplitude: f32) -> FlowField {
    let mut noise = Noise(seed);
    let waves: [[f32; 5]; 6] = std::array::from_fn(|_| std::array::from_fn(|_| noise.next()));
    flow(WIDTH, HEIGHT, |x, y| {
        waves.iter().fold((0.0, 0.0), |(u, v), [kx, ky, phase, to_x, to_y]| {
            let wave = amplitude * (0.15 * (kx * x + ky * y) + 6.0 * phase).sin();
            (u + wave * to_x, v + wave * to_y)
        })
    })
}

/// Every pixel moved on its own, up to `amplitude` px.
fn jitter(seed: u64, amplitude: f32) -> FlowField {
    let mut noise = Noise(seed);
    let mut image = || Image::from_fn(WIDTH, HEIGHT, |_, _| amplitude * noise.next());
    FlowField { u: image(), v: image() }
}

/// Uniform numbers in `[−1, 1)`: a 64-bit linear congruential generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }
}

fn scenes() -> Vec<(String, FlowField)> {
    let mut scenes = vec![
        ("at rest".to_owned(), FlowField::zero(WIDTH, HEIGHT)),
        ("moved by half a pixel".to_owned(), flow(WIDTH, HEIGHT, |_, _| (0.5, -0.5))),
        ("moved out of the image".to_owned(), flow(WIDTH, HEIGHT, |_, _| (-17.3, 9.6))),
        ("squeezed to a third".to_owned(), flow(WIDTH, HEIGHT, |x, y| (0.667 * (47.0 - x), 0.667 * (41.0 - y)))),
        ("stretched out of the image".to_owned(), flow(WIDTH, HEIGHT, |x, y| (0.6 * (x - 47.0), 0.6 * (y - 41.0)))),
    ];
    scenes.extend([25.0, 12.0, -4.0, -12.0, -25.0].map(|peak| (format!("bump of {peak} px"), bump(peak))));
    scenes.extend((0..4).map(|seed| (format!("waves, seed {seed}"), waves(seed, 2.5))));
    scenes.extend((0..2).map(|seed| (format!("jitter, seed {seed}"), jitter(seed, 0.4))));
    scenes
}

fn estimator(method: DensityMethod, sigma_px: f64) -> DensityEstimator {
    let params = DensityParams { sigma_px, method, ..DensityParams::default() };
    DensityEstimator::new(WIDTH, HEIGHT, &params).unwrap()
}

fn estimate(estimator: &mut DensityEstimator, flow: &FlowField) -> DensityField {
    let mut field = DensityField::at_rest(flow.u.width(), flow.u.height());
    field.feature.values_mut().fill(f32::NAN);
    estimator.estimate_into(flow, &mut field);
    field
}

fn current_density(estimator: &mut DensityEstimator, flow: &FlowField) -> Image<f32> {
    let mut density = Image::filled(flow.u.width(), flow.u.height(), f32::NAN);
    estimator.current_density_into(flow, &mut density);
    density
}

/// Asserts that two densities differ by at most `tolerance`, taken of the density where that exceeds 1.
fn assert_close(name: &str, value: &Image<f32>, truth: &Image<f32>, density: impl Fn(f32) -> f32, tolerance: f32) {
    for y in 0..truth.height() {
        for x in 0..truth.width() {
            let (value, truth) = (value.at(x, y), truth.at(x, y));
            let allowed = tolerance * density(truth).max(1.0);
            assert!((value - truth).abs() <= allowed, "{name} at ({x}, {y}): {value}, not {truth} within {allowed}");
        }
    }
}

#[test]
fn the_fast_sum_is_the_exact_one() {
    // The narrower the Gaussian, the more of the pixel grid shows.
    for (sigma, tolerance) in [(1.5, 2.5e-3), (2.0, 5e-4), (3.1, 1e-4)] {
        let (mut fast, mut exact) = (estimator(DensityMethod::Fast, sigma), estimator(DensityMethod::Exact, sigma));
        for (name, flow) in scenes() {
            let name = format!("sigma {sigma} px, {name}");
            let (field, truth) = (estimate(&mut fast, &flow), estimate(&mut exact, &flow));
            assert_close(&name, &field.feature, &truth.feature, |feature| 1.0 - feature, tolerance);
            assert_eq!((&field.valid, field.largest_spacing_px), (&truth.valid, truth.largest_spacing_px), "{name}");
            let (fast, exact) = (current_density(&mut fast, &flow), current_density(&mut exact, &flow));
            assert_close(&name, &fast, &exact, |density| density, tolerance);
        }
    }
}

#[test]
fn instruction_sets_differ_by_rounding_alone() {
    let mut levels = vec![Level::baseline(), Level::new()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(Level::new().as_avx2().map(Level::Avx2));
    for (name, flow) in scenes() {
        let mut fields = levels.iter().map(|&level| {
            let params = DensityParams::default();
            estimate(&mut DensityEstimator::with_level(WIDTH, HEIGHT, &params, level).unwrap(), &flow)
        });
        let first = fields.next().unwrap();
        for field in fields {
            // Some fuse multiply and add, others do not.
            assert_close(&name, &field.feature, &first.feature, |feature| 1.0 - feature, 3e-6);
            assert_eq!((&field.valid, field.largest_spacing_px), (&first.valid, first.largest_spacing_px), "{name}");
        }
    }
}

#[test]
fn a_frame_leaves_no_trace_in_the_next() {
    let mut used = estimator(DensityMethod::Fast, 2.0);
    estimate(&mut used, &bump(25.0));
    let fresh = estimate(&mut estimator(DensityMethod::Fast, 2.0), &waves(5, 2.0));
    assert_eq!(estimate(&mut used, &waves(5, 2.0)), fresh);
}

#[test]
fn a_shifted_surface_is_at_rest_up_to_the_border() {
    let mut fast = estimator(DensityMethod::Fast, 2.0);
    for (u, v) in [(0.0, 0.0), (7.0, -3.0), (0.5, 0.25), (-11.37, 20.81)] {
        let field = estimate(&mut fast, &flow(WIDTH, HEIGHT, |_, _| (u, v)));
        for y in 0..HEIGHT {
            for x in 0..WIDTH {
                let (moved_x, moved_y) = (x as f32 + u, y as f32 + v);
                let is_inside =
                    (0.0..=WIDTH as f32 - 1.0).contains(&moved_x) && (0.0..=HEIGHT as f32 - 1.0).contains(&moved_y);
                assert!(field.feature.at(x, y).abs() < 5e-4, "({u}, {v}) at ({x}, {y}): {}", field.feature.at(x, y));
                assert!(!is_inside || field.valid.at(x, y) == 1, "({u}, {v}) at ({x}, {y}) is in sight");
            }
        }
        assert!((field.largest_spacing_px - 1.0).abs() < 1e-5 && !field.has_gap);
    }
}

#[test]
fn the_current_density_moves_with_the_points() {
    let mut fast = estimator(DensityMethod::Fast, 2.0);
    let still = bump(-6.0);
    let moved = flow(WIDTH, HEIGHT, |x, y| {
        let (x, y) = (x as usize, y as usize);
        (still.u.at(x, y) + 5.0, still.v.at(x, y) - 3.0)
    });
    let (still, moved) = (current_density(&mut fast, &still), current_density(&mut fast, &moved));
    for y in 0..HEIGHT - 3 {
        for x in 0..WIDTH - 5 {
            let (still, moved) = (still.at(x, y + 3), moved.at(x + 5, y));
            assert!((still - moved).abs() < 1e-4, "({x}, {y}): {still} still, {moved} moved");
        }
    }
}

#[test]
fn an_even_stretch_divides_by_its_determinant() {
    let mut fast = estimator(DensityMethod::Fast, 2.0);
    for [xx, xy, yx, yy] in [[1.3f32, 0.0, 0.0, 1.3], [0.7, 0.0, 0.0, 0.7], [1.2, 0.3, -0.1, 0.9], [2.0, 0.0, 0.0, 1.0]]
    {
        let stretch = |x: f32, y: f32| {
            let (x, y) = (x - 48.0, y - 41.0);
            (xx * x + xy * y - x, yx * x + yy * y - y)
        };
        let field = estimate(&mut fast, &flow(WIDTH, HEIGHT, stretch));
        let expected = 1.0 - 1.0 / (xx * yy - xy * yx);
        for (x, y) in [(48, 41), (36, 50), (60, 33), (45, 30)] {
            let feature = field.feature.at(x, y);
            assert!((feature - expected).abs() < 5e-4, "({x}, {y}): {feature}, not {expected}");
        }
    }
}

#[test]
fn points_are_neither_lost_nor_made() {
    let squeezed = flow(WIDTH, HEIGHT, |x, y| (0.6 * (47.0 - x), 0.6 * (41.0 - y)));
    for method in [DensityMethod::Fast, DensityMethod::Exact] {
        let density = current_density(&mut estimator(method, 2.0), &squeezed);
        let sum: f64 = density.values().iter().copied().map(f64::from).sum();
        let points = (WIDTH * HEIGHT) as f64;
        assert!((sum / points - 1.0).abs() < 1e-5, "{method:?}: {sum} of {points} points");
    }
}

#[test]
fn at_rest_the_current_density_falls_at_the_border() {
    let density = current_density(&mut estimator(DensityMethod::Fast, 2.0), &FlowField::zero(WIDTH, HEIGHT));
    // Half of the Gaussians are missing half a pixel outside; the border's own pixels have their own as well.
    let border = 0.5 + 0.5 * (8.0 * std::f32::consts::PI).sqrt().recip();
    for (at, expected) in [((48, 0), border), ((0, 40), border), ((0, 0), border * border), ((48, 40), 1.0)] {
        let value = density.at(at.0, at.1);
        assert!((value - expected).abs() < 5e-4, "{at:?}: {value}, not {expected}");
    }
}

#[test]
fn a_tear_is_invalid_along_its_edges() {
    let torn = flow(WIDTH, HEIGHT, |x, _| if x < 40.0 { (-3.0, 0.0) } else { (3.0, 0.0) });
    let field = estimate(&mut estimator(DensityMethod::Fast, 2.0), &torn);
    assert!(field.has_gap && (field.largest_spacing_px - 7.0).abs() < 1e-6);
    for x in 3..WIDTH - 3 {
        let is_edge = x == 39 || x == 40;
        assert_eq!(field.valid.at(x, 20) == 0, is_edge, "column {x}");
    }
}

#[test]
fn validity_follows_its_definition() {
    let flow = jitter(11, 3.0);
    let field = estimate(&mut estimator(DensityMethod::Fast, 2.0), &flow);
    let moved = |x: usize, y: usize| (x as f64 + f64::from(flow.u.at(x, y)), y as f64 + f64::from(flow.v.at(x, y)));
    let spacing = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let mut largest = 0.0f64;
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let here = moved(x, y);
            let sides = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
            let sides = sides.into_iter().filter(|&(x, y)| x < WIDTH && y < HEIGHT);
            let widest = sides.map(|(x, y)| spacing(here, moved(x, y))).fold(0.0, f64::max);
            largest = largest.max(widest);
            let is_in_sight =
                (-0.5..=WIDTH as f64 - 0.5).contains(&here.0) && (-0.5..=HEIGHT as f64 - 0.5).contains(&here.1);
            assert_eq!(
                field.valid.at(x, y) == 1,
                is_in_sight && widest < 6.0,
                "({x}, {y}): {here:?}, {widest} px apart"
            );
        }
    }
    assert!((f64::from(field.largest_spacing_px) - largest).abs() < 1e-5);
}

#[test]
fn a_flow_that_is_not_a_number_spoils_no_other_density() {
    for method in [DensityMethod::Fast, DensityMethod::Exact] {
        for broken in [f32::NAN, f32::INFINITY, 1e30] {
            let mut flow = FlowField::zero(WIDTH, HEIGHT);
            flow.u.row_mut(30)[40] = broken;
            let field = estimate(&mut estimator(method, 2.0), &flow);
            for y in 0..HEIGHT {
                for x in 0..WIDTH {
                    let distance = x.abs_diff(40) + y.abs_diff(30);
                    assert_eq!(field.valid.at(x, y) == 0, distance <= 1, "{broken} at ({x}, {y})");
                    // One missing point takes at most its own peak, 1/(2πσ²), off the density.
                    assert!(field.feature.at(x, y).abs() < 0.041, "{broken} at ({x}, {y}): {}", field.feature.at(x, y));
                }
            }
            assert!(field.largest_spacing_px < f32::INFINITY);
        }
    }
}

#[test]
fn images_smaller_than_a_group_have_a_density() {
    for (width, height) in [(1, 1), (3, 2), (15, 4), (17, 1), (33, 20)] {
        let mut fast = DensityEstimator::new(width, height, &DensityParams::default()).unwrap();
        let field = estimate(&mut fast, &flow(width, height, |_, _| (0.3, -0.2)));
        assert!(field.feature.values().iter().all(|feature| feature.abs() < 5e-4), "{width}x{height} px");
    }
}
