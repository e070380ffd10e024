//! The elastic inverse on a case: its depth, and how far contact and force are from the truth.

use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_touch::{ElasticDepth, ElasticFields};

use super::{Case, Method, MethodScore};
use crate::experiment::{ExperimentError, Recording, Scorer};
use crate::run::{LEAST_ARM_MM, LEAST_SHEAR};

/// Scores the last frame, from its flow and where that holds. A frame that does not fit the gel has depth 0.
pub(super) fn score(
    case: &Case,
    recording: &Recording,
    (flow, valid): (&FlowField, &Image<u8>),
    scorer: &Scorer,
) -> Result<MethodScore, ExperimentError> {
    let mut inverse = ElasticDepth::new(recording.camera(), &case.scene.gel, flow.size(), &recording.profile.elastic)?;
    let found = inverse.solve(flow, valid);
    let mut score = if found.is_misfit {
        let nothing = |value: f32| Image::filled(flow.u.width(), flow.u.height(), value);
        MethodScore::new(
            Method::Elastic.name(),
            scorer.score(&nothing(0.0), &Image::filled(valid.width(), valid.height(), 0)),
        )
    } else {
        MethodScore::new(Method::Elastic.name(), scorer.score(&found.depth_mm, &found.on_gel))
    };
    score.contact_overlap = Some(overlap(found, recording));
    let Some(([x, y, z], torque)) = found.force_n.zip(found.torque_nmm).filter(|_| !found.is_misfit) else {
        return Ok(score);
    };
    let ([true_x, true_y, true_z], true_torque) = (recording.force_n, recording.torque_z_nmm);
    let shear = true_x.hypot(true_y);
    score.normal_force = part(f64::from(z) - true_z, true_z, 0.0);
    score.shear_force = part((f64::from(x) - true_x).hypot(f64::from(y) - true_y), shear, LEAST_SHEAR * true_z);
    score.torque = part(f64::from(torque) - true_torque, true_torque, LEAST_ARM_MM * true_z);
    Ok(score)
}

/// An error as a part of the true value; none where that is not above the least.
fn part(error: f64, truth: f64, least: f64) -> Option<f64> {
    (truth.abs() > least).then(|| error.abs() / truth.abs())
}

/// Pixels that both masks call contact over those that either does, over what is seen; 0 for a frame that does not fit.
fn overlap(found: &ElasticFields, recording: &Recording) -> f64 {
    let truth = &recording.truth;
    let seen = truth.visible.values().iter().zip(truth.contact.values()).zip(found.contact.values());
    let (mut both, mut either) = (0.0, 0.0);
    for ((_, &truth), &estimate) in seen.filter(|((visible, _), _)| **visible != 0) {
        let (truth, estimate) = (truth != 0, estimate != 0 && !found.is_misfit);
        both += f64::from(u8::from(truth && estimate));
        either += f64::from(u8::from(truth || estimate));
    }
    if either > 0.0 { both / either } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_no_part_of_nothing() {
        assert_eq!(part(-0.5, 2.0, 0.1), Some(0.25));
        assert_eq!(part(0.5, -2.0, 0.1), Some(0.25));
        assert_eq!((part(0.5, 0.05, 0.1), part(0.5, 0.0, 0.0)), (None, None));
    }
}
