//! `fingervision export`: a run or a recording in the form that another program reads.

use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingervision_sink::{Precision, RunArrays, write_npz, write_zarr};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::part::Part;
use crate::place::{Place, recorded};
use crate::profile_args::ProfileArgs;
use crate::tracking::Run;

/// Write a run or a recording as one `.npz` file, a table, a Zarr group or a video
///
/// RUN is a folder of `fingervision track`. A recording is tracked first, with its own profile unless another one is
/// given.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The folder of a run, or a recording (MCAP); FILE.mcap?sensor=NAME selects one of several sensors
    #[arg(value_name = "RUN|FILE.mcap")]
    source: PathBuf,
    /// The file or, for Zarr, folder to write
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// The format; without it the ending of the name decides
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Write a LeRobot data set, format v3.0, into a new folder; only in the command of the Python package
    #[arg(long, conflicts_with = "format")]
    lerobot: bool,
    #[command(flatten)]
    profile: ProfileArgs,
    /// Replace the file, or the folder if it is a Zarr group
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Arrays and table in one file, for `numpy.load`
    Npz,
    /// The table of readings
    Csv,
    /// A Zarr group, version 2: arrays and table, a frame per chunk
    Zarr,
    /// A video of camera image, depth and force, motion JPEG; for recordings only
    Avi,
    /// The same video as H.264; only in programs that were built with `--features mp4`
    Mp4,
}

impl Format {
    fn is_video(self) -> bool {
        matches!(self, Self::Avi | Self::Mp4)
    }
}

#[derive(Debug, Serialize)]
struct ExportSummary {
    file: PathBuf,
    frames: u64,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    if args.lerobot {
        let hint = "pip install './python[lerobot]' in the project's folder, and use the command `fingervision` of that package";
        return Err(Failure::new("this program does not write LeRobot data sets", hint));
    }
    let format = args.format()?;
    // A run has no camera images: it is refused whatever the video's format.
    if format == Format::Mp4 && cfg!(not(feature = "mp4")) && !args.source.is_dir() {
        let message = format!("{}: this program was built without MP4", args.out.display());
        let hint = "name it .avi, or build the program with `cargo install --path crates/cli --features mp4`";
        return Err(Failure::new(message, hint));
    }
    args.clear_destination(format)?;
    let frames = match Place::of(&args.source)? {
        Place::Recording(path, sensor) => args.export_recording(&path, sensor.as_deref(), format)?,
        Place::File(folder) if folder.is_dir() => {
            if !args.profile.is_absent() {
                let message = "a run was tracked already: --profile and --set have no effect";
                return Err(Failure::new(message, "track the recording again, or leave them out"));
            }
            args.export_run(&folder, format)?
        }
        _ => {
            let message = format!("{} is neither a run nor a recording", args.source.display());
            return Err(Failure::new(message, "give a folder of `fingervision track`, or an MCAP file"));
        }
    };
    let summary = ExportSummary { file: args.out.clone(), frames };
    args.output.result(out, &summary, &format!("exported {}: {frames} frames", args.out.display()))
}

impl Args {
    /// The format: the option, or the one of the name's ending.
    fn format(&self) -> Result<Format, Failure> {
        let ending = self.out.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase();
        let of_ending = <Format as clap::ValueEnum>::from_str(&ending, true).ok();
        let format = self.format.or(of_ending).ok_or_else(|| {
            let message = format!("{} names no format", self.out.display());
            Failure::new(message, "end it in .npz, .csv, .zarr, .avi or .mp4, or give --format")
        })?;
        if format.is_video() && of_ending != Some(format) {
            let message =
                format!("{}: the name of a video ends in .avi or .mp4, as its format does", self.out.display());
            return Err(Failure::new(message, "name it so, and leave out --format"));
        }
        Ok(format)
    }

    /// Refuses to replace an existing file or folder, or removes it if it may be replaced.
    fn clear_destination(&self, format: Format) -> Result<(), Failure> {
        let out = &self.out;
        if !out.exists() {
            return Ok(());
        }
        let is_ours = if format == Format::Zarr { out.join(".zgroup").is_file() } else { out.is_file() };
        if !(self.overwrite && is_ours) {
            let hint = if is_ours { "choose a new name or pass --overwrite" } else { "choose a new name" };
            return Err(Failure::new(format!("{} exists already", out.display()), hint));
        }
        let removed = if format == Format::Zarr { fs::remove_dir_all(out) } else { fs::remove_file(out) };
        removed.map_err(|error| Failure::new(format!("cannot replace {}: {error}", out.display()), "choose a new name"))
    }

    /// Tracks a recording into a folder beside the result, and exports that.
    fn export_recording(&self, path: &Path, sensor: Option<&str>, format: Format) -> Result<u64, Failure> {
        let (profile, mut source) = recorded(path, sensor)?;
        let beside = self.out.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let work = tempfile::Builder::new().prefix(".export-").tempdir_in(beside).map_err(|error| {
            Failure::new(format!("cannot write into {}: {error}", beside.display()), "choose a writable folder")
        })?;
        let run = Run {
            profile: self.profile.load_or(profile)?,
            fields: None,
            precision: Precision::default(),
            overlay: format.is_video().then(|| self.out.clone()),
            folder: work.path().join("run"),
            overwrite: false,
            part: Part::default(),
            skips_bad_frames: false,
            output: self.output,
        };
        let (summary, failure) = run.track(source.as_mut())?;
        failure.map_or(Ok(()), Err)?;
        if format.is_video() {
            return Ok(summary.tally.frames);
        }
        self.export_run(&run.folder, format)
    }

    fn export_run(&self, folder: &Path, format: Format) -> Result<u64, Failure> {
        let run = RunArrays::open(folder)?;
        match format {
            Format::Npz => write_npz(&run, &self.out)?,
            Format::Zarr => write_zarr(&run, &self.out)?,
            Format::Csv => {
                let copied = fs::copy(folder.join("readings.csv"), &self.out);
                copied.map_err(|error| {
                    Failure::new(format!("cannot write {}: {error}", self.out.display()), "choose a writable folder")
                })?;
            }
            Format::Avi | Format::Mp4 => {
                let message = format!("{} has no camera images for a video", folder.display());
                return Err(Failure::new(message, "export the recording, or track it again with --overlay FILE.avi"));
            }
        }
        Ok(run.table.columns.first().map_or(0, |(_, column)| column.rows()) as u64)
    }
}
