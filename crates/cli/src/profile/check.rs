//! `fingervision profile check`: wrong, suspicious and missing values.

use std::fmt;
use std::io::Write;
use std::path::PathBuf;

use fingervision_simulation::open;
use fingervision_source::Options;
use fingervision_touch::{Profile, ProfileReview, Weight};
use serde::Serialize;

use super::show::Facts;
use crate::failure::Failure;
use crate::output::OutputArgs;

/// Check a profile: impossible and suspicious values, and the parts that are missing for depth and force
///
/// The command exits with 1 if there are faults: tracking would fail, or its numbers would be wrong. Warnings and
/// missing parts are only listed. With a recording the profile is also checked against the size of its frames.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The profile, or the run.toml of a run
    file: PathBuf,
    /// A recording of the sensor, in any form that `track` accepts
    source: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct Checked {
    file: PathBuf,
    /// Columns and rows of the recording's frames, px.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame_size: Option<(usize, usize)>,
    is_sound: bool,
    #[serde(flatten)]
    review: ProfileReview,
    #[serde(skip)]
    profile: Profile,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = Profile::load(&args.file)?;
    let source = args.source.as_ref().map(|source| open(source, &Options::default())).transpose()?;
    let frame_size = source.map(|source| source.size());
    let review = profile.review(frame_size);
    let is_sound = review.faults().next().is_none();
    let checked = Checked { file: args.file.clone(), frame_size, is_sound, review, profile };
    args.output.result(out, &checked, &checked.to_string())?;
    let Some(first) = checked.review.faults().next() else { return Ok(()) };
    Err(Failure::new(format!("{}: {}", args.file.display(), first.message), first.hint.clone()))
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { review, profile, .. } = self;
        writeln!(f, "profile         \"{}\", {}", profile.name, self.file.display())?;
        if let Some((width, height)) = self.frame_size {
            writeln!(f, "frames          {width}x{height} px")?;
        }
        write!(f, "{}", Facts { review, profile })?;
        for remark in &review.remarks {
            writeln!(f, "{:15} {}", Facts::word(remark.weight), remark.message)?;
            writeln!(f, "{:15} {}", "", remark.hint)?;
        }
        let warnings = review.remarks.iter().filter(|remark| remark.weight == Weight::Warning).count();
        match (review.faults().count(), warnings) {
            (0, 0) => writeln!(f, "no faults"),
            (0, 1) => writeln!(f, "no faults, 1 warning"),
            (0, warnings) => writeln!(f, "no faults, {warnings} warnings"),
            (1, _) => writeln!(f, "1 fault"),
            (faults, _) => writeln!(f, "{faults} faults"),
        }
    }
}
