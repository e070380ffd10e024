use crate::Rect;

/// Errors of an image, found before any computation starts.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// A buffer does not hold `width · height` values.
    #[error("{len} values cannot fill an image of {width}x{height} px")]
    WrongLength {
        /// Requested columns, px.
        width: usize,
        /// Requested rows, px.
        height: usize,
        /// Number of values.
        len: usize,
    },
    /// A rectangle reaches outside the image.
    #[error("region {region:?} does not fit an image of {width}x{height} px")]
    RegionOutside {
        /// The requested rectangle.
        region: Rect,
        /// Columns of the image, px.
        width: usize,
        /// Rows of the image, px.
        height: usize,
    },
}
