use fingervision_flow::FlowError;
use fingervision_image::ImageError;
use thiserror::Error;

/// With fewer images a wrong step cannot be distinguished from the others.
pub const LEAST_IMAGES: usize = 6;

/// Why a recording of a board does not determine a camera.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum BoardError {
    /// The recording is too short.
    #[error("the board is shown in {images} images: at least {LEAST_IMAGES} are needed")]
    TooFewImages {
        /// Number of images.
        images: usize,
    },
    /// There is too little texture.
    #[error("only {:.0} % of image {image} has texture that can be tracked", 100.0 * textured)]
    NoTexture {
        /// The image, counted from 1.
        image: usize,
        /// The part that has texture, 0 to 1.
        textured: f32,
    },
    /// Two images do not show the same board.
    #[error("images {image} and {} do not match: {:.0} % of the textured part is found in both", image + 1, 100.0 * matched)]
    NoMatch {
        /// The first of the two, counted from 1.
        image: usize,
        /// The part that is found in both, 0 to 1.
        matched: f32,
    },
    /// Nothing moves.
    #[error("the board does not move: its displacement from image to image is {flow_px:.2} px")]
    Still {
        /// The typical displacement, px.
        flow_px: f64,
    },
    /// The images do not show equal steps.
    #[error("{}", step_fault(*image, *steps))]
    UnevenStep {
        /// The image before the step, counted from 1.
        image: usize,
        /// The step's length in typical steps.
        steps: f64,
    },
    /// The board moves in another direction than given.
    #[error("the board moves towards {found_deg:.0}° in the image, not towards {expected_deg:.0}°")]
    WrongDirection {
        /// The direction in which it moves, degrees from x towards y.
        found_deg: f64,
        /// The given direction, degrees from x towards y.
        expected_deg: f64,
    },
    /// The board moves by another length than given.
    #[error("with the known camera, the board moves {found_mm:.3} mm from image to image, not {step_mm} mm")]
    WrongStep {
        /// The step by the known camera, mm.
        found_mm: f64,
        /// The given step, mm.
        step_mm: f64,
    },
    /// Too little of the image could be tracked in enough of the pairs.
    #[error("only {:.0} % of the image could be tracked through the recording", 100.0 * part)]
    TooLittleSeen {
        /// The part of the grid's nodes that have a flow, 0 to 1.
        part: f64,
    },
    /// The fit found no camera.
    #[error("the fit did not converge: {reason} after {evaluations} evaluations, mean residual {residual_px:.3} px")]
    NotConverged {
        /// Why it ended.
        reason: String,
        /// Number of evaluations of the model.
        evaluations: usize,
        /// Mean length of the residual at its end, px.
        residual_px: f64,
    },
    /// A camera that no sensor can have.
    #[error("the fit gives an impossible camera: a {what} of {value:.3} {unit}, {} to {} are possible", range[0], range[1])]
    Impossible {
        /// The impossible quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The value's unit.
        unit: &'static str,
        /// Its possible range.
        range: [f64; 2],
    },
    /// A camera that does not explain the images.
    #[error(
        "no camera explains the images: the residual of a step's flow is {residual_px:.3} px, at most {most_px} px are allowed"
    )]
    Useless {
        /// Mean length of the residual, px.
        residual_px: f64,
        /// Allowed residual, px.
        most_px: f64,
    },
    /// Slides and priors leave focal length or distance open.
    #[error(
        "the slides do not determine the camera: {name} = {value:.1} ± {uncertainty:.1}, which is {:.0} %; at most {:.0} % are allowed",
        100.0 * uncertainty / value,
        100.0 * most_part
    )]
    NotDetermined {
        /// The unknown with the larger uncertainty, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its standard uncertainty.
        uncertainty: f64,
        /// Allowed uncertainty, as a part of the value.
        most_part: f64,
    },
    /// The flow's parameters or the size of its images.
    #[error(transparent)]
    Flow(#[from] FlowError),
    /// An image of another size.
    #[error(transparent)]
    Image(#[from] ImageError),
}

impl BoardError {
    /// What to do about it, if anything.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::TooFewImages { .. } => "slide the board in 20 equal steps and take an image after each: 21 images",
            Self::NoTexture { .. } => {
                "use a board with a dense random pattern that fills the image, sharp and evenly lit; fingervision pattern prints one"
            }
            Self::NoMatch { .. } => {
                "do not change light and exposure, slide by less than a fifth of the image a step, and let nothing but the board move"
            }
            Self::Still { .. } => {
                "slide the board by the same step between any two images, far enough that it moves 3 to 30 px"
            }
            Self::UnevenStep { steps, .. } => uneven_hint(*steps),
            Self::WrongDirection { .. } => {
                "name the direction with --direction x, y or degrees from x towards y, or reverse the order of the images"
            }
            Self::WrongStep { .. } => {
                "check --step-mm; if the step is right, the profile's [camera] or the given prior belongs to another camera: remove it"
            }
            Self::TooLittleSeen { .. } => {
                "let the board fill the image at both ends of the slide, or set image.region_of_interest to the part that it covers"
            }
            Self::NotConverged { .. } => {
                "no profile was written: check --step-mm, --direction and the priors, or start from a [camera] in the profile that is close to the solution"
            }
            Self::Impossible { .. } => {
                "nothing was written: check --step-mm and the priors; all lengths are in mm, a distance of 2.5 cm is 25 mm"
            }
            Self::Useless { .. } => {
                "nothing was written: take the recording again with a flat board and equal steps, and restrict image.region_of_interest to the board"
            }
            Self::NotDetermined { .. } => {
                "nothing was written: measure the distance from the lens to the board and give it, as in --prior distance_mm=25±0.5, or add a second slide perpendicular to the first, with the board tilted by 15° or more"
            }
            Self::Flow(_) => "correct [flow] or image.region_of_interest in the profile, as named",
            Self::Image(_) => "take all images of the slide with the same camera at the same size",
        };
        Some(hint.into())
    }
}

fn step_fault(image: usize, steps: f64) -> String {
    let next = image + 1;
    if steps < -0.3 {
        format!("images are out of order: from image {image} to {next} the board moves back by {:.1} steps", -steps)
    } else if steps < 0.3 {
        format!("images {image} and {next} show the board at the same place")
    } else if is_whole(steps) {
        let missing = steps.round() - 1.0;
        let images = if missing > 1.0 { "images are" } else { "image is" };
        format!("{missing:.0} {images} missing between image {image} and {next}: the board moves {steps:.2} steps")
    } else {
        format!("the steps are uneven: from image {image} to {next} the board moves {steps:.2} times the usual step")
    }
}

fn is_whole(steps: f64) -> bool {
    steps > 1.5 && (steps - steps.round()).abs() < 0.15
}

fn uneven_hint(steps: f64) -> &'static str {
    if steps < -0.3 {
        "number the images in the order in which they were taken"
    } else if steps < 0.3 {
        "leave one of the two out, or take the recording again with a step between any two images"
    } else if is_whole(steps) {
        "put the missing image back, or take the recording again"
    } else {
        "move the board by the same step every time, always from the same side, and let it rest before each image"
    }
}
