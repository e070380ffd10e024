//! The limits on presses for the gel, on the gel, and on the fit, all in one place.
//!
//! None of them is a length: depths and distances are relative to the thickness of the gel, motion is relative to the
//! depth.

/// See [`THRESHOLDS`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Thresholds {
    /// Range of depths of the frames that are used, in thicknesses. Shallower ones contain little information; the bias
    /// of linear elasticity grows with depth, see the table in `docs/gel-from-presses.md`.
    pub(super) depths: [f64; 2],

    /// Least distance from contact, in thicknesses, at which the surface is compared with linear elasticity: nearer to
    /// contact, strain is too large.
    pub(super) away: f64,
    /// Least distance from a side of the gel, in thicknesses: the compliance of the block is not accurate nearer to it.
    pub(super) from_side: f64,

    /// Least number of compared cells around contact in a frame: fewer do not show how far the effect of the press
    /// reaches.
    pub(super) least_around: usize,

    /// Possible Poisson's ratios. The elastic model requires less than 0.5; no soft gel is near 0.
    pub(super) ratios: [f64; 2],
    /// Largest change of the thickness from the profile's, as a factor in both directions: the thickness of a poured
    /// gel is known better than that.
    pub(super) most_factor: f64,
    /// With at least this number of presses, the scatter between them gives the error. Fewer presses do not determine a
    /// scatter, so the sectors around contact are used instead.
    pub(super) least_presses: usize,

    /// Deviations above which a value is not determined: of ν, of ln thickness and of ln E. They are about three times
    /// the error of the model, which remains however good the presses are.
    pub(super) determined: [f64; 3],

    /// Correlation above which ν and thickness change the surface in the same way and cannot be separated. In presses
    /// that determine both it is 0.8 to 0.96.
    pub(super) alike: f64,
    /// Radius of contact, in thicknesses, above which the gel around contact moves too little.
    pub(super) wide: f64,

    /// Residual relative to the depth above which a warning is given: well below the 5 % at which a fit is refused.
    pub(super) usual_unexplained: f64,
    /// A modulus that changes by more than this factor gives a warning. Forces in g or kg instead of N change it by a
    /// factor of 102 or 9.8.
    pub(super) most_stiffer: f64,
    /// Ratio, in both directions, between the depths in the images and the known ones above which a warning is given:
    /// the camera's distance or the depths are then wrong.
    pub(super) most_depth_factor: f64,
    /// Poisson's ratio above which a fit has reached the upper end of `ratios`.
    pub(super) end_of_ratios: f64,
}

/// The values in use. Limits without a stated measurement are choices; `docs/gel-from-presses.md` lists the errors of
/// simulated gels with these values.
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
