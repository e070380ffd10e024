//! The slow definition: every part of a pixel is the mean of a dense raster of rays, each traced to every patch.

use super::*;
use crate::blur::Blur;
use crate::render::light::{Light, vignette};
use crate::render::patch::Patch;
use crate::render::surface::{Instant, Surface};
use crate::render::{FrameRenderer, Lattice};
use crate::{Truth, TruthProjector};

/// Rays per part, and the step that distributes them: both are Fibonacci numbers, so no two rays share a column or a
/// row.
const RAYS: u32 = 144;
const SPREAD: u32 = 89;

struct Twin {
    camera: Camera,
    texture: Texture,
    background: [f32; 3],
    /// Every patch and the box of its corners in the image, widened by what distortion may bend.
    patches: Vec<(Patch, [[f64; 2]; 2])>,
}

impl Twin {
    fn new(params: &RenderParams, camera: &Camera, state: &SurfaceState) -> Self {
        let mut surface = Surface::new(f64::INFINITY);
        let light = Light::new(params.ring, params.shading);
        surface.take(camera, Some(&light), Instant::of(state)).unwrap();
        let patch = |patch: usize| {
            let px = surface.corners(patch).map(|node| node.px);
            let ends = [0, 1].map(|axis| {
                let [a, b, c, d] = px.map(|px| px[axis]);
                [a.min(b).min(c).min(d) - 1.0, a.max(b).max(c).max(d) + 1.0]
            });
            (surface.patch(patch), ends)
        };
        let patches = (0..surface.patches()).map(patch).collect();
        let background = params.background.map(f32::from);
        Self { camera: camera.clone(), texture: texture(), background, patches }
    }

    /// What a ray meets first: place at rest and gain.
    fn nearest(&self, px: [f64; 2]) -> Option<([f64; 2], f64)> {
        let [x, y, z] = self.camera.ray(px)?.direction;
        let is_near = |ends: &[[f64; 2]; 2]| (0..2).all(|axis| (ends[axis][0]..=ends[axis][1]).contains(&px[axis]));
        let patches = self.patches.iter().filter(|(_, ends)| is_near(ends));
        let meetings = patches.flat_map(|(patch, _)| patch.meetings([-x / z, -y / z]));
        let nearest = meetings.min_by(|a, b| a.down_mm.total_cmp(&b.down_mm))?;
        Some((nearest.rest_mm, nearest.gain))
    }

    fn colour(&self, px: [f64; 2]) -> [f32; 3] {
        let Some((rest, gain)) = self.nearest(px) else { return self.background };
        let [u, v] = self.texture.cell_coordinates(rest);
        self.texture.at(u.floor() as i64, v.floor() as i64).map(|level| level * gain as f32)
    }

    fn levels(&self, params: &RenderParams) -> Image<[f32; 3]> {
        let blur = Blur::new(params.blur_px);
        let lattice = Lattice::new(params.width, params.height, blur.margin());
        let share = |k: u32| (f64::from(k) + 0.5) / f64::from(RAYS);
        let parts = Image::from_fn(lattice.columns - 1, lattice.rows - 1, |x, y| {
            let mut sum = [0.0; 3];
            for k in 0..RAYS {
                let px = [lattice.px(x as f64 + share(k)), lattice.px(y as f64 + share(k * SPREAD % RAYS))];
                sum.iter_mut().zip(self.colour(px)).for_each(|(sum, level)| *sum += level);
            }
            sum.map(|sum| sum / RAYS as f32)
        });
        let gains = vignette(&self.camera, params.vignetting, params.width, params.height);
        let mut levels = blur.apply(&parts);
        levels.values_mut().iter_mut().zip(gains).for_each(|(level, gain)| *level = level.map(|level| gain * level));
        levels
    }
}

