//! `fingervision calibrate depth`: fits the relation between density and depth to presses of known depth.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_calibrate::depth::{DepthFit, DepthFitError, FittedLaw, Maximum, Method, PressCurve, PressRecorder};
use fingervision_calibrate::update_profile;
use fingervision_gel::ReadyMade;
use fingervision_sink::write_png;
use fingervision_touch::{DepthLaw, DepthMethod, Profile};
use serde::Serialize;

use super::press::Press;
use super::repeated::refuse_repeated;
use super::{beside, load};
use crate::failure::Failure;
use crate::fingerprint;
use crate::output::OutputArgs;

/// Fit the relation from density feature to depth, using presses of known depth
///
/// Every press is tracked with the profile; the largest density feature of each frame is compared with the known depth.
/// Three laws are fitted to all presses: the published line, a line through the origin, and the camera's perspective.
/// The report shows how well each press and all presses together fit, and which law has the least error. It warns if no
/// single law fits. In the profile only depth.density changes.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Presses: folders of images with their depths, or simulated scenes, as in calibration-centre-1mm
    ///
    /// A folder contains images, directly or in its subfolder frames/, and depth.csv: a line `frame,depth_mm`, then a
    /// row for every image, from 0. A folder written by `simulate` contains all of this. The first image shows the gel
    /// untouched.
    #[arg(required_unless_present = "simulated")]
    presses: Vec<String>,
    /// Press the simulated gel instead: 1, 2 and 3 mm deep at the centre, midway and near a corner
    #[arg(long, conflicts_with = "presses")]
    simulated: bool,
    /// Solve simulated scenes on a coarse mesh: seconds instead of minutes
    #[arg(long)]
    draft: bool,
    /// The profile of the sensor: used to track the presses; the law is written to it
    #[arg(long, value_name = "FILE")]
    profile: PathBuf,
    /// The law to write into the profile
    #[arg(long, value_enum, default_value_t = MethodName::Origin)]
    method: MethodName,
    /// Which value of the feature represents a frame
    #[arg(long, value_enum, default_value_t = MaximumName::Plain)]
    maximum: MaximumName,
    /// The picture of feature against depth; without it PROFILE-depth.png beside the profile
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// The values of `--method`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MethodName {
    /// A line with an intercept, as published: the intercept is added to every untouched pixel
    Line,
    /// A line through the origin: untouched gel has no depth
    Origin,
    /// A slope at every pixel from the camera's perspective, times a fitted gain; needs `[camera]` in the profile
    Perspective,
}

/// The values of `--maximum`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum MaximumName {
    /// The largest value, as published
    Plain,
    /// The largest median over squares of a seventh of the image, not affected by a rim or an outlier
    Robust,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Line => Self::Line,
            MethodName::Origin => Self::Origin,
            MethodName::Perspective => Self::Perspective,
        }
    }
}

impl From<MaximumName> for Maximum {
    fn from(name: MaximumName) -> Self {
        match name {
            MaximumName::Plain => Self::Plain,
            MaximumName::Robust => Self::Robust,
        }
    }
}

#[derive(Debug, Serialize)]
struct DepthResult<'a> {
    #[serde(flatten)]
    fit: &'a DepthFit,
    maximum: Maximum,
    written: &'a FittedLaw,
    profile: &'a Path,
    picture: &'a Path,
}

/// The part of the profile that changes.
#[derive(Debug, Serialize)]
struct DepthTable<'a> {
    density: &'a DepthLaw,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = load(&args.profile)?;
    let method = Method::from(args.method);
    if method == Method::Perspective && profile.camera.is_none() {
        return Err(DepthFitError::NoCamera.into());
    }
    let fit = fit(args, &profile)?;
    let (written, picture) = write(args, &fit, method, &profile)?;
    let mut text = fit.to_string();
    let (file, shown) = (args.profile.display(), picture.display());
    let _ = writeln!(text, "picture      {shown}\nprofile      {file}: depth.density is now {}", law_name(method));
    if profile.depth_method() == DepthMethod::Elastic {
        let _ = writeln!(
            text,
            "note         [camera] and [gel] are known: depth is elastic unless depth.method is \"density\""
        );
    }
    if fit.best != method {
        let best = fit.best.name();
        // A single press leaves none out.
        let tested = if fit.presses.len() == 1 {
            "this press, to which it was fitted"
        } else {
            "presses that were not used for the fit"
        };
        let _ = writeln!(text, "note         --method {best} has a smaller error on {tested}");
    }
    let result =
        DepthResult { fit: &fit, maximum: args.maximum.into(), written, profile: &args.profile, picture: &picture };
    args.output.result(out, &result, &text)
}

/// Tracks the presses and fits every law to them.
pub(super) fn fit(args: &Args, profile: &Profile) -> Result<DepthFit, Failure> {
    let names = || ReadyMade::ALL.iter().map(|scene| scene.name).filter(|name| name.starts_with("calibration-"));
    let presses = if args.simulated { names().map(Into::into).collect() } else { args.presses.clone() };
    refuse_repeated("press", &presses)?;
    let curves = presses.iter().map(|press| record(args, press, profile)).collect::<Result<Vec<_>, _>>()?;
    Ok(DepthFit::new(curves)?)
}

/// Writes the picture, and the law of this form into the profile if a sensor can have such a law; returns the law and
/// the picture's file.
pub(super) fn write<'a>(
    args: &Args,
    fit: &'a DepthFit,
    method: Method,
    profile: &Profile,
) -> Result<(&'a FittedLaw, PathBuf), Failure> {
    let written = fit.law(method)?;
    fit.check(written, profile)?;
    let picture = args.picture.clone().unwrap_or_else(|| beside(&args.profile, "depth"));
    write_png(&fit.draw(), &picture)?;
    update_profile(&args.profile, "depth", &DepthTable { density: &written.law })?;
    fingerprint::write_of_presses(&args.presses, &args.profile)?;
    Ok((written, picture))
}

impl Args {
    /// Recorded presses.
    pub(super) fn recorded(presses: Vec<String>, (profile, picture): (PathBuf, PathBuf), output: OutputArgs) -> Self {
        let (method, maximum) = (MethodName::Origin, MaximumName::Plain);
        Self { presses, simulated: false, draft: false, profile, method, maximum, picture: Some(picture), output }
    }
}

pub(super) fn law_name(method: Method) -> &'static str {
    match method {
        Method::Line => "the published line",
        Method::Origin => "a line through the origin",
        Method::Perspective => "the gain of the camera's perspective",
    }
}

/// Tracks a press.
fn record(args: &Args, press: &str, profile: &Profile) -> Result<PressCurve, Failure> {
    let press = Press::open(press, args.draft, args.output)?;
    if let Some(apart_px) = press.camera_mismatch_px(profile) {
        args.output.note(&format!(
            "{}: its camera differs from the profile's by up to {apart_px:.0} px: the depth law is for the camera of the press",
            press.name
        ));
    }
    let recorder = press.record(
        args.output,
        |Press { name, depths_mm, .. }, size, is_colour| {
            PressRecorder::new(name, depths_mm, profile, size, is_colour, args.maximum.into())
        },
        |recorder, frame| recorder.push(frame).map(|()| true),
    )?;
    Ok(recorder.finish()?)
}
