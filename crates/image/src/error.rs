use crate::Rect;

/// What can be wrong with an image before any computation starts.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// A buffer does not hold `width · height` values.
    #[error("{len} values cannot fill an image of {width}x{height} px")]
    WrongLength {
        /// Columns asked for, px.
        width: usize,
        /// Rows asked for, px.
        height: usize,
        /// Values given.
        len: usize,
    },
    /// A rectangle reaches outside the image.
    #[error("region {region:?} does not fit an image of {width}x{height} px")]
    RegionOutside {
        /// The rectangle asked for.
        region: Rect,
        /// Columns of the image, px.
        width: usize,
        /// Rows of the image, px.
        height: usize,
    },
}
