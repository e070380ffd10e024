//! The thirteen unknowns of a camera, and the coordinates in which they are fitted.

use fingervision_optics::{CameraParams, Distortion, ParameterJacobian, Radial};
use nalgebra::{SMatrix, SVector};

/// Number of unknowns of a camera: one focal length for both axes.
pub const UNKNOWNS: usize = 13;

/// A number for each unknown, in the order of [`Unknown::ALL`].
pub type Unknowns = SVector<f64, UNKNOWNS>;
/// A number for each pair of unknowns.
pub(super) type UnknownsMatrix = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// An unknown of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// Rotation vector along x, rad.
    RotationX,
    /// Rotation vector along y, rad.
    RotationY,
    /// Rotation vector along z, rad.
    RotationZ,
    /// The origin along x in camera space, mm.
    TranslationX,
    /// The origin along y in camera space, mm.
    TranslationY,
    /// The origin along the optical axis, mm: the distance of the surface.
    Distance,
    /// Radial distortion, dimensionless.
    K1,
    /// Radial distortion, dimensionless.
    K2,
    /// Tangential distortion, dimensionless.
    P1,
    /// Tangential distortion, dimensionless.
    P2,
    /// Focal length, px.
    FocalLength,
    /// Column of the principal point, px.
    PrincipalX,
    /// Row of the principal point, px.
    PrincipalY,
}

impl Unknown {
    /// All unknowns, in the order of [`Unknowns`].
    pub const ALL: [Self; UNKNOWNS] = [
        Self::RotationX,
        Self::RotationY,
        Self::RotationZ,
        Self::TranslationX,
        Self::TranslationY,
        Self::Distance,
        Self::K1,
        Self::K2,
        Self::P1,
        Self::P2,
        Self::FocalLength,
        Self::PrincipalX,
        Self::PrincipalY,
    ];

    /// Its name with its unit, as on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RotationX => "rotation_x_rad",
            Self::RotationY => "rotation_y_rad",
            Self::RotationZ => "rotation_z_rad",
            Self::TranslationX => "translation_x_mm",
            Self::TranslationY => "translation_y_mm",
            Self::Distance => "distance_mm",
            Self::K1 => "k1",
            Self::K2 => "k2",
            Self::P1 => "p1",
            Self::P2 => "p2",
            Self::FocalLength => "focal_length_px",
            Self::PrincipalX => "principal_x_px",
            Self::PrincipalY => "principal_y_px",
        }
    }

    /// Its place in [`Unknowns`].
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

/// The camera that the unknowns describe.
#[must_use]
pub fn camera_params(unknowns: &Unknowns, radial: Radial) -> CameraParams {
    let u = unknowns;
    CameraParams {
        focal_length_px: [u[10]; 2],
        principal_point_px: [u[11], u[12]],
        distortion: Distortion { k1: u[6], k2: u[7], p1: u[8], p2: u[9], radial },
        rotation_rad: [u[0], u[1], u[2]],
        translation_mm: [u[3], u[4], u[5]],
    }
}

/// The unknowns of a camera; for two focal lengths their mean.
#[must_use]
pub fn unknowns_of(params: &CameraParams) -> Unknowns {
    let ([a, b, c], [x, y, z]) = (params.rotation_rad, params.translation_mm);
    let Distortion { k1, k2, p1, p2, .. } = params.distortion;
    let ([fx, fy], [cx, cy]) = (params.focal_length_px, params.principal_point_px);
    Unknowns::from([[a, b, c, x, y, z, k1, k2, p1, p2, 0.5 * (fx + fy), cx, cy]])
}

/// The derivatives of a pixel by the unknowns: a row for u and one for v.
pub(super) fn row_by_unknowns(jacobian: &ParameterJacobian) -> [[f64; UNKNOWNS]; 2] {
    [0, 1].map(|row| {
        let [a, b, c] = jacobian.by_rotation[row];
        let [x, y, z] = jacobian.by_translation[row];
        let [k1, k2, p1, p2] = jacobian.by_distortion[row];
        let [fx, fy] = jacobian.by_focal_length[row];
        let [cx, cy] = jacobian.by_principal_point[row];
        [a, b, c, x, y, z, k1, k2, p1, p2, fx + fy, cx, cy]
    })
}

