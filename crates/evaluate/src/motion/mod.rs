//! Simulated presses at several speeds: errors and validity of the flow, in particular at the rim of the contact.
//!
//! Every press is solved once and tracked at several paces, with 1, 2, 4, 10 or 20 of its steps from one image to the
//! next. The flow of every image is compared with the exact truth, by region: in contact, near its border and
//! elsewhere. All visible pixels count, whether they are valid or not, unless the name of a row says otherwise.
//! The same presses are then tracked with disturbed images: blurred by motion, missing, too bright or black.

mod disturbance;
mod follow;
mod tally;

use disturbance::Outcome;

pub use disturbance::Disturbance;
pub use follow::{PACES, Press, Variant};
pub use tally::{BANDS_MM, Sums, Tally};

use crate::experiment::ExperimentError;
use crate::press_options::ready_made_presses;
use crate::{Asked, PressOptions, Table};
use fingervision_gel::PressCache;
use rayon::prelude::*;

/// Error of the flow in contact, px, above which a contact may be lost.
const LOST_PX: f64 = 0.15;

/// The tables of [`measure`].
#[derive(Debug, Clone)]
pub struct Tables {
    /// Error in contact by scene and pace, and the required values over all scenes.
    pub motion: Table,
    /// Error and validity by distance from the border of the contact, at pace 1.
    pub rim: Table,
    /// Part of the errors within the predicted deviation, by region.
    pub deviation: Table,
    /// Errors and flags in disturbed images and after them.
    pub disturbed: Table,
}

/// Tracks the ready-made presses, with two gels and two kinds of contact each, at all paces. Presses that the simulator cannot
/// solve to their end are left out and counted. `progress` is called with the name of every press before it is solved.
///
/// # Errors
///
/// [`ExperimentError::Scene`] for a scene that is not known or cannot be solved; [`ExperimentError::Track`] if a frame
/// cannot be tracked, which would be a bug.
pub fn measure(
    options: &PressOptions,
    cache: &PressCache,
    progress: &mut dyn FnMut(&str),
) -> Result<Tables, ExperimentError> {
    options.check()?;
    let names = ready_made_presses().map(|scene| scene.name).filter(|name| options.includes(name));
    let columns = PACES.map(|pace| if pace == 1 { "1 step".to_owned() } else { format!("{pace} steps") });
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut motion =
        Table::new("Presses by steps between two images: largest error in contact of an image, px", &columns);
    let mut all: Vec<Vec<Tally>> = PACES.iter().map(|_| Vec::new()).collect();
    let mut outcomes: Vec<Vec<Outcome>> = Disturbance::ALL.iter().map(|_| Vec::new()).collect();
    let mut unsolved = 0;
    for name in names {
        let mut worst = [f64::NAN; PACES.len()];
        for variant in Variant::ALL {
            progress(&format!("{name}, {}", variant.name()));
            let press = match Press::solve(name, variant, options.mesh, cache) {
                Ok(press) => press,
                Err(ExperimentError::EndedEarly { reason, .. }) => {
                    progress(&format!("left out: {reason}"));
                    unsolved += 1;
                    continue;
                }
                Err(error) => return Err(error),
            };
            let tallies = PACES.par_iter().map(|&pace| press.follow(pace)).collect::<Result<Vec<_>, _>>()?;
            for ((worst, all), tally) in worst.iter_mut().zip(&mut all).zip(tallies) {
                *worst = worst.max(tally.contact_px());
                all.push(tally);
            }
            let found = Disturbance::ALL.par_iter().map(|&disturbance| press.follow_disturbed(disturbance));
            for (outcomes, outcome) in outcomes.iter_mut().zip(found.collect::<Result<Vec<_>, _>>()?) {
                outcomes.push(outcome);
            }
        }
        motion.push(name, None, worst.to_vec());
    }
    let mut row = |name: &str, asked: Option<Asked>, figure: &dyn Fn(&[Tally]) -> f64| {
        motion.push(name, asked, all.iter().map(|tallies| figure(tallies)).collect());
    };
    row("largest step, px", None, &|all| largest(all, |tally| tally.step_px));
    row("presses above 0.15 px in contact, number", None, &|all| {
        all.iter().filter(|tally| tally.contact_px() > LOST_PX).count() as f64
    });
    row("valid with an error above 0.5 px, largest part", Some(Asked::AtMost(0.001)), &|all| {
        largest(all, Tally::wrong)
    });
    row("valid, mean part", Some(Asked::AtLeast(0.97)), &|all| mean(all, Tally::valid));
    row("within 1 mm of the border, mean, px", Some(Asked::AtMost(0.12)), &|all| mean(all, Tally::rim_px));
    row("within 1 mm of the border, largest, px", None, &|all| largest(all, Tally::rim_px));
    row("within 1 mm of the border, valid, mean part", Some(Asked::AtLeast(0.5)), &|all| mean(all, Tally::rim_valid));
    row("presses left out, not solved to their end, number", None, &|_| f64::from(unsolved));
    row("flagged images, mean part", None, &|all| mean(all, Tally::flagged));
    row("error of the last normal force, mean part", Some(Asked::AtMost(0.02)), &|all| mean(all, Tally::force_off));
    row("error of the last normal force, largest part", Some(Asked::AtMost(0.05)), &|all| {
        largest(all, Tally::force_off)
    });
    Ok(Tables { motion, rim: rim(&all[0]), deviation: deviation(&all), disturbed: disturbed(&outcomes) })
}

