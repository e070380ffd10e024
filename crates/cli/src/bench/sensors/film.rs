//! The frames that the sensors send, coded as a camera codes them.

use std::ops::ControlFlow;

use fingervision_gel::{PressCache, Scene, Simulation};
use fingervision_image::{Frame, Pixels};
use fingervision_pipeline::Replay;
use fingervision_simulation::simulated_profile;
use fingervision_source::{CameraCoding, CameraLayout, Options};
use fingervision_touch::{ElasticMode, Profile};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use super::SensorsArgs;
use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::place::{Place, recorded};
use crate::profile_args::ProfileArgs;

/// The ready-made press that is played.
const SCENE: &str = "sphere";
/// The gel of the ready-made press fills the width of images of this many columns at a focal length of 400 px.
const COLUMNS: f64 = 480.0;
const FOCAL_LENGTH_PX: f64 = 400.0;
/// Most frames of a recording that are kept.
const MOST_FRAMES: usize = 300;

/// Coded frames and their sensor.
pub(super) struct Film {
    pub(super) profile: Profile,
    pub(super) description: String,
    pub(super) layout: CameraLayout,
    frames: Vec<Vec<u8>>,
}

impl Film {
    /// Renders the press, or reads the recording, and codes its frames.
    pub(super) fn make(wanted: &SensorsArgs, profile: &ProfileArgs, output: OutputArgs) -> Result<Self, Failure> {
        let Some(recording) = &wanted.recording else { return Self::render(wanted, profile, output) };
        let (own, mut source) = match Place::of(recording)? {
            Place::Camera(_) => {
                let message = format!("{} is a camera, whose frames cannot be repeated", recording.display());
                return Err(Failure::new(message, "record it first: fingervision record SOURCE FILE.mcap"));
            }
            Place::Recording(path, sensor) => recorded(&path, sensor.as_deref())?,
            Place::Simulated(location) => {
                let own = simulated_profile(&location.scene()?);
                (own, crate::place::solve(&location, Options::default(), output)?)
            }
            Place::File(path) => (Profile::default(), fingervision_simulation::open(&path, &Options::default())?),
        };
        let description = source.description();
        let mut frames = Vec::new();
        while let Some(frame) = source.next_frame()? {
            frames.push(coded(&frame, wanted.quality)?);
            if frames.len() == MOST_FRAMES {
                break;
            }
        }
        let profile = profile.load_or(live(own))?;
        Ok(Self { profile, description, layout: layout(source.size()), frames })
    }

    fn render(wanted: &SensorsArgs, profile: &ProfileArgs, output: OutputArgs) -> Result<Self, Failure> {
        let scene = scene(wanted.size)?;
        let profile = profile.load_or(live(simulated_profile(&scene)))?;
        let mut simulation = Simulation::new(&scene)?;
        let count = scene.motion.frames as u64;
        let bar = output.progress("solving", Some(count));
        simulation.solve(&PressCache::standard(), &mut |frames| {
            bar.set_position(frames as u64);
            ControlFlow::Continue(())
        })?;
        bar.finish_and_clear();
        let bar = output.progress("coding", Some(count));
        let mut frames = Vec::new();
        for index in 0..simulation.states().len() {
            let pixels = simulation.frame(index)?.clone();
            frames.push(coded(&Frame { sequence: index as u64, capture_time_s: 0.0, pixels }, wanted.quality)?);
            bar.inc(1);
        }
        bar.finish_and_clear();
        let description = format!("the simulated press \"{SCENE}\", a draft mesh");
        Ok(Self { profile, description, layout: layout(wanted.size), frames })
    }

    /// As many frames as last this long, to be played.
    pub(super) fn replay(&self, frames_per_second: f64, seconds: f64) -> Replay {
        let count = 1 + (seconds * frames_per_second).round() as u64;
        Replay::new(self.frames.clone(), self.layout, frames_per_second, count)
    }

    /// Mean length of a coded frame, bytes.
    pub(super) fn frame_bytes(&self) -> f64 {
        self.frames.iter().map(Vec::len).sum::<usize>() as f64 / self.frames.len().max(1) as f64
    }
}

/// The press as a camera with this many pixels sees it; the gel is as wide as the image.
fn scene((width, height): (usize, usize)) -> Result<Scene, Failure> {
    let mut scene = Scene::find(SCENE)?;
    scene.make_draft();
    (scene.render.width, scene.render.height) = (width, height);
    scene.camera.focal_length_px = [FOCAL_LENGTH_PX * width.max(height) as f64 / COLUMNS; 2];
    Ok(scene)
}

fn live(mut profile: Profile) -> Profile {
    profile.elastic.mode = ElasticMode::Live;
    profile
}

fn layout((width, height): (usize, usize)) -> CameraLayout {
    CameraLayout { coding: CameraCoding::MotionJpeg, width, height, row_bytes: 0 }
}

/// A frame as JPEG with chroma halved across, as USB cameras send it.
fn coded(frame: &Frame, quality: u8) -> Result<Vec<u8>, Failure> {
    let (width, height) = frame.pixels.size();
    let size = [width, height].map(u16::try_from);
    let too_large = || Failure::new(format!("JPEG pictures of {width}x{height} px do not exist"), "use smaller frames");
    let [Ok(columns), Ok(rows)] = size else { return Err(too_large()) };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(SamplingFactor::F_2_1);
    let done = if let Pixels::Rgb8(image) = &frame.pixels {
        encoder.encode(image.values().as_flattened(), columns, rows, ColorType::Rgb)
    } else {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let levels = places.map(|(x, y)| frame.pixels.levels(x, y).map(|level| level.round() as u8));
        if frame.pixels.is_colour() {
            encoder.encode(&levels.flatten().collect::<Vec<u8>>(), columns, rows, ColorType::Rgb)
        } else {
            encoder.encode(&levels.map(|[grey, _, _]| grey).collect::<Vec<u8>>(), columns, rows, ColorType::Luma)
        }
    };
    done.map_err(|error| {
        Failure::new(format!("frame {} cannot be coded: {error}", frame.sequence), "use other frames")
    })?;
    Ok(bytes)
}
