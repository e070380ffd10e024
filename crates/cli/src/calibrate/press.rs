//! A press of known depth, recorded or simulated, before it is tracked.

use std::ops::ControlFlow;
use std::path::Path;

use fingervision_calibrate::depth::{DepthFitError, PressFolder};
use fingervision_elastic::GelBlock;
use fingervision_gel::{PressCache, ReadyMade};
use fingervision_image::Frame;
use fingervision_optics::{Camera, CameraParams};
use fingervision_simulation::{SimulatedLocation, SimulatedSource, open};
use fingervision_source::{Options, Source};
use fingervision_touch::Profile;

use crate::failure::Failure;
use crate::output::OutputArgs;

/// A press before it is tracked.
pub(super) struct Press {
    pub(super) name: String,
    /// The depth of each of its images, mm.
    pub(super) depths_mm: Vec<f64>,
    /// The normal force in each of them, N, if it is known.
    pub(super) forces_n: Option<Vec<f64>>,
    pub(super) source: Box<dyn Source>,
    /// The camera and the gel of a simulated press.
    pub(super) sensor: Option<(CameraParams, GelBlock)>,
}

/// Two cameras count as different if they see points of a simulated gel farther apart than this part of the image. The
/// error of a fit to a recording of a board is at most a third of it.
const OTHER_CAMERA: f64 = 0.01;
/// Two cameras count as different if their distances to the gel differ by more than this part, because depth then
/// causes different motion in the image.
const OTHER_DISTANCE: f64 = 0.05;
/// Points of the gel that are compared, along each side.
const POINTS: usize = 5;

impl Press {
    /// Finds a press among folders and scenes; scenes are solved, on a coarse mesh if requested.
    pub(super) fn open(press: &str, draft: bool, output: OutputArgs) -> Result<Self, Failure> {
        let path = Path::new(press);
        if path.is_dir() {
            let PressFolder { name, images, depths_mm, forces_n } = PressFolder::open(path)?;
            let source = open(&images, &Options::default())?;
            return Ok(Self { name, depths_mm, forces_n, source, sensor: simulated_sensor(path) });
        }
        let scene = scene_location(press).ok_or_else(|| {
            let message = format!("{press}: there is no such folder and no such scene");
            Failure::new(message, "give folders of images with their depths, or scenes as simulate --list names them")
        })?;
        let joint = if scene.contains('?') { "&" } else { "?" };
        let scene = if draft { format!("{scene}{joint}draft") } else { scene };
        Self::simulated(&scene, output)
    }

    /// Passes the images to a recorder, which `make` creates for their size, px, and whether they have colour, until
    /// `push` returns that no more are needed.
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
        let mut recorder = make(&self, self.source.size(), self.source.tracks_in_colour(&first.pixels))?;
        let mut frame = Some(first);
        while let Some(image) = frame {
            bar.inc(1);
            let needs_more = push(&mut recorder, &image)?;
            frame = if needs_more { self.source.next_frame()? } else { None };
        }
        bar.finish_and_clear();
        Ok(recorder)
    }

    /// A press that is solved, or taken from the cache.
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
        let sensor = Some((scene.camera(), scene.gel));
        Ok(Self { name: scene.name, depths_mm, forces_n: Some(forces_n), source: Box::new(source), sensor })
    }

    /// The largest distance, px, between points of the gel as seen by the profile's camera and by that of a simulated
    /// press, if it is larger than the error of a fit; none for a recording, whose camera is not known.
    pub(super) fn camera_mismatch_px(&self, profile: &Profile) -> Option<f64> {
        let (params, gel) = self.sensor?;
        let cameras = [Camera::new(&params).ok()?, Camera::new(&profile.camera?).ok()?];
        let (width, height) = self.source.size();
        let at = |index: usize, size_mm: f64| size_mm * (index as f64 / (POINTS - 1) as f64 - 0.5);
        let points = (0..POINTS * POINTS).map(|i| [at(i % POINTS, gel.size_mm[0]), at(i / POINTS, gel.size_mm[1])]);
        let is_seen = |[x, y]: [f64; 2]| (0.0..width as f64).contains(&x) && (0.0..height as f64).contains(&y);
        let apart = points.filter_map(|[x, y]| {
            // On the surface and pressed in: a difference that changes with depth is a difference in distance.
            let apart = [0.0, 0.1 * gel.thickness_mm].map(|z| {
                let [a, b] = cameras.each_ref().map(|camera| camera.project([x, y, z]));
                let (a, b) = (a.filter(|&a| is_seen(a))?, b?);
                Some((a[0] - b[0]).hypot(a[1] - b[1]))
            });
            apart.into_iter().flatten().reduce(f64::max)
        });
        let apart_px = apart.fold(0.0, f64::max);
        let [a, b] = cameras.each_ref().map(|camera| camera.position_mm()[2]);
        let is_other = apart_px > OTHER_CAMERA * width as f64 || (a / b - 1.0).abs() > OTHER_DISTANCE;
        is_other.then_some(apart_px)
    }
}

/// The location of a scene that is given by its location or its name.
pub(super) fn scene_location(recording: &str) -> Option<String> {
    if recording.starts_with("sim:") {
        return Some(recording.into());
    }
    ReadyMade::find(recording).map(|_| format!("sim:{recording}"))
}

/// The camera and the gel of a press written by `simulate`, which writes its profile beside the images.
fn simulated_sensor(folder: &Path) -> Option<(CameraParams, GelBlock)> {
    let profile = Profile::load(&folder.join("profile.toml")).ok().filter(|_| folder.join("scene.toml").is_file())?;
    Some((profile.camera?, profile.gel?))
}
