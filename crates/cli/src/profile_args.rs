//! The profile that a command uses: from a file, with single values set on the command line.

use std::path::PathBuf;

use fingervision_touch::{Fields, Profile, Remark, Weight};

use crate::failure::Failure;
use crate::output::OutputArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct ProfileArgs {
    /// The profile of the sensor, as in sensor.toml, or the run.toml of an earlier run
    ///
    /// `fingervision profile new` writes one to start from.
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
    /// Set one value of the profile, as in `flow.noise_levels=1.5`; may be repeated
    ///
    /// `fingervision profile show FILE` and the run.toml of any run list the keys with their values. A value that has
    /// no effect with the other settings is refused.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
}

/// Notes the values of a profile with which the numbers would be wrong or may be; `profile check` lists them, too.
pub(crate) fn note_doubts(profile: &Profile, frame_size: (usize, usize), output: OutputArgs) {
    for Remark { weight, message, hint, .. } in profile.review(Some(frame_size)).remarks {
        let doubt = match weight {
            Weight::Fault => "the profile is faulty, so the numbers may be wrong",
            Weight::Warning => "the profile is unusual; if that is not intended, the numbers are wrong",
            Weight::Missing => continue,
        };
        output.note(&format!("{doubt}: {message}: {hint}"));
    }
}

impl ProfileArgs {
    /// The paths of the values that were set.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.assignments.iter().map(|(key, _)| key.as_str())
    }

    /// Whether no profile and no value was given.
    pub(crate) fn is_absent(&self) -> bool {
        self.profile.is_none() && self.assignments.is_empty()
    }

    /// Refuses values that were set and have no effect on these fields; notes those of the profile's file. The table
    /// `[capture]` has an effect if the frames come from a camera.
    pub(crate) fn expect_effect(
        &self,
        profile: &Profile,
        fields: Fields,
        is_camera: bool,
        output: OutputArgs,
    ) -> Result<(), Failure> {
        let keys = self.keys().filter(|key| !(is_camera && key.starts_with("capture.")));
        profile.expect_effect(keys, fields)?;
        for key in self.profile.iter().flat_map(|_| changed_keys(profile)) {
            if let Some(idle) = profile.no_effect(&key, fields) {
                output.note(&idle.to_string());
            }
        }
        Ok(())
    }

    /// The profile in force.
    pub(crate) fn load(&self) -> Result<Profile, Failure> {
        self.load_or(Profile::default())
    }

    /// The profile in force; `fallback` if no file is named.
    pub(crate) fn load_or(&self, fallback: Profile) -> Result<Profile, Failure> {
        let mut profile = self.profile.as_deref().map_or(Ok(fallback), Profile::load)?;
        profile.set_all(self.assignments.iter().map(|(key, value)| (key.as_str(), value.as_str())))?;
        Ok(profile)
    }
}

/// The paths of the algorithms' parameters that differ from their defaults.
fn changed_keys(profile: &Profile) -> Vec<String> {
    let table = |profile: &Profile| toml::Table::try_from(profile).unwrap_or_default();
    let (profile, defaults) = (table(profile), table(&Profile::default()));
    let mut keys = Vec::new();
    for name in ["flow", "references", "elastic"] {
        if let Some(value) = profile.get(name) {
            add_changed(name, value, defaults.get(name), &mut keys);
        }
    }
    keys
}

fn add_changed(path: &str, value: &toml::Value, default: Option<&toml::Value>, keys: &mut Vec<String>) {
    match value.as_table() {
        Some(table) => table.iter().for_each(|(key, value)| {
            add_changed(&format!("{path}.{key}"), value, default.and_then(|default| default.get(key)), keys);
        }),
        None if default != Some(value) => keys.push(path.into()),
        None => {}
    }
}

/// Splits `KEY=VALUE`.
pub(crate) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().into(), value.trim().into())),
        _ => Err("expected KEY=VALUE, as in flow.noise_levels=1.5".into()),
    }
}
