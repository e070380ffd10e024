//! The colour of a pixel.

/// Red, green and blue, 0 to 255.
pub type Rgb = [u8; 3];

/// The colour for "not valid" in every picture: a grey that is in no colour scale.
pub const INVALID_COLOUR: Rgb = [158; 3];
