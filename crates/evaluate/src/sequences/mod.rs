//! Simulated presses, frame by frame through the whole tracker.
//!
//! The same frames are tracked under every reference policy. The readings are compared with the exact truth, without a
//! border of 16 px. In addition to plain presses there are sequences on which trackers often fail: a press at the
//! start, slow drift, dropped frames.

mod follow;
mod script;

pub use follow::{FrameError, Outcome, follow};
pub use script::{Script, Step};

use crate::{Asked, EvaluateError, Table};
use fingervision_touch::Policy;
use rayon::prelude::*;

/// Frames that a press of 15 px takes, and its release.
const RELEASE_FRAMES: usize = 10;

/// The policies, the default first.
pub const POLICIES: [Policy; 3] = [Policy::Anchored, Policy::Single, Policy::Stack];

/// The results of one script, one per policy.
struct Outcomes(Vec<Outcome>);

impl Outcomes {
    fn measure(script: &Script, policies: &[Policy]) -> Result<Self, EvaluateError> {
        let frames = script.frames()?;
        let outcomes = policies.par_iter().map(|&policy| follow(script, &frames, policy));
        Ok(Self(outcomes.collect::<Result<_, _>>()?))
    }

    fn row(&self, table: &mut Table, name: &str, asked: Option<f64>, figure: impl Fn(&Outcome) -> f64) {
        table.push(name, asked.map(Asked::AtMost), self.0.iter().map(figure).collect());
    }
}

/// Tracks all sequences under some policies, the first of which has required figures.
///
/// # Errors
///
/// [`EvaluateError::Track`] if the default profile does not fit the frames, which would be a bug.
pub fn measure(policies: &[Policy]) -> Result<Table, EvaluateError> {
    let names: Vec<_> = policies.iter().map(|&policy| name(policy)).collect();
    let mut table = Table::new("Simulated sequences: end-point error, px unless stated", &names);
    for (name, script, asked) in [
        ("press 0 to 25 px", Script::press(25.0, 30), [Some(0.03), Some(0.05)]),
        ("same, 15 % light", Script::press(25.0, 30).with_light(), [Some(0.035), Some(0.06)]),
        ("same, every fifth frame only", Script::press(25.0, 30).every(5), [None, None]),
    ] {
        let outcomes = Outcomes::measure(&script, policies)?;
        outcomes.row(&mut table, &format!("{name}: mean"), asked[0], Outcome::mean_px);
        outcomes.row(&mut table, &format!("{name}: final"), asked[1], Outcome::final_px);
        outcomes.row(&mut table, &format!("{name}: largest 99th percentile"), None, Outcome::largest_high_px);
    }
    strong_press(&mut table, policies)?;
    releases(&mut table, policies)?;
    pressed_start(&mut table, policies)?;
    let drift = Outcomes::measure(&Script::drift(), policies)?;
    drift.row(&mut table, "drift by 6 px in 300 frames: mean", None, Outcome::mean_px);
    drift.row(&mut table, "drift by 6 px in 300 frames: final", None, Outcome::final_px);
    Ok(table)
}

fn name(policy: Policy) -> &'static str {
    match policy {
        Policy::Anchored => "anchored",
        Policy::Stack => "stack",
        Policy::Single => "single",
    }
}

fn strong_press(table: &mut Table, policies: &[Policy]) -> Result<(), EvaluateError> {
    let outcomes = Outcomes::measure(&Script::press(40.0, 24), policies)?;
    outcomes.row(table, "press 0 to 40 px: final", Some(0.08), Outcome::final_px);
    outcomes.row(table, "press 0 to 40 px: largest", Some(1.0), Outcome::largest_px);
    outcomes.row(table, "press 0 to 40 px: largest 99th percentile", None, Outcome::largest_high_px);
    outcomes.row(table, "press 0 to 40 px: valid but wrong, part", None, Outcome::trusted_wrong);
    Ok(())
}

fn releases(table: &mut Table, policies: &[Policy]) -> Result<(), EvaluateError> {
    let outcomes = Outcomes::measure(&Script::presses(15.0, RELEASE_FRAMES, 3), policies)?;
    for release in 1..=3 {
        let name = format!("after release {release} of 15 px");
        outcomes.row(table, &name, Some(0.015), |outcome| outcome.frames[2 * RELEASE_FRAMES * release].mean_px);
    }
    Ok(())
}

fn pressed_start(table: &mut Table, policies: &[Policy]) -> Result<(), EvaluateError> {
    let outcomes = Outcomes::measure(&Script::pressed_start(10.0), policies)?;
    outcomes.row(table, "pressed at start: frames until it is flagged", None, |outcome| {
        outcome.frames.iter().position(|frame| frame.is_pressed_at_start).map_or(f64::NAN, |frame| frame as f64)
    });
    outcomes.row(table, "pressed at start: largest up to the release", None, |outcome| {
        outcome.frames[..=script::RELEASED].iter().map(|frame| frame.mean_px).fold(0.0, f64::max)
    });
    outcomes.row(table, "pressed at start: next press, final", None, Outcome::final_px);
    Ok(())
}
