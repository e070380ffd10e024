//! The sensor: from a frame to a reading.
//!
//! A [`Profile`] describes one sensor. A [`Tracker`] made from it takes [`Frame`](fingervision_image::Frame)s and gives a
//! [`Reading`] for each: displacement in px, its deviation and validity, the density feature and, where the profile
//! describes the sensor, depth in mm: by a law of the density feature, or with camera and gel by the gel's elasticity
//! ([`ElasticDepth`]), which also gives contact, 3-D displacement and force. All fields lie on the reference grid: they
//! belong to points of the gel.
//!
//! The parts can be used on their own: the references and their policies ([`ReferenceParams`]), the Gaussian density
//! ([`DensityEstimator`]), the guided filter ([`GuidedFilter`]) and the law from the feature to depth ([`DepthLaw`]).

mod columns;
mod density;
mod depth_law;
mod elastic_depth;
mod error;
mod fields;
mod fingerprint;
mod flag;
mod guided_filter;
mod health;
mod health_counts;
mod parameter_error;
mod profile;
mod reading;
mod reading_numbers;
mod references;
mod stage_times;
mod tracker;
mod whole_motion;

pub use columns::{
    CONTACT_AREA_COLUMN, DEPTH_COLUMN, FORCE_COLUMNS, FRAME_COLUMN, MAX_DEPTH_COLUMN, SEQUENCE_COLUMN, TORQUE_COLUMN,
};
pub use density::{DensityEstimator, DensityField, DensityMethod, DensityParams};
pub use depth_law::{DepthLaw, DepthLine, DepthMap, PerspectiveGain, perspective_slopes_mm};
pub use elastic_depth::{
    Around, Cells, CoarseGrid, ElasticDepth, ElasticError, ElasticFields, ElasticMode, ElasticParams, Limits,
    MOST_UNEXPLAINED, Seen, Strain, TRAINING_RANGE, TractionGrid, Tractions, WithoutDrag,
};
pub use error::TrackError;
pub use fields::Fields;
pub use fingerprint::Fingerprint;
pub use flag::{Flag, Flags};
pub use guided_filter::{GuidedFilter, GuidedFilterParams};
pub use health_counts::HealthCounts;
pub use parameter_error::ParameterError;
pub use profile::{
    CaptureSection, DepthMethod, DepthSection, ImageSection, PatternSection, Profile, ProfileError, ProfileReview,
    Remark, Weight,
};
pub use reading::Reading;
pub use reading_numbers::ReadingNumbers;
pub use references::{Policy, ReferenceParams};
pub use stage_times::StageTimes;
pub use tracker::{DeferredDensity, Tracker};

pub use fingervision_flow::Team;
