//! One press, tracked at several speeds.

use super::Tally;
use super::tally::Regions;
use crate::experiment::ExperimentError;
use fingervision_gel::{MeshParams, PressCache, Resolution, Scene, Simulation, Truth};
use fingervision_image::{Frame, Pixels};
use fingervision_optics::Camera;
use fingervision_simulation::simulated_profile;
use fingervision_touch::{Fields, Profile, Tracker};
use std::ops::ControlFlow;

/// The paces: numbers of steps of the press from one image to the next.
pub const PACES: [usize; 5] = [1, 2, 4, 10, 20];

/// Steps of every press: each pace divides them.
const STEPS: usize = 20;

/// Frames per second in the frames' time stamps; no result depends on it.
const FRAMES_PER_SECOND: f64 = 90.0;

/// A gel and a contact law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    poissons_ratio: &'static str,
    contact: &'static str,
}

impl Variant {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self { poissons_ratio: "0.35", contact: "\"stick\"" },
        Self { poissons_ratio: "0.48", contact: "\"stick\"" },
        Self { poissons_ratio: "0.35", contact: "{ friction = 0.5 }" },
        Self { poissons_ratio: "0.48", contact: "{ friction = 0.5 }" },
    ];

    /// Its description.
    #[must_use]
    pub fn name(&self) -> String {
        format!("Poisson's ratio {}, contact {}", self.poissons_ratio, self.contact)
    }
}

/// A solved press: its images with their truth.
#[derive(Debug)]
pub struct Press {
    profile: Profile,
    pub(super) images: Vec<Pixels>,
    pub(super) truths: Vec<Truth>,
    pub(super) regions: Vec<Regions>,
    pub(super) forces_n: Vec<f64>,
}

impl Press {
    /// Solves a ready-made scene, or takes it from the cache, and draws its images.
    ///
    /// # Errors
    ///
    /// [`ExperimentError::Scene`] if it is not known or cannot be solved.
    pub fn solve(
        name: &str,
        variant: Variant,
        resolution: Resolution,
        cache: &PressCache,
    ) -> Result<Self, ExperimentError> {
        let mut scene = Scene::find(name)?;
        let frames = (STEPS + 1).to_string();
        scene.set_all([
            ("gel.poissons_ratio", variant.poissons_ratio),
            ("contact.law", variant.contact),
            ("motion.frames", &frames),
        ])?;
        scene.mesh = MeshParams { resolution, ..MeshParams::default() };
        let mut simulation = Simulation::new(&scene)?;
        let press = simulation.solve(cache, &mut |_| ControlFlow::Continue(()))?;
        if let Some(end) = &press.end {
            return Err(ExperimentError::EndedEarly { scene: scene.name, reason: end.to_string() });
        }
        let forces_n: Vec<f64> = simulation.states().iter().map(|state| state.force_n[2]).collect();
        let camera = Camera::new(&scene.camera())?;
        let mut press = Self {
            profile: simulated_profile(&scene),
            images: Vec::new(),
            truths: Vec::new(),
            regions: Vec::new(),
            forces_n,
        };
        for frame in 0..press.forces_n.len() {
            press.images.push(simulation.frame(frame)?.clone());
            let truth = simulation.truth(frame)?.clone();
            press.regions.push(Regions::of(&truth, &camera));
            press.truths.push(truth);
        }
        Ok(press)
    }

    /// Tracks every `pace`-th image.
    ///
    /// # Errors
    ///
    /// [`ExperimentError::Track`] if a frame cannot be tracked.
    pub fn follow(&self, pace: usize) -> Result<Tally, ExperimentError> {
        let mut tracker = self.tracker()?;
        let mut tally = Tally::default();
        let mut before: Option<&Truth> = None;
        for (sequence, step) in (0..self.images.len()).step_by(pace).enumerate() {
            let reading = tracker.track(&Self::frame(sequence as u64, &self.images[step]))?;
            if let Some(before) = before {
                tally.add(reading, &self.truths[step], before, &self.regions[step], self.forces_n[step]);
            }
            before = Some(&self.truths[step]);
        }
        Ok(tally)
    }

    /// A tracker of its images.
    pub(super) fn tracker(&self) -> Result<Tracker, ExperimentError> {
        let is_colour = self.images.first().is_some_and(Pixels::is_colour);
        let size = self.truths.first().map_or((0, 0), |truth| truth.depth.size());
        Ok(Tracker::new(&self.profile, size, is_colour, Fields { depth: true, ..Fields::NONE })?)
    }

    /// The frame of an image.
    pub(super) fn frame(sequence: u64, pixels: &Pixels) -> Frame {
        Frame { sequence, capture_time_s: sequence as f64 / FRAMES_PER_SECOND, pixels: pixels.clone() }
    }
}
