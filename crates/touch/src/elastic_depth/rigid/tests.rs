//! The fit's Jacobian against finite differences, and a motion that is known.

use fingervision_elastic::GelBlock;
use fingervision_optics::Camera;

use super::*;
use crate::Profile;

const SENSOR: &str = "[camera]\nfocal_length_px = [100, 100]\nprincipal_point_px = [59.5, 59.5]\n\
                      translation_mm = [0, 0, 25]\n\
                      [gel]\nsize_mm = [30, 30]\nthickness_mm = 10\npoissons_ratio = 0.48\n";
/// A residual that is as large as this has the full weight to eleven digits.
const NO_OUTLIER: f64 = 1e6;

/// The surface of a gel of 30 mm in 24 by 24 cells, 25 mm below the camera.
pub(in super::super) fn surface() -> Surface {
    let (camera, gel): (Camera, GelBlock) = Profile::from_toml(SENSOR).unwrap().elastic_sensor().unwrap();
    Surface::new(&camera, &gel, (120, 120), 24).unwrap()
}

/// The motion of a face that is turned about all axes and moved.
fn motion() -> RigidMotion {
    RigidMotion::NONE.turned([0.04, -0.03, 0.2, 0.5, -0.8, 1.2])
}

/// Sets the measurement of every cell to that of a point at this position, mm, for the position of the cell at rest.
pub(in super::super) fn show_at(surface: &mut Surface, position_mm: impl Fn([f64; 2]) -> [f64; 3]) {
    for cell in 0..surface.seen.len() {
        let rest = surface.centre_mm(cell);
        let to = position_mm(rest);
        let slope = [0, 1].map(|axis| to[axis] / (25.0 - to[2]));
        surface.seen[cell].slope = slope.map(|slope| slope as f32);
        surface.seen[cell].apparent_mm = [0, 1].map(|axis| (to[axis] - rest[axis] + slope[axis] * to[2]) as f32);
    }
}

fn show(surface: &mut Surface, motion: &RigidMotion) {
    show_at(surface, |rest| motion.apply(rest));
}

/// The derivative of a cell's residual by each of a step's six numbers, from steps of 1e-5 to either side.
fn differences(point: &Point, motion: &RigidMotion) -> [[f64; 6]; 2] {
    const STEP: f64 = 1e-5;
    let by = |k: usize| {
        let [ahead, behind] = [STEP, -STEP].map(|step| {
            let mut along = [0.0; 6];
            along[k] = step;
            residual(point, &motion.turned(along))
        });
        [0, 1].map(|axis| (ahead[axis] - behind[axis]) / (2.0 * STEP))
    };
    let columns: [[f64; 2]; 6] = std::array::from_fn(by);
    [0, 1].map(|axis| columns.map(|column| column[axis]))
}

#[test]
fn the_normal_equations_are_those_of_finite_differences() {
    let mut surface = surface();
    show(&mut surface, &RigidMotion::NONE.turned([0.01, 0.02, -0.1, 0.3, 0.4, 0.5]));
    let motion = motion();
    // One cell at a time: the matrix of a single point holds its two rows and nothing that could cancel.
    for cell in [0, 23, 250, 300, 575] {
        let (matrix, right) = normal_equations(&surface, &AtRest, &[cell], &motion, NO_OUTLIER);
        let point = point(&surface, &AtRest, cell);
        let (rows, residuals) = (differences(&point, &motion), residual(&point, &motion));
        assert!(residuals.iter().all(|residual| residual.abs() > 1e-3), "cell {cell}: {residuals:?}");
        for i in 0..6 {
            let expected: f64 = -(0..2).map(|axis| rows[axis][i] * residuals[axis]).sum::<f64>();
            assert!((right[i] - expected).abs() < 1e-6, "cell {cell}, {i}: {} and {expected}", right[i]);
            for j in 0..6 {
                let expected: f64 = (0..2).map(|axis| rows[axis][i] * rows[axis][j]).sum();
                assert!(
                    (matrix[i][j] - expected).abs() < 1e-6,
                    "cell {cell}, {i}, {j}: {} and {expected}",
                    matrix[i][j]
                );
            }
        }
    }
}

#[test]
fn a_known_motion_is_found_among_outliers() {
    let mut surface = surface();
    let motion = motion();
    show(&mut surface, &motion);
    let cells: Vec<usize> = (0..surface.seen.len()).collect();
    for cell in cells.iter().step_by(7) {
        surface.seen[*cell].apparent_mm[0] += 0.4;
    }
    let found = fit(&surface, &AtRest, &cells, 0.01, &mut Vec::new()).unwrap();
    for corner in [[-15.0, -15.0], [15.0, -15.0], [0.0, 15.0]] {
        let (found, expected) = (found.motion.apply(corner), motion.apply(corner));
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
        // What the rays are kept in has seven digits.
        assert!(off < 2e-5, "{corner:?}: {off} mm off");
    }
    assert!((found.matching - 6.0 / 7.0).abs() < 0.01, "{}", found.matching);
}
