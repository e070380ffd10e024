//! A press of known depth, recorded or simulated, before it is tracked.

use std::ops::ControlFlow;
use std::path::Path;

use fingervision_calibrate::depth::{DepthFitError, PressFolder};
use fingervision_gel::{PressCache, ReadyMade};
use fingervision_image::Frame;
use fingervision_source::{Options, SimulatedLocation, SimulatedSource, Source, open};

use crate::failure::Failure;
use crate::output::OutputArgs;

/// A press before it is tracked.
pub(super) struct Press {
    pub(super) name: String,
    /// The depth of each of its images, mm.
    pub(super) depths_mm: Vec<f64>,
    /// The normal force in each of them, N, where it is known.
    pub(super) forces_n: Option<Vec<f64>>,
    pub(super) source: Box<dyn Source>,
}

impl Press {
    /// Finds a press among folders and scenes; scenes are solved, on a coarse mesh where asked for.
    pub(super) fn open(press: &str, draft: bool, output: OutputArgs) -> Result<Self, Failure> {
        let path = Path::new(press);
        if path.is_dir() {
            let PressFolder { name, images, depths_mm, forces_n } = PressFolder::open(path)?;
            return Ok(Self { name, depths_mm, forces_n, source: open(&images, &Options::default())? });
        }
        let is_location = press.starts_with("sim:");
        if !is_location && ReadyMade::find(press).is_none() {
            let message = format!("{press}: there is no such folder and no such scene");
            return Err(Failure::new(
                message,
                "give folders of images with their depths, or scenes as simulate --list names them",
            ));
        }
        let scene = if is_location { press.to_owned() } else { format!("sim:{press}") };
        let joint = if scene.contains('?') { "&" } else { "?" };
        let scene = if draft { format!("{scene}{joint}draft") } else { scene };
        Self::simulated(&scene, output)
    }

    /// Hands the images to a recorder, which `make` makes for their size, px, and whether they have colour, until `push` says
    /// that it needs no more.
    pub(super) fn record<R, E>(
        mut self,
        output: OutputArgs,
        make: impl FnOnce(&Self, (usize, usize), bool) -> Result<R, E>,
        mut push: impl FnMut(&mut R, &Frame) -> Result<bool, E>,
    ) -> Result<R, Failure>
    where
        Failure: From<E>,
    {
        let depths = self.depths_mm.len() as u64;
        let miscounted = |press: String, images: u64| DepthFitError::Count { press, images, depths };
        let count = self.source.frame_count();
        if let Some(images) = count.filter(|&count| count != depths) {
            return Err(miscounted(self.name, images).into());
        }
        let bar = output.progress("tracking", count);
        let Some(first) = self.source.next_frame()? else { return Err(miscounted(self.name, 0).into()) };
        let mut recorder = make(&self, self.source.size(), first.pixels.is_colour())?;
        let mut frame = Some(first);
        while let Some(image) = frame {
            bar.inc(1);
            let needs_more = push(&mut recorder, &image)?;
            frame = if needs_more { self.source.next_frame()? } else { None };
        }
        bar.finish_and_clear();
        Ok(recorder)
    }

    /// A press that is solved, or was before.
    fn simulated(location: &str, output: OutputArgs) -> Result<Self, Failure> {
        let Some(location) = SimulatedLocation::of(Path::new(location))? else {
            return Err(Failure::new(format!("{location}: it names no scene"), "scenes are listed by simulate --list"));
        };
        let scene = location.scene()?;
        let bar = output.progress("solving", Some(scene.motion.frames as u64));
        let mut progress = |frames: usize| {
            bar.set_position(frames as u64);
            ControlFlow::Continue(())
        };
        let source = SimulatedSource::open(&location, &Options::default(), &PressCache::standard(), &mut progress)?;
        bar.finish_and_clear();
        let depths_mm = scene.motion.poses().iter().map(|pose| pose.depth_mm).collect();
        let forces_n: Vec<f64> = source.forces_n().map(|[_, _, normal]| normal).collect();
        Ok(Self { name: scene.name, depths_mm, forces_n: Some(forces_n), source: Box::new(source) })
    }
}
