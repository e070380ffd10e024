//! Writes one scene into a folder: solves, draws, writes and summarises it.

use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fingervision_gel::{EarlyEnd, MotionKind, Origin, PressCache, Scene, Simulation};
use fingervision_simulation::{SimulatedFrame, SimulationFolder, SimulationPreview};
use serde::Serialize;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::OutputArgs;
use crate::summary::Force;

/// Options for writing scenes into folders.
#[derive(Debug)]
pub(crate) struct SimulationRun {
    pub(crate) cache: PressCache,
    /// Whether images are written beside the truth.
    pub(crate) has_images: bool,
    /// Whether a previous simulation may be replaced.
    pub(crate) overwrite: bool,
    pub(crate) output: OutputArgs,
    pub(crate) interrupt: Interrupt,
}

/// The result of a simulation.
#[derive(Debug, Serialize)]
pub(crate) struct SimulationSummary {
    scene: String,
    folder: PathBuf,
    /// Columns and rows of every frame, px.
    size: (usize, usize),
    /// Frames written.
    frames: u64,
    /// Frames of the scene.
    frames_asked: u64,
    /// The origin of the press: `solved`, `cache` or `rigid`.
    press: &'static str,
    solving_s: f64,
    drawing_s: f64,
    /// Of the deepest frame; of the last of them if there are several.
    depth_mm: f64,
    #[serde(flatten)]
    pub(crate) force: Force<f64>,
    /// Step of a rigid board along x from frame to frame, mm; none for a press.
    #[serde(skip)]
    slide_mm: Option<f64>,
    /// The camera's distance, mm.
    #[serde(skip)]
    distance_mm: f64,
    has_images: bool,
    /// Absent if it could not be drawn.
    preview: Option<PathBuf>,
}

impl SimulationRun {
    /// Simulates a scene into a folder.
    ///
    /// The second value is the reason if it ended early; the frames before it are still written.
    ///
    /// # Errors
    ///
    /// Why the simulation cannot begin.
    pub(crate) fn simulate(&self, scene: &Scene, path: &Path) -> Result<(SimulationSummary, Option<Failure>), Failure> {
        let mut simulation = Simulation::new(scene)?;
        let mut folder = SimulationFolder::create(path, scene, self.has_images, self.overwrite)?;
        let begin = Instant::now();
        let (press, end) = self.solve(&mut simulation)?;
        let solving_s = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let mut preview = SimulationPreview::new(scene, simulation.states().len());
        let drawn = self.draw(&mut simulation, &mut folder, &mut preview);
        let closed = folder.finish();
        let frames = *closed.as_ref().unwrap_or(&0);
        let picture = path.join("preview.png");
        let saved = if frames > 0 { preview.save(&picture) } else { Ok(()) };
        let deepest = deepest(&simulation, frames as usize);
        let summary = SimulationSummary {
            scene: scene.name.clone(),
            folder: path.to_owned(),
            size: simulation.size(),
            frames,
            frames_asked: simulation.poses().len() as u64,
            press,
            solving_s,
            drawing_s: begin.elapsed().as_secs_f64(),
            depth_mm: simulation.poses()[deepest].depth_mm,
            force: simulation.states()[deepest].force_n.into(),
            has_images: self.has_images && frames > 0,
            preview: (frames > 0 && saved.is_ok()).then_some(picture),
            slide_mm: slide_mm(&simulation),
            distance_mm: scene.camera().translation_mm[2],
        };
        let ended = drawn.and(closed.map(drop).map_err(Failure::from)).and(saved.map_err(Failure::from));
        let ended = ended.and(end.map_or(Ok(()), |end| Err(ended_early(&end, &summary))));
        Ok((summary, ended.err()))
    }

