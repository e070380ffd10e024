use fingervision_elastic::LayerError;

use crate::depth::DepthFitError;

/// Why a gel cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GelFitError {
    /// A press cannot be read or tracked.
    #[error(transparent)]
    Press(#[from] DepthFitError),
    /// There is nothing to fit to.
    #[error("there are no presses to fit the gel to")]
    NoPresses,
    /// The profile has no camera, or no gel to start the fit from.
    #[error("the profile has no [{table}]")]
    Absent {
        /// The table.
        table: &'static str,
    },
    /// Young's modulus is to be fitted, but there are no forces.
    #[error("youngs-modulus cannot be fitted: none of {presses} presses has forces")]
    NoForces {
        /// Number of presses.
        presses: usize,
    },
    /// A press is too shallow or its depths too coarse.
    #[error(
        "{press}: no frame is {:.2} to {:.2} mm deep, where the gel is linear and moves enough; the deepest is {deepest_mm} mm",
        range_mm[0], range_mm[1]
    )]
    NoDepth {
        /// The press.
        press: String,
        /// The depths that are used, mm.
        range_mm: [f64; 2],
        /// The deepest frame, mm.
        deepest_mm: f64,
    },
    /// Nothing touches the gel.
    #[error("{press}: no contact is found in any of the frames that are used")]
    NoContact {
        /// The press.
        press: String,
    },
    /// There is no free surface to compare with.
    #[error(
        "{press}: too little of the gel is visible around contact, which is as wide as a circle of radius {radius_mm:.1} mm on \
         {thickness_mm:.1} mm of gel"
    )]
    NoSurroundings {
        /// The press.
        press: String,
        /// The radius of a circle as large as contact, mm.
        radius_mm: f64,
        /// Thickness of the gel, mm.
        thickness_mm: f64,
    },
    /// The presses do not determine the values to be fitted.
    #[error("the presses do not determine {}", if free[0] && free[1] { "Poisson's ratio and the thickness separately" } else if free[0] { "Poisson's ratio" } else { "the thickness" })]
    Blind {
        /// Whether Poisson's ratio and thickness were to be fitted.
        free: [bool; 2],
    },
    /// The fit does not converge.
    #[error(
        "the fit does not converge in {steps} steps: it reached a Poisson's ratio of {poissons_ratio:.3} and a thickness of {thickness_mm:.2} mm"
    )]
    Open {
        /// Number of steps.
        steps: usize,
        /// Last Poisson's ratio.
        poissons_ratio: f64,
        /// Last thickness, mm.
        thickness_mm: f64,
    },
    /// No gel moves like this surface.
    #[error("no gel explains the motion around contact: the residual is {:.0} % of the depth, at most 5 % is allowed", 100.0 * unexplained)]
    Misfit {
        /// The residual with the best gel, root mean square over the depth.
        unexplained: f64,
    },
    /// The gel is impossible, or its cells are too coarse.
    #[error("the gel cannot be fitted: {0}")]
    Gel(#[from] LayerError),
}

impl GelFitError {
    /// What the user can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Press(error) => return error.hint(),
            Self::NoPresses => "give presses: folders of images with their depths, or scenes as sim:circle?draft".into(),
            Self::Absent { table: "camera" } => "calibrate the camera first: fingervision calibrate camera".into(),
            Self::Absent { .. } => {
                "give the values that you know: size_mm, thickness_mm as poured, poissons_ratio = 0.48 for soft silicone".into()
            }
            Self::NoForces { .. } => {
                "add a column force_z_n to depth.csv, as read from a scale (g · 0.00981), or leave youngs-modulus out of --fit".into()
            }
            Self::NoDepth { .. } => {
                "record the press in smaller steps of depth; if its depths are right, correct gel.thickness_mm".into()
            }
            Self::NoContact { .. } => {
                "check that the depths belong to these images, that the indenter is in the field of view, and [camera] and gel.size_mm".into()
            }
            Self::NoSurroundings { .. } => {
                "use a smaller indenter, at the middle of the gel: free surface of half a thickness or more must be visible".into()
            }
            Self::Blind { .. } | Self::Open { .. } => {
                "fix one of the two, as in --fit poissons-ratio with a measured gel.thickness_mm; or use a \
                 smaller indenter, check the depths, and start closer to the solution"
                    .into()
            }
            Self::Misfit { .. } => {
                "check the depths, [camera] and gel.size_mm; the gel must be bonded to a flat window and free at its sides".into()
            }
            Self::Gel(_) => "check [gel] in the profile".into(),
        })
    }
}
