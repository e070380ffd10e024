//! `fingervision profile fingerprint`: writes the fingerprint by which another sensor is detected.

use std::fmt;
use std::io::Write;
use std::path::PathBuf;

use fingervision_touch::Fingerprint;
use serde::Serialize;

use crate::failure::Failure;
use crate::fingerprint::{grey, write};
use crate::output::OutputArgs;
use crate::place::Place;

/// Write the fingerprint of the sensor's pattern to its profile, so that another sensor is detected
///
/// The first image of the source must show the gel untouched. From then on, every reading of a sensor with another
/// pattern has the flag `other-sensor`. Write it again after the gel was replaced. `calibrate depth` and `calibrate gel`
/// also write it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The profile of the sensor
    file: PathBuf,
    /// The untouched sensor: a camera, a recording or a simulated scene, in any form that `track` accepts
    source: PathBuf,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Serialize)]
struct Written {
    profile: PathBuf,
    fingerprint: Fingerprint,
    /// Distance of the image to the fingerprint that the profile had before, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    distance_to_previous: Option<f32>,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let profile = fingervision_calibrate::load_to_update(&args.file)?;
    let mut source = Place::of(&args.source)?.source(&profile, args.output)?;
    let shown = args.source.display();
    let Some(frame) = source.next_frame()? else {
        return Err(Failure::new(format!("{shown} contains no frame"), "give a recording of the untouched gel"));
    };
    let grey = grey(&frame, &profile)?;
    let Some(fingerprint) = Fingerprint::of(&grey) else {
        let message = format!("the first image of {shown} has too little texture for a fingerprint");
        return Err(Failure::new(message, "check light, focus and image.region_of_interest"));
    };
    let distance_to_previous = profile.fingerprint().map(|previous| previous.distance(&grey));
    write(&args.file, fingerprint)?;
    let written = Written { profile: args.file.clone(), fingerprint, distance_to_previous };
    args.output.result(out, &written, &written.to_string())
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "profile  {}: pattern.fingerprint is written", self.profile.display())?;
        match self.distance_to_previous {
            Some(distance) if distance > Fingerprint::MOST_DISTANCE => {
                writeln!(f, "before   that of another sensor: {:.0} % of it differ", 100.0 * distance)
            }
            Some(distance) => writeln!(f, "before   that of the same sensor: {:.0} % of it differ", 100.0 * distance),
            None => Ok(()),
        }
    }
}
