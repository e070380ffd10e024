//! The indenter's frame: positions of its points in gel space.

use crate::{Pose, Relief};

/// Length by which a rotation is compared with a translation, mm.
const ARM_MM: f64 = 4.0;
/// Squared cosine of the angle between two motions above which one continues the other.
const STRAIGHT: f64 = 0.99;

/// Rotation and origin of the indenter in gel space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    rotation: [[f64; 3]; 3],
    /// The position of the indenter's origin, mm.
    pub(super) origin: [f64; 3],
}

/// A point of the gel relative to the indenter's face.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// Distance to the face to first order, mm; negative inside the indenter.
    pub(super) distance: f64,
    /// Direction in which the face pushes, in gel space.
    pub(super) normal: [f64; 3],
    /// Second derivative of the distance in gel space, 1/mm, for motions along the face.
    pub(super) curvature: [[f64; 3]; 3],
}

impl Frame {
    pub(super) fn new(pose: &Pose, centre_mm: [f64; 2]) -> Self {
        let [(sin_x, cos_x), (sin_y, cos_y)] = pose.tilt_rad.map(f64::sin_cos);
        let (sin_z, cos_z) = pose.twist_rad.sin_cos();
        let about_x = [[1.0, 0.0, 0.0], [0.0, cos_x, -sin_x], [0.0, sin_x, cos_x]];
        let about_y = [[cos_y, 0.0, sin_y], [0.0, 1.0, 0.0], [-sin_y, 0.0, cos_y]];
        let about_z = [[cos_z, -sin_z, 0.0], [sin_z, cos_z, 0.0], [0.0, 0.0, 1.0]];
        let [x, y] = [0, 1].map(|axis| centre_mm[axis] + pose.shear_mm[axis]);
        Self { rotation: product(&about_z, &product(&about_y, &about_x)), origin: [x, y, pose.depth_mm] }
    }

    pub(super) fn gel_from_indenter(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(point);
        [0, 1, 2].map(|c| self.origin[c] + turned[c])
    }

    pub(super) fn indenter_from_gel(&self, point: [f64; 3]) -> [f64; 3] {
        let from = [0, 1, 2].map(|c| point[c] - self.origin[c]);
        [0, 1, 2].map(|c| (0..3).map(|r| self.rotation[r][c] * from[r]).sum())
    }

    fn turned(&self, direction: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| dot(&row, &direction))
    }

    /// A point of gel space relative to the face; absent where the indenter has none.
    pub(super) fn gap(&self, relief: &dyn Relief, point: [f64; 3]) -> Option<Gap> {
        let own = self.indenter_from_gel(point);
        let face = relief.at(own[0], own[1]);
        if !face.height_mm.is_finite() {
            return None;
        }
        let [slope_x, slope_y] = face.slope;
        let length = (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
        let normal = self.turned([slope_x / length, slope_y / length, 1.0 / length]);
        let [xx, xy, yy] = face.curvature_per_mm.map(|value| value / length);
        let bend = [[xx, xy, 0.0], [xy, yy, 0.0], [0.0; 3]];
        let turned_bend = product(&self.rotation, &bend);
        let curvature = turned_bend.map(|row| self.rotation.map(|axis| dot(&row, &axis)));
        Some(Gap { distance: (own[2] + face.height_mm) / length, normal, curvature })
    }
}

impl Pose {
    /// The pose at a fraction of the motion from this one to another.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self {
            depth_mm: mix(self.depth_mm, other.depth_mm),
            shear_mm: [0, 1].map(|axis| mix(self.shear_mm[axis], other.shear_mm[axis])),
            twist_rad: mix(self.twist_rad, other.twist_rad),
            tilt_rad: [0, 1].map(|axis| mix(self.tilt_rad[axis], other.tilt_rad[axis])),
        }
    }

    /// The motion from this pose to `next`, as a fraction of that from `start` to `goal`; absent if the direction
    /// differs.
    pub(super) fn share_of_way(&self, next: &Self, start: &Self, goal: &Self) -> Option<f64> {
        let way = |from: &Self, to: &Self| {
            let turn = |from: f64, to: f64| ARM_MM * (to - from);
            [
                to.depth_mm - from.depth_mm,
                to.shear_mm[0] - from.shear_mm[0],
                to.shear_mm[1] - from.shear_mm[1],
                turn(from.twist_rad, to.twist_rad),
                turn(from.tilt_rad[0], to.tilt_rad[0]),
                turn(from.tilt_rad[1], to.tilt_rad[1]),
            ]
        };
        let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (then, now) = (way(self, next), way(start, goal));
        let (along, length, other) = (dot(&then, &now), dot(&then, &then), dot(&now, &now));
        (along > 0.0 && along * along > STRAIGHT * length * other).then(|| along / length)
    }

    /// Whether every number of it is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let [x, y] = self.shear_mm;
        let [tilt_x, tilt_y] = self.tilt_rad;
        [self.depth_mm, x, y, self.twist_rad, tilt_x, tilt_y].into_iter().all(f64::is_finite)
    }
}

pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| [0, 1, 2].map(|c| (0..3).map(|k| row[k] * b[k][c]).sum()))
}
