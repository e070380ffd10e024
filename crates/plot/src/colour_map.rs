//! Colours for one number: perceptually uniform, so that equal steps look equal.
//!
//! Each map is stored as 33 evenly spaced colours and interpolated linearly; that is within 5 of 255 levels of the
//! published tables (viridis is in the public domain, the maps of Kovesi are under CC BY 4.0).

use crate::colour::Rgb;

/// Number of colours of a map.
const STOPS: usize = 33;

/// A row of colours for numbers between two ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark violet over green to yellow, for quantities that start at zero. Smith and van der Walt 2015.
    Viridis,
    /// Blue over white to red, for quantities of either sign; the middle is zero. "CET-D1", Kovesi 2015.
    BlueWhiteRed,
}

impl ColourMap {
    /// The colour at a place in the map, from 0 at its lower to 1 at its upper end; places beyond have the end's colour.
    #[must_use]
    pub fn colour(self, place: f32) -> Rgb {
        let stops = match self {
            Self::Viridis => &VIRIDIS,
            Self::BlueWhiteRed => &BLUE_WHITE_RED,
        };
        let place = place.clamp(0.0, 1.0) * (STOPS - 1) as f32;
        let below = (place as usize).min(STOPS - 2);
        let weight = place - below as f32;
        let mix = |channel: usize| {
            let (from, to) = (f32::from(stops[below][channel]), f32::from(stops[below + 1][channel]));
            (from + weight * (to - from)).round() as u8
        };
        [mix(0), mix(1), mix(2)]
    }
}

const VIRIDIS: [[u8; 3]; STOPS] = [
    [68, 1, 84],
    [71, 13, 96],
    [72, 24, 106],
    [72, 35, 116],
    [71, 45, 123],
    [69, 55, 129],
    [66, 64, 134],
    [62, 73, 137],
    [59, 82, 139],
    [55, 91, 141],
    [51, 99, 141],
    [47, 107, 142],
    [44, 114, 142],
    [41, 122, 142],
    [38, 130, 142],
    [35, 137, 142],
    [33, 145, 140],
    [31, 152, 139],
    [31, 160, 136],
    [34, 167, 133],
    [40, 174, 128],
    [50, 182, 122],
    [63, 188, 115],
    [78, 195, 107],
    [94, 201, 98],
    [112, 207, 87],
    [132, 212, 75],
    [152, 216, 62],
    [173, 220, 48],
    [194, 223, 35],
    [216, 226, 25],
    [236, 229, 27],
    [253, 231, 37],
];
const BLUE_WHITE_RED: [[u8; 3]; STOPS] = [
    [32, 80, 218],
    [61, 89, 220],
    [81, 98, 222],
    [97, 107, 224],
    [112, 117, 225],
    [125, 126, 227],
    [137, 136, 228],
    [149, 146, 230],
    [160, 156, 231],
    [170, 166, 232],
    [181, 176, 234],
    [191, 186, 235],
    [201, 197, 236],
    [211, 207, 237],
    [220, 218, 238],
    [230, 227, 238],
    [236, 231, 234],
    [240, 225, 222],
    [241, 214, 207],
    [241, 202, 192],
    [240, 189, 176],
    [238, 177, 161],
    [236, 164, 146],
    [234, 152, 132],
    [231, 140, 118],
    [227, 127, 104],
    [223, 114, 90],
    [219, 101, 76],
    [214, 87, 63],
    [209, 73, 49],
    [203, 57, 36],
    [198, 37, 21],
    [191, 2, 5],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_and_the_middle_are_the_published_colours() {
        assert_eq!(ColourMap::Viridis.colour(0.0), [68, 1, 84]);
        assert_eq!(ColourMap::Viridis.colour(1.0), [253, 231, 37]);
        assert_eq!(ColourMap::BlueWhiteRed.colour(0.5), [236, 231, 234]);
    }

    #[test]
    fn places_beyond_the_ends_take_the_ends_colour() {
        assert_eq!(ColourMap::Viridis.colour(-3.0), ColourMap::Viridis.colour(0.0));
        assert_eq!(ColourMap::Viridis.colour(7.0), ColourMap::Viridis.colour(1.0));
    }
}
