//! The residuals of the camera.

use fingervision_image::Image;
use fingervision_optics::Camera;
use serde::Serialize;

use super::board::GRID;
use super::model::board_flow;
use super::{BoardFlow, Node};

/// Mean and standard deviation of the residual's length, px.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residuals {
    /// Number of nodes.
    pub nodes: usize,
    /// Mean, px.
    pub mean_px: f64,
    /// Standard deviation, px.
    pub deviation_px: f64,
    /// Largest, px.
    pub largest_px: f64,
}

impl Residuals {
    /// Statistics of residual vectors, px; nodes that are not visible are skipped.
    pub(super) fn of(residuals: impl Iterator<Item = Option<[f64; 2]>>) -> Self {
        let lengths: Vec<f64> = residuals.flatten().map(|[x, y]| x.hypot(y)).collect();
        let count = lengths.len() as f64;
        let mean_px = lengths.iter().sum::<f64>() / count;
        let squares: f64 = lengths.iter().map(|length| (length - mean_px).powi(2)).sum();
        let largest_px = lengths.iter().copied().fold(0.0, f64::max);
        Self { nodes: lengths.len(), mean_px, deviation_px: (squares / count).sqrt(), largest_px }
    }

    /// Root mean square of the length, px.
    #[must_use]
    pub fn root_mean_square_px(&self) -> f64 {
        self.mean_px.hypot(self.deviation_px)
    }
}

/// Lengths of the residuals on the grid, px; not a number where the board was not tracked.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualMap {
    /// Columns and rows of the region of interest, px.
    pub size: (usize, usize),
    /// Of the plain camera.
    pub before_px: Image<f32>,
    /// Of the fitted camera.
    pub after_px: Image<f32>,
}

impl ResidualMap {
    pub(super) fn of(flow: &BoardFlow, before: &Camera, after: &Camera) -> Self {
        let [before_px, after_px] = [before, after].map(|camera| {
            let mut map = Image::filled(GRID, GRID, f32::NAN);
            for node in &flow.nodes {
                if let Some([x, y]) = residual_px(flow, node, camera) {
                    map.row_mut(node.place[1])[node.place[0]] = x.hypot(y) as f32;
                }
            }
            map
        });
        Self { size: flow.size, before_px, after_px }
    }
}

fn residual_px(flow: &BoardFlow, node: &Node, camera: &Camera) -> Option<[f64; 2]> {
    let [u, v] = board_flow(camera, node.px, flow.slide.step_vector_mm())?;
    Some([u - node.flow_px[0], v - node.flow_px[1]])
}

/// Number of nodes that share one error: patches of the flow cover several, and the error of the model is smooth.
///
/// `(1 + 2 Σ ρ_x)(1 + 2 Σ ρ_y)` with the correlation ρ of residuals at this distance in columns or rows, summed to where
/// it first falls below 0.05.
pub(super) fn correlated_samples(flow: &BoardFlow, camera: &Camera) -> f64 {
    const MOST_LAGS: usize = GRID / 4;
    const LEAST_CORRELATION: f64 = 0.05;
    let mut field = Image::filled(GRID, GRID, [f64::NAN; 2]);
    for node in &flow.nodes {
        field.row_mut(node.place[1])[node.place[0]] = residual_px(flow, node, camera).unwrap_or([f64::NAN; 2]);
    }
    let covariance = |lag: [usize; 2]| {
        let pairs = (0..GRID - lag[1]).flat_map(|y| (0..GRID - lag[0]).map(move |x| (x, y)));
        let products = pairs.map(|(x, y)| {
            let ([a, b], [c, d]) = (field.at(x, y), field.at(x + lag[0], y + lag[1]));
            a * c + b * d
        });
        let (sum, count) = products
            .filter(|value| value.is_finite())
            .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        sum / f64::max(count, 1.0)
    };
    let variance = covariance([0, 0]);
    let along = |direction: [usize; 2]| {
        let correlations = (1..=MOST_LAGS).map(|lag| covariance(direction.map(|axis| axis * lag)) / variance);
        1.0 + 2.0 * correlations.take_while(|&correlation| correlation > LEAST_CORRELATION).sum::<f64>()
    };
    if variance > 0.0 { along([1, 0]) * along([0, 1]) } else { 1.0 }
}
