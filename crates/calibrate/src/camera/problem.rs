//! The least-squares problem: flows of the board and priors, both in standard deviations.

use fingervision_optics::Camera;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{Const, DVector, Dyn, OMatrix, Owned, U13};

use super::model::{board_flow, board_flow_with_jacobian};
use super::prior::Priors;
use super::unknowns::{Coordinates, UNKNOWNS, Unknown, Unknowns, UnknownsMatrix, camera_params};

/// Residual of a node that the camera does not see, px: more than for any that does.
const UNSEEN_PX: f64 = 1e4;
/// Changes of the cost or the unknowns below this part end the fit.
const TOLERANCE: f64 = 1e-10;
/// Largest number of evaluations per unknown.
const PATIENCE: usize = 30;

/// A measured flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) px: [f64; 2],
    pub(super) step_mm: [f64; 2],
    pub(super) flow_px: [f64; 2],
}

impl Sample {
    /// Predicted minus measured flow, px.
    pub(super) fn residual_px(&self, camera: &Camera) -> Option<[f64; 2]> {
        let [u, v] = board_flow(camera, self.px, self.step_mm)?;
        Some([u - self.flow_px[0], v - self.flow_px[1]])
    }
}

/// The end of a fit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ending {
    pub(super) unknowns: Unknowns,
    pub(super) has_converged: bool,
    pub(super) reason: String,
    pub(super) evaluations: usize,
}

/// The problem at some unknowns.
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    pub(super) samples: &'a [Sample],
    pub(super) priors: &'a Priors,
    /// Standard deviation of a component of a sample's flow, px.
    pub(super) deviation_px: f64,
    pub(super) coordinates: Coordinates,
    at: Unknowns,
    /// 1 for a fitted coordinate, 0 for a fixed one.
    sought: Unknowns,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        samples: &'a [Sample],
        priors: &'a Priors,
        coordinates: Coordinates,
        deviation_px: f64,
        start: &Unknowns,
    ) -> Self {
        let sought = Unknowns::repeat(1.0);
        Self { samples, priors, deviation_px, coordinates, at: coordinates.of(start), sought }
    }

    /// The same with only some of the coordinates fitted.
    pub(super) fn only(mut self, sought: &[Unknown]) -> Self {
        self.sought.fill(0.0);
        for unknown in sought {
            self.sought[unknown.index()] = 1.0;
        }
        self
    }

    pub(super) fn minimize(self) -> Ending {
        let coordinates = self.coordinates;
        let method = LevenbergMarquardt::new().with_tol(TOLERANCE).with_patience(PATIENCE);
        let (solved, report) = method.minimize(self);
        Ending {
            unknowns: coordinates.unknowns(&solved.at),
            has_converged: report.termination.was_successful()
                || matches!(report.termination, TerminationReason::NoImprovementPossible(_)),
            reason: in_words(&report.termination),
            evaluations: report.number_of_evaluations,
        }
    }

    fn unknowns(&self) -> Unknowns {
        self.coordinates.unknowns(&self.at)
    }

    fn camera(&self) -> Option<Camera> {
        Camera::new(&camera_params(&self.unknowns(), self.coordinates.radial)).ok()
    }

    /// `JᵀJ` of the flows alone by the unknowns themselves, in their units.
    pub(super) fn information(&self) -> UnknownsMatrix {
        let mut information = UnknownsMatrix::zeros();
        let Some(camera) = self.camera() else { return information };
        for sample in self.samples {
            let Some(found) = board_flow_with_jacobian(&camera, sample.px, sample.step_mm) else { continue };
            for row in found.by_unknowns {
                let row = Unknowns::from([row]) / self.deviation_px;
                information.syger(1.0, &row, &row, 1.0);
            }
        }
        information.fill_upper_triangle_with_lower_triangle();
        information
    }
}

