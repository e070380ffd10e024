//! The fields of a reading that a run can store.

use fingervision_touch::Reading;

/// A field that a run can keep as an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Field {
    /// Displacement, px: `flow.npy`, float32 `[frame][row][column][x, y]`.
    Flow,
    /// Density feature, dimensionless: `density.npy`, float32 `[frame][row][column]`.
    Density,
    /// Depth, mm, positive pressed in: `depth.npy`, float32 `[frame][row][column]`.
    Depth,
    /// 1 where an elastic depth is valid, and contact and displacement with it: `depth_valid.npy`, uint8
    /// `[frame][row][column]`. If it is written, `valid.npy` refers only to flow and density.
    DepthValid,
    /// Expected error of an elastic depth, mm, infinite where it is not valid: `depth_deviation.npy`, float32
    /// `[frame][row][column]`.
    DepthDeviation,
    /// 1 where the gel touches something: `contact.npy`, uint8 `[frame][row][column]`.
    Contact,
    /// Displacement in gel space, mm: `displacement.npy`, float32 `[frame][row][column][x, y, z]`.
    Displacement,
    /// Traction on the gel, `MPa`: `traction.npy`, float32 `[frame][row][column][x, y, z]` on a grid of its own, in mm
    /// over the undeformed surface.
    Traction,
    /// Predicted standard deviation of the flow, px: `deviation.npy`, float32 `[frame][row][column]`.
    Deviation,
}

impl Field {
    /// Every field.
    pub const ALL: [Self; 9] = [
        Self::Flow,
        Self::Density,
        Self::Depth,
        Self::DepthValid,
        Self::DepthDeviation,
        Self::Contact,
        Self::Displacement,
        Self::Traction,
        Self::Deviation,
    ];

    /// The field's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.file_name().trim_end_matches(".npy")
    }

    /// The field's file.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Flow => "flow.npy",
            Self::Density => "density.npy",
            Self::Depth => "depth.npy",
            Self::DepthValid => "depth_valid.npy",
            Self::DepthDeviation => "depth_deviation.npy",
            Self::Contact => "contact.npy",
            Self::Displacement => "displacement.npy",
            Self::Traction => "traction.npy",
            Self::Deviation => "deviation.npy",
        }
    }

    /// Whether readings with these fields contain it.
    #[must_use]
    pub fn is_in(self, reading: &Reading) -> bool {
        match self {
            Self::Flow | Self::Deviation => true,
            Self::Density => reading.density.is_some(),
            Self::Depth => reading.depth.is_some(),
            Self::DepthValid | Self::DepthDeviation => reading.depth_deviation.is_some(),
            Self::Contact => reading.contact.is_some(),
            Self::Displacement => reading.displacement.is_some(),
            Self::Traction => reading.traction.is_some(),
        }
    }
}
