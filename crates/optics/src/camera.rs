//! The camera, made once from its parameters.

use crate::lens::Lens;
use crate::params::check;
use crate::rotation::{self, Matrix};
use crate::{CameraError, CameraParams};

/// A camera with its pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    params: CameraParams,
    lens: Lens,
    rotation: Matrix,
    /// The rotation after the reflection of z.
    from_gel: Matrix,
    position_mm: [f64; 3],
}

/// The pixel of a point, and its derivatives by the point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// The pixel `(u, v)`, integer at pixel centres.
    pub px: [f64; 2],
    /// Derivatives of u and of v by the point's x, y and z in gel space, px/mm.
    pub by_point: [[f64; 3]; 2],
}

/// Derivatives of the pixel of a point by every parameter of the camera. Each array has a row for u and one for v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterJacobian {
    /// By both focal lengths, dimensionless. One focal length for both: the sum of a row.
    pub by_focal_length: [[f64; 2]; 2],
    /// By the principal point, dimensionless.
    pub by_principal_point: [[f64; 2]; 2],
    /// By k1, k2, p1 and p2, px.
    pub by_distortion: [[f64; 4]; 2],
    /// By the rotation vector, px/rad.
    pub by_rotation: [[f64; 3]; 2],
    /// By the translation, px/mm.
    pub by_translation: [[f64; 3]; 2],
}

/// The ray of a pixel: a half-line in gel space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The camera's centre, mm.
    pub origin_mm: [f64; 3],
    /// From the camera into the scene, of length 1, dimensionless.
    pub direction: [f64; 3],
}

/// A point during its projection.
struct Seen {
    /// `(P_x, P_y) / P_z`, dimensionless.
    direction: [f64; 2],
    distorted: [f64; 2],
    /// `P_z`, mm.
    distance_mm: f64,
}

impl CameraParams {
    /// Checks that every value is possible and that the camera is on its side of the surface.
    ///
    /// # Errors
    ///
    /// [`CameraError`] naming the first value that is not possible.
    pub fn validate(&self) -> Result<(), CameraError> {
        Camera::new(self).map(|_| ())
    }
}

impl Camera {
    /// A camera with these parameters.
    ///
    /// # Errors
    ///
    /// [`CameraError`] if a value is impossible or the camera would be in or below the surface, where the indenter is.
    pub fn new(params: &CameraParams) -> Result<Self, CameraError> {
        params.check_values()?;
        let rotation = rotation::rotation_matrix(params.rotation_rad);
        let from_gel = rotation.map(|[x, y, z]| [x, y, -z]);
        let position_mm = rotation::apply_transposed(&from_gel, params.translation_mm).map(|value| -value);
        let allowed = "an angle below that at which the camera sees the gel from underneath";
        check(position_mm[2] > 0.0, "rotation_rad", params.rotation_rad, allowed)?;
        let lens = Lens::new(&params.distortion);
        Ok(Self { params: *params, lens, rotation, from_gel, position_mm })
    }

    /// The parameters of the camera.
    #[must_use]
    pub fn params(&self) -> &CameraParams {
        &self.params
    }

    /// The camera's centre in gel space, mm.
    #[must_use]
    pub fn position_mm(&self) -> [f64; 3] {
        self.position_mm
    }

    /// A point of gel space in camera space, mm.
    #[must_use]
    #[inline]
    pub fn camera_from_gel(&self, gel_mm: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = rotation::apply(&self.from_gel, gel_mm);
        let [tx, ty, tz] = self.params.translation_mm;
        [x + tx, y + ty, z + tz]
    }

    /// The pixel `(u, v)` at which a point in gel space, mm, appears, even outside the image.
    ///
    /// None behind the camera, and so far from the axis that the distortion polynomial is not one to one (see
    /// [`Camera::ray`]).
    #[must_use]
    #[inline]
    pub fn project(&self, gel_mm: [f64; 3]) -> Option<[f64; 2]> {
        self.see(gel_mm).map(|seen| self.px(seen.distorted))
    }

    /// As [`Camera::project`], with the derivatives by the point.
    #[must_use]
    pub fn project_with_jacobian(&self, gel_mm: [f64; 3]) -> Option<Projection> {
        let seen = self.see(gel_mm)?;
        let by_point = rotation::product(&self.by_camera_point(&seen), &self.from_gel);
        Some(Projection { px: self.px(seen.distorted), by_point })
    }

    /// Derivatives of a point's pixel by every parameter; none where [`Camera::project`] gives none.
    #[must_use]
    pub fn parameter_jacobian(&self, gel_mm: [f64; 3]) -> Option<ParameterJacobian> {
        let seen = self.see(gel_mm)?;
        let by_translation = self.by_camera_point(&seen);
        // d(R q) = −R [q] J dv with q the reflected point.
        let [x, y, z] = gel_mm;
        let reflected = rotation::cross_matrix([-x, -y, z]);
        let turned = rotation::product(&rotation::product(&by_translation, &self.rotation), &reflected);
        let by_rotation = rotation::product(&turned, &rotation::right_jacobian(self.params.rotation_rad));
        let [fx, fy] = self.params.focal_length_px;
        let [by_x, by_y] = self.lens.by_coefficients(seen.direction);
        let [x_d, y_d] = seen.distorted;
        Some(ParameterJacobian {
            by_focal_length: [[x_d, 0.0], [0.0, y_d]],
            by_principal_point: [[1.0, 0.0], [0.0, 1.0]],
            by_distortion: [by_x.map(|value| fx * value), by_y.map(|value| fy * value)],
            by_rotation,
            by_translation,
        })
    }