impl LeastSquaresProblem<f64, Dyn, U13> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, U13>;
    type ParameterStorage = Owned<f64, U13>;

    fn set_params(&mut self, at: &Unknowns) {
        self.at = *at;
    }

    fn params(&self) -> Unknowns {
        self.at
    }

    /// An impossible camera has such a large cost that the method steps back from it.
    fn residuals(&self) -> Option<DVector<f64>> {
        let unseen = [UNSEEN_PX; 2];
        let camera = self.camera();
        let flows = self.samples.iter().flat_map(|sample| {
            let residual = camera.as_ref().and_then(|camera| sample.residual_px(camera));
            residual.unwrap_or(unseen).map(|value| value / self.deviation_px)
        });
        let known = (self.unknowns() - self.priors.values()).component_mul(&self.priors.weights());
        let count = 2 * self.samples.len() + UNKNOWNS;
        Some(DVector::from_iterator(count, flows.chain(known.iter().copied())))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U13>> {
        let camera = self.camera()?;
        let by_coordinates = self.coordinates.jacobian(&self.at) * UnknownsMatrix::from_diagonal(&self.sought);
        let mut jacobian = OMatrix::<f64, Dyn, U13>::zeros_generic(Dyn(2 * self.samples.len() + UNKNOWNS), Const);
        for (index, sample) in self.samples.iter().enumerate() {
            let Some(found) = board_flow_with_jacobian(&camera, sample.px, sample.step_mm) else { continue };
            for (component, row) in found.by_unknowns.into_iter().enumerate() {
                let row = Unknowns::from([row]).transpose() * by_coordinates / self.deviation_px;
                jacobian.set_row(2 * index + component, &row);
            }
        }
        let weights = self.priors.weights();
        for index in 0..UNKNOWNS {
            jacobian.set_row(2 * self.samples.len() + index, &(by_coordinates.row(index) * weights[index]));
        }
        Some(jacobian)
    }
}

fn in_words(reason: &TerminationReason) -> String {
    match reason {
        TerminationReason::ResidualsZero | TerminationReason::Orthogonal | TerminationReason::Converged { .. } => {
            "converged".into()
        }
        TerminationReason::NoImprovementPossible(_) => "no improvement is possible in double precision".into(),
        TerminationReason::LostPatience => "it did not end".into(),
        TerminationReason::Numerical(what) => format!("{what} is not finite"),
        TerminationReason::User(_) => "the start is an impossible camera".into(),
        TerminationReason::NoParameters | TerminationReason::NoResiduals | TerminationReason::WrongDimensions(_) => {
            "there is nothing to fit".into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_optics::Radial;
    use levenberg_marquardt::differentiate_numerically;

    #[test]
    fn the_jacobian_is_that_of_differences() {
        let unknowns =
            Unknowns::from([[0.06, -0.04, 0.02, 1.0, -2.0, 25.0, -0.08, 0.02, 0.001, -0.0005, 400.0, 241.0, 236.0]]);
        let samples: Vec<Sample> = [[20.0, 30.0], [450.0, 200.0], [240.0, 470.0], [100.0, 300.0]]
            .into_iter()
            .flat_map(|px| [[0.5, 0.0], [0.0, 0.5]].map(|step_mm| Sample { px, step_mm, flow_px: [7.0, 0.5] }))
            .collect();
        let priors = Priors::weak(480, [239.5; 2]);
        for radial in [Radial::Brown, Radial::Printed] {
            let coordinates = Coordinates { half_diagonal_px: 340.0, radial };
            let mut problem = Problem::new(&samples, &priors, coordinates, 0.01, &unknowns);
            let numerical = differentiate_numerically(&mut problem).unwrap();
            let exact = problem.jacobian().unwrap();
            for column in 0..UNKNOWNS {
                let scale = exact.column(column).amax();
                let error = (exact.column(column) - numerical.column(column)).amax() / scale;
                assert!(error < 1e-6, "{radial:?}, coordinate {column}: {error:e}");
            }
        }
    }
}
