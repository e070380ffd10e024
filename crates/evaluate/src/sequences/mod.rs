//! Simulated presses, frame by frame through the whole tracker.
//!
//! The same frames go through a tracker under every reference policy; what it reads is compared with exact truth, a
//! border of 16 px left out. Beside the presses that figures are asked for there are the ones that break trackers: a
//! press at start-up, slow drift, dropped frames.

mod follow;
mod script;

pub use follow::{FrameError, Outcome, follow};
pub use script::{Script, Step};

use crate::{Asked, EvaluateError, Table};
use fingervision_touch::Policy;
use rayon::prelude::*;

/// The policies in the order of the columns: the default first.
const POLICIES: [Policy; 3] = [Policy::Anchored, Policy::Single, Policy::Stack];

/// The outcome of one script under every policy.
struct Outcomes([Outcome; 3]);

impl Outcomes {
    fn measure(script: &Script) -> Result<Self, EvaluateError> {
        let frames = script.frames()?;
        let outcomes = POLICIES.par_iter().map(|&policy| follow(script, &frames, policy));
        let outcomes = outcomes.collect::<Result<Vec<_>, _>>()?;
        let outcomes = outcomes.try_into().unwrap_or_else(|_| unreachable!("one outcome a policy"));
        Ok(Self(outcomes))
    }

    fn row(&self, table: &mut Table, name: &str, asked: Option<f64>, figure: impl Fn(&Outcome) -> f64) {
        table.push(name, asked.map(Asked::AtMost), self.0.iter().map(figure).collect());
    }
}

/// Tracks all sequences.
///
/// # Errors
///
/// [`EvaluateError::Track`] if the default profile does not fit the frames, which would be a bug.
pub fn measure() -> Result<Table, EvaluateError> {
    let mut table = Table::new("Simulated sequences: end-point error, px", &["anchored", "single", "stack"]);
    for (name, script, asked) in [
        ("press 0 to 25 px", Script::press(25.0, 30), [Some(0.03), Some(0.05)]),
        ("same, 15 % light", Script::press(25.0, 30).with_light(), [Some(0.035), Some(0.06)]),
        ("same, every fifth frame only", Script::press(25.0, 30).every(5), [None, None]),
    ] {
        let outcomes = Outcomes::measure(&script)?;
        outcomes.row(&mut table, &format!("{name}: mean"), asked[0], Outcome::mean_px);
        outcomes.row(&mut table, &format!("{name}: final"), asked[1], Outcome::final_px);
        outcomes.row(&mut table, &format!("{name}: largest 99th percentile"), None, Outcome::largest_high_px);
    }
    strong_press(&mut table)?;
    releases(&mut table)?;
    pressed_start(&mut table)?;
    let drift = Outcomes::measure(&Script::drift())?;
    drift.row(&mut table, "drift by 6 px in 300 frames: mean", None, Outcome::mean_px);
    drift.row(&mut table, "drift by 6 px in 300 frames: final", None, Outcome::final_px);
    Ok(table)
}

fn strong_press(table: &mut Table) -> Result<(), EvaluateError> {
    let outcomes = Outcomes::measure(&Script::press(40.0, 24))?;
    outcomes.row(table, "press 0 to 40 px: final", Some(0.08), Outcome::final_px);
    outcomes.row(table, "press 0 to 40 px: largest", Some(1.0), Outcome::largest_px);
    outcomes.row(table, "press 0 to 40 px: largest 99th percentile", None, Outcome::largest_high_px);
    outcomes.row(table, "press 0 to 40 px: wrong but valid, part", None, Outcome::trusted_wrong);
    Ok(())
}

fn releases(table: &mut Table) -> Result<(), EvaluateError> {
    let script = Script::presses(15.0, 10, 3);
    let outcomes = Outcomes::measure(&script)?;
    for release in 1..=3 {
        let name = format!("after release {release} of 15 px");
        outcomes.row(table, &name, Some(0.015), |outcome| outcome.frames[20 * release].mean_px);
    }
    Ok(())
}

fn pressed_start(table: &mut Table) -> Result<(), EvaluateError> {
    let script = Script::pressed_start(10.0);
    let outcomes = Outcomes::measure(&script)?;
    outcomes.row(table, "pressed at start: frames before that is flagged", None, |outcome| {
        outcome.frames.iter().position(|frame| frame.is_pressed_at_start).map_or(f64::NAN, |frame| frame as f64)
    });
    outcomes.row(table, "pressed at start: largest up to the release", None, |outcome| {
        outcome.frames[..=script::RELEASED].iter().map(|frame| frame.mean_px).fold(0.0, f64::max)
    });
    outcomes.row(table, "pressed at start: next press, final", None, Outcome::final_px);
    Ok(())
}
