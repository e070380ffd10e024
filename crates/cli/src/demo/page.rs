//! The demo on a page: presses one after another, until the user ends it.

use std::io::Write;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};

use fingervision_gel::{PressCache, Progress, Scene, SceneError, Simulation};
use fingervision_pipeline::{Input, Pace, Sensor};
use fingervision_simulation::{PressFilm, simulated_profile};
use fingervision_source::Options;
use fingervision_touch::ElasticMode;

use super::{Args, SCENE};
use crate::failure::Failure;
use crate::live;
use crate::output::OutputArgs;

/// The presses that follow the first one: a ready-made scene and the values that are set in it.
const MORE: [(&str, &[(&str, &str)]); 6] = [
    ("sphere", &[]),
    ("letter", &[("indenter.text", "F")]),
    ("press-then-twist", &[]),
    ("crossing", &[]),
    ("press-then-shear", &[]),
    ("ring", &[]),
];

pub(super) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    args.page.check()?;
    let bar = args.output.progress("solving the first press", Some(Scene::find(SCENE)?.motion.frames as u64));
    let first = solve(&scene(SCENE, &[])?, &mut |frames| {
        bar.set_position(frames as u64);
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    let (more, solver) = Solver::start(args.output)?;
    let mut profile = simulated_profile(first.scene());
    profile.elastic.mode = ElasticMode::Live;
    let fields = live::fields(&profile);
    let film = PressFilm::new(first, Some(more), &Options::default())?;
    let sensor = Sensor::open("demo", profile, Input::source(Box::new(film), Pace::Recorded), fields)?;
    let show = live::Show { page: Some(args.page), opens_browser: !args.no_browser, ..live::Show::default() };
    let ended = live::run_sensors(vec![sensor], &show, args.output, out);
    solver.stop();
    ended
}

fn scene(name: &str, settings: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let mut scene = Scene::find(name)?;
    scene.set_all(settings.iter().copied())?;
    scene.make_draft();
    Ok(scene)
}

fn solve(scene: &Scene, progress: Progress) -> Result<Simulation, SceneError> {
    let mut simulation = Simulation::new(scene)?;
    simulation.solve(&PressCache::standard(), progress)?;
    Ok(simulation)
}

/// The thread that solves further presses while the first one is shown.
struct Solver {
    is_stopped: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

impl Solver {
    fn start(output: OutputArgs) -> Result<(Receiver<Simulation>, Self), Failure> {
        let (sender, more) = mpsc::channel();
        let is_stopped = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&is_stopped);
        let thread = thread::Builder::new().name("solve".into()).spawn(move || {
            // One thread, so that tracking keeps the other cores.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
            let solved = match pool {
                Ok(pool) => pool.install(|| solve_more(&sender, &stop)),
                Err(_) => solve_more(&sender, &stop),
            };
            if let Err(error) = solved {
                output.note(&format!("no more presses: {error}"));
            }
        })?;
        Ok((more, Self { is_stopped, thread }))
    }

    fn stop(self) {
        self.is_stopped.store(true, Ordering::Release);
        // A thread that panicked has ended, too.
        let _ = self.thread.join();
    }
}

fn solve_more(sender: &Sender<Simulation>, stop: &AtomicBool) -> Result<(), SceneError> {
    for (name, settings) in MORE {
        let simulation = solve(&scene(name, settings)?, &mut |_| {
            if stop.load(Ordering::Acquire) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        if stop.load(Ordering::Acquire) || sender.send(simulation).is_err() {
            break;
        }
    }
    Ok(())
}
