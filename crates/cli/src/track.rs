//! `fingervision track`: tracks a recording and writes a folder of fields.

mod folder;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::builder::PossibleValue;
use fingervision_camera::CameraSource;
use fingervision_simulation::{open, simulated_profile};
use fingervision_sink::{Field, Precision, RunFolder};
use fingervision_source::{Options, Source};
use fingervision_touch::Profile;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::part::{Part, PartArgs};
use crate::place::{Place, recorded, solve};
use crate::profile_args::ProfileArgs;
use crate::summary::Summary;
use crate::tracking::{Run, fields_to_compute};
use folder::RecordingFolder;

/// Track a recording: flow, density and, with a profile that describes the sensor, depth, contact and force of every
/// frame
///
/// Without --profile the whole image is tracked, without depth.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A folder of PNG, JPEG, TIFF or BMP images, a video (H.264 in MP4 or MOV, motion JPEG in AVI, MP4 or MOV), a
    /// recording (MCAP), a simulated scene or a camera
    ///
    /// A recording contains its profile, which is used without --profile; FILE.mcap?sensor=NAME selects one of several
    /// sensors. A scene is sim:NAME or sim:FILE, as in sim:letter; `fingervision simulate --list` lists the ready-made
    /// ones. Options follow it: sim:letter?fps=60 sets the rate, sim:letter?draft selects a coarse mesh. Without
    /// --profile the scene's own camera and gel are used. A camera is camera:ID, or `camera` if only one is plugged in;
    /// tracking then continues until Ctrl-C.
    ///
    /// Of a folder of recordings, videos and folders of images, each is tracked, as many at the same time as there are
    /// threads. Its run is the folder of its name in --out.
    source: PathBuf,
    /// The folder to write, as in run: new, empty, or with --overwrite a previous run
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    profile: ProfileArgs,
    /// The fields to write, as in flow,depth; without it flow and, if the profile allows it, depth, and density where
    /// depth is not elastic
    ///
    /// With elastic depth, contact and validity (`contact.npy`, `depth_valid.npy`) are written, too.
    #[arg(long, value_delimiter = ',', value_name = "FIELD,...", value_enum)]
    fields: Option<Vec<FieldName>>,
    /// Number format: float16 needs half the disk space and has an error of up to 1 part in 2048
    ///
    /// For a flow of 8 to 16 px that is 0.004 px, for a depth of 1 to 2 mm 0.0005 mm.
    #[arg(long, value_name = "TYPE", value_enum, default_value_t = NumberType::Float32)]
    dtype: NumberType,
    /// Also write a video: the camera image with the contact, depth, and force over time
    ///
    /// The file is motion JPEG in AVI, FILE.avi. It can be played while it is written, and after the run was killed. Programs
    /// that were built with `--features mp4` also write FILE.mp4, H.264.
    #[arg(long, value_name = "FILE", value_parser = overlay_name)]
    overlay: Option<PathBuf>,
    /// Nominal rate of an image folder or a simulated scene, frames per second; videos have their own time stamps
    ///
    /// Without it 30.
    #[arg(long, value_name = "RATE", value_parser = rate)]
    fps: Option<f64>,
    #[command(flatten)]
    part: PartArgs,
    /// Skip frames that cannot be read, such as a truncated image, instead of ending the run at the first one
    ///
    /// Each is named in a note and counted in the result; the reading after it is flagged `dropped`. A video continues
    /// at its next key frame. The reference frame must be readable.
    #[arg(long)]
    skip_bad_frames: bool,
    /// Replace a previous run in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

/// The values of `--dtype`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum NumberType {
    Float32,
    Float16,
}

impl From<NumberType> for Precision {
    fn from(number: NumberType) -> Self {
        match number {
            NumberType::Float32 => Self::Float32,
            NumberType::Float16 => Self::Float16,
        }
    }
}

/// The values of `--fields`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FieldName(Field);

impl clap::ValueEnum for FieldName {
    fn value_variants<'a>() -> &'a [Self] {
        const FIELDS: [FieldName; 8] = [
            FieldName(Field::Flow),
            FieldName(Field::Density),
            FieldName(Field::Depth),
            FieldName(Field::DepthDeviation),
            FieldName(Field::Contact),
            FieldName(Field::Displacement),
            FieldName(Field::Traction),
            FieldName(Field::Deviation),
        ];
        &FIELDS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Field::Flow => "Displacement, px",
            Field::Density => "Density feature, dimensionless",
            Field::Depth => "Depth, mm; needs a profile with a camera and a gel, or with depth.density",
            Field::DepthDeviation => "Expected error of an elastic depth, mm",
            Field::Contact => "1 where the gel is touched; needs elastic depth",
            Field::Displacement => "Displacement x, y, z in gel space, mm; needs elastic depth",
            Field::Traction => {
                "Traction x, y, z on a grid over the gel, MPa; needs elastic depth and `gel.youngs_modulus_mpa`"
            }
            Field::Deviation => "Predicted standard deviation of the flow, px",
            _ => return None,
        };
        let name = PossibleValue::new(self.0.name()).help(help);
        Some(if self.0 == Field::DepthDeviation { name.alias("depth-deviation") } else { name })
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let part = args.part.part()?;
    keep_recording(args)?;
    if let Some(folder) = RecordingFolder::of(&args.source)? {
        return folder.track(args, part, out);
    }
    // Before a simulated press is solved.
    RunFolder::check(&args.out, args.overwrite)?;
    let (summary, failure) = track(args, &args.source, part, args.out.clone(), args.output)?;
    args.output.result(out, &summary, &summary.to_string())?;
    failure.map_or(Ok(()), Err)
}

