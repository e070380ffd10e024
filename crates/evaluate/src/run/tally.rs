//! Adds up the errors of one quantity in one region: frame by frame, and over all frames in bounded memory.

use super::Errors;
use super::correlation::Correlation;
use super::histogram::{Histogram, quantile};

const PERCENTILE: f64 = 0.95;

/// The errors of a frame while it is read, and of all frames before.
#[derive(Debug)]
pub(super) struct Tally {
    frame: Sums,
    frame_errors: Vec<f32>,
    all: Sums,
    all_errors: Histogram,
}

impl Tally {
    pub(super) fn new() -> Self {
        Self { frame: Sums::default(), frame_errors: Vec::new(), all: Sums::default(), all_errors: Histogram::new() }
    }

    /// Adds a pixel: the estimated and the true value, and the error.
    pub(super) fn push(&mut self, estimate: f64, truth: f64, error: f64) {
        self.frame.push(estimate, truth, error);
        self.frame_errors.push(error as f32);
    }

    /// The errors of the frame, which ends here; none if it has no pixel in this region.
    pub(super) fn end_frame(&mut self) -> Option<Errors> {
        self.frame_errors.iter().for_each(|&error| self.all_errors.push(error));
        let errors = self.frame.errors(quantile(&mut self.frame_errors, PERCENTILE));
        self.all.merge(&self.frame);
        self.frame = Sums::default();
        self.frame_errors.clear();
        errors
    }

    /// The errors of all pixels of all frames that ended; none if there are none.
    pub(super) fn pooled(&self) -> Option<Errors> {
        self.all.errors(self.all_errors.quantile(PERCENTILE))
    }
}

#[derive(Debug, Clone, Copy)]
struct Sums {
    pixels: u64,
    error: f64,
    squared_error: f64,
    difference: f64,
    largest: f64,
    highest_estimate: f64,
    highest_truth: f64,
    pairs: Correlation,
}

impl Default for Sums {
    fn default() -> Self {
        let lowest = f64::NEG_INFINITY;
        Self {
            pixels: 0,
            error: 0.0,
            squared_error: 0.0,
            difference: 0.0,
            largest: 0.0,
            highest_estimate: lowest,
            highest_truth: lowest,
            pairs: Correlation::default(),
        }
    }
}

impl Sums {
    fn push(&mut self, estimate: f64, truth: f64, error: f64) {
        self.pixels += 1;
        self.error += error;
        self.squared_error += error * error;
        self.difference += estimate - truth;
        self.largest = self.largest.max(error);
        self.highest_estimate = self.highest_estimate.max(estimate);
        self.highest_truth = self.highest_truth.max(truth);
        self.pairs.push(estimate, truth);
    }

    fn merge(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.error += other.error;
        self.squared_error += other.squared_error;
        self.difference += other.difference;
        self.largest = self.largest.max(other.largest);
        self.highest_estimate = self.highest_estimate.max(other.highest_estimate);
        self.highest_truth = self.highest_truth.max(other.highest_truth);
        self.pairs.merge(&other.pairs);
    }

    fn errors(&self, percentile_95: Option<f64>) -> Option<Errors> {
        let pixels = self.pixels as f64;
        Some(Errors {
            pixels: self.pixels,
            mean: self.error / pixels,
            root_mean_square: (self.squared_error / pixels).sqrt(),
            // A bin's middle may lie beyond its largest number.
            percentile_95: percentile_95?.min(self.largest),
            largest: self.largest,
            bias: self.difference / pixels,
            true_peak: self.highest_truth,
            estimated_peak: self.highest_estimate,
            correlation: self.pairs.coefficient(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_apart_and_pooled() {
        let mut tally = Tally::new();
        assert_eq!(tally.end_frame(), None);
        for (estimate, truth) in [(1.0, 2.0), (2.5, 2.0), (0.0, 0.0), (4.0, 3.0)] {
            tally.push(estimate, truth, f64::abs(estimate - truth));
        }
        let first = tally.end_frame().unwrap();
        assert_eq!((first.pixels, first.largest, first.percentile_95), (4, 1.0, 1.0));
        assert_eq!((first.mean, first.bias), (0.625, 0.125));
        assert!((first.root_mean_square - 0.75).abs() < 1e-12);
        assert_eq!((first.estimated_peak, first.true_peak), (4.0, 3.0));
        tally.push(-9.0, 1.0, 10.0);
        let second = tally.end_frame().unwrap();
        assert_eq!((second.pixels, second.mean, second.bias, second.correlation), (1, 10.0, -10.0, None));
        assert_eq!((second.estimated_peak, second.true_peak), (-9.0, 1.0));

        let pooled = tally.pooled().unwrap();
        assert_eq!((pooled.pixels, pooled.mean, pooled.bias), (5, 2.5, -1.9));
        assert_eq!((pooled.largest, pooled.estimated_peak, pooled.true_peak), (10.0, 4.0, 3.0));
        assert!((pooled.root_mean_square - (102.25_f64 / 5.0).sqrt()).abs() < 1e-12);
    }
}
