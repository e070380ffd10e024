//! Frames of a simulated press, like those of a camera: `sim:circle`, `sim:my/scene.toml?fps=60`.

use std::ops::ControlFlow;
use std::path::Path;

use fingervision_gel::{EarlyEnd, PressCache, Progress, Scene, SceneError, Simulation};
use fingervision_image::Frame;
use fingervision_source::{FrameFormat, FrameTruth, Options, Source, SourceError};

use crate::PressFilm;
use crate::frame::frame_truth;

const PREFIX: &str = "sim:";

/// Opens a simulated scene, `sim:SCENE`, or any source that [`fingervision_source::open`] opens.
///
/// A scene is solved first, which may take minutes; [`SimulatedSource::open`] reports the progress.
///
/// # Errors
///
/// [`SourceError::Rate`] if the options make no sense, [`SourceError::Simulated`] if the scene cannot be, as
/// [`SimulatedLocation::of`], and as [`fingervision_source::open`].
pub fn open(location: impl AsRef<Path>, options: &Options) -> Result<Box<dyn Source>, SourceError> {
    options.validate()?;
    let Some(scene) = SimulatedLocation::of(location.as_ref())? else {
        return fingervision_source::open(location, options);
    };
    scene.open(options, &PressCache::standard(), &mut |_| ControlFlow::Continue(()))
}

/// A simulated press given by a location.
///
/// `sim:SCENE`, where the scene is a ready-made one or a file, then `?` and options separated by `&`: `fps=60` sets the
/// rate, `draft` selects a coarse mesh, `loop` repeats the press, in and out, without end ([`PressFilm`]).
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedLocation {
    /// The whole location.
    location: String,
    /// Name or file of the scene.
    scene: String,
    frames_per_second: Option<f64>,
    is_draft: bool,
    is_repeated: bool,
}

impl SimulatedLocation {
    /// The press at a location; absent if it is something else.
    ///
    /// # Errors
    ///
    /// [`SourceError::NotRead`] for an unknown option, [`SourceError::Option`] and [`SourceError::Rate`] for an invalid
    /// rate.
    pub fn of(location: &Path) -> Result<Option<Self>, SourceError> {
        let Some(location) = location.to_str().filter(|location| location.starts_with(PREFIX)) else { return Ok(None) };
        let rest = &location[PREFIX.len()..];
        let (scene, options) = rest.split_once('?').unwrap_or((rest, ""));
        let (location, scene) = (location.to_owned(), scene.to_owned());
        let mut asked = Self { location, scene, frames_per_second: None, is_draft: false, is_repeated: false };
        for option in options.split('&').filter(|option| !option.is_empty()) {
            match option.split_once('=') {
                Some(("fps", rate)) => {
                    let not_a_number = |_| SourceError::Option { location: asked.location.clone(), value: rate.into() };
                    let frames_per_second = rate.parse().map_err(not_a_number)?;
                    Options { frames_per_second }.validate()?;
                    asked.frames_per_second = Some(frames_per_second);
                }
                None if option == "draft" => asked.is_draft = true,
                None if option == "loop" => asked.is_repeated = true,
                _ => return Err(asked.unknown(option)),
            }
        }
        Ok(Some(asked))
    }

    /// Whether the location contains a rate.
    #[must_use]
    pub fn has_rate(&self) -> bool {
        self.frames_per_second.is_some()
    }

    /// The name or file of the scene.
    #[must_use]
    pub fn scene_name(&self) -> &str {
        &self.scene
    }

    /// The scene of the location.
    ///
    /// # Errors
    ///
    /// [`SourceError::Simulated`] if it is impossible.
    pub fn scene(&self) -> Result<Scene, SourceError> {
        let mut scene = Scene::find(&self.scene).map_err(|error| self.refused(&error))?;
        if self.is_draft {
            scene.make_draft();
        }
        Ok(scene)
    }

    /// Solves the press, or takes it from the cache, and opens it; `progress` gets the state of the solution.
    ///
    /// # Errors
    ///
    /// As [`SimulatedSource::open`].
    pub fn open(
        &self,
        options: &Options,
        cache: &PressCache,
        progress: Progress,
    ) -> Result<Box<dyn Source>, SourceError> {
        let source = SimulatedSource::open(self, options, cache, progress)?;
        if !self.is_repeated {
            return Ok(Box::new(source));
        }
        let options = Options { frames_per_second: source.frames_per_second };
        Ok(Box::new(PressFilm::new(source.simulation, None, &options)?))
    }

    fn unknown(&self, option: &str) -> SourceError {
        let (path, what) = (self.location.clone().into(), format!("the option {option}"));
        SourceError::NotRead {
            path,
            what,
            hint: "a simulated scene takes fps=RATE, draft and loop, separated by &".into(),
        }
    }

    fn refused(&self, error: &SceneError) -> SourceError {
        self.fault(error.to_string(), error.hint())
    }

    fn fault(&self, reason: String, hint: Option<String>) -> SourceError {
        SourceError::Simulated { location: self.location.clone(), reason, hint }
    }
}

/// The camera's frames of a simulated press: every run gives the same bytes.
///
/// A press that cannot be solved to its end gives the frames before that, then the error.
#[derive(Debug)]
pub struct SimulatedSource {
    location: SimulatedLocation,
    simulation: Simulation,
    frames_per_second: f64,
    next: usize,
    /// Why there are fewer frames than in the scene, until it is reported.
    end: Option<EarlyEnd>,
}

