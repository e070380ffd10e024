//! Checks whether the values of a scene are possible.

use fingervision_elastic::ContactLaw;
use fingervision_optics::CameraError;
use fingervision_settings::{Place, SettingsError};

use super::{MotionKind, Scene, SceneError};
use crate::PatternError;

/// Most cells of a mesh: a few gigabytes of memory.
const MOST_CELLS: usize = 3_000_000;

impl Scene {
    /// Checks that every value is possible, on its own and with the others.
    ///
    /// # Errors
    ///
    /// [`SceneError`] naming the first value that is not.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.validate_sensor()?;
        self.motion.validate()?;
        self.validate_place()?;
        if self.motion.kind == MotionKind::Press {
            self.validate_contact()?;
            self.validate_mesh()?;
            self.validate_depth()?;
            self.relief()?;
        }
        Ok(())
    }

    fn validate_sensor(&self) -> Result<(), SceneError> {
        self.gel
            .validate()
            .map_err(|error| impossible("gel", error.key, format!("{:?}", error.value), error.allowed))?;
        self.camera().validate().map_err(camera_fault)?;
        self.render.validate().map_err(render_fault)?;
        match self.pattern.validate() {
            Err(PatternError::OutOfRange { key, value, allowed }) => {
                Err(impossible("pattern", key, value, allowed).into())
            }
            checked => Ok(checked?),
        }
    }

    fn validate_place(&self) -> Result<(), SettingsError> {
        let (centre, [width, height]) = (self.motion.centre_mm, self.gel.size_mm);
        let is_on_gel = centre[0].abs() <= 0.5 * width && centre[1].abs() <= 0.5 * height;
        let allowed = || format!("a place on the gel of {width}x{height} mm about its centre");
        if is_on_gel { Ok(()) } else { Err(SettingsError::out_of_range("motion.centre_mm", centre, allowed())) }
    }

    fn validate_contact(&self) -> Result<(), SettingsError> {
        match self.contact.law {
            ContactLaw::Friction(coefficient) if !(coefficient.is_finite() && coefficient > 0.0) => {
                Err(impossible("contact", "law.friction", format!("{coefficient:?}"), "a finite coefficient above 0"))
            }
            _ => Ok(()),
        }
    }

    fn validate_mesh(&self) -> Result<(), SettingsError> {
        let Some(cells) = self.mesh.cells else { return Ok(()) };
        let count = cells.iter().try_fold(1_usize, |count, &cells| count.checked_mul(cells));
        if count.is_some_and(|count| (1..=MOST_CELLS).contains(&count)) {
            return Ok(());
        }
        let allowed = format!("cells along x, y and z, {MOST_CELLS} in all at most");
        Err(SettingsError::out_of_range("mesh.cells", cells, allowed))
    }

    /// The base of the gel is rigid: nothing is pressed into it.
    fn validate_depth(&self) -> Result<(), SettingsError> {
        let thickness = self.gel.thickness_mm;
        let depths = self.motion.keyframes.iter().map(|keyframe| keyframe.depth_mm.unwrap_or_default());
        match depths.enumerate().find(|(_, depth)| *depth >= thickness) {
            Some((index, depth)) => {
                let key = format!("motion.keyframes[{index}].depth_mm");
                let allowed = format!("less than the gel's thickness of {thickness} mm");
                Err(SettingsError::out_of_range(key, depth, allowed))
            }
            None => Ok(()),
        }
    }
}

/// What is wrong with the camera, by its key in the scene.
pub(super) fn camera_fault(error: CameraError) -> SettingsError {
    impossible("camera", error.key, error.value, error.allowed)
}

fn impossible(table: &str, key: &str, value: String, allowed: &str) -> SettingsError {
    let (place, key) = (Place::default(), format!("{table}.{key}"));
    SettingsError::OutOfRange { place, key, value, allowed: allowed.into() }
}

fn render_fault(error: crate::RenderError) -> SceneError {
    match error {
        crate::RenderError::OutOfRange { key, value, allowed } => {
            impossible("render", key, value.to_string(), allowed).into()
        }
        other => other.into(),
    }
}
