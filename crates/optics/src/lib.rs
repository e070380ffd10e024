//! The camera: from a point of the gel to a pixel and back.
//!
//! A pinhole with Brown's distortion and a pose. [`Camera::project`] takes a point in gel space to the image,
//! [`Camera::ray`] and [`Camera::surface_point`] take a pixel back, and the Jacobians are the derivatives of a pixel by
//! the point ([`Projection`]) and by every parameter ([`ParameterJacobian`]). [`Camera::area_growth_per_mm`] is the
//! growth of the surface in the image as it comes nearer: the information about depth from perspective alone.
//!
//! # Spaces
//!
//! *Gel space*, mm: origin at the centre of the undeformed surface, x right, y down in the image, **z towards the
//! camera**. *Camera space*, mm: x right, y down, **z along the optical axis, away from the camera**. Both are described
//! as the camera sees them and differ in the sense of z, so one is a mirror image of the other: going from gel to
//! camera is a reflection, then a rotation, then a translation,
//!
//! ```text
//! P = R(rotation_rad) · diag(1, 1, −1) · p + translation_mm
//! ```
//!
//! Without rotation `P = (x + tx, y + ty, tz − z)`: a point that is pressed in by z comes nearer to the camera.
//!
//! # Projection
//!
//! With `(x, y) = (P_x, P_y) / P_z` and `r² = x² + y²`, the pixel `(u, v)`, integer at pixel centres, is
//!
//! ```text
//! x_d = x f(r) + 2 p1 x y + p2 (r² + 2 x²)        u = focal_x · x_d + principal_x
//! y_d = y f(r) + p1 (r² + 2 y²) + 2 p2 x y        v = focal_y · y_d + principal_y
//! f(r) = 1 + k1 r² + k2 r⁴                        (Brown: D. C. Brown, *Close-range camera calibration*, 1971)
//! ```
//!
//! ```
//! use fingervision_optics::{Camera, CameraParams, Distortion};
//!
//! let camera = Camera::new(&CameraParams {
//!     focal_length_px: [400.0, 400.0],
//!     principal_point_px: [239.5, 239.5],
//!     distortion: Distortion::default(),
//!     rotation_rad: [0.0; 3],
//!     translation_mm: [0.0, 0.0, 25.0],
//! })?;
//! assert_eq!(camera.project([5.0, 0.0, 0.0]), Some([319.5, 239.5]));
//! // Pressed in by 1 mm, the same point appears farther from the centre.
//! assert!(camera.project([5.0, 0.0, 1.0]).unwrap()[0] > 319.5);
//! assert_eq!(camera.surface_point([319.5, 239.5], 0.0), Some([5.0, 0.0]));
//! # Ok::<(), fingervision_optics::CameraError>(())
//! ```

mod camera;
mod lens;
mod params;
mod rotation;
#[cfg(test)]
mod tests;

pub use camera::{Camera, ParameterJacobian, Projection, Ray};
pub use params::{CameraError, CameraParams, Distortion, Radial};
pub use rotation::rotation_matrix;