impl SimulatedSource {
    /// Sets up and solves the press, or takes it from the cache; `progress` gets the state of the solution.
    ///
    /// # Errors
    ///
    /// [`SourceError::Simulated`] if the scene is impossible, or `progress` stops it.
    pub fn open(
        location: &SimulatedLocation,
        options: &Options,
        cache: &PressCache,
        progress: Progress,
    ) -> Result<Self, SourceError> {
        options.validate()?;
        let refused = |error| location.refused(&error);
        let mut simulation = Simulation::new(&location.scene()?).map_err(refused)?;
        let end = simulation.solve(cache, progress).map_err(refused)?.end.clone();
        if end == Some(EarlyEnd::Stopped) {
            return Err(location.fault(EarlyEnd::Stopped.to_string(), Some("run the command again".into())));
        }
        let frames_per_second = location.frames_per_second.unwrap_or(options.frames_per_second);
        Ok(Self { location: location.clone(), simulation, frames_per_second, next: 0, end })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        self.simulation.scene()
    }

    /// The force of the indenter on the gel `(x, y, z)` in every frame, N.
    pub fn forces_n(&self) -> impl Iterator<Item = [f64; 3]> {
        self.simulation.states().iter().map(|state| state.force_n)
    }
}

impl Source for SimulatedSource {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.next >= self.simulation.states().len() {
            let end = self.end.take().map(|end| self.location.fault(end.to_string(), end.hint()));
            return end.map_or(Ok(None), Err);
        }
        let sequence = self.next as u64;
        let pixels = match self.simulation.frame(self.next) {
            Ok(pixels) => pixels.clone(),
            Err(error) => {
                (self.next, self.end) = (usize::MAX, None);
                return Err(self.location.refused(&error));
            }
        };
        self.next += 1;
        Ok(Some(Frame { sequence, capture_time_s: sequence as f64 / self.frames_per_second, pixels }))
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.simulation.poses().len() as u64)
    }

    fn last_sequence(&self) -> Option<u64> {
        (self.simulation.poses().len() as u64).checked_sub(1)
    }

    fn size(&self) -> (usize, usize) {
        self.simulation.size()
    }

    fn truth(&self) -> Option<FrameTruth> {
        frame_truth(&self.simulation, self.next.checked_sub(1)?)
    }

    fn scene_toml(&self) -> Option<String> {
        Some(self.scene().to_toml())
    }

    fn description(&self) -> String {
        let ((width, height), count, rate) = (self.size(), self.simulation.poses().len(), self.frames_per_second);
        let format = FrameFormat { width, height, is_colour: self.scene().render.colour, bits: 8 };
        format!("{}: {count} images, {format}, nominally {rate} frames per second", self.location.location)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn location(text: &str) -> SimulatedLocation {
        SimulatedLocation::of(Path::new(text)).unwrap().unwrap()
    }

    #[test]
    fn options_stand_behind_the_scene() {
        assert_eq!(SimulatedLocation::of(Path::new("press")).unwrap(), None);
        let plain = location("sim:letter");
        assert_eq!((plain.scene.as_str(), plain.frames_per_second, plain.is_draft), ("letter", None, false));
        let asked = location("sim:my/scene.toml?fps=62.5&draft");
        assert_eq!(asked.scene, "my/scene.toml");
        assert_eq!((asked.frames_per_second, asked.is_draft), (Some(62.5), true));
    }

    #[test]
    fn what_is_no_option_is_named() {
        let refusal = |text: &str| SimulatedLocation::of(Path::new(text)).unwrap_err().to_string();
        assert_eq!(refusal("sim:letter?frames=3"), "sim:letter?frames=3: the option frames=3 is not supported");
        assert_eq!(refusal("sim:letter?fps=fast"), "sim:letter?fps=fast: fast is not a number of frames per second");
        assert_eq!(refusal("sim:letter?fps=nan"), "NaN frames per second: a rate is a number from 1e-6 to 1e6");
        assert!(refusal("sim:letter?fps=1e-100").ends_with("a rate is a number from 1e-6 to 1e6"));
        assert!(refusal("sim:letter?fps=0").starts_with("0 frames per second"));
    }

    #[test]
    fn frames_come_in_order_and_in_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let scene = "[motion]\nkind = 'rigid'\nframes = 5\n[render]\nwidth = 40\nheight = 30";
        std::fs::write(&path, scene).unwrap();
        let location = location(&format!("sim:{}?fps=50", path.display()));
        let open = || {
            let progress: Progress = &mut |_| ControlFlow::Continue(());
            SimulatedSource::open(&location, &Options::default(), &PressCache::OFF, progress).unwrap()
        };
        let mut source = open();
        assert_eq!((source.frame_count(), source.size()), (Some(5), (40, 30)));
        assert!(
            source
                .description()
                .ends_with("scene.toml?fps=50: 5 images, 40x30 px 8-bit colour, nominally 50 frames per second")
        );
        let frames: Vec<Frame> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
        let times: Vec<f64> = frames.iter().map(|frame| frame.capture_time_s).collect();
        assert_eq!(times, [0.0, 0.02, 0.04, 0.06, 0.08]);
        assert_eq!(frames.iter().map(|frame| frame.sequence).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        let mut again = open();
        assert!(std::iter::from_fn(|| again.next_frame().unwrap()).eq(frames));
    }

    #[test]
    fn a_scene_that_is_not_there_is_named() {
        let error = location("sim:leter").scene().unwrap_err();
        assert!(error.to_string().starts_with("sim:leter: no scene leter"), "{error}");
        assert_eq!(error.hint().unwrap(), "did you mean letter?");
        let error = open("sim:press", &Options::default()).err().unwrap();
        assert_eq!(error.to_string(), "sim:press: no scene press: it is neither a file nor a ready-made scene");
        assert!(error.hint().is_some());
    }
}
