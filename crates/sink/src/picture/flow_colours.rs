//! Flow as colour: hue tells the direction, strength of colour the length.
//!
//! The wheel of Baker et al., "A Database and Evaluation Methodology for Optical Flow", IJCV 2011: 55 hues, spaced so
//! that they look evenly spaced; white where nothing moves, darker beyond the wheel's radius.

use std::array::from_fn;
use std::f32::consts::PI;

use fingervision_flow::FlowField;
use fingervision_image::Image;

use super::{INVALID_COLOUR, Rgb};

/// Hues on the way from each pure colour to the next: red, yellow, green, cyan, blue, magenta, red.
const HUES: [usize; 6] = [15, 6, 4, 11, 13, 6];
/// All hues.
const HUE_COUNT: usize = 55;
/// The channel that changes on each of these ways, and whether it rises.
const CHANGES: [(usize, bool); 6] = [(1, true), (0, false), (2, true), (1, false), (0, true), (2, false)];

/// The colours of a flow field on a wheel of radius `max_px`; [`INVALID_COLOUR`] where `valid` is 0.
///
/// Rightwards is red, downwards yellow, leftwards cyan, upwards violet.
///
/// # Panics
///
/// If field and mask differ in size.
#[must_use]
pub fn flow_colours(flow: &FlowField, valid: &Image<u8>, max_px: f32) -> Image<Rgb> {
    assert_eq!(flow.size(), valid.size(), "sizes of field and mask");
    let wheel = wheel();
    Image::from_fn(valid.width(), valid.height(), |x, y| match valid.at(x, y) {
        0 => INVALID_COLOUR,
        _ => wheel_colour(&wheel, flow.u.at(x, y) / max_px, flow.v.at(x, y) / max_px),
    })
}

/// The wheel itself, `diameter` px across, on a background: the legend of [`flow_colours`].
#[must_use]
pub fn colour_wheel(diameter: usize, background: Rgb) -> Image<Rgb> {
    let wheel = wheel();
    let radius = diameter as f32 / 2.0;
    let offset = |pixel: usize| (pixel as f32 + 0.5) / radius - 1.0;
    Image::from_fn(diameter, diameter, |x, y| {
        let (u, v) = (offset(x), offset(y));
        let inside = (radius * (1.0 - u.hypot(v)) + 0.5).clamp(0.0, 1.0);
        let length = u.hypot(v).max(1.0);
        let colour = wheel_colour(&wheel, u / length, v / length);
        from_fn(|i| (f32::from(background[i]) * (1.0 - inside) + f32::from(colour[i]) * inside).round() as u8)
    })
}

/// The pure hues, each channel from 0 to 1.
fn wheel() -> [[f32; 3]; HUE_COUNT] {
    let mut hues = [[0.0; 3]; HUE_COUNT];
    let mut pure = [1.0, 0.0, 0.0];
    let mut next = hues.iter_mut();
    for (count, (channel, rises)) in HUES.into_iter().zip(CHANGES) {
        for (step, hue) in next.by_ref().take(count).enumerate() {
            let risen = (255.0 * step as f32 / count as f32).floor() / 255.0;
            *hue = pure;
            hue[channel] = if rises { risen } else { 1.0 - risen };
        }
        pure[channel] = if rises { 1.0 } else { 0.0 };
    }
    hues
}

/// The colour of a displacement in units of the wheel's radius.
fn wheel_colour(wheel: &[[f32; 3]; HUE_COUNT], u: f32, v: f32) -> Rgb {
    let length = u.hypot(v);
    if !length.is_finite() {
        return INVALID_COLOUR;
    }
    let place = ((-v).atan2(-u) / (2.0 * PI) + 0.5) * (HUE_COUNT - 1) as f32;
    let below = (place as usize).min(HUE_COUNT - 1);
    let (from, to) = (wheel[below], wheel[(below + 1) % HUE_COUNT]);
    let weight = place - below as f32;
    from_fn(|i| {
        let hue = (1.0 - weight) * from[i] + weight * to[i];
        // Rounding may put the wheel's rim just outside of it.
        let level = if length <= 1.0 + 1e-5 { 1.0 - length.min(1.0) * (1.0 - hue) } else { 0.75 * hue };
        (255.0 * level) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wheel_agrees_with_the_published_program() {
        // From `computeColor` of the Middlebury flow code in double precision; it rounds down, so one level may differ.
        let published: [([f32; 2], Rgb); 6] = [
            ([0.0, 0.0], [255, 255, 255]),
            ([1.0, 0.0], [255, 0, 0]),
            ([0.0, 1.0], [255, 229, 0]),
            ([-1.0, 0.0], [0, 209, 255]),
            ([0.0, -1.0], [88, 0, 255]),
            ([2.0, 0.0], [191, 0, 0]),
        ];
        for ([u, v], expected) in published {
            let colour = wheel_colour(&wheel(), u, v);
            let is_close = colour.iter().zip(expected).all(|(&level, expected)| level.abs_diff(expected) <= 1);
            assert!(is_close, "({u}, {v}): {colour:?} instead of {expected:?}");
        }
    }

    #[test]
    fn what_is_not_valid_is_grey() {
        let mut flow = FlowField::zero(2, 1);
        flow.u.values_mut()[1] = f32::NAN;
        let valid = Image::from_vec(2, 1, vec![0, 1]).unwrap();
        assert_eq!(flow_colours(&flow, &valid, 1.0).values(), [INVALID_COLOUR; 2]);
    }
}
