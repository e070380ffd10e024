//! The topics of a sensor, as in `/SENSOR/reading`.

use crate::schema::{self, Schema};

/// The content of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Topic {
    Frame,
    Image,
    Preview,
    Reading,
    Surface,
    Calibration,
    Transform,
    Log,
    Truth,
}

impl Topic {
    /// Every topic, in the order of its number.
    pub(crate) const ALL: [Self; 9] = [
        Self::Frame,
        Self::Image,
        Self::Preview,
        Self::Reading,
        Self::Surface,
        Self::Calibration,
        Self::Transform,
        Self::Log,
        Self::Truth,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Image => "image",
            Self::Preview => "preview",
            Self::Reading => "reading",
            Self::Surface => "surface",
            Self::Calibration => "calibration",
            Self::Transform => "transform",
            Self::Log => "log",
            Self::Truth => "truth",
        }
    }

    pub(crate) fn schema(self) -> &'static Schema {
        match self {
            Self::Frame => &schema::FRAME,
            Self::Image => &schema::COMPRESSED_IMAGE,
            Self::Preview => &schema::RAW_IMAGE,
            Self::Reading => &schema::READING,
            Self::Surface => &schema::POINT_CLOUD,
            Self::Calibration => &schema::CAMERA_CALIBRATION,
            Self::Transform => &schema::FRAME_TRANSFORM,
            Self::Log => &schema::LOG,
            Self::Truth => &schema::TRUTH,
        }
    }

    /// The whole topic of a sensor with this prefix.
    pub(crate) fn of(self, prefix: &str) -> String {
        format!("/{prefix}/{}", self.name())
    }
}

/// A prefix for each sensor: its name, with `_` in place of characters that a topic cannot have, and a number if
/// another sensor has the same name.
pub(crate) fn prefixes<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut prefixes: Vec<String> = Vec::new();
    for name in names {
        let is_plain = |letter: char| letter.is_alphanumeric() || matches!(letter, '-' | '_' | '.');
        let mut plain: String = name.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect();
        if plain.is_empty() {
            plain.push_str("sensor");
        }
        let numbered = (2..).map(|number| format!("{plain}_{number}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|prefix| !prefixes.contains(prefix));
        prefixes.extend(free);
    }
    prefixes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sensor_has_a_prefix_of_its_own() {
        assert_eq!(
            prefixes(["left", "left index", "left/index", ""]),
            ["left", "left_index", "left_index_2", "sensor"]
        );
    }
}
