//! `fingervision calibrate gel`: fits the gel to presses of known depth, and optionally of known force.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_calibrate::gel::{GelPress, GelPressRecorder, GelReport, GelTable, Unknowns, fit_gel};
use fingervision_calibrate::update_profile;
use fingervision_sink::write_png;
use fingervision_touch::{Profile, Remark};
use serde::Serialize;

use super::press::Press;
use super::repeated::refuse_repeated;
use super::{beside, load};
use crate::failure::Failure;
use crate::fingerprint;
use crate::output::OutputArgs;

/// Find Poisson's ratio, thickness and Young's modulus of the gel, from presses of known depth
///
/// Every press is tracked with the profile; four of its frames, 4 to 12 % of the thickness deep, are used. The motion
/// of the gel around contact determines Poisson's ratio and thickness; forces from a scale or a force sensor determine
/// Young's modulus. The report shows how well each value is determined, and the determined ones are written to the
/// profile's `[gel]`. The profile needs `[camera]`, and a `[gel]` to start from.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Presses: folders of images with their depths, or simulated scenes, as in sim:circle?draft
    ///
    /// A folder contains images, directly or in its subfolder frames/, and depth.csv: a line
    /// `frame,depth_mm,force_z_n`, then a row for every image, from 0; the column of normal forces, N, may be left out.
    /// A folder written by `simulate` contains all of this. The first image shows the gel untouched. Small contacts
    /// give the most information: no wider than the gel is thick.
    #[arg(required = true)]
    presses: Vec<String>,
    /// Solve simulated scenes on a coarse mesh: seconds instead of minutes
    #[arg(long)]
    draft: bool,
    /// The profile of the sensor: used to track the presses; values that are determined are written to it
    #[arg(long, value_name = "FILE")]
    profile: PathBuf,
    /// The values to fit; the others keep the profile's value. Without it all values that the presses can determine
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VALUES")]
    fit: Vec<Value>,
    /// The picture of the residual over Poisson's ratio and thickness; without it PROFILE-gel.png beside the profile
    ///
    /// With forces a second one, with -force in its name, shows the measured and the predicted forces.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

/// The values of `--fit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Value {
    /// `gel.poissons_ratio`
    PoissonsRatio,
    /// `gel.thickness_mm`
    Thickness,
    /// `gel.youngs_modulus_mpa`; needs forces
    YoungsModulus,
}

#[derive(Debug, Serialize)]
struct GelResult<'a> {
    #[serde(flatten)]
    report: &'a GelReport,
    written: Option<GelTable>,
    profile: &'a Path,
    pictures: &'a [PathBuf],
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = load(&args.profile)?;
    let report = fit_presses(&args.presses, args.draft, &args.fit, &profile, args.output)?;
    let written = report.table();
    if let Some(table) = &written {
        refuse_impossible(&with_table(&profile, table), &profile.review(None).remarks)?;
    }
    let pictures = draw(args, &report)?;
    if let Some(table) = &written {
        update_profile(&args.profile, "gel", table)?;
    }
    fingerprint::write_of_presses(&args.presses, &args.profile)?;
    let text = text(&report, written.as_ref(), &args.profile, &pictures);
    let result = GelResult { report: &report, written, profile: &args.profile, pictures: &pictures };
    args.output.result(out, &result, &text)
}

/// The profile with the fitted values.
fn with_table(profile: &Profile, table: &GelTable) -> Profile {
    let mut fitted = profile.clone();
    if let Some(gel) = &mut fitted.gel {
        gel.poissons_ratio = table.poissons_ratio.unwrap_or(gel.poissons_ratio);
        gel.thickness_mm = table.thickness_mm.unwrap_or(gel.thickness_mm);
        gel.youngs_modulus_mpa = table.youngs_modulus_mpa.or(gel.youngs_modulus_mpa);
    }
    fitted
}

