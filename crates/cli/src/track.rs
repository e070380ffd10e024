//! `fingervision track`: from a recording to a folder of fields.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

use fingervision_gel::PressCache;
use fingervision_sink::{Field, simulated_profile};
use fingervision_source::{Options, SimulatedLocation, SimulatedSource, Source, open};
use fingervision_touch::Profile;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::ProfileArgs;
use crate::tracking::Run;

/// Track a recording: flow, density and, with a profile that knows the sensor, depth, contact and force of every frame
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A folder of PNG, JPEG, TIFF or BMP images, a video (H.264 MP4 or MOV, motion JPEG AVI) or a simulated scene
    ///
    /// A scene is sim:NAME or sim:FILE, as in sim:letter; `fingervision simulate --list` names those that are ready-made.
    /// Options follow it: sim:letter?fps=60 sets the rate, sim:letter?draft takes a coarse mesh. Without --profile its own
    /// camera and gel are the sensor.
    source: PathBuf,
    /// The folder to write: new, empty, or with --overwrite a previous run
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    profile: ProfileArgs,
    /// The fields to write; without it flow, density and, where calibrated, depth
    ///
    /// With elastic depth, the contact and where both hold (`contact.npy`, `depth_valid.npy`) are written beside it.
    #[arg(long, value_delimiter = ',', value_name = "FIELD,...", value_enum)]
    fields: Option<Vec<FieldName>>,
    /// Nominal rate of an image folder or a simulated scene, frames a second; videos carry their own times
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
    /// Depth, mm; needs a profile with a camera and a gel, or with depth.density
    Depth,
    /// Expected error of an elastic depth, mm
    #[value(name = "depth_deviation", alias = "depth-deviation")]
    DepthDeviation,
    /// 1 where the gel is touched; needs elastic depth
    Contact,
    /// Displacement x, y, z in gel space, mm; needs elastic depth
    Displacement,
    /// Traction x, y, z on a grid over the gel, `MPa`; needs elastic depth and `gel.youngs_modulus_mpa`
    Traction,
    /// Predicted standard deviation of the flow, px
    Deviation,
}

impl From<FieldName> for Field {
    fn from(name: FieldName) -> Self {
        match name {
            FieldName::Flow => Self::Flow,
            FieldName::Density => Self::Density,
            FieldName::Depth => Self::Depth,
            FieldName::DepthDeviation => Self::DepthDeviation,
            FieldName::Contact => Self::Contact,
            FieldName::Displacement => Self::Displacement,
            FieldName::Traction => Self::Traction,
            FieldName::Deviation => Self::Deviation,
        }
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let (profile, mut source) = sensor(args)?;
    let fields = args.fields.as_ref().map(|fields| fields.iter().map(|&field| field.into()).collect());
    let (folder, overwrite, output) = (args.out.clone(), args.overwrite, args.output);
    let run = Run { profile, fields, folder, overwrite, output };
    let (summary, failure) = run.track(source.as_mut())?;
    output.result(out, &summary, &summary.to_string())?;
    failure.map_or(Ok(()), Err)
}

/// The profile in force and the frames. A simulated scene knows its own sensor.
fn sensor(args: &Args) -> Result<(Profile, Box<dyn Source>), Failure> {
    let options = Options { frames_per_second: args.fps };
    let Some(location) = SimulatedLocation::of(&args.source)? else {
        return Ok((args.profile.load()?, open(&args.source, &options)?));
    };
    let scene = location.scene()?;
    let profile = args.profile.load_or(simulated_profile(&scene))?;
    let bar = args.output.progress("solving", Some(scene.motion.frames as u64));
    let mut progress = |frames: usize| {
        bar.set_position(frames as u64);
        ControlFlow::Continue(())
    };
    let source = SimulatedSource::open(&location, &options, &PressCache::standard(), &mut progress)?;
    bar.finish_and_clear();
    Ok((profile, Box::new(source)))
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(rate),
        _ => Err("a rate is a number above 0".into()),
    }
}
