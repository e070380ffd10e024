//! Prints the time to render a frame: 640×480 px in colour with all effects, one thread.
//!
//! `cargo run --release -p fingervision-gel --example frame_rate`

use fingervision_elastic::SurfaceState;
use fingervision_gel::{FrameRenderer, Pattern, RenderParams};
use fingervision_optics::{Camera, CameraParams, Distortion};
use std::io::Write;
use std::time::Instant;

/// A press that rises to `depth_mm` within `radius_mm`, on cells of 0.2 mm.
fn press(radius_mm: f64, depth_mm: f64) -> SurfaceState {
    let lines: Vec<f64> = (0..=150).map(|k| 0.2 * f64::from(k) - 15.0).collect();
    let nodes = lines.iter().flat_map(|&y| lines.iter().map(move |&x| (x, y)));
    let rise = |(x, y): (f64, f64)| [0.0, 0.0, depth_mm / (1.0 + (4.0 * (x.hypot(y) - radius_mm)).exp())];
    let displacement_mm: Vec<[f64; 3]> = nodes.map(rise).collect();
    let in_contact = vec![false; displacement_mm.len()];
    SurfaceState { x_mm: lines.clone(), y_mm: lines, displacement_mm, in_contact, ..SurfaceState::default() }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let camera = Camera::new(&CameraParams {
        focal_length_px: [400.0; 2],
        principal_point_px: [319.5, 239.5],
        distortion: Distortion { k1: -0.05, ..Distortion::default() },
        rotation_rad: [0.0; 3],
        translation_mm: [0.0, 0.0, 25.0],
    })?;
    let params = RenderParams { width: 640, height: 480, ..RenderParams::default() };
    let texture = Pattern::default().texture([30.0; 2])?;
    let mut renderer = FrameRenderer::new(&params, &camera, &texture)?;
    let states: Vec<_> = (0..=20).map(|k| press(4.0, 0.1 * f64::from(k))).collect();
    let mut times_s = Vec::new();
    for frame in 0..5 * states.len() {
        let start = Instant::now();
        renderer.render(&states[frame % states.len()], frame as u64)?;
        times_s.push(start.elapsed().as_secs_f64());
    }
    times_s.sort_by(f64::total_cmp);
    let [median, late] = [50, 95].map(|percent| 1e3 * times_s[percent * (times_s.len() - 1) / 100]);
    writeln!(std::io::stdout(), "{median:.1} ms a frame, 95 % within {late:.1} ms: {:.1} frames/s", 1e3 / median)?;
    Ok(())
}
