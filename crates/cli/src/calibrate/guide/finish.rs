//! Fits the profile to the checked recordings, and reports its accuracy.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::{BoardError, CameraReport};
use fingervision_calibrate::depth::{DepthFit, FittedLaw, Method};
use fingervision_calibrate::gel::GelTable;
use fingervision_calibrate::update_profile;
use fingervision_elastic::GelBlock;
use fingervision_source::images_of;
use fingervision_touch::Profile;
use serde::Serialize;

use crate::calibrate::{beside, camera, depth, gel};
use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::unfinished::Unfinished;

use super::PROFILE;
use super::answers::Answers;
use super::look::{Kind, Step, noise_to_set};

/// The profile while it is being written.
const DRAFT: &str = "sensor.toml.draft";
/// A camera with a larger residual of a step's flow, px, is not the one that took the images: five times the residual
/// that noise causes in a good recording.
const LARGEST_RESIDUAL_PX: f64 = 0.05;

/// Allowed relative difference between the width of the view by the camera and by a ruler.
const LARGEST_VIEW_ERROR: f64 = 0.15;
/// An image wider than this many widths of the gel shows little of it.
const MOST_GELS: f64 = 1.5;
/// Allowed relative difference between the fitted and the measured thickness.
const LARGEST_THICKNESS_ERROR: f64 = 0.3;

/// A calibrated sensor.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    profile: PathBuf,
    /// The noise that was written, grey levels.
    noise_levels: Option<f32>,
    camera: CameraReport,
    depth: DepthFit,
    /// The law that was written.
    law: FittedLaw,
    /// The gel that was written, if its size is known.
    gel: Option<GelOutcome>,
    pictures: [PathBuf; 2],
}

/// The result for the gel.
#[derive(Debug, Serialize)]
struct GelOutcome {
    /// As described by the user.
    described: GelBlock,
    /// What the presses determined and was written.
    fitted: Option<GelTable>,
    /// Why nothing was determined.
    remark: Option<String>,
    /// What is suspicious in the values.
    warnings: Vec<String>,
}

/// The values written to `[flow]`.
#[derive(Debug, Serialize)]
struct FlowTable {
    noise_levels: f32,
}

/// Fits camera, depth and gel to the recordings of a folder and writes its profile; either all of it or, if a part is
/// not valid, nothing.
pub(super) fn calibrate(
    folder: &Path,
    answers: &Answers,
    steps: &[Step],
    output: OutputArgs,
) -> Result<Outcome, Failure> {
    let (profile, path) = (folder.join(PROFILE), folder.join(DRAFT));
    let named = |error: io::Error| {
        let message = format!("{}: {}", folder.join(DRAFT).display(), error.kind());
        Failure::new(message, "make the sensor's folder writable")
    };
    let draft = Unfinished::copy_of(&profile, path).map_err(named)?;
    let outcome = fit(folder, draft.path(), answers, steps, output)?;
    draft.finish(&profile).map_err(named)?;
    Ok(outcome)
}

/// Fits everything into the draft of the profile.
fn fit(folder: &Path, draft: &Path, answers: &Answers, steps: &[Step], output: OutputArgs) -> Result<Outcome, Failure> {
    let profile = folder.join(PROFILE);
    let noise_levels = steps.iter().find(|step| step.kind == Kind::Still).and_then(noise_to_set);
    if let Some(noise_levels) = noise_levels {
        update_profile(draft, "flow", &FlowTable { noise_levels })?;
    }
    let recordings = |kind| steps.iter().filter(move |step| step.kind == kind).filter_map(|step| step.folder.clone());
    let board = recordings(Kind::Board)
        .next()
        .map(|folder| images_of(&folder))
        .ok_or(BoardError::TooFewImages { images: 0 })?;
    let distance = answers.distance().ok_or_else(|| {
        Failure::new("the distance from the lens to the gel is not known", "give it with --distance-mm 25±0.5")
    })?;
    let picture = beside(&profile, "camera");
    let slide = camera::Args::slide(board, answers.slide(), distance, (draft.to_owned(), picture), output);
    let (camera, residuals) = camera::fit(&slide)?;
    check_view(&camera, answers)?;
    let presses: Vec<String> = recordings(Kind::Press).map(|press| press.to_string_lossy().into_owned()).collect();
    let args = depth::Args::recorded(presses.clone(), (draft.to_owned(), beside(&profile, "depth")), output);
    let described = Profile::load(draft)?;
    let fit = depth::fit(&args, &described)?;
    let (law, curves) = depth::write(&args, &fit, method(&fit), &described)?;
    let law = *law;
    let gel = answers.gel().map(|gel| fit_gel(draft, gel, &presses, output)).transpose()?;
    Ok(Outcome { profile, noise_levels, camera, law, depth: fit, gel, pictures: [residuals, curves] })
}

