//! From sound recordings to the profile, and what it is worth.

use std::fmt;
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::{BoardError, CameraReport};
use fingervision_calibrate::depth::{DepthFit, FittedLaw, Method};
use fingervision_calibrate::update_profile;
use fingervision_touch::Profile;
use serde::Serialize;

use crate::calibrate::{camera, depth};
use crate::failure::Failure;
use crate::output::OutputArgs;

use super::PROFILE;
use super::answers::Answers;
use super::look::{Kind, Step, images_of, noise_to_set};

/// A camera that leaves more than this of a step's flow unexplained, px, is not the one that took the images: five times
/// what noise leaves of a good recording.
const LARGEST_RESIDUAL_PX: f64 = 0.05;

/// A calibrated sensor.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    profile: PathBuf,
    /// Noise that was written, grey levels; absent where the profile's was right.
    noise_levels: Option<f32>,
    camera: CameraReport,
    depth: DepthFit,
    /// The law that was written.
    law: FittedLaw,
    pictures: [PathBuf; 2],
}

/// What is written of the flow.
#[derive(Debug, Serialize)]
struct FlowTable {
    noise_levels: f32,
}

/// Fits camera and depth to the recordings of a folder and writes its profile.
pub(super) fn calibrate(
    folder: &Path,
    answers: &Answers,
    steps: &[Step],
    output: OutputArgs,
) -> Result<Outcome, Failure> {
    let profile = folder.join(PROFILE);
    let before = if profile.exists() { Profile::load(&profile)? } else { Profile::default() };
    let noise_levels = steps.iter().find(|step| step.kind == Kind::Still).and_then(|step| noise_to_set(step, &before));
    if let Some(noise_levels) = noise_levels {
        update_profile(&profile, "flow", &FlowTable { noise_levels })?;
    }
    let recordings = |kind| steps.iter().filter(move |step| step.kind == kind).filter_map(|step| step.folder.clone());
    let board = recordings(Kind::Board)
        .next()
        .map(|folder| images_of(&folder))
        .ok_or(BoardError::TooFewImages { images: 0 })?;
    let distance = answers.distance().ok_or_else(|| {
        Failure::new("the distance from the lens to the gel is not known", "give it with --distance-mm 25±0.5")
    })?;
    let slide = camera::Args::slide(board, answers.slide(), distance, profile.clone(), output);
    let (camera, residuals) = camera::fit(&slide)?;
    let presses = recordings(Kind::Press).map(|press| press.to_string_lossy().into_owned()).collect();
    let presses = depth::Args::recorded(presses, profile.clone(), output);
    let fit = depth::fit(&presses, &Profile::load(&profile)?)?;
    let (law, curves) = depth::write(&presses, &fit, method(&fit))?;
    Ok(Outcome { profile, noise_levels, camera, law: *law, depth: fit, pictures: [residuals, curves] })
}

/// The law of least error among those that leave what is untouched at rest.
fn method(fit: &DepthFit) -> Method {
    let error = |law: &&FittedLaw| law.left_out_error_mm.unwrap_or(law.error_mm);
    let through_rest = fit.laws.iter().filter(|law| law.method != Method::Line);
    through_rest.min_by(|a, b| error(a).total_cmp(&error(b))).map_or(Method::Origin, |law| law.method)
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { profile, camera, depth, law, pictures: [residuals, curves], .. } = self;
        let profile = profile.display();
        let (after, test) = (camera.residuals.after.mean_px, camera.test_over_after);
        if let Some(noise) = self.noise_levels {
            writeln!(f, "noise     {noise} grey levels, as measured: written as flow.noise_levels")?;
        }
        writeln!(
            f,
            "camera    leaves {after:.4} px of the flow, {:.4} mm on the board, and {test:.2} times that where it was not fitted",
            camera.residual_mm
        )?;
        if after > LARGEST_RESIDUAL_PX {
            writeln!(
                f,
                "warning   that is more than {LARGEST_RESIDUAL_PX} px: is the board flat, its steps equal? see {}",
                residuals.display()
            )?;
        }
        for blind in &camera.knowledge.blind {
            writeln!(f, "not seen  {}", blind.meaning)?;
        }
        let least = depth.presses.iter().map(|press| press.line.correlation).fold(1.0, f64::min);
        let error = law.left_out_error_mm.unwrap_or(law.error_mm);
        writeln!(
            f,
            "depth     errs by {error:.3} mm on a press left out; correlation {least:.3} or more in each press, {:.3} in all together",
            depth.pooled.correlation
        )?;
        for warning in &depth.warnings {
            writeln!(f, "warning   {warning}")?;
        }
        writeln!(f, "pictures  {}, {}", residuals.display(), curves.display())?;
        writeln!(f, "profile   {profile}: [camera], and depth by the {} law\n", depth::law_name(law.method))?;
        writeln!(f, "The sensor is calibrated. Track with it:")?;
        writeln!(f, "  fingervision track RECORDING --out run --profile {profile}\n")?;
        writeln!(
            f,
            "For depth from elasticity, contact and force write what you know of the gel into its [gel], then fit it:"
        )?;
        writeln!(f, "  fingervision calibrate gel PRESSES --profile {profile}")
    }
}
