//! A field of one number per pixel as an image.

use fingervision_image::Image;

use crate::colour::{INVALID_COLOUR, Rgb};
use crate::colour_map::ColourMap;

/// The relation between numbers and colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatScale {
    /// The colours.
    pub map: ColourMap,
    /// The number at the map's lower end, in the field's unit.
    pub low: f32,
    /// The number at the map's upper end, in the field's unit.
    pub high: f32,
}

impl HeatScale {
    /// For a field of either sign: white at zero, blue down to `-limit`, red up to `limit`.
    #[must_use]
    pub fn around_zero(limit: f32) -> Self {
        Self { map: ColourMap::BlueWhiteRed, low: -limit, high: limit }
    }

    /// For a field that is never negative: zero to `limit`.
    #[must_use]
    pub fn from_zero(limit: f32) -> Self {
        Self { map: ColourMap::Viridis, low: 0.0, high: limit }
    }

    /// The colour of a number; numbers beyond the ends have the end's colour, NaN is [`INVALID_COLOUR`].
    #[must_use]
    pub fn colour(&self, value: f32) -> Rgb {
        let place = (value - self.low) / (self.high - self.low);
        if place.is_nan() { INVALID_COLOUR } else { self.map.colour(place) }
    }
}

/// The colours of a field; [`INVALID_COLOUR`] where `valid` is 0.
///
/// # Panics
///
/// If the two differ in size.
#[must_use]
pub fn heat_map(values: &Image<f32>, valid: &Image<u8>, scale: HeatScale) -> Image<Rgb> {
    assert_eq!(values.size(), valid.size(), "sizes of field and mask");
    Image::from_fn(values.width(), values.height(), |x, y| match valid.at(x, y) {
        0 => INVALID_COLOUR,
        _ => scale.colour(values.at(x, y)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_the_middle_of_a_signed_scale() {
        let values = Image::from_vec(4, 1, vec![-2.0, 0.0, 2.0, f32::NAN]).unwrap();
        let colours = heat_map(&values, &Image::filled(4, 1, 1), HeatScale::around_zero(2.0));
        let map = ColourMap::BlueWhiteRed;
        assert_eq!(colours.values(), [map.colour(0.0), map.colour(0.5), map.colour(1.0), INVALID_COLOUR]);
    }

    #[test]
    fn what_is_not_valid_is_grey() {
        let colours = heat_map(&Image::filled(1, 1, 1.0), &Image::filled(1, 1, 0), HeatScale::from_zero(2.0));
        assert_eq!(colours.at(0, 0), INVALID_COLOUR);
    }
}