/// Writes the gel as described, then the values that the presses determine.
fn fit_gel(draft: &Path, described: GelBlock, presses: &[String], output: OutputArgs) -> Result<GelOutcome, Failure> {
    update_profile(draft, "gel", &described)?;
    let report = match gel::fit(presses, &Profile::load(draft)?, output) {
        Ok(report) => report,
        Err(failure) => {
            return Ok(GelOutcome { described, fitted: None, remark: Some(failure.to_string()), warnings: Vec::new() });
        }
    };
    let fitted = report.table();
    let thickness_mm = fitted.and_then(|table| table.thickness_mm).unwrap_or(described.thickness_mm);
    if (thickness_mm / described.thickness_mm - 1.0).abs() > LARGEST_THICKNESS_ERROR {
        let message = format!(
            "the presses give a gel of {thickness_mm:.2} mm thickness, but --gel-mm says {} mm",
            described.thickness_mm
        );
        return Err(Failure::new(
            message,
            "measure the gel's thickness again, and check the board's step, the distance and the depths: nothing was written",
        ));
    }
    if let Some(table) = &fitted {
        update_profile(draft, "gel", table)?;
        gel::refuse_impossible(&Profile::load(draft)?, &[])?;
    }
    let remark = fitted.is_none().then(|| "the presses do not determine it".into());
    Ok(GelOutcome { described, fitted, remark, warnings: report.warnings })
}

/// Refuses a camera whose field of view contradicts the ruler or the gel's size.
fn check_view(camera: &CameraReport, answers: &Answers) -> Result<(), Failure> {
    let Some(slide) = camera.slides.first() else { return Ok(()) };
    let seen_mm = slide.size.0 as f64 / camera.px_per_mm;
    let step = slide.step_mm;
    if let Some(view_mm) = answers.view_mm()
        && (seen_mm / view_mm - 1.0).abs() > LARGEST_VIEW_ERROR
    {
        return Err(Failure::new(
            format!(
                "with a step of {step} mm the image shows {seen_mm:.1} mm of the board from left to right, but --view-mm is {view_mm} mm"
            ),
            format!(
                "if --view-mm is right, the step was {:.2} mm: give it with --step-mm; otherwise measure --view-mm again",
                step * view_mm / seen_mm
            ),
        ));
    }
    if let Some(gel) = answers.gel().filter(|gel| seen_mm > MOST_GELS * gel.size_mm[0]) {
        return Err(Failure::new(
            format!(
                "with a step of {step} mm the image shows {seen_mm:.1} mm, but the gel is {} mm wide",
                gel.size_mm[0]
            ),
            "check --step-mm and --gel-mm, or set image.region_of_interest in sensor.toml to the gel",
        ));
    }
    Ok(())
}

/// The law with the least error among those that give untouched gel no depth.
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
            "camera    residual {after:.4} px of the flow, {:.4} mm on the board; at nodes not used for the fit {test:.2} times as much",
            camera.residual_mm
        )?;
        if after > LARGEST_RESIDUAL_PX {
            writeln!(
                f,
                "warning   that is more than {LARGEST_RESIDUAL_PX} px: is the board flat, its steps equal? see {}",
                residuals.display()
            )?;
        }
        // The same unknown can be undetermined along x and along y: it is reported once.
        let mut meanings: Vec<&str> = Vec::new();
        for meaning in camera.knowledge.blind.iter().map(|blind| blind.meaning) {
            if !meanings.contains(&meaning) {
                writeln!(f, "not determined  {meaning}")?;
                meanings.push(meaning);
            }
        }
        let least = depth.presses.iter().map(|press| press.line.correlation).fold(1.0, f64::min);
        let error = law.left_out_error_mm.unwrap_or(law.error_mm);
        writeln!(
            f,
            "depth     error {error:.3} mm on a press that was left out; correlation {least:.3} or more in each press, {:.3} in all together",
            depth.pooled.correlation
        )?;
        for warning in &depth.warnings {
            writeln!(f, "warning   {warning}")?;
        }
        self.write_gel(f)?;
        writeln!(f, "pictures  {}, {}", residuals.display(), curves.display())?;
        writeln!(f, "profile   {profile}: [camera], and depth.density as {}\n", depth::law_name(law.method))?;
        writeln!(f, "The sensor is calibrated. Track with it:")?;
        writeln!(f, "  fingervision track RECORDING --out run --profile {profile}")?;
        if self.gel.is_none() {
            writeln!(f, "\nFor depth from elasticity, contact and force, describe the gel:")?;
            return writeln!(f, "  fingervision calibrate --folder {} --gel-mm WIDTH,HEIGHT,THICKNESS", self.folder());
        }
        writeln!(f, "Depth and contact come from elasticity; force as well if Young's modulus is known.")
    }
}

impl Outcome {
    /// The result for the gel, if it is described.
    fn write_gel(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(GelOutcome { fitted, remark, warnings, .. }) = &self.gel else { return Ok(()) };
        let values = fitted.map(|GelTable { poissons_ratio, thickness_mm, youngs_modulus_mpa }| {
            let named = [
                ("Poisson's ratio", poissons_ratio, ""),
                ("thickness", thickness_mm, " mm"),
                ("Young's modulus", youngs_modulus_mpa, " MPa"),
            ];
            let text =
                |(name, value, unit): (&str, Option<f64>, &str)| value.map(|value| format!("{name} {value:.3}{unit}"));
            named.into_iter().filter_map(text).collect::<Vec<_>>().join(", ")
        });
        match (values, remark) {
            (Some(values), _) => writeln!(f, "gel       {values}, from the presses; the rest as you described it"),
            (None, Some(remark)) => writeln!(f, "gel       as you described it: {remark}"),
            (None, None) => writeln!(f, "gel       as you described it"),
        }?;
        warnings.iter().try_for_each(|warning| writeln!(f, "warning   {warning}"))
    }

    fn folder(&self) -> std::path::Display<'_> {
        self.profile.parent().unwrap_or(Path::new(".")).display()
    }
}
