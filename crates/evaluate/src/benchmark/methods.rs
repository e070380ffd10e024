//! The methods for depth that are compared.

use fingervision_calibrate::depth::{self, DepthFit};
use fingervision_image::Image;
use serde::Serialize;

use crate::experiment::{Following, Recording, clipped, depth_of};

/// A method that computes depth from images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Depth is 0 everywhere: every method should be better.
    Nothing,
    /// The published line with its intercept.
    Density,
    /// A line through the origin.
    DensityOrigin,
    /// A slope at every pixel from the camera's perspective.
    DensityPerspective,
    /// The same, with negative depth set to 0.
    DensityClipped,
    /// The published line on 15×15 dots instead of the dense pattern.
    Dots,
    /// The gel's elasticity, from the flow.
    Elastic,
}

impl Method {
    /// Every method, the simplest first.
    pub const ALL: [Self; 7] = [
        Self::Nothing,
        Self::Density,
        Self::DensityOrigin,
        Self::DensityPerspective,
        Self::DensityClipped,
        Self::Dots,
        Self::Elastic,
    ];

    /// Its name in tables and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Density => "density",
            Self::DensityOrigin => "density-origin",
            Self::DensityPerspective => "density-perspective",
            Self::DensityClipped => "density-clipped",
            Self::Dots => "dots",
            Self::Elastic => "elastic",
        }
    }

    /// A description in one line.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Nothing => "depth 0 everywhere",
            Self::Density => "the published line with its intercept",
            Self::DensityOrigin => "a line through the origin",
            Self::DensityPerspective => {
                "a line through the origin, whose slope at every pixel follows from the camera's perspective"
            }
            Self::DensityClipped => "the same, with negative depth set to 0",
            Self::Dots => "15×15 dots, interpolated, and the published line",
            Self::Elastic => {
                "from the flow by the gel's elasticity and the camera's perspective, without calibration presses"
            }
        }
    }

    /// How the gel is tracked for it.
    pub(super) fn following(self) -> Following {
        if self == Self::Dots { Following::Dots } else { Following::Dense }
    }

    /// Depth from a feature by the calibrated law. `None` if the law is not available, or if the method does not use
    /// the feature.
    pub(super) fn depth(self, feature: &Image<f32>, fit: &DepthFit, recording: &Recording) -> Option<Image<f32>> {
        let method = match self {
            Self::Elastic => return None,
            Self::Nothing => return Some(Image::filled(feature.width(), feature.height(), 0.0)),
            Self::Density | Self::Dots => depth::Method::Line,
            Self::DensityOrigin => depth::Method::Origin,
            Self::DensityPerspective | Self::DensityClipped => depth::Method::Perspective,
        };
        let depth = depth_of(feature, fit, method, recording).ok()?;
        Some(if self == Self::DensityClipped { clipped(depth) } else { depth })
    }
}
