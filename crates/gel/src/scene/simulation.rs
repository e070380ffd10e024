//! Computes the frames of a scene, with their truth.

use fingervision_elastic::{Pose, SurfaceState};
use fingervision_image::Pixels;
use fingervision_optics::Camera;

use super::solve::Progress;
use super::{PressCache, Scene, SceneError, SolvedPress};
use crate::{FrameRenderer, Truth, TruthProjector};

/// A scene with its renderer: solved once, then rendered frame by frame.
#[derive(Debug)]
pub struct Simulation {
    scene: Scene,
    poses: Vec<Pose>,
    renderer: FrameRenderer,
    projector: TruthProjector,
    press: Option<SolvedPress>,
}

impl Simulation {
    /// Sets the scene up. Impossible scenes are refused here, before anything is solved.
    ///
    /// # Errors
    ///
    /// [`SceneError`] if the scene is impossible.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let camera = Camera::new(&scene.camera()).map_err(super::validate::camera_fault)?;
        let texture = scene.pattern.texture(scene.gel.size_mm)?;
        let renderer = FrameRenderer::new(&scene.render, &camera, &texture)?;
        let projector = TruthProjector::new(&camera, scene.render.width, scene.render.height);
        Ok(Self { scene: scene.clone(), poses: scene.motion.poses(), renderer, projector, press: None })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The indenter's pose in every frame.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Columns and rows of every frame, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.scene.render.width, self.scene.render.height)
    }

    /// Solves the press; see [`Scene::solve`].
    ///
    /// # Errors
    ///
    /// [`SceneError`] if the scene is impossible.
    pub fn solve(&mut self, cache: &PressCache, progress: Progress) -> Result<&SolvedPress, SceneError> {
        let press = self.scene.solve(cache, progress)?;
        Ok(self.press.insert(press))
    }

    /// The gel's surface in every frame that is solved; none before [`Simulation::solve`].
    #[must_use]
    pub fn states(&self) -> &[SurfaceState] {
        self.press.as_ref().map_or(&[], |press| &press.states)
    }

    /// The camera's image of a frame. The same scene gives the same bytes, in whatever order frames are requested.
    ///
    /// # Errors
    ///
    /// [`SceneError::Render`] if the surface cannot be rendered.
    ///
    /// # Panics
    ///
    /// If the frame is not solved.
    pub fn frame(&mut self, frame: usize) -> Result<&Pixels, SceneError> {
        let states = self.press.as_ref().map_or(&[][..], |press| &press.states);
        let (before, state) = (&states[frame.saturating_sub(1)], &states[frame]);
        let is_blurred = self.scene.render.motion_blur.sub_frames > 1;
        let pixels = if is_blurred {
            self.renderer.render_moving(before, state, frame as u64)
        } else {
            self.renderer.render(state, frame as u64)
        };
        Ok(pixels?)
    }
    /// What a frame shows.
    ///
    /// # Errors
    ///
    /// [`SceneError::Render`] if the surface is none.
    ///
    /// # Panics
    ///
    /// If the frame is not solved.
    pub fn truth(&mut self, frame: usize) -> Result<&Truth, SceneError> {
        let states = self.press.as_ref().map_or(&[][..], |press| &press.states);
        Ok(self.projector.project(&states[frame])?)
    }
}
