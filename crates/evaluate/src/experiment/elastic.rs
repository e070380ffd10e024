//! Depth from elasticity on a recording: the errors of its depth, contact and force.

use fingervision_image::Image;
use fingervision_touch::{ElasticDepth, ElasticFields, TrackError};
use serde::Serialize;

use super::{DepthScore, ExperimentError, Followed, Recording, Scorer};
use crate::run::{LEAST_ARM_MM, LEAST_SHEAR};

/// The errors of the elastic inverse. Forces are computed with the true Young's modulus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ElasticScore {
    /// Errors of depth.
    pub depth: DepthScore,
    /// Intersection over union of estimated and true contact, 0 to 1.
    pub contact_overlap: f64,
    /// Error of the normal force over the true one, dimensionless, positive where the estimate is too large; none for a
    /// frame that does not fit the gel.
    pub normal_force: Option<f64>,
    /// Length of the error of the shear force over the true shear force, dimensionless; none where the true one is
    /// below 5 % of the normal force.
    pub shear_force: Option<f64>,
    /// Error of the torque about z over the true torque, dimensionless, positive where the estimate is too large; none
    /// where the true one is below the normal force times an arm of 0.1 mm.
    pub torque: Option<f64>,
}

/// Depth from elasticity over the frames of a recording.
#[derive(Debug)]
pub struct ElasticRun {
    inverse: ElasticDepth,
}

impl ElasticRun {
    /// With the recording's profile.
    ///
    /// # Errors
    ///
    /// [`ExperimentError`] if the profile has no camera or no gel, or the elastic model of the gel cannot be made.
    pub fn new(recording: &Recording) -> Result<Self, ExperimentError> {
        let (camera, gel) = recording.profile.elastic_sensor()?;
        let inverse = ElasticDepth::new(&camera, &gel, recording.size(), &recording.profile.elastic);
        Ok(Self { inverse: inverse.map_err(TrackError::from)? })
    }

    /// Takes the next frame.
    pub fn take(&mut self, found: Followed) {
        self.inverse.solve(found.flow, found.deviation, found.valid);
    }

    /// The errors in the recording's last frame, and its estimated depth, mm. A frame that does not fit the gel has depth 0.
    #[must_use]
    pub fn score(&self, recording: &Recording, scorer: &Scorer) -> (ElasticScore, Image<f32>) {
        let found = self.inverse.fields();
        let (width, height) = found.depth_mm.size();
        let (depth_mm, holds) = if found.is_unexplained {
            (Image::filled(width, height, 0.0), Image::filled(width, height, 0))
        } else {
            (found.depth_mm.clone(), found.on_gel.clone())
        };
        let mut score = ElasticScore {
            depth: scorer.score(&depth_mm, &holds),
            contact_overlap: overlap(found, recording),
            normal_force: None,
            shear_force: None,
            torque: None,
        };
        if let Some((force_n, torque)) = found.force_n.zip(found.torque_nmm).filter(|_| !found.is_unexplained) {
            let true_torque = recording.torque_z_nmm;
            [score.normal_force, score.shear_force] = force_errors(force_n, recording.force_n);
            score.torque = part(f64::from(torque) - true_torque, true_torque, LEAST_ARM_MM * recording.force_n[2]);
        }
        (score, depth_mm)
    }
}

/// Errors of the normal force and of the shear force as [`ElasticScore`] has them, from the estimated and the true force, N.
pub(crate) fn force_errors(force_n: [f32; 3], [true_x, true_y, true_z]: [f64; 3]) -> [Option<f64>; 2] {
    let [x, y, z] = force_n.map(f64::from);
    let shear = part((x - true_x).hypot(y - true_y), true_x.hypot(true_y), LEAST_SHEAR * true_z);
    [part(z - true_z, true_z, 0.0), shear]
}

/// An error relative to the true value; none where the absolute true value is not above `least`.
fn part(error: f64, truth: f64, least: f64) -> Option<f64> {
    (truth.abs() > least).then(|| error / truth)
}

/// Intersection over union of both contact masks over the visible pixels; 0 for a frame that does not fit the gel.
fn overlap(found: &ElasticFields, recording: &Recording) -> f64 {
    let truth = &recording.truth;
    let seen = truth.visible.values().iter().zip(truth.contact.values()).zip(found.contact.values());
    let (mut both, mut either) = (0.0, 0.0);
    for ((_, &truth), &estimate) in seen.filter(|((visible, _), _)| **visible != 0) {
        let (truth, estimate) = (truth != 0, estimate != 0 && !found.is_unexplained);
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
        assert_eq!(part(-0.5, 2.0, 0.1), Some(-0.25));
        assert_eq!(part(0.5, -2.0, 0.1), Some(-0.25));
        assert_eq!((part(0.5, 0.05, 0.1), part(0.5, 0.0, 0.0)), (None, None));
    }
}
