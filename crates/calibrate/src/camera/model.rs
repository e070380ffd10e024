//! The flow of a sliding board, predicted by a camera.

use fingervision_optics::Camera;

use super::unknowns::{UNKNOWNS, row_by_unknowns};

/// The flow at a pixel, px, when the board moves by `step_mm` along the surface.
///
/// The pixel's ray meets the board at X; after the step, this point of the board is seen at the image of X + step. None
/// if either is not visible.
#[must_use]
pub fn board_flow(camera: &Camera, px: [f64; 2], step_mm: [f64; 2]) -> Option<[f64; 2]> {
    let [x, y] = camera.surface_point(px, 0.0)?;
    let there = camera.project([x + step_mm[0], y + step_mm[1], 0.0])?;
    Some([there[0] - px[0], there[1] - px[1]])
}

/// The flow of [`board_flow`] and its derivatives by the unknowns, a row for each component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardFlowJacobian {
    /// The flow, px.
    pub flow_px: [f64; 2],
    /// Its derivatives, in the order of [`super::Unknown::ALL`].
    pub by_unknowns: [[f64; UNKNOWNS]; 2],
}

/// As [`board_flow`], with the derivatives.
///
/// The pixel is fixed while the camera changes, so the point X that it sees moves on the board: with A the derivative
/// of the image by the board's x and y and J that by the unknowns,
///
/// ```text
/// A(X) dX + J(X) dp = 0        d flow = A(X + step) dX + J(X + step) dp
/// ```
#[must_use]
pub fn board_flow_with_jacobian(camera: &Camera, px: [f64; 2], step_mm: [f64; 2]) -> Option<BoardFlowJacobian> {
    let [x, y] = camera.surface_point(px, 0.0)?;
    let (here, there) = ([x, y, 0.0], [x + step_mm[0], y + step_mm[1], 0.0]);
    let (seen_here, seen_there) = (camera.project_with_jacobian(here)?, camera.project_with_jacobian(there)?);
    let by_here = row_by_unknowns(&camera.parameter_jacobian(here)?);
    let by_there = row_by_unknowns(&camera.parameter_jacobian(there)?);
    let carried = carry(&seen_here.by_point, &seen_there.by_point);
    let by_unknowns = [0, 1].map(|row| {
        std::array::from_fn(|i| by_there[row][i] - carried[row][0] * by_here[0][i] - carried[row][1] * by_here[1][i])
    });
    Some(BoardFlowJacobian { flow_px: [seen_there.px[0] - px[0], seen_there.px[1] - px[1]], by_unknowns })
}

/// `A(there) A(here)⁻¹`: motion in the image there, when the board's point moves by one pixel here.
fn carry(here: &[[f64; 3]; 2], there: &[[f64; 3]; 2]) -> [[f64; 2]; 2] {
    let [[a, b, _], [c, d, _]] = *here;
    let determinant = a * d - b * c;
    let inverse = [[d / determinant, -b / determinant], [-c / determinant, a / determinant]];
    there.map(|[x, y, _]| [0, 1].map(|column| x * inverse[0][column] + y * inverse[1][column]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::unknowns::{Unknowns, camera_params};
    use fingervision_optics::Radial;

    fn camera(unknowns: &Unknowns, radial: Radial) -> Camera {
        Camera::new(&camera_params(unknowns, radial)).unwrap()
    }

    fn slanted() -> Unknowns {
        Unknowns::from([[0.06, -0.04, 0.02, 1.0, -2.0, 25.0, -0.08, 0.02, 0.001, -0.0005, 400.0, 241.0, 236.0]])
    }

    #[test]
    fn a_board_that_is_parallel_moves_as_a_whole() {
        let unknowns = Unknowns::from([[0.0, 0.0, 0.0, 0.0, 0.0, 25.0, 0.0, 0.0, 0.0, 0.0, 400.0, 240.0, 240.0]]);
        let flow = board_flow(&camera(&unknowns, Radial::Brown), [13.0, 401.0], [0.5, -0.25]).unwrap();
        assert!((flow[0] - 8.0).abs() < 1e-12 && (flow[1] + 4.0).abs() < 1e-12, "{flow:?}");
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for radial in [Radial::Brown, Radial::Printed] {
            for (px, step) in [([20.0, 30.0], [0.5, 0.0]), ([450.0, 200.0], [0.0, 0.5]), ([240.0, 470.0], [0.3, -0.4])]
            {
                let found = board_flow_with_jacobian(&camera(&slanted(), radial), px, step).unwrap();
                for column in 0..UNKNOWNS {
                    let size = 1e-4 * slanted()[column].abs().max(0.1);
                    let at = |change: f64| {
                        let mut unknowns = slanted();
                        unknowns[column] += change * size;
                        board_flow(&camera(&unknowns, radial), px, step).unwrap()
                    };
                    // The central difference of fourth order.
                    let [near, back, far, far_back] = [1.0, -1.0, 2.0, -2.0].map(at);
                    for row in 0..2 {
                        let difference = (8.0 * (near[row] - back[row]) - (far[row] - far_back[row])) / (12.0 * size);
                        let exact = found.by_unknowns[row][column];
                        let scale = found.by_unknowns.iter().map(|row| row[column].abs()).fold(1e-3, f64::max);
                        let error = (exact - difference).abs() / scale;
                        assert!(error < 1e-6, "{radial:?} {px:?} unknown {column}: {exact} and {difference}");
                    }
                }
            }
        }
    }
}
