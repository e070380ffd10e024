//! Simulated presses that repeat without end, for the web page: `sim:letter?loop`.

use std::sync::mpsc::Receiver;

use fingervision_gel::{Scene, Simulation};
use fingervision_image::{Frame, Pixels};
use fingervision_source::{FrameFormat, FrameTruth, Options, Source, SourceError};

use crate::frame::frame_truth;
use crate::simulated_profile;

/// Frames at rest before each press.
const REST: usize = 12;
/// Frames at the end of the motion, before it is reversed.
const HOLD: usize = 12;

/// Presses one after another, each in and out again, without end.
///
/// Every press begins at rest and all have the same gel, camera and pattern, so they are one recording. Frames are
/// rendered once and kept.
pub struct PressFilm {
    /// The presses so far; the first one is present from the beginning.
    presses: Vec<Press>,
    /// Presses that are still being solved.
    more: Option<Receiver<Simulation>>,
    frames_per_second: f64,
    next_sequence: u64,
    press: usize,
    /// The next frame of this cycle.
    step: usize,
}

struct Press {
    simulation: Simulation,
    frames: Vec<Option<Pixels>>,
}

impl Press {
    fn new(simulation: Simulation) -> Option<Self> {
        let count = simulation.states().len();
        (count > 0).then(|| Self { simulation, frames: vec![None; count] })
    }

    /// Frames of a cycle: at rest, in, held, and out again.
    fn cycle(&self) -> usize {
        REST + HOLD + 2 * (self.frames.len() - 1)
    }

    /// The frame of the press that a step of the cycle shows.
    fn index(&self, step: usize) -> usize {
        let (last, place) = (self.frames.len() - 1, step.saturating_sub(REST));
        if place <= last + HOLD { place.min(last) } else { 2 * last + HOLD - place }
    }

    fn pixels(&mut self, step: usize) -> Result<Pixels, SourceError> {
        let index = self.index(step);
        if let Some(pixels) = &self.frames[index] {
            return Ok(pixels.clone());
        }
        let rendered = match self.simulation.frame(index) {
            Ok(pixels) => pixels.clone(),
            Err(error) => {
                let (location, reason) = (self.simulation.scene().name.clone(), error.to_string());
                return Err(SourceError::Simulated { location, reason, hint: error.hint() });
            }
        };
        Ok(self.frames[index].insert(rendered).clone())
    }
}

impl PressFilm {
    /// Begins with a solved press; others are added as they arrive through `more`, if they show the same sensor.
    ///
    /// # Errors
    ///
    /// [`SourceError::Rate`] if the rate makes no sense, [`SourceError::Simulated`] if no frame of the press is solved.
    pub fn new(first: Simulation, more: Option<Receiver<Simulation>>, options: &Options) -> Result<Self, SourceError> {
        options.validate()?;
        let location = first.scene().name.clone();
        let unsolved = || SourceError::Simulated { location, reason: "no frame is solved".into(), hint: None };
        let presses = vec![Press::new(first).ok_or_else(unsolved)?];
        let frames_per_second = options.frames_per_second;
        Ok(Self { presses, more, frames_per_second, next_sequence: 0, press: 0, step: 0 })
    }

    fn first_scene(&self) -> &Scene {
        self.presses[0].simulation.scene()
    }

    /// Takes the presses that were solved in the meantime.
    fn collect(&mut self) {
        let Some(more) = &self.more else { return };
        let arrived: Vec<Simulation> = more.try_iter().collect();
        let sensor = |scene: &Scene| (simulated_sensor(scene), scene.pattern.clone(), scene.render.clone());
        for simulation in arrived {
            if sensor(simulation.scene()) == sensor(self.first_scene()) {
                self.presses.extend(Press::new(simulation));
            }
        }
    }
}

/// The profile without its name.
fn simulated_sensor(scene: &Scene) -> fingervision_touch::Profile {
    fingervision_touch::Profile { name: String::new(), ..simulated_profile(scene) }
}