/// Root mean square and greatest difference between renderer and definition, grey levels.
fn differences(params: &RenderParams, camera: &Camera, state: &SurfaceState) -> [f32; 2] {
    let expected = Twin::new(params, camera, state).levels(params);
    let mut renderer = FrameRenderer::new(params, camera, &texture()).unwrap();
    let levels = renderer.render_levels(state).unwrap();
    let pairs = levels.values().as_flattened().iter().zip(expected.values().as_flattened());
    let squares: Vec<f32> = pairs.map(|(level, expected)| (level - expected).powi(2)).collect();
    let mean = squares.iter().sum::<f32>() / squares.len() as f32;
    [mean.sqrt(), squares.into_iter().fold(0.0, f32::max).sqrt()]
}

/// The difference comes from the twin: an edge through a part lies between its rays, which changes the part by up to
/// 225/144 levels. With more rays the difference falls.
#[test]
fn a_smooth_surface_is_the_limit_of_dense_rays() {
    let params = params(36, 28);
    let [mean, most] = differences(&params, &camera(36, 28), &surface(12, bump));
    assert!(mean < 0.15 && most < 1.2, "rms {mean}, most {most} levels");
}

#[test]
fn a_camera_that_tilts_and_distorts_sees_the_same() {
    let params = params(36, 28);
    let camera = Camera::new(&CameraParams {
        distortion: Distortion { k1: -0.3, k2: 0.1, p1: 0.02, p2: -0.03, ..Distortion::default() },
        rotation_rad: [0.2, -0.3, 0.4],
        translation_mm: [0.3, -0.2, 8.0],
        ..camera_params(36, 28)
    });
    let [mean, most] = differences(&params, &camera.unwrap(), &surface(9, bump));
    assert!(mean < 0.15 && most < 1.2, "rms {mean}, most {most} levels");
}

#[test]
fn the_gels_border_is_cut_by_area() {
    // The gel's lower right corner lies in the image.
    let params = RenderParams { background: [0, 90, 200], ..params(36, 28) };
    let camera = Camera::new(&CameraParams {
        translation_mm: [-2.6, -2.1, 10.0],
        rotation_rad: [0.1, 0.0, 0.3],
        ..camera_params(36, 28)
    });
    let [mean, most] = differences(&params, &camera.unwrap(), &surface(9, bump));
    assert!(mean < 0.1 && most < 0.8, "rms {mean}, most {most} levels");
}

#[test]
fn a_fold_shows_its_nearer_side() {
    let params = params(36, 28);
    let (camera, state) = (camera(36, 28), surface(20, mushroom));
    let [mean, most] = differences(&params, &camera, &state);
    assert!(mean < 0.2 && most < 2.0, "rms {mean}, most {most} levels");
}

#[test]
fn what_a_fold_hides_is_not_visible() {
    let params = params(36, 28);
    let (camera, state) = (camera(36, 28), surface(20, mushroom));
    let twin = Twin::new(&params, &camera, &state);
    let mut projector = TruthProjector::new(&camera, 36, 28);
    let Truth { flow, visible, .. } = projector.project(&state).unwrap();
    let mut hidden = 0;
    for (x, y) in (0..36).flat_map(|x| (0..28).map(move |y| (x, y))) {
        let px = [x as f64, y as f64];
        let rest = camera.surface_point(px, 0.0).unwrap();
        let [u, v] = flow.at(x, y).map(f64::from);
        let now = [px[0] + u, px[1] + v];
        let is_inside = (-0.5..=35.5).contains(&now[0]) && (-0.5..=27.5).contains(&now[1]);
        // The flow is of single precision, so the ray meets the point's surroundings.
        let is_first = twin.nearest(now).is_some_and(|(seen, _)| (seen[0] - rest[0]).hypot(seen[1] - rest[1]) < 0.01);
        hidden += usize::from(is_inside && !is_first);
        assert_eq!(visible.at(x, y) == 1, is_inside && is_first, "pixel ({x}, {y}), now at {now:?}");
    }
    assert!(hidden > 40, "{hidden} points are hidden");
}
