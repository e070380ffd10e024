//! A layer that adds a function of the mean over the whole gel to every cell.

use super::plane::Plane;

/// Adds a linear function of the mean over all cells to every cell, then sets negative values to zero.
#[derive(Debug, Clone)]
pub(super) struct GlobalContext {
    /// `[output][input]`.
    weights: Vec<f32>,
    bias: Vec<f32>,
    mean: Vec<f32>,
    change: Vec<f32>,
}

impl GlobalContext {
    /// Number of weights and biases of a matrix from this many channels to as many.
    pub(super) fn len(channels: usize) -> usize {
        channels * (channels + 1)
    }

    /// From the weights `[output][input]` followed by a bias for each output.
    pub(super) fn new(channels: usize, values: &[f32]) -> Self {
        let (weights, bias) = values.split_at(channels * channels);
        Self { weights: weights.to_vec(), bias: bias.to_vec(), mean: vec![0.0; channels], change: vec![0.0; channels] }
    }

    /// Changes all cells.
    pub(super) fn apply(&mut self, plane: &mut Plane) {
        assert_eq!(plane.channels, self.bias.len(), "channels of the layer");
        self.mean.fill(0.0);
        for row in 0..plane.rows {
            for cell in plane.row(row).chunks_exact(plane.channels) {
                self.mean.iter_mut().zip(cell).for_each(|(sum, value)| *sum += value);
            }
        }
        let count = (plane.columns * plane.rows) as f32;
        self.mean.iter_mut().for_each(|sum| *sum /= count);
        let rows = self.weights.chunks_exact(plane.channels);
        for ((change, weights), bias) in self.change.iter_mut().zip(rows).zip(&self.bias) {
            *change = bias + weights.iter().zip(&self.mean).map(|(weight, mean)| weight * mean).sum::<f32>();
        }
        for row in 0..plane.rows {
            for cell in plane.row_mut(row).chunks_exact_mut(self.bias.len()) {
                cell.iter_mut().zip(&self.change).for_each(|(value, change)| *value = (*value + change).max(0.0));
            }
        }
    }
}
