//! `fingervision bench`: measures speed and accuracy of tracking on this machine, or how many sensors it can track.

mod press;
mod report;
mod sensors;

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use fingervision_elastic::GelBlock;
use fingervision_image::Frame;
use fingervision_touch::{DepthLine, DepthSection, ElasticMode, Fields, ImageSection, Profile, Reading, Tracker};

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::pattern::simulated_camera;
use crate::profile_args::ProfileArgs;

use press::{FRAMES, Press};
use report::{ElasticTimes, Report, end_point_error_px};
use sensors::SensorsArgs;

/// Columns and rows of the press if the profile names none, px.
const SIZE: (usize, usize) = (610, 450);
/// Possible sides of an image with the principal point in its middle, px; otherwise the usual size is used.
const LEAST_SIDE: f64 = 32.0;
const MOST_SIDE: f64 = 4096.0;

/// Measure the speed of tracking on this machine, one thread
///
/// A press is rendered first: a reference, then a round bump that grows to 25 px in 30 frames, or in proportion where
/// the shorter side is not 450 px. The images are as large as the profile's region of interest; without [image], as the
/// image around the camera's principal point; without --profile, 610x450 px. The press is tracked once to warm up, then
/// repeatedly, each time from a new reference. Every frame after the reference is timed from the colour image in memory
/// to depth: flow, density, filter and line, or with [camera] and [gel] elasticity. No gel deforms like this press, so
/// the time for elasticity is the longest possible. Without --profile, example values are used for the depth line, and
/// the additional time of depth from elasticity is measured, too, with an example camera and gel. No files are read or
/// written during the timing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Least number of frames to time; the last press is always finished
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "load")]
    frames: u32,
    /// Write the press to a new folder instead: frames/*.png, the reference first, and their flow as truth/flow.npy
    #[arg(long, value_name = "DIR", conflicts_with_all = ["frames", "load"])]
    write_frames: Option<PathBuf>,
    #[command(flatten)]
    sensors: SensorsArgs,
    #[command(flatten)]
    profile: ProfileArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    if args.sensors.is_asked() {
        return sensors::run(args, out);
    }
    let mut profile = args.profile.load_or(calibrated())?;
    let size = image_size(&profile);
    // The images show only what is tracked: positions in a profile are those in the region.
    profile.image = None;
    // Errors of the tracker are reported before anything is rendered.
    Tracker::new(&profile, size, true, Fields::NONE)?;
    let press = Press::new(size)?;
    if let Some(folder) = &args.write_frames {
        let written = press.write(folder, &args.output.progress("writing", Some(FRAMES)))?;
        return args.output.result(out, &written, &written.to_string());
    }
    let report = measure(args, &profile, &press)?;
    args.output.result(out, &report, &report.to_string())
}

/// Renders the press, tracks it once for its error, then as often as needed for its times.
fn measure(args: &Args, profile: &Profile, press: &Press) -> Result<Report, Failure> {
    args.profile.expect_effect(profile, Fields::default(), false, args.output)?;
    let region = profile.region(press.size())?;
    let passes = u64::from(args.frames).div_ceil(FRAMES - 1);
    let is_made_up = args.profile.is_absent();
    let elastic_passes = if is_made_up { 3 } else { 0 };
    let progress = args.output.progress("tracking", Some(FRAMES + (1 + passes + elastic_passes) * (FRAMES - 1)));
    let mut frames = Vec::new();
    for sequence in 0..FRAMES {
        frames.push(press.frame(sequence)?);
        progress.inc(1);
    }
    let (mut errors_px, mut times_ms) = (Vec::new(), Vec::new());
    track(profile, press, &frames, Fields::default(), |reading, _| {
        errors_px.push(end_point_error_px([&reading.flow.u, &reading.flow.v], &press.motion(reading.sequence), region));
        progress.inc(1);
    })?;
    for _ in 0..passes {
        track(profile, press, &frames, Fields::default(), |_, time_ms| {
            times_ms.push(time_ms);
            progress.inc(1);
        })?;
    }
    let elastic = is_made_up.then(|| elastic_times(press, &frames, || progress.inc(1))).transpose()?;
    progress.finish_and_clear();
    Ok(Report::new((region.width, region.height), press.amplitude_px(), times_ms, &errors_px, elastic))
}

/// Columns and rows of the images for a profile's sensor, px: its region of interest, or the image with the camera's
/// principal point in its middle, or the usual size.
fn image_size(profile: &Profile) -> (usize, usize) {
    if let Some(ImageSection { region_of_interest: [_, _, width, height] }) = profile.image {
        return (width, height);
    }
    let around =
        |middle: f64| Some((2.0 * middle + 1.0).round()).filter(|side| (LEAST_SIDE..=MOST_SIDE).contains(side));
    let sides = profile.camera.map(|camera| camera.principal_point_px.map(around));
    match sides {
        Some([Some(width), Some(height)]) => (width as usize, height as usize),
        _ => SIZE,
    }
}

/// Tracks the press with a new tracker; passes on each reading after the reference and its time, ms.
fn track(
    profile: &Profile,
    press: &Press,
    frames: &[Frame],
    fields: Fields,
    mut each: impl FnMut(&Reading, f64),
) -> Result<(), Failure> {
    let mut tracker = Tracker::new(profile, press.size(), true, fields)?;
    for frame in frames {
        let arrival = Instant::now();
        let reading = tracker.track(frame)?;
        let time_ms = 1e3 * arrival.elapsed().as_secs_f64();
        if frame.sequence > 0 {
            each(reading, time_ms);
        }
    }
    Ok(())
}

/// Times a frame of flow alone, and of flow and depth from elasticity in both modes. The press is not that of a gel, so
/// the solver needs its largest number of steps.
fn elastic_times(press: &Press, frames: &[Frame], mut tick: impl FnMut()) -> Result<ElasticTimes, Failure> {
    let mut times = |mode: ElasticMode, fields: Fields| {
        let mut profile = elastic(press);
        profile.elastic.mode = mode;
        let mut times_ms = Vec::new();
        track(&profile, press, frames, fields, |_, time_ms| {
            times_ms.push(time_ms);
            tick();
        })
        .map(|()| times_ms)
    };
    let depth = Fields { depth: true, ..Fields::NONE };
    let flow = times(ElasticMode::Live, Fields::NONE)?;
    Ok(ElasticTimes::new(flow, times(ElasticMode::Live, depth)?, times(ElasticMode::Exact, depth)?))
}

/// A sensor whose gel fills the image, with example values.
fn elastic(press: &Press) -> Profile {
    let size_px = <[usize; 2]>::from(press.size());
    let camera = simulated_camera(size_px);
    let size_mm = size_px.map(|pixels| pixels as f64 * camera.translation_mm[2] / camera.focal_length_px[0]);
    Profile {
        camera: Some(camera),
        gel: Some(GelBlock { size_mm, thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: Some(0.6) }),
        ..Profile::default()
    }
}

/// A sensor with a depth line, so that every stage runs, with example values.
fn calibrated() -> Profile {
    let line = DepthLine { slope_mm: 15.2, intercept_mm: 0.0 };
    Profile { depth: DepthSection { density: Some(line.into()), ..DepthSection::default() }, ..Profile::default() }
}
