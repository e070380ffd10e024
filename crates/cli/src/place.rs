//! The place from which a command reads frames: a camera, a simulated scene, a recording, a video or a folder.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fingervision_camera::CameraSource;
use fingervision_gel::PressCache;
use fingervision_recording::{Recording, RecordingSource};
use fingervision_simulation::SimulatedLocation;
use fingervision_source::{Options, Source, SourceError};
use fingervision_touch::Profile;

use crate::failure::Failure;
use crate::output::OutputArgs;

/// The prefix of a camera's id; alone it means the only camera that is plugged in.
const CAMERA: &str = "camera";

/// The text between a recording and the name of a sensor in it.
pub(crate) const SENSOR: &str = "?sensor=";

/// A place from which frames are read.
#[derive(Debug, PartialEq)]
#[non_exhaustive]
pub enum Place {
    /// A camera, by its id, serial number or name; absent: the one that the profile names, or else the only one.
    Camera(Option<String>),
    /// A simulated scene.
    Simulated(SimulatedLocation),
    /// A recording, and the name of a sensor in it.
    Recording(PathBuf, Option<String>),
    /// A video or a folder.
    File(PathBuf),
}

impl Place {
    /// The place that a user names: `camera`, `camera:ID`, `/dev/v4l/by-id/…`, `sim:SCENE`, a path, `FILE.mcap?sensor=NAME`.
    ///
    /// # Errors
    ///
    /// As [`SimulatedLocation::of`].
    pub fn of(location: &Path) -> Result<Self, SourceError> {
        if let Some(scene) = SimulatedLocation::of(location)? {
            return Ok(Self::Simulated(scene));
        }
        let text = location.to_str().unwrap_or_default();
        if text.starts_with("/dev/video") || text.starts_with("/dev/v4l/") {
            return Ok(Self::Camera(Some(text.into())));
        }
        if Recording::is_at(location) {
            return Ok(Self::Recording(location.into(), None));
        }
        if let Some((file, sensor)) = text.rsplit_once(SENSOR).filter(|(file, _)| Recording::is_at(Path::new(file))) {
            return Ok(Self::Recording(file.into(), Some(sensor.into())));
        }
        Ok(match text.strip_prefix(CAMERA) {
            // If there is a folder of this name, it is used.
            Some("") if location.exists() => Self::File(location.into()),
            Some("" | ":") => Self::Camera(None),
            Some(rest) if rest.starts_with(':') => Self::Camera(Some(rest[1..].into())),
            _ => Self::File(location.into()),
        })
    }
}

impl Place {
    /// The frames of this place; a camera captures as the profile's `[capture]` says.
    pub(crate) fn source(&self, profile: &Profile, output: OutputArgs) -> Result<Box<dyn Source>, Failure> {
        Ok(match self {
            Self::Camera(id) => {
                let camera = fingervision_camera::open(profile.capture_from(id.as_deref()))?;
                Box::new(CameraSource::new(camera))
            }
            Self::Simulated(location) => solve(location, Options::default(), output)?,
            Self::Recording(path, sensor) => recorded(path, sensor.as_deref())?.1,
            Self::File(path) => fingervision_simulation::open(path, &Options::default())?,
        })
    }
}

/// The frames of a sensor of a recording, and the profile that is recorded with them.
pub(crate) fn recorded(path: &Path, sensor: Option<&str>) -> Result<(Profile, Box<dyn Source>), Failure> {
    let recording = Recording::open(path)?;
    let sensor = recording.sensor(sensor)?;
    let profile = recording.profile(sensor)?.unwrap_or_default();
    Ok((profile, Box::new(RecordingSource::open(recording, sensor)?)))
}

/// Solves a simulated press, with a bar, or takes it from the cache.
pub(crate) fn solve(
    location: &SimulatedLocation,
    options: Options,
    output: OutputArgs,
) -> Result<Box<dyn Source>, Failure> {
    let frames = location.scene()?.motion.frames as u64;
    let bar = output.progress("solving", Some(frames));
    let mut is_begun = false;
    let mut progress = |solved: usize| {
        // Not called if the solution is in the cache.
        if !std::mem::replace(&mut is_begun, true) {
            output.note_without_terminal(&format!("solving {frames} frames of sim:{}", location.scene_name()));
        }
        bar.set_position(solved as u64);
        ControlFlow::Continue(())
    };
    let source = location.open(&options, &PressCache::standard(), &mut progress)?;
    bar.finish_and_clear();
    Ok(source)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_told_apart() {
        let place = |text: &str| Place::of(Path::new(text)).unwrap();
        let camera = |name: Option<&str>| Place::Camera(name.map(Into::into));
        assert_eq!([place("camera"), place("camera:")], [camera(None), camera(None)]);
        assert_eq!(place("camera:SN7"), camera(Some("SN7")));
        assert_eq!(place("/dev/video0"), camera(Some("/dev/video0")));
        assert_eq!(place("cameras/left"), Place::File("cameras/left".into()));
        assert_eq!(place("press.mp4"), Place::File("press.mp4".into()));
        assert!(matches!(place("sim:letter"), Place::Simulated(_)));
    }
}