    /// The ray of a pixel.
    ///
    /// Distortion is undone by Newton's method to a residual of 1e-13 focal lengths. None outside the range in which
    /// distortion is one to one: the image of the largest disc about the axis on which the determinant of its Jacobian
    /// is positive.
    #[must_use]
    pub fn ray(&self, px: [f64; 2]) -> Option<Ray> {
        let direction = self.direction(px)?;
        let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
        Some(Ray { origin_mm: self.position_mm, direction: direction.map(|value| value / length) })
    }

    /// Where a pixel's ray meets the plane `z = z_mm` of gel space: x and y there, mm.
    ///
    /// None where [`Camera::ray`] gives none and where the ray does not reach the plane.
    #[must_use]
    pub fn surface_point(&self, px: [f64; 2], z_mm: f64) -> Option<[f64; 2]> {
        let direction = self.direction(px)?;
        let along = (z_mm - self.position_mm[2]) / direction[2];
        let is_ahead = along.is_finite() && along > 0.0;
        is_ahead.then(|| [0, 1].map(|axis| self.position_mm[axis] + along * direction[axis]))
    }

    /// Size of a pixel on the undeformed surface, mm: the square root of the area that it covers there, for a flat gel.
    ///
    /// None where [`Camera::surface_point`] gives none.
    #[must_use]
    pub fn mm_per_px(&self, px: [f64; 2]) -> Option<f64> {
        let [x, y] = self.surface_point(px, 0.0)?;
        let [by_u, by_v] = self.project_with_jacobian([x, y, 0.0])?.by_point;
        Some((by_u[0] * by_v[1] - by_u[1] * by_v[0]).abs().sqrt().recip())
    }

    /// Relative growth of a small patch of the undeformed surface in the image, per mm that it moves straight towards the
    /// camera, 1/mm.
    ///
    /// With `P` the point in camera space, `c` the gel's z axis there and `h = −P · c` the camera's height over the
    /// surface, the image of an area is `h / P_z³` times the determinant of the distortion's Jacobian, so that
    ///
    /// ```text
    /// d ln(area) / dz = −3 c_z / P_z − 1 / h + ∇ ln det(lens) · d(direction) / dz
    /// ```
    ///
    /// An untilted pinhole at the distance z₀ has `2 / z₀` everywhere. The lens as printed has a kink on its axis, where its
    /// part is left out. None where [`Camera::surface_point`] gives none.
    #[must_use]
    pub fn area_growth_per_mm(&self, px: [f64; 2]) -> Option<f64> {
        let [x, y] = self.surface_point(px, 0.0)?;
        let Seen { direction, distance_mm, .. } = self.see([x, y, 0.0])?;
        let axis = self.from_gel.map(|row| row[2]);
        let by_height = [0, 1].map(|i| (axis[i] - direction[i] * axis[2]) / distance_mm);
        let by_direction = self.lens.log_determinant_gradient(direction);
        let lens = by_direction[0] * by_height[0] + by_direction[1] * by_height[1];
        Some(-3.0 * axis[2] / distance_mm - 1.0 / self.position_mm[2] + lens)
    }

    #[inline]
    fn see(&self, gel_mm: [f64; 3]) -> Option<Seen> {
        let [x, y, distance_mm] = self.camera_from_gel(gel_mm);
        if distance_mm > 0.0 {
            let direction = [x / distance_mm, y / distance_mm];
            Some(Seen { direction, distorted: self.lens.distort(direction)?, distance_mm })
        } else {
            None
        }
    }

    #[inline]
    fn px(&self, distorted: [f64; 2]) -> [f64; 2] {
        let ([fx, fy], [cx, cy]) = (self.params.focal_length_px, self.params.principal_point_px);
        [fx * distorted[0] + cx, fy * distorted[1] + cy]
    }

    /// Derivatives of the pixel by the point in camera space, px/mm.
    fn by_camera_point(&self, seen: &Seen) -> [[f64; 3]; 2] {
        let [fx, fy] = self.params.focal_length_px;
        let [xx, xy, yy] = self.lens.jacobian(seen.direction);
        let [x, y] = seen.direction;
        [[fx * xx, fx * xy], [fy * xy, fy * yy]]
            .map(|[by_x, by_y]| [by_x, by_y, -(by_x * x + by_y * y)].map(|value| value / seen.distance_mm))
    }

    /// The direction of a pixel's ray in gel space, with component 1 along the optical axis.
    fn direction(&self, px: [f64; 2]) -> Option<[f64; 3]> {
        let ([fx, fy], [cx, cy]) = (self.params.focal_length_px, self.params.principal_point_px);
        let [x, y] = self.lens.undistort([(px[0] - cx) / fx, (px[1] - cy) / fy])?;
        Some(rotation::apply_transposed(&self.from_gel, [x, y, 1.0]))
    }
}
