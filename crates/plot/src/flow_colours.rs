//! Flow as colour: hue shows the direction, saturation the length.
//!
//! The colour wheel is a tilted circle in the colour space `OKLab` (Ottosson 2020), in which equal distances look about
//! equal: neighbouring directions differ by the same step all the way round, so that no edge appears that is not in the
//! flow. The tilt is along the axis from green to red, the one that people with red-green colour blindness do not see:
//! they distinguish these directions by lightness. White where nothing moves, darker beyond the wheel's radius.

use std::array::from_fn;

use fingervision_flow::FlowField;
use fingervision_image::Image;

use crate::colour::{INVALID_COLOUR, Rgb};

/// Least flow with full colour or length, px: noise must not look like touch.
pub const LEAST_FLOW_PX: f32 = 0.1;

/// Radius of the circle in `OKLab`, dimensionless.
const RADIUS: f32 = 0.135;
/// Lightness of its centre, where white is 1.
const LIGHTNESS: f32 = 0.7;
/// By how much red is darker and green lighter than the centre.
const TILT: f32 = 0.09;
/// Factor for every coordinate beyond the wheel.
const BEYOND: f32 = 0.75;

/// The colours of a flow field on a wheel of radius `max_px`; [`INVALID_COLOUR`] where `valid` is 0.
///
/// Rightwards is red, downwards yellow, leftwards green, upwards blue.
///
/// # Panics
///
/// If field and mask differ in size.
#[must_use]
pub fn flow_colours(flow: &FlowField, valid: &Image<u8>, max_px: f32) -> Image<Rgb> {
    assert_eq!(flow.size(), valid.size(), "sizes of field and mask");
    Image::from_fn(valid.width(), valid.height(), |x, y| match valid.at(x, y) {
        0 => INVALID_COLOUR,
        _ => wheel_colour(flow.u.at(x, y) / max_px, flow.v.at(x, y) / max_px),
    })
}

/// The wheel itself, `diameter` px across, on a background: the legend of [`flow_colours`].
#[must_use]
pub fn colour_wheel(diameter: usize, background: Rgb) -> Image<Rgb> {
    let radius = diameter as f32 / 2.0;
    let offset = |pixel: usize| (pixel as f32 + 0.5) / radius - 1.0;
    Image::from_fn(diameter, diameter, |x, y| {
        let (u, v) = (offset(x), offset(y));
        let inside = (radius * (1.0 - u.hypot(v)) + 0.5).clamp(0.0, 1.0);
        let length = u.hypot(v).max(1.0);
        let colour = wheel_colour(u / length, v / length);
        from_fn(|i| (f32::from(background[i]) * (1.0 - inside) + f32::from(colour[i]) * inside).round() as u8)
    })
}

/// The colour of a displacement in units of the wheel's radius.
fn wheel_colour(u: f32, v: f32) -> Rgb {
    let length = u.hypot(v);
    if !length.is_finite() {
        return INVALID_COLOUR;
    }
    let (cos, sin) = if length > 0.0 { (u / length, v / length) } else { (0.0, 0.0) };
    let rim = [LIGHTNESS - TILT * cos, (RADIUS * RADIUS - TILT * TILT).sqrt() * cos, RADIUS * sin];
    // Rounding may put the wheel's rim slightly outside of it.
    let shown = if length <= 1.0 + 1e-5 {
        let strength = length.min(1.0);
        [1.0 - strength * (1.0 - rim[0]), strength * rim[1], strength * rim[2]]
    } else {
        rim.map(|coordinate| BEYOND * coordinate)
    };
    srgb(shown)
}

