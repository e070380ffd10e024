//! Opens the sensors that a live command names.

use std::path::{Path, PathBuf};

use fingervision_pipeline::{Input, Pace, Sensor};
use fingervision_simulation::simulated_profile;
use fingervision_source::Options;
use fingervision_touch::{DepthMethod, ElasticMode, Fields, Profile};

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::place::{Place, recorded, solve};
use crate::profile_args::{assignment, note_doubts};

#[derive(Debug, clap::Args)]
pub(crate) struct SensorArgs {
    /// What to track: a camera, a video, a folder of images, a recording or a simulated scene; give several for several
    /// sensors
    ///
    /// `camera` is the only camera that is plugged in, camera:ID selects one of several: `fingervision doctor` lists
    /// the ids. A scene is sim:NAME, as in sim:letter?loop, which repeats the press without end. Without a source, the
    /// cameras that the profiles name are tracked, or the only camera.
    #[arg(value_name = "SOURCE")]
    pub(crate) sources: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) options: SensorOptions,
}

#[derive(Debug, Clone, clap::Args)]
pub(crate) struct SensorOptions {
    /// The profile of the sensor, as in sensor.toml; for several sensors give one for each, in the same order, or one
    /// for all
    #[arg(long = "profile", value_name = "FILE")]
    profiles: Vec<PathBuf>,
    /// Set one value of all profiles, as in `capture.frames_per_second=90`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
    /// Compute depth exactly as `track` does; without it depth is computed faster, with an error about a tenth larger
    ///
    /// The option sets `elastic.mode` in the profile. Recordings contain the profile, so tracking them gives the same
    /// values.
    #[arg(long)]
    exact: bool,
}

/// A sensor that is named but not opened yet.
#[derive(Debug)]
struct Named {
    place: Place,
    profile: Option<PathBuf>,
}

impl SensorArgs {
    /// Opens all sensors: every one has delivered a frame, and its profile fits.
    pub(crate) fn open(&self, pace: Pace, output: OutputArgs) -> Result<Vec<Sensor>, Failure> {
        let mut sensors: Vec<Sensor> = Vec::new();
        let all = self.named()?;
        // A wrong name is refused before the presses of the others are solved.
        for named in &all {
            if let Place::Simulated(location) = &named.place {
                location.scene()?;
            }
        }
        for named in all {
            let taken: Vec<&str> = sensors.iter().map(|sensor| sensor.handle().name()).collect();
            let sensor = self.open_one(&named, &taken, pace, output)?;
            for remark in sensor.remarks() {
                output.note(&format!("{}: {remark}", sensor.handle().name()));
            }
            note_doubts(sensor.handle().profile(), sensor.handle().frame_size(), output);
            sensors.push(sensor);
        }
        Ok(sensors)
    }

    /// Pairs sources with profiles.
    fn named(&self) -> Result<Vec<Named>, Failure> {
        let all = &self.options.profiles;
        let (sources, profiles) = (self.sources.len(), all.len());
        if sources == 0 {
            let of_profile = |profile: &PathBuf| Named { place: Place::Camera(None), profile: Some(profile.clone()) };
            let only = || vec![Named { place: Place::Camera(None), profile: None }];
            return Ok(if profiles == 0 { only() } else { all.iter().map(of_profile).collect() });
        }
        if profiles > 1 && profiles != sources {
            let message = format!("{sources} sources and {profiles} profiles");
            return Err(Failure::new(message, "name one profile for each source, in the same order, or one for all"));
        }
        let named = |(index, source): (usize, &PathBuf)| {
            let profile = all.get(index).or(all.first()).cloned();
            Ok(Named { place: Place::of(source)?, profile })
        };
        self.sources.iter().enumerate().map(named).collect()
    }

    /// Whether one of the sources is a camera.
    pub(crate) fn has_camera(&self) -> Result<bool, Failure> {
        Ok(self.named()?.iter().any(|named| matches!(named.place, Place::Camera(_))))
    }

