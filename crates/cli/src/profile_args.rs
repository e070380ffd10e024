//! The profile that a command runs with: from a file, with single values set on the command line.

use std::path::PathBuf;

use fingervision_touch::Profile;

use crate::failure::Failure;

#[derive(Debug, clap::Args)]
pub(crate) struct ProfileArgs {
    /// The file that describes the sensor; without it the whole image is tracked, uncalibrated
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
    /// Set one value of the profile, as in `flow.finest_level=1`; may be repeated
    ///
    /// The run.toml of any run lists the keys with their values.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = assignment)]
    assignments: Vec<(String, String)>,
}

impl ProfileArgs {
    /// Whether nothing was said of the profile.
    pub(crate) fn is_absent(&self) -> bool {
        self.profile.is_none() && self.assignments.is_empty()
    }

    /// The profile in force.
    pub(crate) fn load(&self) -> Result<Profile, Failure> {
        self.load_or(Profile::default())
    }

    /// The profile in force, made from `fallback` where no file is named.
    pub(crate) fn load_or(&self, fallback: Profile) -> Result<Profile, Failure> {
        let mut profile = self.profile.as_deref().map_or(Ok(fallback), Profile::load)?;
        profile.set_all(self.assignments.iter().map(|(key, value)| (key.as_str(), value.as_str())))?;
        Ok(profile)
    }
}

/// Takes `KEY=VALUE` apart.
pub(crate) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().into(), value.trim().into())),
        _ => Err("it takes KEY=VALUE, as in flow.finest_level=1".into()),
    }
}