/// Coordinates in which the flow of a sliding board is nearly linear, and in which the undetermined combination is one
/// coordinate instead of a curved valley.
///
/// A longer focal length f with a board farther away gives the same flow if distortion and tilt grow with it. So the
/// coordinates, with the half diagonal h of the picture in px, are
///
/// ```text
/// tilt · h/f    twist    T_x/T_z, T_y/T_z    log T_z    k1 (h/f)²    k2 (h/f)⁴    p1 h/f    p2 h/f    f/T_z    u/h
/// ```
///
/// and only the logarithm is along the valley. With the published radial form k2 is multiplied by h/f.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coordinates {
    /// Half the diagonal of the picture, px.
    pub(super) half_diagonal_px: f64,
    pub(super) radial: Radial,
}

impl Coordinates {
    /// Powers of f/h with which tilt and distortion grow.
    fn powers(&self) -> [(usize, i32); 6] {
        let second = match self.radial {
            Radial::Brown => 4,
            Radial::Printed => 1,
        };
        [(0, 1), (1, 1), (6, 2), (7, second), (8, 1), (9, 1)]
    }

    pub(super) fn of(&self, unknowns: &Unknowns) -> Unknowns {
        let (focal, distance) = (unknowns[10], unknowns[5]);
        let mut coordinates = *unknowns;
        for (index, power) in self.powers() {
            coordinates[index] /= (focal / self.half_diagonal_px).powi(power);
        }
        coordinates[3] /= distance;
        coordinates[4] /= distance;
        coordinates[5] = distance.ln();
        coordinates[10] = focal / distance;
        coordinates[11] /= self.half_diagonal_px;
        coordinates[12] /= self.half_diagonal_px;
        coordinates
    }

    pub(super) fn unknowns(&self, coordinates: &Unknowns) -> Unknowns {
        let distance = coordinates[5].exp();
        let focal = distance * coordinates[10];
        let mut unknowns = *coordinates;
        for (index, power) in self.powers() {
            unknowns[index] *= (focal / self.half_diagonal_px).powi(power);
        }
        unknowns[3] *= distance;
        unknowns[4] *= distance;
        unknowns[5] = distance;
        unknowns[10] = focal;
        unknowns[11] *= self.half_diagonal_px;
        unknowns[12] *= self.half_diagonal_px;
        unknowns
    }

    /// Derivatives of the unknowns, in the rows, by the coordinates, in the columns.
    pub(super) fn jacobian(&self, coordinates: &Unknowns) -> UnknownsMatrix {
        let unknowns = self.unknowns(coordinates);
        let (focal, distance) = (unknowns[10], unknowns[5]);
        let mut jacobian = UnknownsMatrix::identity();
        for (index, power) in self.powers() {
            jacobian[(index, index)] = (focal / self.half_diagonal_px).powi(power);
            let by_log_focal = f64::from(power) * unknowns[index];
            (jacobian[(index, 5)], jacobian[(index, 10)]) = (by_log_focal, by_log_focal / coordinates[10]);
        }
        for index in [3, 4] {
            (jacobian[(index, index)], jacobian[(index, 5)]) = (distance, unknowns[index]);
        }
        jacobian[(5, 5)] = distance;
        (jacobian[(10, 5)], jacobian[(10, 10)]) = (focal, distance);
        (jacobian[(11, 11)], jacobian[(12, 12)]) = (self.half_diagonal_px, self.half_diagonal_px);
        jacobian
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknowns() -> Unknowns {
        Unknowns::from([[0.06, -0.04, 0.02, 1.0, -2.0, 25.0, -0.08, 0.02, 0.001, -0.0005, 400.0, 241.0, 236.0]])
    }

    #[test]
    fn coordinates_lead_back_to_the_unknowns() {
        for radial in [Radial::Brown, Radial::Printed] {
            let coordinates = Coordinates { half_diagonal_px: 340.0, radial };
            let back = coordinates.unknowns(&coordinates.of(&unknowns()));
            assert!((back - unknowns()).amax() < 1e-11, "{radial:?}: {back}");
        }
        let params = camera_params(&unknowns(), Radial::Brown);
        assert_eq!(unknowns_of(&params), unknowns());
    }

    #[test]
    fn the_jacobian_of_the_coordinates_is_that_of_differences() {
        for radial in [Radial::Brown, Radial::Printed] {
            let coordinates = Coordinates { half_diagonal_px: 340.0, radial };
            let at = coordinates.of(&unknowns());
            let jacobian = coordinates.jacobian(&at);
            for column in 0..UNKNOWNS {
                let mut step = Unknowns::zeros();
                step[column] = 1e-5;
                let difference = (coordinates.unknowns(&(at + step)) - coordinates.unknowns(&(at - step))) / 2e-5;
                let scale = difference.amax().max(1e-3);
                let error = (difference - jacobian.column(column)).amax() / scale;
                assert!(error < 1e-6, "{radial:?}, column {column}: {error:e}");
            }
        }
    }
}
