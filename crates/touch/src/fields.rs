//! The fields of a reading that are requested.

/// Which fields a tracker computes in addition to the flow and its validity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each field is requested separately")]
pub struct Fields {
    /// The density feature.
    pub density: bool,
    /// Depth, if the profile is calibrated for it; elastic depth with its contact, area and force.
    pub depth: bool,
    /// Displacement, with elastic depth.
    pub displacement: bool,
    /// Traction, with elastic depth and a known Young's modulus.
    pub traction: bool,
}

impl Fields {
    /// Only the flow and its validity.
    pub const NONE: Self = Self { density: false, depth: false, displacement: false, traction: false };
}

/// Density and depth.
impl Default for Fields {
    fn default() -> Self {
        Self { density: true, depth: true, ..Self::NONE }
    }
}
