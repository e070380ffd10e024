//! The largest number of sensors, or the highest rate, that this machine tracks without dropped frames.

use super::film::Film;
use super::report::Found;
use super::trial::{Load, Measured};
use crate::failure::Failure;
use crate::output::OutputArgs;

/// Rates are found to this part.
const PRECISION: f64 = 0.03;
/// The least rate that is tried, frames per second.
const LEAST_RATE: f64 = 1.0;
/// The largest number of sensors that is tried.
const MOST_SENSORS: usize = 256;

type Outcome = (Option<Found>, Measured);

/// The largest number of sensors at the load's rate. If not even one is carried, the highest rate of one.
pub(super) fn most_sensors(load: Load, film: &Film, output: OutputArgs) -> Result<Outcome, Failure> {
    let mut carried = None;
    let mut most = MOST_SENSORS;
    let mut sensors = 1;
    while sensors <= most {
        let measured = Load { sensors, ..load }.run(film, output)?;
        report(&measured, output);
        // Half of the machine's time leaves room for twice as many sensors.
        if measured.is_carried() {
            carried = Some(measured);
            sensors = if most == MOST_SENSORS { 2 * sensors } else { sensors + 1 };
        } else {
            most = sensors - 1;
            sensors = carried.as_ref().map_or(sensors, |carried: &Measured| carried.load.sensors + 1);
        }
    }
    match carried {
        Some(measured) => Ok((Some(Found::Sensors(measured.load.sensors)), measured)),
        None => highest_rate(Load { sensors: 1, ..load }, film, output),
    }
}

/// The highest rate of the load's sensors, up to the load's own.
pub(super) fn highest_rate(load: Load, film: &Film, output: OutputArgs) -> Result<Outcome, Failure> {
    let first = load.run(film, output)?;
    report(&first, output);
    if first.is_carried() {
        return Ok((Some(Found::Rate(load.rate)), first));
    }
    let (mut too_high, mut rate) = (load.rate, first.sustained_rate().clamp(LEAST_RATE, 0.97 * load.rate));
    let mut carried: Option<Measured> = None;
    loop {
        let measured = Load { rate, ..load }.run(film, output)?;
        report(&measured, output);
        let is_lowest = rate <= LEAST_RATE;
        if measured.is_carried() {
            carried = Some(measured);
        } else {
            too_high = rate;
        }
        let lower = carried.as_ref().map_or(LEAST_RATE, |carried| carried.load.rate);
        if carried.is_some() && too_high - lower <= PRECISION * too_high {
            break;
        }
        if carried.is_none() && is_lowest {
            let message = format!("{} sensors drop frames even at {LEAST_RATE} frame/s", load.sensors);
            return Err(Failure::new(message, "use fewer sensors or smaller frames"));
        }
        rate = if carried.is_some() { 0.5 * (lower + too_high) } else { (0.9 * rate).max(LEAST_RATE) };
    }
    match carried {
        Some(measured) => Ok((Some(Found::Rate(measured.load.rate)), measured)),
        None => Ok((None, first)),
    }
}

fn report(measured: &Measured, output: OutputArgs) {
    let Measured { load: Load { sensors, rate, .. }, dropped, .. } = measured;
    let plural = if *sensors == 1 { "" } else { "s" };
    output.note(&format!("{sensors} sensor{plural} at {rate:.1} frames/s: {dropped} frames dropped"));
}
