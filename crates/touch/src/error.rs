use crate::{ElasticError, ParameterError, ProfileError};
use fingervision_flow::FlowError;
use fingervision_image::ImageError;

/// Why a frame cannot be tracked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrackError {
    /// The profile does not fit the frames or is inconsistent.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The flow cannot be computed with these parameters or on this size.
    #[error(transparent)]
    Flow(#[from] FlowError),
    /// The image cannot be taken from the frame.
    #[error("frame {sequence}: {source}")]
    Image {
        /// The frame's sequence number.
        sequence: u64,
        /// What is wrong with it.
        source: ImageError,
    },
    /// A frame differs in size from the first one.
    #[error("frame {sequence} is {width}x{height} px, the previous frames were {expected_width}x{expected_height} px")]
    SizeChanged {
        /// The frame's sequence number.
        sequence: u64,
        /// Its columns, px.
        width: usize,
        /// Its rows, px.
        height: usize,
        /// Columns of the previous frames, px.
        expected_width: usize,
        /// Rows of the previous frames, px.
        expected_height: usize,
    },
    /// A frame's number is not larger than that of the previous frame, or its time is earlier.
    #[error("frame {sequence} at {time_s} s came after frame {previous} at {previous_time_s} s")]
    OutOfOrder {
        /// The frame's sequence number.
        sequence: u64,
        /// Its capture time, s.
        time_s: f64,
        /// Sequence number of the previous frame.
        previous: u64,
        /// Capture time of the previous frame, s.
        previous_time_s: f64,
    },
    /// The method for depth needs a gel surface that the camera does not see.
    #[error("depth: no pixel of the region of interest shows the undeformed gel")]
    NoSurface,
    /// The gel's elasticity cannot be inverted.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
}

impl TrackError {
    /// What to do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Profile(error) => error.hint(),
            Self::Parameter(error) => {
                Some(format!("change {} in the profile, or with --set: it must be {}", error.key, error.allowed))
            }
            Self::Flow(FlowError::Parameter { name, range, .. }) => {
                Some(format!("change flow.{name} in the profile, or with --set: it must be {range}"))
            }
            Self::Flow(FlowError::TooSmall { .. }) => {
                Some("record at a larger size or widen image.region_of_interest".into())
            }
            Self::Flow(FlowError::TooLarge { .. }) => Some("crop with image.region_of_interest".into()),
            Self::Image { .. } => {
                Some("correct image.region_of_interest = [x, y, width, height], or leave [image] out".into())
            }
            Self::SizeChanged { .. } => Some("record with one camera mode, or track the parts separately".into()),
            Self::OutOfOrder { .. } => Some("pass frames in the order of capture".into()),
            Self::NoSurface | Self::Elastic(ElasticError::NoSurface) => Some(
                "correct [camera], or set depth.method=density and give depth.density a slope_mm and an intercept_mm"
                    .into(),
            ),
            Self::Elastic(ElasticError::Gel(_)) => {
                Some("correct size_mm, thickness_mm and poissons_ratio in the profile's [gel]".into())
            }
        }
    }
}
