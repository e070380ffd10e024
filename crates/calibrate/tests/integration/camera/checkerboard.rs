//! Corners of a checkerboard whose camera is known.

use fingervision_calibrate::camera::{Corner, CornerError, fit_corners};
use fingervision_optics::{Camera, CameraParams, Distortion, Radial};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::world::uniform;

fn truth() -> CameraParams {
    CameraParams {
        focal_length_px: [400.0; 2],
        principal_point_px: [246.0, 233.0],
        distortion: Distortion { k1: -0.08, k2: 0.02, p1: 0.001, p2: -0.0005, radial: Radial::Brown },
        rotation_rad: [0.05, -0.03, 0.1],
        translation_mm: [0.5, -0.3, 25.0],
    }
}

/// Corners of a board of 11×9 squares of 2 mm, turned by these angles, seen with noise.
fn images(turns_rad: &[[f64; 3]]) -> Vec<Vec<Corner>> {
    let random = &mut Pcg64Mcg::seed_from_u64(5);
    let image = |&rotation_rad: &[f64; 3]| {
        let camera = Camera::new(&CameraParams { rotation_rad, ..truth() }).unwrap();
        let places = (0..80).map(|corner| [f64::from(corner % 10) * 2.0 - 9.0, f64::from(corner / 10) * 2.0 - 7.0]);
        places
            .map(|board_mm: [f64; 2]| {
                let px = camera.project([board_mm[0], board_mm[1], 0.0]).unwrap();
                Corner { board_mm, px: px.map(|value| value + 0.1 * uniform(random)) }
            })
            .collect()
    };
    turns_rad.iter().map(image).collect()
}

const TURNS: [[f64; 3]; 5] =
    [[0.05, -0.03, 0.1], [0.5, 0.0, 0.0], [-0.4, 0.2, 0.3], [0.1, 0.5, -0.2], [0.0, -0.5, 0.1]];

#[test]
fn corners_in_five_poses_give_lens_distance_and_pose() {
    let fit = fit_corners(&images(&TURNS), Radial::Brown).unwrap();
    let truth = truth();
    assert!(fit.reprojection.mean_px < 0.1, "{:?}", fit.reprojection);
    let found = &fit.params;
    let off = [
        ("focal length, px", found.focal_length_px[0] - truth.focal_length_px[0], fit.uncertainty[4]),
        ("principal x, px", found.principal_point_px[0] - truth.principal_point_px[0], fit.uncertainty[5]),
        ("principal y, px", found.principal_point_px[1] - truth.principal_point_px[1], fit.uncertainty[6]),
        ("k1", found.distortion.k1 - truth.distortion.k1, fit.uncertainty[0]),
        ("distance, mm", found.translation_mm[2] - truth.translation_mm[2], fit.uncertainty[12]),
        ("tilt, rad", found.rotation_rad[0] - truth.rotation_rad[0], fit.uncertainty[7]),
    ];
    for (name, error, uncertainty) in off {
        assert!(error.abs() < 4.5 * uncertainty, "{name} is off by {error}, uncertainty {uncertainty}");
    }
    assert!(off[0].2 < 1.0 && off[4].2 < 0.06, "{off:?}");
}

#[test]
fn corners_that_do_not_tell_the_lens_are_refused() {
    let refused = |images: &[Vec<Corner>]| fit_corners(images, Radial::Brown).unwrap_err();
    assert_eq!(refused(&images(&TURNS[..2])), CornerError::TooFewImages { images: 2 });
    let mut few = images(&TURNS);
    few[3].truncate(5);
    assert_eq!(refused(&few), CornerError::TooFewCorners { image: 3, corners: 5 });
    let mut line = images(&TURNS);
    line[1].retain(|corner| corner.board_mm[1] < -6.0);
    assert_eq!(refused(&line), CornerError::NoPlane);
    let mut swapped = images(&TURNS);
    for image in &mut swapped {
        for corner in image.iter_mut().step_by(3) {
            corner.board_mm.swap(0, 1);
        }
    }
    assert!(matches!(refused(&swapped), CornerError::NotConverged { .. } | CornerError::NoTilt));
}
