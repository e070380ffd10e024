//! `fingervision track`: from a recording to a folder of fields.

use std::io::Write;
use std::path::PathBuf;

use fingervision_sink::Field;
use fingervision_source::{Options, open};

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::ProfileArgs;
use crate::tracking::Run;

/// Track a recording: flow, density and, with a calibrated profile, depth of every frame
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A folder of PNG, JPEG, TIFF or BMP images, or a video: H.264 MP4 or MOV, motion JPEG AVI
    source: PathBuf,
    /// The folder to write: new, empty, or with --overwrite a previous run
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    profile: ProfileArgs,
    /// The fields to write; without it flow, density and, where calibrated, depth
    #[arg(long, value_delimiter = ',', value_name = "FIELD,...", value_enum)]
    fields: Option<Vec<FieldName>>,
    /// Nominal rate of an image folder, frames a second; videos carry their own times
    #[arg(long, value_name = "RATE", default_value_t = Options::default().frames_per_second, value_parser = rate)]
    fps: f64,
    /// Replace a previous run in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// What `--fields` takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum FieldName {
    /// Displacement, px
    Flow,
    /// Density feature, dimensionless
    Density,
    /// Depth, mm; needs a profile with a depth line
    Depth,
    /// Predicted standard deviation of the flow, px
    Deviation,
}

impl From<FieldName> for Field {
    fn from(name: FieldName) -> Self {
        match name {
            FieldName::Flow => Self::Flow,
            FieldName::Density => Self::Density,
            FieldName::Depth => Self::Depth,
            FieldName::Deviation => Self::Deviation,
        }
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = args.profile.load()?;
    let mut source = open(&args.source, &Options { frames_per_second: args.fps })?;
    let fields = args.fields.as_ref().map(|fields| fields.iter().map(|&field| field.into()).collect());
    let (folder, overwrite, output) = (args.out.clone(), args.overwrite, args.output);
    let run = Run { profile, fields, folder, overwrite, output };
    let (summary, failure) = run.track(source.as_mut(), None)?;
    output.result(out, &summary, &summary.to_string())?;
    failure.map_or(Ok(()), Err)
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(rate),
        _ => Err("a rate is a number above 0".into()),
    }
}