/// Tracks one recording into a folder; the second value is the reason if the run ended early.
fn track(
    args: &Args,
    location: &Path,
    part: Part,
    folder: PathBuf,
    output: OutputArgs,
) -> Result<(Summary, Option<Failure>), Failure> {
    let (profile, mut source) = sensor(args, location, part, output)?;
    let fields: Option<Vec<Field>> = args.fields.as_ref().map(|fields| fields.iter().map(|field| field.0).collect());
    let to_compute = fields_to_compute(fields.as_deref(), profile.depth_method());
    let is_camera = matches!(Place::of(location)?, Place::Camera(_));
    args.profile.expect_effect(&profile, to_compute, is_camera, output)?;
    let (precision, overlay, overwrite) = (args.dtype.into(), args.overlay.clone(), args.overwrite);
    let skips_bad_frames = args.skip_bad_frames;
    let run = Run { profile, fields, precision, overlay, folder, overwrite, part, skips_bad_frames, output };
    run.track(source.as_mut())
}

/// Refuses to replace the recording by its run.
fn keep_recording(args: &Args) -> Result<(), Failure> {
    let source = match Place::of(&args.source)? {
        Place::Recording(path, _) => path,
        _ => args.source.clone(),
    };
    let Ok(source) = fs::canonicalize(source) else { return Ok(()) };
    let place = |path: &Path| fs::canonicalize(path).ok();
    if let Some(overlay) = args.overlay.as_ref().filter(|overlay| place(overlay).as_ref() == Some(&source)) {
        let message = format!("{} is the recording itself", overlay.display());
        return Err(Failure::new(message, "give --overlay another name"));
    }
    if args.overwrite && source.is_file() && source.parent() == place(&args.out).as_deref() {
        let message = format!("{} is in {}, which --overwrite clears", args.source.display(), args.out.display());
        return Err(Failure::new(message, "choose another folder with --out"));
    }
    Ok(())
}

/// The profile in force and the frames. A simulated scene has its own sensor.
fn sensor(args: &Args, location: &Path, part: Part, output: OutputArgs) -> Result<(Profile, Box<dyn Source>), Failure> {
    let options = args.fps.map_or_else(Options::default, |frames_per_second| Options { frames_per_second });
    let location = match Place::of(location)? {
        Place::Simulated(location) => location,
        Place::Camera(id) => {
            args.expect_no_rate(true, "a camera has")?;
            let profile = args.profile.load()?;
            let camera = fingervision_camera::open(profile.capture_from(id.as_deref()))?;
            return Ok((profile, Box::new(CameraSource::new(camera))));
        }
        Place::Recording(path, sensor) => {
            args.expect_no_rate(true, &format!("{} has", path.display()))?;
            let (profile, source) = recorded(&path, sensor.as_deref())?;
            return Ok((args.profile.load_or(profile)?, source));
        }
        Place::File(path) => {
            args.expect_no_rate(path.is_file(), &format!("{} has", path.display()))?;
            return Ok((args.profile.load()?, open(&path, &options)?));
        }
    };
    if args.fps.is_some() && location.has_rate() {
        let message = format!("--fps has no effect: {} already contains a rate", args.source.display());
        return Err(Failure::new(message, "give the rate once"));
    }
    let scene = location.scene()?;
    let frames = scene.motion.frames as u64;
    part.expect_within(frames.saturating_sub(1))?;
    let profile = args.profile.load_or(simulated_profile(&scene))?;
    Ok((profile, solve(&location, options, output)?))
}

impl Args {
    /// Refuses `--fps` for frames that have times of their own.
    fn expect_no_rate(&self, has_times: bool, who: &str) -> Result<(), Failure> {
        if !(self.fps.is_some() && has_times) {
            return Ok(());
        }
        Err(Failure::new(format!("--fps has no effect: {who} its own time stamps"), "leave --fps out"))
    }
}

fn overlay_name(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let ends_in = |wanted: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(wanted));
    if ends_in("avi") || cfg!(feature = "mp4") && ends_in("mp4") {
        return Ok(path);
    }
    let avi = path.with_extension("avi");
    Err(format!(
        "the video is motion JPEG in AVI: name it {}; `ffmpeg -i {0} -c:v libx264 -pix_fmt yuv420p {}` converts it",
        avi.display(),
        path.with_extension("mp4").display()
    ))
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(rate),
        _ => Err("a rate is a number above 0".into()),
    }
}
