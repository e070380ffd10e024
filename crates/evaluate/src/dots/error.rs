use fingervision_image::ImageError;
use fingervision_touch::ParameterError;

/// Why dots cannot be tracked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DotError {
    /// The image shows too few dots to interpolate between them, or all of them are on one line.
    #[error("{seen} dots are visible: {least} or more, not all on one line, are needed")]
    TooFew {
        /// Dots found.
        seen: usize,
        /// Dots needed.
        least: usize,
    },
    /// An image differs in size from the first.
    #[error("the image is {}x{} px, the first was {}x{} px", found.0, found.1, expected.0, expected.1)]
    SizeChanged {
        /// Its columns and rows, px.
        found: (usize, usize),
        /// Those of the first, px.
        expected: (usize, usize),
    },
    /// The image cannot be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A parameter of density or filter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}