/// The largest figure; not a number if there is none, so that a table of no press does not look good.
fn largest<T>(of: &[T], figure: impl Fn(&T) -> f64) -> f64 {
    of.iter().map(figure).fold(f64::NAN, f64::max)
}

/// The mean of the figures; not a number if there is none.
fn mean<T>(of: &[T], figure: impl Fn(&T) -> f64) -> f64 {
    of.iter().map(figure).sum::<f64>() / of.len() as f64
}

/// Errors and flags by disturbance.
fn disturbed(all: &[Vec<Outcome>]) -> Table {
    let columns = [
        "contact, mean px",
        "largest",
        "> 0.15 px and not flagged",
        "valid, wrong, largest part",
        "valid part",
        "flagged part",
        "2 images later, largest px",
    ];
    let mut table = Table::new("Disturbed images: error in contact, validity, flags", &columns);
    for (disturbance, outcomes) in Disturbance::ALL.iter().zip(all) {
        let of_disturbed = |figure: fn(&Tally) -> f64| mean(outcomes, |outcome| figure(&outcome.disturbed));
        let silent = outcomes.iter().filter(|outcome| outcome.disturbed.silent_px() > LOST_PX).count() as f64;
        let later = largest(outcomes, |outcome| outcome.after.contact_px());
        let values = vec![
            of_disturbed(Tally::contact_px),
            largest(outcomes, |outcome| outcome.disturbed.contact_px()),
            silent,
            largest(outcomes, |outcome| outcome.disturbed.wrong()),
            of_disturbed(Tally::valid),
            of_disturbed(Tally::flagged),
            if matches!(disturbance, Disturbance::MotionBlur { .. }) { f64::NAN } else { later },
        ];
        table.push(disturbance.name(), None, values);
    }
    let [black, flagged] = all
        .iter()
        .flatten()
        .fold([0, 0], |[black, flagged], outcome| [black + outcome.black[0], flagged + outcome.black[1]]);
    let mut values = vec![f64::NAN; columns.len()];
    values[5] = flagged as f64 / black as f64;
    table.push("the black images themselves", None, values);
    table
}

/// Error by distance from the border.
fn rim(tallies: &[Tally]) -> Table {
    let mut names: Vec<String> = BANDS_MM.iter().map(|reach| format!("< {reach} mm")).collect();
    names.push("farther".into());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut table = Table::new("By distance from the border of the contact, one step between two images", &names);
    let sums = tallies.iter().fold(Tally::default(), Tally::with);
    table.push("mean error of all visible pixels, px", None, sums.bands().map(Sums::mean_px).collect());
    table.push("mean error of the valid ones, px", None, sums.bands().map(Sums::mean_valid_px).collect());
    table.push("valid part", None, sums.bands().map(Sums::valid).collect());
    table
}

/// Part of the errors within the predicted deviation.
fn deviation(all: &[Vec<Tally>]) -> Table {
    let columns = ["contact", "rim", "outside"];
    let mut table =
        Table::new("Part of the valid pixels whose error is within the predicted deviation, all paces", &columns);
    let sums = all.iter().flatten().fold(Tally::default(), Tally::with);
    for (k, asked) in [(0, 0.68), (1, 0.95)] {
        let name = format!("within {}", if k == 0 { "one" } else { "two" });
        table.push(name, Some(Asked::AtLeast(asked)), sums.places().map(|place| place.covered(k)).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_no_press_are_missing() {
        assert!(largest(&[], Tally::wrong).is_nan() && mean(&[], Tally::valid).is_nan());
        assert_eq!((largest(&[2.0, 3.0, 1.0], |x| *x), mean(&[2.0, 3.0, 1.0], |x| *x)), (3.0, 2.0));
    }
}
