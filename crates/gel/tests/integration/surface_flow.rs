//! Rendered surfaces compared with their truth.

use crate::lanczos::{REACH, weights};
use fingervision_elastic::SurfaceState;
use fingervision_gel::{ColourPattern, FrameRenderer, RenderParams, Texture, Truth, TruthProjector};
use fingervision_image::{Image, Pixels};
use fingervision_optics::{Camera, CameraParams, Distortion};

type Colours = Image<[f32; 3]>;

const SIZE: (usize, usize) = (200, 160);

/// Pixels at the image's border that are left out: the interpolation's reach and the largest flow.
const BORDER: usize = 30;

/// Half the step of the difference quotient that is used as gradient, px.
const HALF_STEP: f64 = 1e-3;

/// The default sensor's camera, with a smaller field of view.
fn camera(distortion: Distortion) -> Camera {
    let params = CameraParams {
        focal_length_px: [400.0; 2],
        principal_point_px: [0.5 * (SIZE.0 as f64 - 1.0), 0.5 * (SIZE.1 as f64 - 1.0)],
        distortion,
        rotation_rad: [0.0; 3],
        translation_mm: [0.0, 0.0, 25.0],
    };
    Camera::new(&params).unwrap()
}

fn texture(cell_mm: f64) -> Texture {
    let pattern = ColourPattern::random(200, 180, [16, 240], 5).unwrap();
    let cells = (0..180).flat_map(|y| (0..200).map(move |x| (x, y))).map(|(x, y)| pattern.at(x, y)).collect();
    Texture::new(Image::from_vec(200, 180, cells).unwrap(), [cell_mm; 2], 1.5_f64.to_radians())
}

/// A gel of 24 mm in even cells of 0.3 mm, displaced by a formula, mm.
fn surface(displacement: impl Fn(f64, f64) -> [f64; 3]) -> SurfaceState {
    let lines: Vec<f64> = (0..=80).map(|k| 0.3 * f64::from(k) - 12.0).collect();
    let nodes = lines.iter().flat_map(|&y| lines.iter().map(move |&x| (x, y)));
    let displacement_mm: Vec<_> = nodes.map(|(x, y)| displacement(x, y)).collect();
    let in_contact = vec![false; displacement_mm.len()];
    SurfaceState { x_mm: lines.clone(), y_mm: lines, displacement_mm, in_contact, ..SurfaceState::default() }
}

/// A press of 1 mm without an edge.
fn bump(x: f64, y: f64) -> [f64; 3] {
    let height = (-(x * x + y * y) / 8.0).exp();
    [0.1 * x * height, 0.1 * y * height, height]
}

/// The same light everywhere, so that two images differ only by the motion.
fn params() -> RenderParams {
    RenderParams { width: SIZE.0, height: SIZE.1, shading: 0.0, vignetting: 0.0, ..RenderParams::default() }
}

/// The reference and the current image before noise, and the truth.
fn images(camera: &Camera, cell_mm: f64, state: &SurfaceState) -> (Colours, Colours, Truth) {
    let mut renderer = FrameRenderer::new(&params(), camera, &texture(cell_mm)).unwrap();
    let reference = renderer.render_levels(&surface(|_, _| [0.0; 3])).unwrap().clone();
    let current = renderer.render_levels(state).unwrap().clone();
    let truth = TruthProjector::new(camera, SIZE.0, SIZE.1).project(state).unwrap().clone();
    (reference, current, truth)
}

fn sample(image: &Colours, place: [f64; 2]) -> [f64; 3] {
    let [(left, across), (top, down)] =
        place.map(|place| (place.floor() as usize + 1 - REACH, weights(place - place.floor())));
    let mut total = [0.0; 3];
    for (y, down) in down.iter().enumerate() {
        for (pixel, across) in image.row(top + y)[left..].iter().zip(&across) {
            total.iter_mut().zip(pixel).for_each(|(total, level)| *total += down * across * f64::from(*level));
        }
    }
    total
}

/// Every pixel of the reference that is tested, and the current position of its point.
fn moved_pixels(truth: &Truth) -> impl Iterator<Item = ((usize, usize), [f64; 2])> {
    let inside = (BORDER..SIZE.1 - BORDER).flat_map(|y| (BORDER..SIZE.0 - BORDER).map(move |x| (x, y)));
    inside.filter(|&(x, y)| truth.visible.at(x, y) == 1).map(|(x, y)| {
        let [u, v] = truth.flow.at(x, y).map(f64::from);
        ((x, y), [x as f64 + u, y as f64 + v])
    })
}