    fn solve(&self, simulation: &mut Simulation) -> Result<(&'static str, Option<EarlyEnd>), Failure> {
        let bar = self.output.progress("solving", Some(simulation.poses().len() as u64));
        let mut progress = |frames: usize| {
            bar.set_position(frames as u64);
            if self.interrupt.is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let press = simulation.solve(&self.cache, &mut progress)?;
        bar.finish_and_clear();
        if let Some(fault) = &press.cache_fault {
            self.output.note(&format!("{fault}; the press was solved again"));
        }
        let origin = match press.origin {
            Origin::Solved => "solved",
            Origin::Cache => "cache",
            Origin::Rigid => "rigid",
        };
        Ok((origin, press.end.clone()))
    }

    /// Draws and writes frame after frame; returns why it ended early.
    fn draw(
        &self,
        simulation: &mut Simulation,
        folder: &mut SimulationFolder,
        preview: &mut SimulationPreview,
    ) -> Result<(), Failure> {
        let count = simulation.states().len();
        let bar = self.output.progress("drawing", Some(count as u64));
        for number in 0..count {
            let pixels = if self.has_images { Some(simulation.frame(number)?.clone()) } else { None };
            let depth_mm = simulation.poses()[number].depth_mm;
            let state = &simulation.states()[number];
            let (force_n, torque_z_nmm) = (state.force_n, state.torque_nmm[2]);
            let truth = simulation.truth(number)?;
            let frame = SimulatedFrame { depth_mm, force_n, torque_z_nmm, pixels: pixels.as_ref(), truth };
            folder.write(&frame)?;
            preview.write(&frame);
            bar.inc(1);
            if self.interrupt.is_asked() && number + 1 < count {
                let asked = simulation.poses().len();
                let message = format!("interrupted after {} of {asked} frames", number + 1);
                return Err(Failure::new(message, "the frames written so far can be used; --overwrite starts again"));
            }
        }
        bar.finish_and_clear();
        Ok(())
    }
}

/// Step of a rigid board along x from frame to frame, mm; none for another motion.
fn slide_mm(simulation: &Simulation) -> Option<f64> {
    let [first, second, ..] = simulation.poses() else { return None };
    let step_mm = second.shear_mm[0] - first.shear_mm[0];
    (simulation.scene().motion.kind == MotionKind::Rigid && step_mm > 0.0).then_some((1e6 * step_mm).round() / 1e6)
}

/// The last of the deepest among the first frames; the first one if there is none.
fn deepest(simulation: &Simulation, frames: usize) -> usize {
    let depths = simulation.poses().iter().take(frames).map(|pose| pose.depth_mm);
    let deepest = depths.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
    deepest.map_or(0, |(frame, _)| frame)
}

/// Names the scene, the number of frames written, and what to do.
fn ended_early(end: &EarlyEnd, summary: &SimulationSummary) -> Failure {
    let SimulationSummary { scene, frames, frames_asked, .. } = summary;
    let are = if *frames == 1 { "is" } else { "are" };
    let message = format!("{scene}: {end}; {frames} of {frames_asked} frames {are} written");
    let hint = end.hint().unwrap_or_else(|| "the frames written so far can be used; --overwrite starts again".into());
    Failure::new(message, hint)
}

impl SimulationSummary {
    /// What was simulated, and how long it took.
    pub(crate) fn headline(&self) -> String {
        let Self { scene, frames, size: (width, height), solving_s, drawing_s, .. } = self;
        let press = match self.press {
            "cache" => "solution from the cache".into(),
            "rigid" => "nothing to solve".into(),
            _ => format!("solved in {solving_s:.1} s"),
        };
        let plural = if *frames == 1 { "" } else { "s" };
        format!("{scene}: {frames} frame{plural} of {width}x{height} px, {press}, drawn in {drawing_s:.1} s")
    }

    /// A summary in one line.
    pub(crate) fn line(&self) -> String {
        let Self { folder, frames, depth_mm, force, solving_s, drawing_s, .. } = self;
        let (folder, seconds) = (folder.display(), solving_s + drawing_s);
        format!("{folder}  {frames} frames, {depth_mm:.2} mm deep, force {force}, {seconds:.1} s")
    }
}

/// A few lines for people.
impl fmt::Display for SimulationSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (folder, force) = (self.folder.display(), self.force);
        writeln!(f, "{}", self.headline())?;
        writeln!(f, "force    {force} on the gel at {:.2} mm", self.depth_mm)?;
        writeln!(f, "folder   {folder}")?;
        if let Some(preview) = &self.preview {
            writeln!(f, "preview  {}", preview.display())?;
        }
        if let Some(step_mm) = self.slide_mm.filter(|_| self.has_images) {
            writeln!(
                f,
                "next     fingervision calibrate camera {folder}/frames --step-mm {step_mm} --profile SENSOR.toml --prior distance_mm={}±0.5",
                self.distance_mm
            )?;
        } else if self.has_images && self.frames > 1 {
            writeln!(f, "next     fingervision track {folder}/frames --profile {folder}/profile.toml --out RUN")?;
        }
        Ok(())
    }
}
