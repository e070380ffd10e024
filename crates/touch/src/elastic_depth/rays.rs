//! The slopes of the camera's rays, and the displacement of the points that they meet.

use fearless_simd::{Level, dispatch, f32x4, prelude::*};
use fearless_simd_macros::simd;
use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_optics::Camera;

use crate::whole_motion::WholeMotion;

/// The slope of the ray of every pixel. Between pixels slopes are interpolated, because they hardly bend over one pixel: with a focal
/// length of 120 px and a strongly distorting lens points are wrong by up to 0.2 µm at 25 mm.
#[derive(Debug, Clone)]
pub(super) struct Rays {
    level: Level,
    camera: Camera,
    size: (usize, usize),
    /// Row by row; NaN where the ray does not reach the gel's plane.
    slopes: Vec<[f32; 2]>,
}

impl Rays {
    /// The rays of a camera in images of this size, at least 2×2 px.
    pub(super) fn new(camera: &Camera, size: (usize, usize)) -> Self {
        let pixels = (0..size.1).flat_map(|y| (0..size.0).map(move |x| [x as f64, y as f64]));
        Self { level: Level::new(), camera: camera.clone(), size, slopes: pixels.map(|px| slope(camera, px)).collect() }
    }

    /// The displacement along x and y, mm, of every pixel's point that `shows` selects, from its flow, px, and its depth, mm: at rest the
    /// point lies on the surface and on the ray of the pixel, now on the ray of the place where it is seen, before the whole image `moved`.
    /// Zero at all other pixels and where a ray does not reach the gel's plane.
    pub(super) fn lateral_into(
        &self,
        flow: &FlowField,
        moved: &WholeMotion,
        depth_mm: &Image<f32>,
        shows: impl Fn(usize) -> bool,
        lateral_mm: [&mut Image<f32>; 2],
    ) {
        dispatch!(self.level, simd => self.fill(simd, (flow, moved), depth_mm, shows, lateral_mm));
    }

    #[simd]
    fn fill<S: Simd>(
        &self,
        simd: S,
        (flow, whole): (&FlowField, &WholeMotion),
        depth_mm: &Image<f32>,
        shows: impl Fn(usize) -> bool,
        [x_mm, y_mm]: [&mut Image<f32>; 2],
    ) {
        let height_mm = self.camera.position_mm()[2] as f32;
        // Linear in the place: where the origin was before the motion, and how that changes along x and y.
        let [origin, right, down] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|px| whole.undo(px));
        let [origin_x, origin_y] = origin.map(|px| px as f32);
        let [x_along, y_along] = [0, 1].map(|axis| (right[axis] - origin[axis]) as f32);
        let [x_down, y_down] = [0, 1].map(|axis| (down[axis] - origin[axis]) as f32);
        for y in 0..self.size.1 {
            let moved = flow.u.row(y).iter().zip(flow.v.row(y)).zip(depth_mm.row(y));
            let targets = x_mm.row_mut(y).iter_mut().zip(y_mm.row_mut(y));
            let first = y * self.size.0;
            let rest = self.slopes[first..first + self.size.0].iter().enumerate();
            for ((x_mm, y_mm), (((&u, &v), &depth), (x, rest))) in targets.zip(moved.zip(rest)) {
                // An integer of 32 bits is converted in one instruction.
                let (seen_x, seen_y) = (x as u32 as f32 + u, y as u32 as f32 + v);
                let then_x = origin_x + x_along * seen_x + x_down * seen_y;
                let then_y = origin_y + y_along * seen_x + y_down * seen_y;
                let now = self.at(simd, then_x, then_y);
                let lateral_x = height_mm * (now[0] - rest[0]) - depth * now[0];
                let lateral_y = height_mm * (now[1] - rest[1]) - depth * now[1];
                let is_known = shows(first + x) && lateral_x.is_finite() && lateral_y.is_finite();
                (*x_mm, *y_mm) = if is_known { (lateral_x, lateral_y) } else { (0.0, 0.0) };
            }
        }
    }

    /// The slope at a place in the image, px.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, x: f32, y: f32) -> [f32; 2] {
        let (width, height) = self.size;
        let is_inside = x >= 0.0 && y >= 0.0 && x < (width - 1) as f32 && y < (height - 1) as f32;
        if !is_inside {
            return slope(&self.camera, [f64::from(x), f64::from(y)]);
        }
        let (left, top) = (x as i32 as u32, y as i32 as u32);
        let (right, down) = (x - left as f32, y - top as f32);
        // The left and the right pixel of a row. No closure: the compiler would not use the instruction set in it.
        let slopes = self.slopes.as_flattened();
        let first = 2 * (top as usize * width + left as usize);
        let upper = f32x4::from_slice(simd, &slopes[first..first + 4]);
        let lower = f32x4::from_slice(simd, &slopes[first + 2 * width..first + 2 * width + 4]);
        let sides = (lower - upper).mul_add(f32x4::splat(simd, down), upper).to_array();
        [sides[0] + right * (sides[2] - sides[0]), sides[1] + right * (sides[3] - sides[1])]
    }
}

