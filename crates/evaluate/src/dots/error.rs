use fingervision_image::ImageError;
use fingervision_touch::ParameterError;

/// What keeps dots from being followed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DotError {
    /// The image shows too few dots, or all in a row, for a field between them.
    #[error("{seen} dots are seen where {least} or more, not all in a row, are needed")]
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
