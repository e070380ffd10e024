//! Three panels of one quantity: truth, estimate and their difference.

use fingervision_flow::FlowField;
use fingervision_image::Image;

use super::Pair;
use crate::canvas::{Area, Canvas};
use crate::colour::Rgb;
use crate::flow_colours::{LEAST_FLOW_PX, flow_colours};
use crate::heat_map::{HeatScale, heat_map};
use crate::keys::{draw_colour_bar, draw_invalid_key, draw_wheel_key};
use crate::outline::{Outline, draw_outline_key};
use crate::page::NOTE;
use crate::panel::Panel;
use crate::ticks::round_up;

/// The end of a scale covers this many of 1000 values, so that a few outliers have no effect.
const TYPICAL: usize = 999;

/// A row of panels and their common data.
pub(super) struct Row<'a> {
    pub(super) panels: [Panel; 3],
    pub(super) seen: &'a Image<u8>,
    pub(super) valid: &'a Image<u8>,
    pub(super) outline: Option<&'a Outline>,
}

impl Row<'_> {
    pub(super) fn draw_depth(&self, canvas: &mut Canvas, pair: &Pair<Image<f32>>) {
        let both = both(self.seen, self.valid);
        let difference = zipped(pair.estimate, pair.truth, |estimate, truth| estimate - truth);
        let limit = shared_limit(typical(pair.truth, self.seen), typical(pair.estimate, self.valid));
        let scale = HeatScale::around_zero(limit);
        let error_scale = HeatScale::around_zero(round_up(typical(&difference, &both)));

        let [truth, estimate, error] = self.panels;
        self.put(canvas, truth, "True depth, mm", &heat_map(pair.truth, self.seen, scale));
        self.put(canvas, estimate, "Estimated depth, mm", &heat_map(pair.estimate, self.valid, scale));
        self.put(canvas, error, "Depth: estimate − truth, mm", &heat_map(&difference, &both, error_scale));
        draw_bar(canvas, truth, scale, "Red is pressed in, blue bulges out.");
        draw_bar(canvas, estimate, scale, "The same scale.");
        draw_bar(canvas, error, error_scale, "Red is estimated too deep, blue too shallow.");
        self.draw_keys(canvas, 3.4);
    }

    pub(super) fn draw_flow(&self, canvas: &mut Canvas, pair: &Pair<FlowField>) {
        let both = both(self.seen, self.valid);
        let length = |flow: &FlowField| zipped(&flow.u, &flow.v, f32::hypot);
        let along_x = zipped(&pair.estimate.u, &pair.truth.u, |estimate, truth| estimate - truth);
        let along_y = zipped(&pair.estimate.v, &pair.truth.v, |estimate, truth| estimate - truth);
        let difference = zipped(&along_x, &along_y, f32::hypot);
        let longest =
            shared_limit(typical(&length(pair.truth), self.seen), typical(&length(pair.estimate), self.valid));
        let radius_px = round_up(longest.max(LEAST_FLOW_PX));
        let error_scale = HeatScale::from_zero(round_up(typical(&difference, &both)));

        let [truth, estimate, error] = self.panels;
        self.put(canvas, truth, "True flow", &flow_colours(pair.truth, self.seen, radius_px));
        self.put(canvas, estimate, "Estimated flow", &flow_colours(pair.estimate, self.valid, radius_px));
        self.put(canvas, error, "Flow: length of estimate − truth, px", &heat_map(&difference, &both, error_scale));
        draw_wheel_key(canvas, truth, radius_px);
        canvas.text("The same wheel.", (estimate.legend.x, estimate.line(0.0)), NOTE);
        draw_bar(canvas, error, error_scale, "Distance between the estimated and the true place.");
    }

    fn put(&self, canvas: &mut Canvas, panel: Panel, heading: &str, image: &Image<Rgb>) {
        panel.put(canvas, heading, &panel.fit(image));
        if let Some(outline) = self.outline {
            outline.draw(canvas, panel);
        }
    }

    /// The meaning of the line and the grey, on a line of the legends.
    fn draw_keys(&self, canvas: &mut Canvas, line: f32) {
        let [truth, estimate, error] = self.panels;
        if self.outline.is_some() {
            let y = truth.line(line);
            let x = draw_outline_key(canvas, (truth.legend.x, y));
            canvas.text("border of the true contact", (x, y), NOTE);
        }
        draw_invalid_key(canvas, (estimate.legend.x, estimate.line(line)), "not valid");
        draw_invalid_key(canvas, (error.legend.x, error.line(line)), "hidden or not valid");
    }
}

fn draw_bar(canvas: &mut Canvas, panel: Panel, scale: HeatScale, note: &str) {
    draw_colour_bar(canvas, Area { height: 16.0, ..panel.legend }, scale);
    canvas.text(note, (panel.legend.x, panel.line(2.2)), NOTE);
}

/// The end of the common scale of truth and estimate. An estimate with a large error must not make the truth invisible:
/// it counts at most twice.
fn shared_limit(truth: f32, estimate: f32) -> f32 {
    round_up(if truth > 0.0 { estimate.clamp(truth, 2.0 * truth) } else { estimate })
}

fn both(seen: &Image<u8>, valid: &Image<u8>) -> Image<u8> {
    zipped(seen, valid, |seen, valid| seen & valid)
}

fn zipped<T: Copy, U>(a: &Image<T>, b: &Image<T>, value: impl Fn(T, T) -> U) -> Image<U> {
    assert_eq!(a.size(), b.size(), "sizes of the fields");
    Image::from_fn(a.width(), a.height(), |x, y| value(a.at(x, y), b.at(x, y)))
}

/// The absolute value that nearly all values of a mask do not exceed; 0 where there are none.
fn typical(values: &Image<f32>, mask: &Image<u8>) -> f32 {
    let sizes = values.values().iter().zip(mask.values()).filter(|(value, mask)| **mask != 0 && value.is_finite());
    let mut sizes: Vec<f32> = sizes.map(|(value, _)| value.abs()).collect();
    let Some(last) = sizes.len().checked_sub(1) else { return 0.0 };
    *sizes.select_nth_unstable_by((last * TYPICAL).div_ceil(1000), f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_far_off_does_not_wash_out_the_truth() {
        for (truth, estimate, expected) in [(2.0, 1.0, 2.0), (2.0, 3.0, 3.0), (2.0, 90.0, 4.0), (0.0, 3.0, 3.0)] {
            let limit = shared_limit(truth, estimate);
            assert!((limit - expected).abs() < 1e-4, "{truth} and {estimate}: {limit} instead of {expected}");
        }
    }

    #[test]
    fn what_is_masked_does_not_set_the_scale() {
        let values = Image::from_vec(4, 1, vec![1.0, -2.0, 99.0, f32::NAN]).unwrap();
        let mask = Image::from_vec(4, 1, vec![1, 1, 0, 1]).unwrap();
        assert!((typical(&values, &mask) - 2.0).abs() < 1e-6);
        assert!(typical(&values, &Image::filled(4, 1, 0)).abs() < 1e-6);
    }
}
