use std::path::Path;

use fingervision_flow::FlowError;
use fingervision_image::Rect;
use fingervision_settings::{Place, SettingsError};

use crate::ParameterError;

/// Why a profile cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileError {
    /// The file or a value in it.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The region of interest does not fit the frames.
    #[error(
        "image.region_of_interest = [{}, {}, {}, {}] reaches outside the frames of {}x{} px",
        region.x, region.y, region.width, region.height, frame_size.0, frame_size.1
    )]
    RegionOutside {
        /// The region, px.
        region: Rect,
        /// Columns and rows of the frames, px.
        frame_size: (usize, usize),
    },
    /// A setting that has no effect with the other settings.
    #[error("{key} has no effect: {reason}")]
    NoEffect {
        /// The path of the setting.
        key: String,
        /// Why not.
        reason: String,
        /// What gives it an effect.
        hint: String,
    },
    /// Elastic depth is requested, but the table that describes camera or gel is missing.
    #[error("depth.method = \"elastic\" needs [{table}], which is missing in the profile")]
    ElasticNeeds {
        /// The table.
        table: &'static str,
    },
}

impl ProfileError {
    /// What the user can do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Settings(error) if error.is_not_found() => {
                Some("check the name; `fingervision profile new` writes a profile to start from".into())
            }
            Self::Settings(SettingsError::OutOfRange { key, allowed, .. }) if allowed.ends_with(" mm") => {
                Some(format!("write {key} in mm: multiply a value in m by 1000, divide a value in µm by 1000"))
            }
            Self::Settings(SettingsError::OutOfRange { key, allowed, .. }) => {
                Some(format!("change {key} in the profile, or with --set: it must be {allowed}"))
            }
            Self::Settings(error) => error.hint(),
            Self::RegionOutside { frame_size: (width, height), .. } => {
                Some(format!("the region is [x, y, width, height]; the whole frame is [0, 0, {width}, {height}]"))
            }
            Self::NoEffect { key, hint, .. } => Some(format!("{hint}, or leave {key} out")),
            Self::ElasticNeeds { table: "camera" } => {
                Some("fit [camera] with `fingervision calibrate camera`, or set depth.method=density".into())
            }
            Self::ElasticNeeds { table } => Some(format!(
                "describe [{table}] by size_mm, thickness_mm and poissons_ratio, or set depth.method=density"
            )),
        }
    }

    /// The same error, with the file's name.
    pub(super) fn in_file(self, path: &Path) -> Self {
        self.map_settings(|error| error.in_file(path))
    }

    /// The same error, with its line in the text if it had none.
    pub(super) fn in_text(self, text: &str) -> Self {
        self.map_settings(|error| error.in_text(text))
    }

    fn map_settings(self, change: impl FnOnce(SettingsError) -> SettingsError) -> Self {
        match self {
            Self::Settings(error) => Self::Settings(change(error)),
            other @ (Self::RegionOutside { .. } | Self::NoEffect { .. } | Self::ElasticNeeds { .. }) => other,
        }
    }

    /// A value that no sensor has.
    pub(super) fn impossible(key: impl Into<String>, value: String, allowed: impl Into<String>) -> Self {
        let place = Place::default();
        Self::Settings(SettingsError::OutOfRange { place, key: key.into(), value, allowed: allowed.into() })
    }
}

impl From<ParameterError> for ProfileError {
    fn from(error: ParameterError) -> Self {
        Self::impossible(error.key, error.value.to_string(), error.allowed)
    }
}

/// Names the key that an error of the flow refers to; the size of a picture is that of the region of interest.
impl From<FlowError> for ProfileError {
    fn from(error: FlowError) -> Self {
        const REGION: &str = "image.region_of_interest";
        match error {
            FlowError::Parameter { name, value, range } => {
                Self::impossible(format!("flow.{name}"), value.to_string(), range)
            }
            FlowError::TooSmall { width, height, least } => Self::impossible(
                REGION,
                format!("{width}x{height} px"),
                format!("{least} px or more in width and height"),
            ),
            FlowError::TooLarge { width, height, most } => {
                Self::impossible(REGION, format!("{width}x{height} px"), format!("{most} px or less in total"))
            }
        }
    }
}