/// Difference between the motion in two images and the truth, px: one Gauss–Newton step, starting from the truth.
fn bias((reference, current, truth): &(Colours, Colours, Truth)) -> [f64; 2] {
    let [mut xx, mut xy, mut yy, mut bx, mut by] = [0.0; 5];
    for ((x, y), [px, py]) in moved_pixels(truth) {
        let value = sample(current, [px, py]);
        let slope = |dx: f64, dy: f64| {
            let [after, before] = [1.0, -1.0].map(|sign| sample(current, [px + sign * dx, py + sign * dy]));
            [0, 1, 2].map(|channel| (after[channel] - before[channel]) / (2.0 * HALF_STEP))
        };
        let (gx, gy) = (slope(HALF_STEP, 0.0), slope(0.0, HALF_STEP));
        for channel in 0..3 {
            let residual = f64::from(reference.at(x, y)[channel]) - value[channel];
            xx += gx[channel] * gx[channel];
            xy += gx[channel] * gy[channel];
            yy += gy[channel] * gy[channel];
            bx += gx[channel] * residual;
            by += gy[channel] * residual;
        }
    }
    let determinant = xx * yy - xy * xy;
    [(yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant]
}

fn assert_unbiased(camera: &Camera, displacement_mm: [f64; 3]) {
    let [x, y] = bias(&images(camera, 0.1, &surface(|_, _| displacement_mm)));
    println!("displacement {displacement_mm:?} mm: bias ({x:.5}, {y:.5}) px");
    assert!(x.abs() < 0.002 && y.abs() < 0.002, "displacement {displacement_mm:?} mm: bias ({x:.5}, {y:.5}) px");
}

#[test]
fn a_sliding_surface_is_rendered_without_sub_pixel_bias() {
    // A pixel is 0.0625 mm wide on the gel.
    for px in [0.1, 0.25, 0.5, 0.9, 2.3] {
        assert_unbiased(&camera(Distortion::default()), [0.0625 * px, -0.0625 * 0.7 * px, 0.0]);
    }
}

#[test]
fn a_rising_surface_is_rendered_without_sub_pixel_bias() {
    for depth_mm in [0.05, 0.3] {
        assert_unbiased(&camera(Distortion::default()), [0.02, 0.01, depth_mm]);
    }
}

#[test]
fn a_distorting_lens_leaves_no_sub_pixel_bias() {
    let lens = Distortion { k1: -0.3, k2: 0.1, p1: 0.004, p2: -0.006, ..Distortion::default() };
    for depth_mm in [0.0, 0.1] {
        assert_unbiased(&camera(lens), [0.05, -0.02, depth_mm]);
    }
}

/// Mean square of the difference between the reference and an image warped back with the truth, grey levels squared.
fn residual(reference: &Colours, current: &Colours, truth: &Truth) -> f64 {
    let [mut sum, mut count] = [0.0; 2];
    for ((x, y), place) in moved_pixels(truth) {
        let levels = sample(current, place);
        sum += levels.iter().zip(reference.at(x, y)).map(|(a, b)| (a - f64::from(b)).powi(2)).sum::<f64>();
        count += 3.0;
    }
    sum / count
}

/// The press magnifies the pattern by up to 8 %, so the pressed image is sharper than the reference by the same factor.
/// This causes the difference without noise: 1.9 levels for cells of 1.6 px, 1.2 for cells of 4.8 px. The rest is
/// noise.
#[test]
fn the_truth_brings_a_pressed_image_back_to_the_reference() {
    let camera = camera(Distortion::default());
    let state = surface(bump);
    for (cell_mm, sharper) in [(0.1, 2.0), (0.3, 1.25)] {
        let images = images(&camera, cell_mm, &state);
        let [x, y] = bias(&images);
        assert!(x.abs() < 0.002 && y.abs() < 0.002, "cells of {cell_mm} mm: bias ({x:.5}, {y:.5}) px");
        let (reference, current, truth) = images;
        let mut renderer = FrameRenderer::new(&params(), &camera, &texture(cell_mm)).unwrap();
        let Pixels::Rgb8(frame) = renderer.render(&state, 1).unwrap() else { panic!("colour was asked for") };
        let noisy = Image::from_fn(SIZE.0, SIZE.1, |x, y| frame.at(x, y).map(f32::from));
        let [clean, noisy] = [current, noisy].map(|image| residual(&reference, &image, &truth));
        println!(
            "cells of {cell_mm} mm: {} levels, with noise {}, bias ({x:.5}, {y:.5}) px",
            clean.sqrt(),
            noisy.sqrt()
        );
        assert!(clean.sqrt() < sharper, "cells of {cell_mm} mm: {} levels remain", clean.sqrt());
        // Noise of 2 levels and rounding, reduced by the low-pass of the interpolation.
        let noise = noisy - clean;
        assert!((3.5..4.2).contains(&noise), "cells of {cell_mm} mm: {noise} levels squared are of the noise");
    }
}
