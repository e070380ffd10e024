//! A simulated press: a scene that is solved and rendered.

use fingervision_gel::{PressCache, Scene, Simulation, Truth};
use fingervision_image::{Frame, Pixels};
use fingervision_optics::Camera;
use fingervision_simulation::simulated_profile;
use fingervision_touch::{Fields, Profile};
use std::ops::ControlFlow;

use super::{ExperimentError, Scorer};

/// Frames per second in the frames' time stamps; no result depends on it.
const FRAMES_PER_SECOND: f64 = 90.0;

/// A simulated press: its images, and the truth of its last frame.
#[derive(Debug, Clone)]
pub struct Recording {
    /// The scene's name.
    pub name: String,
    /// The tracker's profile: the scene's camera and gel, unless [changed](Self::with_assignments).
    pub profile: Profile,
    /// Depth of the indenter in every frame, mm.
    pub depths_mm: Vec<f64>,
    /// The last frame's truth.
    pub truth: Truth,
    /// Force of the indenter on the gel in the last frame, N.
    pub force_n: [f64; 3],
    /// Torque of the indenter on the gel about z through the centre of contact in the last frame, N mm.
    pub torque_z_nmm: f64,
    camera: Camera,
    images: Vec<Pixels>,
}

impl Recording {
    /// Solves a scene, or takes the press from the cache, and draws all its frames.
    ///
    /// # Errors
    ///
    /// [`ExperimentError::Scene`] if the scene is impossible, [`ExperimentError::EndedEarly`] if it was not solved to
    /// its end.
    pub fn of(scene: &Scene, cache: &PressCache) -> Result<Self, ExperimentError> {
        Self::with_assignments(scene, &[], cache)
    }

    /// As [`Recording::of`], with some values of the tracker's profile changed: keys of the profile with their values.
    ///
    /// # Errors
    ///
    /// [`ExperimentError::Profile`] naming the key, before anything is solved; and as [`Recording::of`].
    pub fn with_assignments(
        scene: &Scene,
        assignments: &[(String, String)],
        cache: &PressCache,
    ) -> Result<Self, ExperimentError> {
        let profile = profile_with_assignments(scene, assignments)?;
        let mut simulation = Simulation::new(scene)?;
        let press = simulation.solve(cache, &mut |_| ControlFlow::Continue(()))?;
        if let Some(end) = &press.end {
            return Err(ExperimentError::EndedEarly { scene: scene.name.clone(), reason: end.to_string() });
        }
        let count = simulation.states().len();
        let images = (0..count).map(|frame| simulation.frame(frame).cloned()).collect::<Result<_, _>>()?;
        let truth = simulation.truth(count - 1)?.clone();
        Ok(Self {
            name: scene.name.clone(),
            profile,
            depths_mm: simulation.poses().iter().map(|pose| pose.depth_mm).collect(),
            torque_z_nmm: simulation.states().last().map_or(0.0, |state| state.torque_nmm[2]),
            force_n: simulation.states().last().map_or([0.0; 3], |state| state.force_n),
            truth,
            camera: Camera::new(&scene.camera())?,
            images,
        })
    }

    /// Columns and rows of every frame, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        self.truth.depth.size()
    }

    /// A scorer that compares depth maps with the truth of the last frame.
    #[must_use]
    pub fn scorer(&self) -> Scorer<'_> {
        Scorer::new(&self.truth, &self.camera)
    }

    /// The images as frames of a camera.
    pub fn frames(&self) -> impl Iterator<Item = Frame> {
        self.images.iter().enumerate().map(|(number, pixels)| Frame {
            sequence: number as u64,
            capture_time_s: number as f64 / FRAMES_PER_SECOND,
            pixels: pixels.clone(),
        })
    }

    /// The last image.
    #[must_use]
    pub fn last_image(&self) -> Option<&Pixels> {
        self.images.last()
    }
}

/// The profile of a scene's sensor with some values changed, given as keys with their values.
///
/// # Errors
///
/// [`ExperimentError::Profile`] naming the key.
pub(crate) fn profile_with_assignments(
    scene: &Scene,
    assignments: &[(String, String)],
) -> Result<Profile, ExperimentError> {
    let mut profile = simulated_profile(scene);
    profile.set_all(assignments.iter().map(|(key, value)| (key.as_str(), value.as_str())))?;
    // All methods for depth are compared, so a value has no effect only if none of them uses it.
    let keys = assignments.iter().map(|(key, _)| key.as_str());
    profile.expect_effect(keys.filter(|key| !key.starts_with("depth.")), Fields::default())?;
    Ok(profile)
}
