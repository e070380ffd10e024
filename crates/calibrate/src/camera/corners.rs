//! Fits the camera to corners of a checkerboard in several poses, which determine every parameter.

use fingervision_optics::{Camera, CameraParams, Radial};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Owned, Rotation3, Vector3};
use serde::Serialize;

use super::Residuals;
use super::corner_error::{CornerError, LEAST_CORNERS, LEAST_POSES};
use super::thresholds::THRESHOLDS;
use super::unknowns::{Unknowns, camera_params, row_by_unknowns};

/// Focal length, principal point and distortion come first, then six numbers for each pose.
const LENS: usize = 7;
const POSE: usize = 6;
/// Indices of lens and pose among the unknowns of a camera.
pub(super) const LENS_PLACES: [usize; LENS] = [6, 7, 8, 9, 10, 11, 12];
pub(super) const POSE_PLACES: [usize; POSE] = [0, 1, 2, 3, 4, 5];
/// Residual of a corner behind the camera, px.
const UNSEEN_PX: f64 = 1e4;

/// A corner that was detected in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Its position on the board, mm: x right, y down, as seen by an upright camera.
    pub board_mm: [f64; 2],
    /// Its detected position, px in the region of interest.
    pub px: [f64; 2],
}

/// A camera from corners. Its pose is that of the first image: gel space is the board's there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CornerFit {
    /// The camera.
    #[serde(rename = "camera")]
    pub params: CameraParams,
    /// Number of images.
    pub images: usize,
    /// Distance between the predicted and the detected corners, px.
    pub reprojection: Residuals,
    /// Standard uncertainties of k1, k2, p1, p2, focal length and principal point, then of rotation and translation.
    pub uncertainty: Vec<f64>,
}

/// Fits lens and poses to the corners of several images, one item for each image ([Zhang2000]).
///
/// A homography for each image gives a first focal length and pose, with the principal point in the middle of the
/// corners; Levenberg–Marquardt then minimises the squared distances of all corners, with distortion.
///
/// # Errors
///
/// [`CornerError`] if there are too few images or corners, if the corners do not span the board, or if no camera
/// explains them.
///
/// [Zhang2000]: https://doi.org/10.1109/34.888718
pub fn fit_corners(images: &[Vec<Corner>], radial: Radial) -> Result<CornerFit, CornerError> {
    if images.len() < LEAST_POSES {
        return Err(CornerError::TooFewImages { images: images.len() });
    }
    if let Some((image, corners)) = images.iter().enumerate().find(|(_, corners)| corners.len() < LEAST_CORNERS) {
        return Err(CornerError::TooFewCorners { image, corners: corners.len() });
    }
    let start = start(images)?;
    let method = LevenbergMarquardt::new().with_tol(1e-12).with_patience(20);
    let (solved, _) = method.minimize(CornerProblem { images, radial, at: start });
    let reprojection = solved.reprojection();
    if reprojection.mean_px.is_nan() || reprojection.mean_px > THRESHOLDS.most_corner_residual_px {
        return Err(CornerError::NotConverged { residual_px: reprojection.mean_px });
    }
    let params = camera_params(&solved.camera_unknowns(0), radial);
    Ok(CornerFit { params, images: images.len(), reprojection, uncertainty: solved.uncertainty(&reprojection) })
}

struct CornerProblem<'a> {
    images: &'a [Vec<Corner>],
    radial: Radial,
    at: DVector<f64>,
}

impl CornerProblem<'_> {
    fn camera_unknowns(&self, image: usize) -> Unknowns {
        let mut unknowns = Unknowns::zeros();
        for (index, place) in LENS_PLACES.into_iter().enumerate() {
            unknowns[place] = self.at[index];
        }
        for (index, place) in POSE_PLACES.into_iter().enumerate() {
            unknowns[place] = self.at[LENS + POSE * image + index];
        }
        unknowns
    }

    fn camera(&self, image: usize) -> Option<Camera> {
        Camera::new(&camera_params(&self.camera_unknowns(image), self.radial)).ok()
    }

    fn corners(&self) -> usize {
        self.images.iter().map(Vec::len).sum()
    }

    fn residual_vectors(&self) -> impl Iterator<Item = Option<[f64; 2]>> {
        self.images.iter().enumerate().flat_map(|(image, corners)| {
            let camera = self.camera(image);
            corners.iter().map(move |corner| {
                let [x, y] = corner.board_mm;
                let [u, v] = camera.as_ref()?.project([x, y, 0.0])?;
                Some([u - corner.px[0], v - corner.px[1]])
            })
        })
    }

    fn reprojection(&self) -> Residuals {
        Residuals::of(self.residual_vectors())
    }

    /// Of the lens and the first pose, `σ √diag (JᵀJ)⁻¹` with σ from the residuals; infinite where a value is not
    /// determined.
    fn uncertainty(&self, reprojection: &Residuals) -> Vec<f64> {
        let Some(jacobian) = self.jacobian() else { return vec![f64::INFINITY; LENS + POSE] };
        let free = (2 * self.corners()).saturating_sub(self.at.len()).max(1) as f64;
        let variance = reprojection.root_mean_square_px().powi(2) * self.corners() as f64 / free;
        let information = jacobian.tr_mul(&jacobian);
        let scale = information.diagonal().map(|value| value.sqrt().recip());
        let scaled = DMatrix::from_fn(self.at.len(), self.at.len(), |row, column| {
            information[(row, column)] * scale[row] * scale[column]
        });
        let Some(inverse) = scaled.try_inverse() else { return vec![f64::INFINITY; LENS + POSE] };
        (0..LENS + POSE).map(|index| (variance * inverse[(index, index)]).sqrt() * scale[index]).collect()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for CornerProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = self.residual_vectors().flat_map(|residual| residual.unwrap_or([UNSEEN_PX; 2]));
        Some(DVector::from_iterator(2 * self.corners(), residuals))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(2 * self.corners(), self.at.len());
        let mut row = 0;
        for (image, corners) in self.images.iter().enumerate() {
            let camera = self.camera(image)?;
            for corner in corners {
                let [x, y] = corner.board_mm;
                if let Some(found) = camera.parameter_jacobian([x, y, 0.0]) {
                    for (component, by_unknowns) in row_by_unknowns(&found).into_iter().enumerate() {
                        for (index, place) in LENS_PLACES.into_iter().enumerate() {
                            jacobian[(row + component, index)] = by_unknowns[place];
                        }
                        for (index, place) in POSE_PLACES.into_iter().enumerate() {
                            jacobian[(row + component, LENS + POSE * image + index)] = by_unknowns[place];
                        }
                    }
                }
                row += 2;
            }
        }
        Some(jacobian)
    }
}

