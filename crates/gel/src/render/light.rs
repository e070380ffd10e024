//! The light: a ring of lamps shines on the surface, and the lens passes less light off its axis.

use super::RingLight;
use fingervision_optics::Camera;
use std::f64::consts::TAU;

const LAMPS: usize = 16;

/// The gain on the pattern's colours, by place and slope.
///
/// A share of the light comes from the ring, the rest evenly from everywhere: `gain = 1 + share (E/E₀ − 1)` with `E = Σ
/// max(0, n · d) / |d|³` over the vector d to each lamp, limited to `2 E₀`, and `E₀` that of the undeformed surface at
/// the origin. Surfaces that face the near lamps are brighter; there are no cast shadows.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    lamps: [[f64; 3]; LAMPS],
    share: f64,
    /// `1 / E₀`.
    scale: f64,
}

impl Light {
    pub(crate) fn new(ring: RingLight, share: f64) -> Self {
        let lamps = std::array::from_fn(|k| {
            let (sin, cos) = (TAU * (k as f64 + 0.5) / LAMPS as f64).sin_cos();
            [ring.radius_mm * cos, ring.radius_mm * sin, ring.height_mm]
        });
        let light = Self { lamps, share, scale: 1.0 };
        let scale = light.irradiance([0.0; 3], [0.0, 0.0, 1.0]).recip();
        Self { scale, ..light }
    }

    /// Gain at a point of the surface, mm, whose normal has any length and points to the camera's side.
    pub(crate) fn gain(&self, point: [f64; 3], normal: [f64; 3]) -> f64 {
        if self.share == 0.0 {
            return 1.0;
        }
        1.0 + self.share * ((self.irradiance(point, normal) * self.scale).clamp(0.0, 2.0) - 1.0)
    }

    fn irradiance(&self, point: [f64; 3], normal: [f64; 3]) -> f64 {
        let lit = |lamp: &[f64; 3]| {
            let way = [0, 1, 2].map(|axis| lamp[axis] - point[axis]);
            let squared = dot(way, way);
            dot(normal, way).max(0.0) / (squared * squared.sqrt())
        };
        self.lamps.iter().map(lit).sum::<f64>() / dot(normal, normal).sqrt()
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The lens's gain at every pixel, row by row: `1 + strength (cos⁴ θ − 1)`, θ the angle to the optical axis.
pub(crate) fn vignette(camera: &Camera, strength: f64, width: usize, height: usize) -> Vec<f32> {
    let axis = camera.ray(camera.params().principal_point_px).map_or([0.0; 3], |ray| ray.direction);
    let gain = |x: usize, y: usize| {
        let cosine = camera.ray([x as f64, y as f64]).map_or(0.0, |ray| dot(ray.direction, axis));
        (1.0 + strength * (cosine.powi(4) - 1.0)) as f32
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| gain(x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(share: f64) -> Light {
        Light::new(RingLight::default(), share)
    }

    #[test]
    fn the_gain_is_one_at_rest_in_the_middle() {
        assert!((light(0.15).gain([0.0; 3], [0.0, 0.0, 3.0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_side_that_faces_the_near_lamps_is_brighter() {
        let light = light(0.15);
        let at = |slope: f64| light.gain([10.0, 0.0, 0.0], [slope, 0.0, 1.0]);
        assert!(at(0.5) > at(0.0) && at(0.0) > at(-0.5), "{} {} {}", at(0.5), at(0.0), at(-0.5));
    }

    #[test]
    fn the_gain_keeps_within_its_share() {
        let light = light(0.15);
        for normal in [[1.0, 0.0, 0.0], [-1.0, 0.2, 0.01], [0.0, 0.0, -1.0], [0.7, 0.0, 0.7]] {
            for point in [[0.0; 3], [14.0, 3.0, 2.0], [24.0, 0.0, 14.0]] {
                let gain = light.gain(point, normal);
                assert!((0.85..=1.15).contains(&gain), "{gain} at {point:?}, {normal:?}");
            }
        }
        assert_eq!(self::light(0.0).gain([14.0, 3.0, 2.0], [0.7, 0.0, 0.7]).to_bits(), 1.0_f64.to_bits());
    }
}
