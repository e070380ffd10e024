//! `fingervision profile new`: a profile to start from.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_calibrate::write_profile;
use fingervision_touch::{DepthMethod, Profile};
use serde::Serialize;

use super::known::Known;
use super::template;
use crate::failure::Failure;
use crate::output::OutputArgs;

/// Write a commented profile to start from, with the known values of a new sensor
///
/// Values that are not known yet stay in the file as comments that explain how to find them. Every option may be left
/// out. An example: fingervision profile new --out sensor.toml --image-size 640x480 --gel-size-mm 30,30 --thickness-mm 10
/// --distance-mm 25 --view-width-mm 38
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The file to write; one that exists is replaced only with --overwrite
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    known: Known,
    /// Replace the file if it exists
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// The result.
#[derive(Debug, Serialize)]
struct Written {
    profile: PathBuf,
    depth: Option<DepthMethod>,
    has_force: bool,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let text = template::text(&args.known)?;
    let profile = Profile::from_toml(&text)?;
    let review = profile.review(args.known.image_size.map(Into::into));
    if let Some(size) = args.known.image_size {
        profile.region(size.into())?;
    }
    write(&args.out, &text, args.overwrite)?;
    for remark in review.remarks {
        args.output.note(&format!("{}; {}", remark.message, remark.hint));
    }
    let written = Written { profile: args.out.clone(), depth: review.depth, has_force: review.has_force };
    args.output.result(out, &written, &written.to_string())
}

/// Writes the file, which must not exist without `overwrite`.
fn write(path: &Path, text: &str, overwrite: bool) -> Result<(), Failure> {
    if !overwrite && path.exists() {
        let message = format!("{} exists already", path.display());
        return Err(Failure::new(message, "choose another name, or replace the file with --overwrite"));
    }
    Ok(write_profile(path, text)?)
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.profile.display();
        writeln!(f, "profile  {file}")?;
        writeln!(f, "next     fingervision profile check {file} RECORDING")?;
        writeln!(f, "         fingervision track RECORDING --out run --profile {file}")
    }
}
