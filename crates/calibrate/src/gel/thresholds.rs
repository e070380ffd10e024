//! The limits on presses for the gel, on the gel, and on the fit, all in one place.
//!
//! None is a length: depths and distances are in thicknesses of the gel, motion is a part of the depth.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Depths of the frames of a press that are kept, in thicknesses: shallower ones contain little information, deeper ones
    /// are not linear.
    pub(super) depths: [f64; 2],

    /// Distance from contact, in thicknesses, beyond which the surface is compared with linear elasticity: nearer, strain is
    /// too large.
    pub(super) away: f64,
    /// Least distance from a side of the gel, in thicknesses: the compliance does not resolve what is nearer.
    pub(super) from_side: f64,

    /// Number of cells around contact that a frame needs to be compared.
    pub(super) least_around: usize,

    /// Allowed Poisson's ratios.
    pub(super) ratios: [f64; 2],
    /// The largest change of the thickness from the profile's, as a factor.
    pub(super) most_factor: f64,
    /// From this number of presses on, their scatter gives the error; with fewer, the sectors around contact do.
    pub(super) least_presses: usize,

    /// Deviations beyond which a value is not determined: of ν, of ln thickness and of ln E.
    pub(super) determined: [f64; 3],

    /// A correlation beyond which ν and thickness change the surface in the same way.
    pub(super) alike: f64,
    /// Contact that is wider than this, as radius over thickness, moves little of the gel around it.
    pub(super) wide: f64,

    /// Motion that may stay unexplained, as a part of the depth, before a warning.
    pub(super) usual_unexplained: f64,
    /// A modulus that changes by more than this factor gives a warning: forces in another unit do that.
    pub(super) most_stiffer: f64,
    /// Depths in the images that differ by more than this factor from the known ones give a warning.
    pub(super) most_depth_factor: f64,
    /// Poisson's ratio above which a fit has reached the end of its range.
    pub(super) end_of_ratios: f64,
}

/// The values in use, for presses of simulated gels; `docs/gel-from-presses.md` lists the errors that they leave.
pub(super) const THRESHOLDS: Thresholds = Thresholds {
    depths: [0.04, 0.12],
    away: 0.5,
    from_side: 0.125,
    least_around: 100,
    ratios: [0.05, 0.499],
    most_factor: 2.5,
    least_presses: 4,
    determined: [0.05, 0.1, 0.15],
    alike: 0.97,
    wide: 1.0,
    usual_unexplained: 0.02,
    most_stiffer: 5.0,
    most_depth_factor: 1.5,
    end_of_ratios: 0.498,
};
