//! The user's answers about the recordings, stored beside them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use fingervision_calibrate::camera::{Prior, Slide};
use fingervision_elastic::GelBlock;
use fingervision_sink::write_file;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The answers' file in the sensor's folder.
const FILE: &str = "answers.toml";

/// Values that no image contains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Answers {
    /// Step of the board between consecutive images, mm.
    step_mm: f64,
    /// Direction of the step, degrees from x towards y.
    direction_deg: f64,
    /// From the lens to the gel's surface, mm, and its standard deviation.
    #[serde(skip_serializing_if = "Option::is_none")]
    distance_mm: Option<[f64; 2]>,
    /// Width of the gel's surface in the image, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    view_mm: Option<f64>,
    /// The gel's width, height and thickness, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    gel_mm: Option<[f64; 3]>,
    /// Its Young's modulus, MPa.
    #[serde(skip_serializing_if = "Option::is_none")]
    youngs_modulus_mpa: Option<f64>,
}

/// Answers given now, on the command line or at a prompt.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Given {
    pub(super) step_mm: Option<f64>,
    pub(super) direction_deg: Option<f64>,
    pub(super) distance: Option<Prior>,
    pub(super) view_mm: Option<f64>,
    pub(super) gel_mm: Option<[f64; 3]>,
    pub(super) youngs_modulus_mpa: Option<f64>,
}

/// Poisson's ratio of soft silicone, used until the gel's own is fitted to presses.
const SILICONE: f64 = 0.48;

impl Default for Answers {
    fn default() -> Self {
        Self {
            step_mm: 0.5,
            direction_deg: 0.0,
            distance_mm: None,
            view_mm: None,
            gel_mm: None,
            youngs_modulus_mpa: None,
        }
    }
}

impl Answers {
    /// The answers of a folder; the defaults if it has none.
    pub(super) fn load(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(FILE);
        let text = match fs::read_to_string(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(refused(&path, &error.kind())),
            Ok(text) => text,
        };
        let answers: Self = toml::from_str(&text).map_err(|error| refused(&path, &error.message()))?;
        let is_length = |value: f64| value.is_finite() && value > 0.0;
        let lengths = [answers.step_mm]
            .into_iter()
            .chain(answers.distance_mm.into_iter().flatten())
            .chain(answers.view_mm)
            .chain(answers.gel_mm.into_iter().flatten())
            .chain(answers.youngs_modulus_mpa);
        match lengths.into_iter().find(|&value| !is_length(value)) {
            Some(value) => Err(refused(&path, &format!("{value} mm is not a length"))),
            None if !answers.direction_deg.is_finite() => Err(refused(&path, &"direction_deg is not an angle")),
            None => Ok(answers),
        }
    }

    /// These answers, with the new ones in place of the old.
    pub(super) fn with(self, given: &Given) -> Self {
        Self {
            step_mm: given.step_mm.unwrap_or(self.step_mm),
            direction_deg: given.direction_deg.unwrap_or(self.direction_deg),
            distance_mm: given.distance.map(|prior| [prior.value, prior.deviation]).or(self.distance_mm),
            view_mm: given.view_mm.or(self.view_mm),
            gel_mm: given.gel_mm.or(self.gel_mm),
            youngs_modulus_mpa: given.youngs_modulus_mpa.or(self.youngs_modulus_mpa),
        }
    }

    /// Stores the answers in a folder that exists.
    pub(super) fn save(&self, folder: &Path) -> Result<(), Failure> {
        let path = folder.join(FILE);
        let text = toml::to_string(self).map_err(|error| refused(&path, &error))?;
        Ok(write_file(&path, text.as_bytes())?)
    }

    /// The board's slide.
    pub(super) fn slide(&self) -> Slide {
        Slide { step_mm: self.step_mm, direction_rad: self.direction_deg.to_radians() }
    }

    /// Width of the gel's surface in the image, mm, if it was measured.
    pub(super) fn view_mm(&self) -> Option<f64> {
        self.view_mm
    }

    /// The gel before it is fitted, if its size is known.
    pub(super) fn gel(&self) -> Option<GelBlock> {
        self.gel_mm.map(|[width, height, thickness_mm]| GelBlock {
            size_mm: [width, height],
            thickness_mm,
            poissons_ratio: SILICONE,
            youngs_modulus_mpa: self.youngs_modulus_mpa,
        })
    }

    /// The distance from the lens to the gel's surface, mm, if it was measured.
    pub(super) fn distance(&self) -> Option<Prior> {
        self.distance_mm.map(|[value, deviation]| Prior { value, deviation })
    }
}

fn refused(path: &Path, reason: &impl ToString) -> Failure {
    let path: PathBuf = path.into();
    Failure::new(
        format!("{}: {}", path.display(), reason.to_string()),
        "remove the file and give --step-mm, --direction, --distance-mm, --view-mm and --gel-mm again, or correct it",
    )
}
