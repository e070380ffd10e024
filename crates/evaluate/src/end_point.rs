//! End-point errors, and how well the predicted deviation agrees with them.

use fingervision_flow::{Estimate, FlowField};
use fingervision_image::Rect;

/// An error beyond which a displacement counts as wrong, px.
const WRONG_PX: f32 = 1.0;

/// The image without a border of this width, px; empty if nothing is left.
#[must_use]
pub fn without_border((width, height): (usize, usize), border: usize) -> Rect {
    let inner = |size: usize| size.saturating_sub(2 * border);
    Rect { x: border, y: border, width: inner(width), height: inner(height) }
}

/// Length of the difference between flow and true flow, px, at every pixel of the region, row by row, valid or not.
pub fn end_point_errors(flow: &FlowField, truth: &FlowField, region: Rect) -> impl Iterator<Item = f32> {
    pixels(region).map(move |(x, y)| error_at(flow, truth, x, y))
}

/// The mean of some errors; not a number if there are none.
#[must_use]
pub fn mean(errors: impl IntoIterator<Item = f32>) -> f64 {
    let (sum, count) = errors.into_iter().fold((0.0, 0), |(sum, count), error| (sum + f64::from(error), count + 1));
    sum / f64::from(count)
}

/// The quantile of the errors, `quantile` from 0 to 1; not a number if there are none.
#[must_use]
pub fn quantile(errors: impl IntoIterator<Item = f32>, quantile: f64) -> f64 {
    let mut errors: Vec<f32> = errors.into_iter().collect();
    let Some(last) = errors.len().checked_sub(1) else { return f64::NAN };
    let place = (quantile.clamp(0.0, 1.0) * last as f64).round() as usize;
    f64::from(*errors.select_nth_unstable_by(place, f32::total_cmp).1)
}

/// How reliable validity and predicted deviation are, summed over estimates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibration {
    pixels: usize,
    valid: usize,
    wrong: usize,
    wrong_but_valid: usize,
    squared_ratios: f64,
}

impl Calibration {
    /// The calibration of one estimate over a region.
    #[must_use]
    pub fn measure(estimate: &Estimate, truth: &FlowField, region: Rect) -> Self {
        let mut sums = Self::default();
        for (x, y) in pixels(region) {
            let error = error_at(&estimate.flow, truth, x, y);
            let (is_valid, is_wrong) = (estimate.valid.at(x, y) == 1, error > WRONG_PX);
            sums.pixels += 1;
            sums.valid += usize::from(is_valid);
            sums.wrong += usize::from(is_wrong);
            sums.wrong_but_valid += usize::from(is_valid && is_wrong);
            if is_valid {
                sums.squared_ratios += f64::from(error / estimate.deviation.at(x, y)).powi(2);
            }
        }
        sums
    }

    /// Both together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            valid: self.valid + other.valid,
            wrong: self.wrong + other.wrong,
            wrong_but_valid: self.wrong_but_valid + other.wrong_but_valid,
            squared_ratios: self.squared_ratios + other.squared_ratios,
        }
    }

    /// Root mean square of error over predicted deviation where valid, dimensionless: 1 if the prediction is right.
    #[must_use]
    pub fn error_over_deviation(&self) -> f64 {
        (self.squared_ratios / self.valid as f64).sqrt()
    }

    /// Part of all pixels that are valid.
    #[must_use]
    pub fn valid_part(&self) -> f64 {
        self.valid as f64 / self.pixels as f64
    }

    /// Part of all pixels with an error of more than 1 px.
    #[must_use]
    pub fn wrong_part(&self) -> f64 {
        self.wrong as f64 / self.pixels as f64
    }

    /// Part of the pixels with an error of more than 1 px that are marked as valid; 0 if there are no such pixels.
    #[must_use]
    pub fn trusted_part_of_wrong(&self) -> f64 {
        self.wrong_but_valid as f64 / self.wrong.max(1) as f64
    }
}

fn pixels(region: Rect) -> impl Iterator<Item = (usize, usize)> {
    let columns = region.x..region.x + region.width;
    (region.y..region.y + region.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

fn error_at(flow: &FlowField, truth: &FlowField, x: usize, y: usize) -> f32 {
    (flow.u.at(x, y) - truth.u.at(x, y)).hypot(flow.v.at(x, y) - truth.v.at(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_distances_inside_the_border() {
        let truth = FlowField::zero(8, 6);
        let mut flow = FlowField::zero(8, 6);
        flow.u.row_mut(3)[4] = 3.0;
        flow.v.row_mut(3)[4] = -4.0;
        flow.u.row_mut(0)[0] = 99.0;
        let errors = || end_point_errors(&flow, &truth, without_border((8, 6), 2));
        assert_eq!(errors().count(), 8);
        assert!((mean(errors()) - 5.0 / 8.0).abs() < 1e-12);
        assert!((quantile(errors(), 1.0) - 5.0).abs() < 1e-12 && quantile(errors(), 0.5).abs() < 1e-12);
        assert!(mean([]).is_nan() && quantile([], 0.5).is_nan());
    }

    #[test]
    fn a_large_error_with_a_small_deviation_is_counted() {
        let truth = FlowField::zero(4, 1);
        let mut estimate = Estimate::new(4, 1);
        estimate.flow.u.values_mut().copy_from_slice(&[0.1, 0.2, 2.0, 3.0]);
        estimate.deviation.values_mut().copy_from_slice(&[0.1, 0.1, 0.1, f32::INFINITY]);
        estimate.valid.values_mut().copy_from_slice(&[1, 1, 1, 0]);
        let calibration = Calibration::measure(&estimate, &truth, Rect::whole(4, 1));
        let expected = ((1.0 + 4.0 + 400.0) / 3.0_f64).sqrt();
        assert!((calibration.error_over_deviation() - expected).abs() < 1e-4);
        let parts = [calibration.valid_part(), calibration.wrong_part(), calibration.trusted_part_of_wrong()];
        let expected = [0.75, 0.5, 0.5];
        assert!(parts.iter().zip(expected).all(|(part, expected)| (part - expected).abs() < 1e-12), "{parts:?}");
        assert_eq!(calibration.and(calibration).pixels, 8);
    }
}