impl Source for PressFilm {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.step >= self.presses[self.press].cycle() {
            self.collect();
            (self.press, self.step) = ((self.press + 1) % self.presses.len(), 0);
        }
        let pixels = self.presses[self.press].pixels(self.step)?;
        let sequence = self.next_sequence;
        self.step += 1;
        self.next_sequence += 1;
        Ok(Some(Frame { sequence, capture_time_s: sequence as f64 / self.frames_per_second, pixels }))
    }

    fn frame_count(&self) -> Option<u64> {
        None
    }

    fn size(&self) -> (usize, usize) {
        self.presses[0].simulation.size()
    }

    /// On the way out the truth is that of the way in, whose image is shown again.
    fn truth(&self) -> Option<FrameTruth> {
        let press = &self.presses[self.press];
        frame_truth(&press.simulation, press.index(self.step.checked_sub(1)?))
    }

    fn scene_toml(&self) -> Option<String> {
        Some(self.first_scene().to_toml())
    }

    fn description(&self) -> String {
        let ((width, height), scene) = (self.size(), self.first_scene());
        let format = FrameFormat { width, height, is_colour: scene.render.colour, bits: 8 };
        let (name, rate) = (&scene.name, self.frames_per_second);
        format!("simulated presses without end, first {name}: {format}, {rate} frames per second")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_gel::PressCache;
    use std::ops::ControlFlow;
    use std::sync::mpsc;

    fn solved(name: &str, seed: u64) -> Simulation {
        solved_scene("board", None, name, seed)
    }

    fn solved_scene(scene: &str, set: Option<(&str, &str)>, name: &str, seed: u64) -> Simulation {
        let mut scene = Scene::find(scene).unwrap();
        let sets = [("render.width", "32"), ("render.height", "24"), ("motion.frames", "4")];
        scene.set_all(sets.into_iter().chain(set)).unwrap();
        scene.set_seed(seed);
        scene.name = name.into();
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(())).unwrap();
        simulation
    }

    #[test]
    fn a_press_goes_in_and_out_and_the_next_one_follows() {
        let (sender, more) = mpsc::channel();
        sender.send(solved("second", 1)).unwrap();
        sender.send(solved("of another pattern", 2)).unwrap();
        let mut film = PressFilm::new(solved("first", 1), Some(more), &Options { frames_per_second: 10.0 }).unwrap();
        let frames: Vec<Frame> = (0..80).map(|_| film.next_frame().unwrap().unwrap()).collect();
        assert_eq!(film.presses.len(), 2);
        assert!(frames.iter().zip(0..).all(|(frame, number)| frame.sequence == number));
        assert!((frames[7].capture_time_s - 0.7).abs() < 1e-12);
        // At rest, three steps in, held, three out, at rest again.
        let is_same = |a: usize, b: usize| frames[a].pixels == frames[b].pixels;
        let (deepest, out) = (REST + 3, REST + 3 + HOLD);
        assert!(is_same(0, REST) && is_same(deepest, out) && !is_same(deepest - 1, deepest));
        assert!(is_same(deepest - 1, out + 1) && is_same(deepest - 2, out + 2) && is_same(0, out + 3));
    }

    #[test]
    fn the_truth_is_that_of_the_image_shown() {
        let press = solved_scene("circle", Some(("mesh.cells", "[12, 12, 3]")), "press", 1);
        let mut film = PressFilm::new(press, None, &Options::default()).unwrap();
        assert_eq!(film.truth(), None, "no frame was shown");
        let shown = std::iter::from_fn(|| film.next_frame().unwrap().and(film.truth()));
        let truths: Vec<FrameTruth> = shown.take(REST + HOLD + 7).collect();
        let (deepest, out) = (REST + 3, REST + 3 + HOLD);
        let simulation = &film.presses[0].simulation;
        for (step, index) in [(0, 0), (REST, 0), (REST + 1, 1), (deepest, 3), (out, 3), (out + 1, 2), (out + 3, 0)] {
            let (pose, state) = (simulation.poses()[index], &simulation.states()[index]);
            let expected =
                FrameTruth { depth_mm: pose.depth_mm, force_n: state.force_n, torque_nmm: state.torque_nmm[2] };
            assert_eq!(truths[step], expected, "step {step}");
        }
        assert!(truths[deepest].force_n[2] > truths[REST + 1].force_n[2], "{truths:?}");
    }
}