/// Refuses values that no sensor has; `known` are the remarks on the profile before the fit.
pub(super) fn refuse_impossible(fitted: &Profile, known: &[Remark]) -> Result<(), Failure> {
    let review = fitted.review(None);
    let Some(Remark { message, .. }) = review.faults().find(|fault| !known.contains(fault)) else { return Ok(()) };
    let hint = "check the units of the presses' forces (N; 1 g is 0.00981 N) and depths (mm): nothing was written";
    Err(Failure::new(format!("the presses give an impossible gel: {message}"), hint))
}

/// Fits all values that the recorded presses can determine.
pub(super) fn fit(presses: &[String], profile: &Profile, output: OutputArgs) -> Result<GelReport, Failure> {
    fit_presses(presses, false, &[], profile, output)
}

/// Tracks presses and fits these values to them; if none is named, all values that the presses can determine.
fn fit_presses(
    names: &[String],
    is_draft: bool,
    values: &[Value],
    profile: &Profile,
    output: OutputArgs,
) -> Result<GelReport, Failure> {
    refuse_repeated("press", names)?;
    let mut has_forces = false;
    let mut presses = Vec::with_capacity(names.len());
    for name in names {
        let press = Press::open(name, is_draft, output)?;
        if let Some(apart_px) = press.camera_mismatch_px(profile) {
            return Err(other_camera(&press.name, apart_px));
        }
        has_forces |= press.forces_n.is_some();
        presses.push(record(press, profile, output)?);
    }
    let asks = |value: Value, can: bool| if values.is_empty() { can } else { values.contains(&value) };
    let unknowns = Unknowns {
        poissons_ratio: asks(Value::PoissonsRatio, true),
        thickness: asks(Value::Thickness, true),
        youngs_modulus: asks(Value::YoungsModulus, has_forces),
    };
    output.note("fitting the gel: this takes some seconds per press");
    Ok(fit_gel(&presses, profile, unknowns)?)
}

/// If the press has another camera than the profile, the values would be wrong without any sign in the fit.
fn other_camera(press: &str, apart_px: f64) -> Failure {
    Failure::new(
        format!(
            "{press}: the profile's [camera] differs from that of this press: points of the gel are up to {apart_px:.0} px apart"
        ),
        "use the profile.toml that simulate writes beside the press, or simulate the press with the profile's [camera]",
    )
}

/// Tracks a press up to the last frame that is used.
fn record(press: Press, profile: &Profile, output: OutputArgs) -> Result<GelPress, Failure> {
    let recorder = press.record(
        output,
        |Press { name, depths_mm, forces_n, .. }, size, is_colour| {
            GelPressRecorder::new(name, depths_mm, forces_n.as_deref(), profile, size, is_colour)
        },
        GelPressRecorder::push,
    )?;
    Ok(recorder.finish()?)
}

fn draw(args: &Args, report: &GelReport) -> Result<Vec<PathBuf>, Failure> {
    let map = args.picture.clone().unwrap_or_else(|| beside(&args.profile, "gel"));
    write_png(&report.draw(), &map)?;
    let mut pictures = vec![map];
    if let Some(forces) = report.draw_forces() {
        let path = beside(&pictures[0], "force");
        write_png(&forces, &path)?;
        pictures.push(path);
    }
    Ok(pictures)
}

fn text(report: &GelReport, written: Option<&GelTable>, profile: &Path, pictures: &[PathBuf]) -> String {
    let mut text = report.to_string();
    for picture in pictures {
        let _ = writeln!(text, "picture             {}", picture.display());
    }
    let keys: Vec<_> =
        report.estimates.iter().filter(|estimate| estimate.is_determined).map(|estimate| estimate.key).collect();
    let (file, keys) = (profile.display(), keys.join(", "));
    let _ = match written {
        Some(_) => writeln!(text, "profile             {file}: [gel] has a new {keys}"),
        None => writeln!(text, "profile             {file} is not changed: nothing is determined"),
    };
    text
}
