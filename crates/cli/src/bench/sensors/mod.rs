//! `fingervision bench --sensors`: several sensors at camera rate, from the bytes of a camera to readings.

mod film;
mod machine;
mod report;
mod search;
mod trial;

use std::io::Write;
use std::path::PathBuf;

use fingervision_touch::{DepthMethod, Fields, Profile};

use super::Args;
use crate::failure::Failure;
use crate::threads;
use film::Film;
use report::SensorsReport;
use trial::Load;

/// Each sensor has its own references and reading in memory.
const MOST_SENSORS: i64 = 256;

#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("load").multiple(true).args(["sensors", "find"])))]
pub(super) struct SensorsArgs {
    /// Instead, track N simulated cameras at camera rate, as `live` does
    ///
    /// Each camera sends motion JPEG of a simulated press, forwards and backwards in turn, or the frames of --recording. All cameras
    /// send at the same moments. The frames are encoded in advance. The report has the dropped frames, the time of each stage, the
    /// latency from the moment at which a frame is due to its reading, memory and processor time. Depth, contact and force are
    /// computed from elasticity in live mode; --set elastic.mode=exact changes that.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_SENSORS))]
    pub(super) sensors: Option<u16>,
    /// Find the largest number of sensors without dropped frames; with --sensors, the highest rate without dropped frames
    #[arg(long)]
    pub(super) find: bool,
    /// Frames per second of each sensor
    #[arg(long, value_name = "RATE", default_value_t = 90.0, value_parser = rate, requires = "load")]
    rate: f64,
    /// Duration; with --find that of each trial
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = seconds, requires = "load")]
    seconds: f64,
    /// Play these frames instead of the simulated press, at most 300, of which the first shows the gel untouched
    ///
    /// A folder, a video, a recording or a scene. They are encoded as JPEG again.
    #[arg(long, value_name = "SOURCE", conflicts_with = "size", requires = "load")]
    recording: Option<PathBuf>,
    /// Columns and rows of the simulated press, px
    #[arg(long, value_name = "WxH", default_value = "640x480", value_parser = size, requires = "load")]
    size: (usize, usize),
    /// JPEG quality, 1 to 100
    #[arg(long, value_name = "Q", default_value_t = 85, value_parser = clap::value_parser!(u8).range(1..=100), requires = "load")]
    quality: u8,
}

impl SensorsArgs {
    /// Whether sensors are measured, and not single frames.
    pub(super) fn is_asked(&self) -> bool {
        self.sensors.is_some() || self.find
    }
}

pub(super) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let (wanted, output) = (&args.sensors, args.output);
    let film = Film::make(wanted, &args.profile, output)?;
    let fields = fields(&film.profile);
    args.profile.expect_effect(&film.profile, fields, false, output)?;
    let workers = threads::count();
    let sensors = wanted.sensors.map_or(1, usize::from);
    let load = Load { sensors, rate: wanted.rate, seconds: wanted.seconds, fields, workers };
    let (found, mut measured) = match (wanted.find, wanted.sensors) {
        (false, _) => (None, load.run(&film, output)?),
        (true, None) => search::most_sensors(load, &film, output)?,
        (true, Some(_)) => search::highest_rate(load, &film, output)?,
    };
    if wanted.find {
        // The sensors of a trial use the memory that those of the one before have left.
        measured.memory.of_sensor = None;
    }
    let report = SensorsReport::new(&film, measured, found);
    output.result(out, &report, &report.to_string())
}

/// Depth, and what comes with it.
fn fields(profile: &Profile) -> Fields {
    Fields { density: profile.depth_method() == DepthMethod::Density, depth: true, ..Fields::NONE }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (0.1..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("expected frames per second, 0.1 to 1000".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 1 or more".into()),
    }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.parse::<usize>().ok().filter(|side| (64..=4096).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "expected columns and rows, 64 to 4096 px, as in 640x480".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_rates_and_times_are_checked() {
        assert_eq!(size("640x480"), Ok((640, 480)));
        for text in ["640", "640x", "0x480", "640x5000", "640x480x3"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert!(rate("90").is_ok() && rate("0").is_err() && rate("nan").is_err() && rate("-3").is_err());
        assert!(seconds("60").is_ok() && seconds("0").is_err() && seconds("inf").is_err());
    }
}