/// The slope of the ray at a place in the image: how far it leans from the z axis along x and y, dimensionless.
#[cold]
fn slope(camera: &Camera, px: [f64; 2]) -> [f32; 2] {
    let [camera_x, camera_y, height] = camera.position_mm();
    let point = camera.surface_point(px, 0.0);
    point.map_or([f32::NAN; 2], |[x, y]| [((x - camera_x) / height) as f32, ((y - camera_y) / height) as f32])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    const SIZE: (usize, usize) = (64, 48);

    /// A tilted camera with a strongly distorting lens.
    fn camera() -> Camera {
        let text = "[camera]\nfocal_length_px = [120, 116]\nprincipal_point_px = [31, 25]\n\
                    translation_mm = [1, -2, 25]\nrotation_rad = [0.1, -0.15, 0.05]\n\
                    [camera.distortion]\nk1 = -0.2\nk2 = 0.05\np1 = 0.002\np2 = -0.001\n";
        Camera::new(&Profile::from_toml(text).unwrap().camera.unwrap()).unwrap()
    }

    #[test]
    fn points_lie_on_the_rays_of_the_pixels_where_they_are_seen() {
        let (camera, (width, height)) = (camera(), SIZE);
        let wave = |x: usize, y: usize, k: f32| 4.0 * (0.2 * x as f32 + 0.3 * y as f32 + k).sin();
        let flow = FlowField {
            u: Image::from_fn(width, height, |x, y| wave(x, y, 0.0)),
            v: Image::from_fn(width, height, |x, y| wave(x, y, 1.0)),
        };
        let depth = Image::from_fn(width, height, |x, y| 0.5 + 0.1 * wave(x, y, 2.0));
        let camera_moves = [([0.0, 0.0], [0.3, -0.2]), ([60.0, 0.0], [0.5, -0.1]), ([0.0, 40.0], [0.2, 0.1])];
        let moved = WholeMotion::fit(camera_moves.into_iter()).unwrap().motion;
        let mut found = [Image::filled(width, height, 9.0), Image::filled(width, height, 9.0)];
        let [x_mm, y_mm] = &mut found;
        Rays::new(&camera, SIZE).lateral_into(&flow, &moved, &depth, |pixel| pixel != 7, [x_mm, y_mm]);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let px = [x as f64, y as f64];
            let seen_px = [px[0] + f64::from(flow.u.at(x, y)), px[1] + f64::from(flow.v.at(x, y))];
            let now_px = moved.undo(seen_px);
            let rest = camera.surface_point(px, 0.0).unwrap();
            let now = camera.surface_point(now_px, f64::from(depth.at(x, y))).unwrap();
            for (axis, found) in found.iter().enumerate() {
                let expected = if (x, y) == (7, 0) { 0.0 } else { now[axis] - rest[axis] };
                let difference = f64::from(found.at(x, y)) - expected;
                assert!(difference.abs() < 3e-4, "({x}, {y}): {} against {expected}", found.at(x, y));
            }
        }
    }
}
