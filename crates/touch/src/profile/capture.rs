//! The camera of a sensor and its settings: the table `[capture]`.

use serde::{Deserialize, Serialize};

use super::ProfileError;

/// The longest possible exposure, s: a value above is assumed to be in another unit.
const LONGEST_EXPOSURE_S: f64 = 10.0;
/// The codes of the pixel formats that can be decoded.
const FORMATS: [&str; 5] = ["MJPG", "JPEG", "YUYV", "GREY", "Y16"];
/// Possible colour temperatures, K.
const WHITE_BALANCES_K: [u32; 2] = [1000, 20_000];

/// The camera of the sensor and its settings. Absent controls keep the camera's own values; absent values of the mode
/// are chosen from what the camera offers.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CaptureSection {
    /// The camera's id, its serial number, or a part of its name that no other camera has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<String>,
    /// The pixel format: `MJPG`, `JPEG`, `YUYV`, `GREY` or `Y16`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// Columns and rows of the frames, px.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_px: Option<[u32; 2]>,
    /// Frames per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_per_second: Option<f64>,
    /// The exposure of each frame, s; switches automatic exposure off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure_s: Option<f64>,
    /// The gain, in the camera's own unit; switches automatic gain off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<i64>,
    /// The colour temperature of the light, K; switches automatic white balance off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white_balance_k: Option<u32>,
}

impl CaptureSection {
    pub(super) fn validate(&self) -> Result<(), ProfileError> {
        let impossible = |key: &str, value: String, allowed: &str| {
            Err(ProfileError::impossible(format!("capture.{key}"), value, allowed))
        };
        let is_known = |format: &String| FORMATS.iter().any(|known| known.eq_ignore_ascii_case(format.trim_end()));
        match self {
            Self { camera: Some(camera), .. } if camera.trim().is_empty() => {
                impossible("camera", format!("{camera:?}"), "an id, a serial number or a part of a name")
            }
            Self { format: Some(format), .. } if !is_known(format) => {
                impossible("format", format!("{format:?}"), "MJPG, JPEG, YUYV, GREY or Y16")
            }
            Self { size_px: Some(size), .. } if size.contains(&0) => {
                impossible("size_px", format!("{size:?}"), "[width, height], both above 0 px")
            }
            Self { frames_per_second: Some(rate), .. } if !(rate.is_finite() && *rate > 0.0) => {
                impossible("frames_per_second", rate.to_string(), "a number above 0")
            }
            Self { exposure_s: Some(exposure), .. } if !(*exposure > 0.0 && *exposure <= LONGEST_EXPOSURE_S) => {
                impossible("exposure_s", exposure.to_string(), "above 0 and at most 10 s, as in 0.005 for 5 ms")
            }
            Self { white_balance_k: Some(kelvin), .. }
                if !(WHITE_BALANCES_K[0]..=WHITE_BALANCES_K[1]).contains(kelvin) =>
            {
                impossible("white_balance_k", kelvin.to_string(), "1000 to 20000 K")
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::Profile;

    #[test]
    fn a_capture_table_is_read_and_written() {
        let text = "[capture]\ncamera = \"SN7\"\nformat = \"MJPG\"\nsize_px = [640, 480]\nframes_per_second = 90\n\
                    exposure_s = 0.005\ngain = 16\nwhite_balance_k = 4500\n";
        let profile = Profile::from_toml(text).unwrap();
        let capture = profile.capture.clone().unwrap();
        assert_eq!((capture.size_px, capture.gain), (Some([640, 480]), Some(16)));
        assert_eq!(Profile::from_toml(&profile.to_toml()).unwrap(), profile);
        assert!(!Profile::default().to_toml().contains("capture"));
    }

    #[test]
    fn impossible_values_are_refused_with_their_key() {
        let wrong = [
            ("camera = \" \"", "capture.camera"),
            ("format = \"MOTION\"", "capture.format"),
            ("size_px = [640, 0]", "capture.size_px"),
            ("frames_per_second = -1", "capture.frames_per_second"),
            ("exposure_s = 50", "capture.exposure_s"),
            ("white_balance_k = 45", "capture.white_balance_k"),
            ("exposure = 1", "exposure"),
        ];
        for (line, key) in wrong {
            let error = Profile::from_toml(&format!("[capture]\n{line}\n")).unwrap_err();
            assert!(error.to_string().contains(key), "{line}: {error}");
        }
    }
}