/// A lens without distortion, and the poses for it.
fn start(images: &[Vec<Corner>]) -> Result<DVector<f64>, CornerError> {
    let all = || images.iter().flatten();
    let middle = [0, 1].map(|axis| {
        let (low, high) = all()
            .map(|corner| corner.px[axis])
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), px| (low.min(px), high.max(px)));
        0.5 * (low + high)
    });
    let homographies: Option<Vec<Matrix3<f64>>> = images.iter().map(|corners| homography(corners, middle)).collect();
    let Some(homographies) = homographies else { return Err(CornerError::NoPlane) };
    let focal = focal_length(&homographies).ok_or(CornerError::NoTilt)?;
    let lens = [0.0, 0.0, 0.0, 0.0, focal, middle[0], middle[1]];
    let poses = homographies.iter().flat_map(|homography| pose(homography, focal));
    Ok(DVector::from_iterator(LENS + POSE * images.len(), lens.into_iter().chain(poses)))
}

/// The matrix that takes `(x, y, 1)` on the board to the pixel from the middle, by the smallest singular vector.
fn homography(corners: &[Corner], middle: [f64; 2]) -> Option<Matrix3<f64>> {
    let mut rows = DMatrix::zeros(2 * corners.len(), 9);
    // Both sides are scaled to about 1; otherwise the singular values are ill-conditioned.
    let (size_mm, size_px) = corners.iter().fold((0.0_f64, 0.0_f64), |(mm, px), corner| {
        (
            mm.max(corner.board_mm[0].hypot(corner.board_mm[1])),
            px.max((corner.px[0] - middle[0]).hypot(corner.px[1] - middle[1])),
        )
    });
    for (index, corner) in corners.iter().enumerate() {
        let [x, y] = corner.board_mm.map(|value| value / size_mm);
        let [u, v] = [0, 1].map(|axis| (corner.px[axis] - middle[axis]) / size_px);
        for (column, value) in [x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y, -u].into_iter().enumerate() {
            rows[(2 * index, column)] = value;
        }
        for (column, value) in [0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y, -v].into_iter().enumerate() {
            rows[(2 * index + 1, column)] = value;
        }
    }
    let eigen = rows.tr_mul(&rows).symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    // Corners on a line determine no unique matrix.
    if eigen.eigenvalues[order[1]] < 1e-9 * eigen.eigenvalues[order[8]] {
        return None;
    }
    let found = eigen.eigenvectors.column(order[0]);
    let scaled = Matrix3::from_row_slice(found.as_slice());
    let to_px = Matrix3::from_diagonal(&Vector3::new(size_px, size_px, 1.0));
    let to_unit = Matrix3::from_diagonal(&Vector3::new(size_mm.recip(), size_mm.recip(), 1.0));
    let matrix = to_px * scaled * to_unit;
    // The board is in front of the camera.
    Some(if matrix[(2, 2)] < 0.0 { -matrix } else { matrix })
}

/// The first two columns of a homography are images of equally long, orthogonal vectors: least squares for 1/f².
fn focal_length(homographies: &[Matrix3<f64>]) -> Option<f64> {
    let (mut numerator, mut denominator) = (0.0, 0.0);
    for matrix in homographies {
        let (a, b) = (matrix.column(0), matrix.column(1));
        let length = a.norm_squared() + b.norm_squared();
        for (across, along) in [
            (a[0] * b[0] + a[1] * b[1], a[2] * b[2]),
            (a[0] * a[0] + a[1] * a[1] - b[0] * b[0] - b[1] * b[1], a[2] * a[2] - b[2] * b[2]),
        ] {
            numerator -= across * along / length.powi(2);
            denominator += across * across / length.powi(2);
        }
    }
    let focal = (denominator / numerator).sqrt();
    focal.is_finite().then_some(focal)
}

/// Rotation vector and translation of a homography, for a focal length.
fn pose(homography: &Matrix3<f64>, focal: f64) -> [f64; 6] {
    let matrix = Matrix3::from_diagonal(&Vector3::new(focal.recip(), focal.recip(), 1.0)) * homography;
    let scale = 2.0 / (matrix.column(0).norm() + matrix.column(1).norm());
    let (a, b, translation) = (matrix.column(0) * scale, matrix.column(1) * scale, matrix.column(2) * scale);
    let nearly = Matrix3::from_columns(&[a, b, a.cross(&b)]);
    let rotation = Rotation3::from_matrix(&nearly).scaled_axis();
    [rotation.x, rotation.y, rotation.z, translation.x, translation.y, translation.z]
}