/// From `OKLab` to `sRGB`.
fn srgb([lightness, a, b]: [f32; 3]) -> Rgb {
    let cubed = |along_a: f32, along_b: f32| (lightness + along_a * a + along_b * b).powi(3);
    let l = cubed(0.396_337_78, 0.215_803_76);
    let m = cubed(-0.105_561_346, -0.063_854_17);
    let s = cubed(-0.089_484_18, -1.291_485_5);
    let linear = [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ];
    linear.map(|level| {
        let level = level.clamp(0.0, 1.0);
        let encoded = if level <= 0.003_130_8 { 12.92 * level } else { 1.055 * level.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions around the wheel, a degree apart, the last beside the first.
    fn around(length: f32) -> Vec<[f32; 3]> {
        let colour = |degree: u16| {
            let angle = f32::from(degree).to_radians();
            wheel_colour(length * angle.cos(), length * angle.sin()).map(f32::from)
        };
        (0..=360).map(|degree| colour(degree % 360)).collect()
    }

    fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    }

    #[test]
    fn the_wheel_has_no_seam() {
        for length in [0.5, 1.0, 2.0] {
            let colours = around(length);
            let (_, seamless) = colours.split_last().unwrap();
            let steps = |pitch: usize| (0..360).map(move |k| distance(seamless[k], seamless[(k + pitch) % 360]));
            // Ten degrees are more than the rounding to whole levels.
            let (least, most) =
                steps(10).fold((f32::MAX, 0.0_f32), |(least, most), step| (least.min(step), most.max(step)));
            assert!(most < 3.5 * least, "length {length}: steps of {least} to {most} levels over ten degrees");
            let largest = steps(1).fold(0.0, f32::max);
            assert!(largest < 6.0, "length {length}: a step of {largest} levels over a degree");
            // The direction at 0 degrees, where the angle wraps around.
            let across = distance(colours[359], colours[1]);
            assert!(across <= 2.0 * largest, "length {length}: {across} levels across 0 degrees");
        }
    }

    #[test]
    fn people_with_a_red_green_deficiency_tell_every_direction_from_its_opposite() {
        // Machado et al. 2009, full severity, in linear light.
        let deuteranopia = [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]];
        let protanopia = [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]];
        for sight in [deuteranopia, protanopia] {
            let seen: Vec<[f32; 3]> = around(1.0).iter().map(|colour| seen(*colour, sight)).collect();
            for degree in 0..180 {
                let apart = distance(seen[degree], seen[degree + 180]);
                assert!(apart > 50.0, "{degree} degrees: {apart} levels apart");
            }
        }
    }

    /// A colour as seen with another kind of colour vision.
    fn seen(colour: [f32; 3], sight: [[f32; 3]; 3]) -> [f32; 3] {
        let linear = colour.map(|level| (level / 255.0).powf(2.2));
        let mixed = sight.map(|row| row.iter().zip(linear).map(|(part, level)| part * level).sum::<f32>());
        mixed.map(|level| 255.0 * level.clamp(0.0, 1.0).powf(1.0 / 2.2))
    }

    #[test]
    fn directions_have_their_colours_and_rest_is_white() {
        let right = wheel_colour(1.0, 0.0);
        let down = wheel_colour(0.0, 1.0);
        let left = wheel_colour(-1.0, 0.0);
        let up = wheel_colour(0.0, -1.0);
        assert!(right[0] > right[1] + 40 && right[0] > right[2] + 40, "{right:?} is no red");
        assert!(down[0] > down[2] + 100 && down[1] > down[2] + 60, "{down:?} is no yellow");
        assert!(left[1] > left[0] + 60 && left[1] > left[2], "{left:?} is no green");
        assert!(up[2] > up[0] + 100, "{up:?} is no blue");
        assert_eq!(wheel_colour(0.0, 0.0), [255; 3]);
        assert!(wheel_colour(2.0, 0.0).iter().zip(right).all(|(beyond, rim)| *beyond < rim));
    }

    #[test]
    fn what_is_not_valid_is_grey() {
        let mut flow = FlowField::zero(2, 1);
        flow.u.values_mut()[1] = f32::NAN;
        let valid = Image::from_vec(2, 1, vec![0, 1]).unwrap();
        assert_eq!(flow_colours(&flow, &valid, 1.0).values(), [INVALID_COLOUR; 2]);
    }
}
