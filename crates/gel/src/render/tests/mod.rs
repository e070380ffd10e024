//! Rendering against its definition and its conventions.

mod frames;
mod twin;

use super::RenderParams;
use crate::{ColourPattern, Texture};
use fingervision_elastic::SurfaceState;
use fingervision_image::Image;
use fingervision_optics::{Camera, CameraParams, Distortion};

/// Lines from `-half_mm` to `half_mm`, closer in the middle.
fn lines(cells: u32, half_mm: f64) -> Vec<f64> {
    let even = |k: u32| 2.0 * f64::from(k) / f64::from(cells) - 1.0;
    (0..=cells).map(|k| half_mm * even(k) * (0.6 + 0.4 * even(k).abs())).collect()
}

/// A gel of 6×5 mm whose points are displaced by a formula, mm.
fn surface(cells: u32, displacement: impl Fn(f64, f64) -> [f64; 3]) -> SurfaceState {
    let (x_mm, y_mm) = (lines(cells, 3.0), lines(cells, 2.5));
    let nodes = || y_mm.iter().flat_map(|&y| x_mm.iter().map(move |&x| (x, y)));
    let displacement_mm = nodes().map(|(x, y)| displacement(x, y)).collect();
    let in_contact = nodes().map(|_| false).collect();
    SurfaceState { displacement_mm, in_contact, x_mm, y_mm, ..SurfaceState::default() }
}

/// A bump of 0.4 mm that is also pulled sideways.
fn bump(x: f64, y: f64) -> [f64; 3] {
    let height = (-(x - 0.3).powi(2) - (y + 0.2).powi(2)).exp();
    [0.1 * height, -0.05 * height, 0.4 * height]
}

/// A mushroom beside the axis: its head hangs over on every side.
fn mushroom(x: f64, y: f64) -> [f64; 3] {
    let (dx, dy) = (x - 0.7, y - 0.3);
    let distance = dx.hypot(dy).max(1e-9);
    let head = 1.0 / (1.0 + ((distance - 0.6) * 12.0).exp());
    let outward = 0.55 * head * (distance / 0.6) / distance;
    [outward * dx, outward * dy, 1.1 * head]
}

/// A camera 10 mm from the gel that sees 0.1 mm a pixel.
fn camera_params(width: usize, height: usize) -> CameraParams {
    CameraParams {
        focal_length_px: [100.0; 2],
        principal_point_px: [width, height].map(|size| 0.5 * (size as f64 - 1.0)),
        distortion: Distortion::default(),
        rotation_rad: [0.0; 3],
        translation_mm: [0.0, 0.0, 10.0],
    }
}

fn camera(width: usize, height: usize) -> Camera {
    Camera::new(&camera_params(width, height)).unwrap()
}

fn params(width: usize, height: usize) -> RenderParams {
    RenderParams { width, height, ..RenderParams::default() }
}

/// Cells of 1.6 px.
fn texture() -> Texture {
    let pattern = ColourPattern::random(60, 50, [16, 240], 3).unwrap();
    let cells = (0..50).flat_map(|y| (0..60).map(move |x| (x, y))).map(|(x, y)| pattern.at(x, y)).collect();
    Texture::new(Image::from_vec(60, 50, cells).unwrap(), [0.16; 2], 1.5_f64.to_radians())
}
