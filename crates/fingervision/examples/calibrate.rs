//! Fits the law from density feature to depth, as used in a profile, to presses of known depth.
//!
//! The presses are simulated here; for a real sensor they are recordings, with the depth of every image.
//!
//! `cargo run --release -p fingervision --example calibrate -- [PROFILE.toml]` writes the profile with the law to a file.
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use fingervision::{DepthMethod, Frame, PressCache, Profile, ReadyMade, Simulation, simulated_profile};
use fingervision_calibrate::depth::{DepthFit, Maximum, Method, PressCurve, PressRecorder};
use std::error::Error;
use std::ops::ControlFlow;

/// Tracks a simulated press whose depths are known.
fn record(name: &str) -> Result<(PressCurve, Profile), Box<dyn Error>> {
    let mut scene = ReadyMade::find(name).ok_or("there is no such scene")?.scene();
    scene.make_draft();
    scene.set_all([("motion.frames", "8")])?;
    let mut press = Simulation::new(&scene)?;
    press.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(()))?;

    // Depth is to come from the density feature, not from the gel's elasticity.
    let mut profile = simulated_profile(&scene);
    profile.depth.method = Some(DepthMethod::Density);
    let depths_mm: Vec<f64> = press.poses().iter().map(|pose| pose.depth_mm).collect();
    let mut recorder = PressRecorder::new(name, &depths_mm, &profile, press.size(), true, Maximum::Plain)?;
    for number in 0..depths_mm.len() {
        let pixels = press.frame(number)?.clone();
        recorder.push(&Frame { sequence: number as u64, capture_time_s: number as f64 / 30.0, pixels })?;
    }
    Ok((recorder.finish()?, profile))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (first, mut profile) = record("calibration-centre-1mm")?;
    let (second, _) = record("calibration-midway-1mm")?;

    let fit = DepthFit::new(vec![first, second])?;
    println!("{fit}");
    let chosen = fit.law(Method::Perspective)?;
    fit.check(chosen, &profile)?;
    println!("depth is off by {:.3} mm over the presses it was fitted to", chosen.error_mm);

    profile.depth.density = Some(chosen.law);
    match std::env::args().nth(1) {
        Some(file) => std::fs::write(file, profile.to_toml())?,
        None => println!("{}", profile.to_toml()),
    }
    Ok(())
}
