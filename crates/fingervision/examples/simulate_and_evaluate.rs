//! Presses a ball into a simulated gel, tracks the camera's images and compares depth, contact and force with the truth.
//!
//! `cargo run --release -p fingervision --example simulate_and_evaluate`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use fingervision::{Fields, Frame, PressCache, Scene, Simulation, Tracker, simulated_profile};
use std::ops::ControlFlow;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `Scene::find("sphere")` has such a press ready-made; missing values of a scene are the default sensor's.
    let mut scene = Scene::from_toml(
        "indenter = { shape = 'sphere', radius_mm = 6.0 }\n\
         [motion]\nframes = 11\nkeyframes = [{ at = 6, depth_mm = 1.5 }, { at = 10, depth_mm = 1.5, shear_mm = [0.5, 0] }]",
    )?;
    scene.make_draft(); // a coarse mesh: seconds instead of minutes
    let mut press = Simulation::new(&scene)?;
    let forces_n: Vec<[f64; 3]> = {
        // `PressCache::standard()` keeps solved presses for the next time.
        let solved = press.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(()))?;
        solved.states.iter().map(|state| state.force_n).collect()
    };

    let profile = simulated_profile(&scene);
    let mut tracker = Tracker::new(&profile, press.size(), scene.render.colour, Fields::default())?;
    println!("frame  deepest, true [mm]  depth is off by [mm]  contact overlaps  force, true [N]  flags");
    for (number, true_n) in forces_n.iter().enumerate() {
        let pixels = press.frame(number)?.clone();
        let reading =
            tracker.track(&Frame { sequence: number as u64, capture_time_s: number as f64 / 30.0, pixels })?;
        let (Some(depth), Some(contact)) = (&reading.depth, &reading.contact) else {
            return Err("the simulated sensor has a camera and a gel, so there is depth".into());
        };
        let truth = press.truth(number)?;
        // The truth is not a number beside the gel.
        let pairs = depth.values().iter().zip(truth.depth.values()).filter(|(_, truth)| truth.is_finite());
        let (sum, count) =
            pairs.fold((0.0, 0), |(sum, count), (depth, truth)| (sum + (depth - truth).abs(), count + 1));
        let touched = || contact.values().iter().zip(truth.contact.values());
        let both = touched().filter(|&(found, truth)| found & truth == 1).count();
        let either = touched().filter(|&(found, truth)| found | truth == 1).count();
        println!(
            "{number:5}  {:13.2}, {:.2}  {:20.3}  {:14.0} %  {}, {true_n:+.1?}  {}",
            reading.max_depth_mm.unwrap_or(f32::NAN),
            truth.depth.values().iter().copied().fold(0.0, f32::max),
            sum / count as f32,
            if either == 0 { 100.0 } else { 100.0 * both as f32 / either as f32 },
            reading.force_n.map_or("-".into(), |force_n| format!("{force_n:+.1?}")),
            reading.flags,
        );
    }
    Ok(())
}
