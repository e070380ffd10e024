//! The profile's file: a calibration changes its own tables and leaves everything else unchanged.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use fingervision_settings::write_file;
use fingervision_touch::{Profile, ProfileError};
use serde::Serialize;
use thiserror::Error;
use toml_edit::{DocumentMut, Item, TableLike, Value};

/// Significant digits that are written: more than any calibration gives.
const DIGITS: i32 = 9;

/// Why a profile was not changed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ProfileFileError {
    /// The file cannot be read, or it or the result is not a valid profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// The file is the record of a run, which must not be changed.
    #[error("{} is the record of a run, not the profile of a sensor", path.display())]
    RunRecord {
        /// The file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("cannot write the profile {}: {}", path.display(), why_not_written(*kind))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's message.
        kind: io::ErrorKind,
    },
}

impl ProfileFileError {
    /// What to do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Profile(error) => error.hint(),
            Self::RunRecord { path } => {
                let path = path.display();
                Some(format!("extract its profile: fingervision profile show {path} --toml > sensor.toml"))
            }
            Self::Write { kind: io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded, .. } => {
                Some("free some space or choose another disk".into())
            }
            Self::Write { .. } => Some("choose a writable file in an existing folder".into()),
        }
    }
}

/// Writes one table to a profile's file, as in `camera` or `depth.density`; a file that does not exist is created.
///
/// Existing keys of the table take the new values, others are added; comments, order and everything outside the table do
/// not change. The file is replaced as a whole or not at all.
///
/// # Errors
///
/// [`ProfileFileError`]; the file is then unchanged.
pub fn update_profile(path: &Path, table: &str, values: &impl Serialize) -> Result<(), ProfileFileError> {
    let text = match fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
        _ => {
            load_to_update(path)?;
            fs::read_to_string(path).map_err(|error| refused(path, &error))?
        }
    };
    let text = with_table(&text, table, values);
    Profile::from_toml(&text)?;
    write_profile(path, &text)
}

/// Writes a profile's file as a whole or not at all.
///
/// # Errors
///
/// [`ProfileFileError::Write`]; a file that was there is then unchanged.
pub fn write_profile(path: &Path, text: &str) -> Result<(), ProfileFileError> {
    write_file(path, text.as_bytes()).map_err(|error| refused(path, &error))
}

/// The profile of a sensor that is to be calibrated further, before anything is measured.
///
/// # Errors
///
/// [`ProfileFileError`] if the file is not a profile, or is the record of a run.
pub fn load_to_update(path: &Path) -> Result<Profile, ProfileFileError> {
    let profile = Profile::load(path)?;
    let text = fs::read_to_string(path).map_err(|error| refused(path, &error))?;
    if Profile::is_run_record(&text) {
        return Err(ProfileFileError::RunRecord { path: path.to_owned() });
    }
    Ok(profile)
}

fn why_not_written(kind: io::ErrorKind) -> String {
    match kind {
        io::ErrorKind::NotFound => "there is no such folder".into(),
        _ => kind.to_string(),
    }
}

fn refused(path: &Path, error: &io::Error) -> ProfileFileError {
    ProfileFileError::Write { path: path.to_owned(), kind: error.kind() }
}

/// The text of a profile with some values of one table replaced.
///
/// # Panics
///
/// If the text is not TOML, or the values do not form a table.
fn with_table(text: &str, path: &str, values: &impl Serialize) -> String {
    let mut document: DocumentMut = text.parse().expect("the profile was read before");
    let values = toml::to_string(values).expect("a calibration's values make a table");
    let values: DocumentMut = values.parse().expect("it was just printed");
    let mut table: &mut dyn TableLike = document.as_table_mut();
    let steps: Vec<&str> = path.split('.').collect();
    for (depth, step) in steps.iter().enumerate() {
        let is_last = depth + 1 == steps.len();
        let made = || {
            let mut made = toml_edit::Table::new();
            // A table that only contains another one needs no heading.
            made.set_implicit(!is_last);
            Item::Table(made)
        };
        table = table.entry(step).or_insert_with(made).as_table_like_mut().expect("a profile's tables are tables");
    }
    for (key, item) in values.iter() {
        let mut value = item.clone().into_value().expect("every item of a table is a value");
        round(&mut value);
        value.decor_mut().clear();
        put(table, key, value);
    }
    document.to_string()
}

/// Sets one value; the comment after the old value stays.
fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

fn round(value: &mut Value) {
    match value {
        Value::Float(number) => {
            let exact = *number.value();
            if exact != 0.0 && exact.is_finite() {
                let scale = 10f64.powi(DIGITS - 1 - exact.abs().log10().floor() as i32);
                *value = Value::from((exact * scale).round() / scale);
            }
        }
        Value::Array(values) => {
            values.iter_mut().for_each(round);
            values.fmt();
        }
        Value::InlineTable(table) => {
            table.iter_mut().for_each(|(_, value)| round(value));
            table.fmt();
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_optics::{CameraParams, Distortion};
    use fingervision_touch::DepthLine;

    fn camera() -> CameraParams {
        CameraParams {
            focal_length_px: [400.123_456_789_123; 2],
            principal_point_px: [239.5, 240.0],
            distortion: Distortion { k1: -1.0 / 12.0, ..Distortion::default() },
            rotation_rad: [0.0; 3],
            translation_mm: [0.0, 0.0, 25.0],
        }
    }

    #[test]
    fn a_profile_keeps_what_is_not_its_camera() {
        let before = "# my sensor\nname = \"left\" # index\n\n[camera]\n# measured on Monday\nfocal_length_px = [1.0, 1.0] # px\n\
            principal_point_px = [0.0, 0.0]\ntranslation_mm = [0.0, 0.0, 9.0]\n\n[flow]\nnoise_levels = 3.0\n";
        let after = with_table(before, "camera", &camera());
        assert!(
            after.starts_with("# my sensor\nname = \"left\" # index\n\n[camera]\n# measured on Monday\n"),
            "{after}"
        );
        assert!(after.contains("focal_length_px = [400.123457, 400.123457] # px\n"), "{after}");
        assert!(after.ends_with("\n[flow]\nnoise_levels = 3.0\n"), "{after}");
        let profile = Profile::from_toml(&after).unwrap();
        assert_eq!((profile.camera.unwrap().distortion.k1, profile.flow.noise_levels), (-0.083_333_333_3, 3.0));
    }

    #[test]
    fn a_profile_is_made_where_there_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sensor.toml");
        update_profile(&path, "camera", &camera()).unwrap();
        update_profile(&path, "depth.density", &DepthLine { slope_mm: 15.0, intercept_mm: 0.0 }).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("[camera]\nfocal_length_px"), "{text}");
        assert!(text.contains("\n[depth.density]\nslope_mm = 15.0"), "{text}");
        assert_eq!(Profile::load(&path).unwrap().camera.map(|camera| camera.principal_point_px), Some([239.5, 240.0]));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_table_in_braces_stays_in_braces() {
        let after = with_table(
            "depth = { method = \"density\" }\n",
            "depth.density",
            &DepthLine { slope_mm: 15.0, intercept_mm: 0.0 },
        );
        assert!(Profile::from_toml(&after).unwrap().depth.density.is_some(), "{after}");
    }

    #[test]
    fn an_invalid_profile_is_not_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sensor.toml");
        fs::write(&path, "nam = 'left'").unwrap();
        assert!(update_profile(&path, "camera", &camera()).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "nam = 'left'");
        assert!(update_profile(folder.path(), "camera", &camera()).is_err());
        assert!(update_profile(&folder.path().join("no/sensor.toml"), "camera", &camera()).is_err());
    }
}