    fn open_one(&self, named: &Named, taken: &[&str], pace: Pace, output: OutputArgs) -> Result<Sensor, Failure> {
        let file = named.profile.as_deref();
        let source = |source| Input::source(source, pace);
        let (profile, input) = match &named.place {
            Place::Camera(id) => {
                let profile = self.options.profile(file, None, Pace::Recorded)?;
                let camera = fingervision_camera::open(profile.capture_from(id.as_deref()))?;
                (profile, Input::camera(camera))
            }
            Place::Simulated(location) => {
                let profile = self.options.profile(file, Some(simulated_profile(&location.scene()?)), pace)?;
                (profile, source(solve(location, Options::default(), output)?))
            }
            Place::Recording(path, sensor) => {
                let (own, frames) = recorded(path, sensor.as_deref())?;
                (self.options.profile(file, Some(own), pace)?, source(frames))
            }
            Place::File(path) => {
                let profile = self.options.profile(file, None, pace)?;
                (profile, source(fingervision_simulation::open(path, &Options::default())?))
            }
        };
        let name = free_name(&name(&named.place, &profile), taken);
        let fields = fields(&profile);
        Ok(Sensor::open(&name, profile, input, fields)?)
    }
}

impl SensorOptions {
    /// The profile of a sensor. Frames in real time leave no time for exact depth.
    fn profile(&self, file: Option<&Path>, own: Option<Profile>, pace: Pace) -> Result<Profile, Failure> {
        let fallback = own.unwrap_or_default();
        let mut profile = file.map_or(Ok(fallback), Profile::load)?;
        if !self.exact && pace == Pace::Recorded {
            profile.elastic.mode = ElasticMode::Live;
        }
        profile.set_all(self.assignments.iter().map(|(key, value)| (key.as_str(), value.as_str())))?;
        Ok(profile)
    }
}

/// All fields that a page can show.
pub(crate) fn fields(profile: &Profile) -> Fields {
    let is_elastic = profile.depth_method() == DepthMethod::Elastic;
    let has_traction = is_elastic && profile.gel.is_some_and(|gel| gel.youngs_modulus_mpa.is_some());
    Fields { density: !is_elastic, depth: true, displacement: is_elastic, traction: has_traction }
}

/// A short name for a sensor: that of its profile, or of its source.
fn name(place: &Place, profile: &Profile) -> String {
    if profile.name != Profile::default().name && !matches!(place, Place::Simulated(_)) {
        return profile.name.clone();
    }
    match place {
        Place::Camera(Some(id)) => id.clone(),
        Place::Camera(None) => "camera".into(),
        Place::Simulated(location) => location.scene_name().into(),
        Place::Recording(_, Some(sensor)) => sensor.clone(),
        Place::Recording(path, None) | Place::File(path) => {
            path.file_stem().map_or_else(|| "recording".into(), |name| name.display().to_string())
        }
    }
}

/// The name, followed by a number if another sensor has the same name.
fn free_name(name: &str, taken: &[&str]) -> String {
    let numbered = (2..).map(|number| format!("{name} {number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken.contains(&name.as_str())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(sources: &[&str], profiles: &[&str]) -> SensorArgs {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect();
        let options = SensorOptions { profiles: paths(profiles), assignments: Vec::new(), exact: false };
        SensorArgs { sources: paths(sources), options }
    }

    #[test]
    fn sources_and_profiles_are_paired() {
        let pairs = |sources: &[&str], profiles: &[&str]| -> Vec<(Place, Option<PathBuf>)> {
            args(sources, profiles).named().unwrap().into_iter().map(|named| (named.place, named.profile)).collect()
        };
        assert_eq!(pairs(&[], &[]), [(Place::Camera(None), None)]);
        assert_eq!(pairs(&[], &["a", "b"])[1], (Place::Camera(None), Some("b".into())));
        assert_eq!(pairs(&["x", "y"], &["a"])[1], (Place::File("y".into()), Some("a".into())));
        assert_eq!(pairs(&["x", "y"], &["a", "b"])[1], (Place::File("y".into()), Some("b".into())));
        let error = args(&["x"], &["a", "b"]).named().unwrap_err();
        assert_eq!(error.to_string(), "1 sources and 2 profiles");
    }

    #[test]
    fn no_two_sensors_have_the_same_name() {
        assert_eq!(free_name("left", &["right"]), "left");
        assert_eq!(free_name("left", &["left", "left 2"]), "left 3");
    }
}
