//! The noise that a pattern's trackability predicts, against the noise of the flow that is measured on rendered frames.

use fingervision_flow::{Estimate, FlowEstimator, FlowField, FlowParams, STRONG_GRADIENT, Start};
use fingervision_gel::{Coupling, Light, Motif, Motion, Pattern, Sheet, SheetRenderer, View, trackability};
use fingervision_image::{Image, Pixels, Rect};

const SIZE_PX: [usize; 2] = [256, 192];
const BORDER_PX: usize = 16;
const NOISE_LEVELS: f64 = 2.0;
/// Frames of one motion, each with noise of its own.
const REPEATS: u64 = 3;
/// Number of estimates, each starting from the one before, until the steps have converged.
const PASSES: usize = 4;
/// Sides of the cells, px; a pixel is 1 mm wide on the gel.
const CELLS_PX: [f64; 7] = [0.8, 1.2, 1.6, 2.4, 4.0, 7.0, 12.0];

/// Noise of the mean of red, green and blue, relative to the noise of one channel.
fn noise_levels(colour: bool) -> f64 {
    let luma = [0.299_f64, 0.587, 0.114].map(|weight| weight * weight).iter().sum::<f64>().sqrt();
    if colour { NOISE_LEVELS } else { luma * NOISE_LEVELS }
}

fn params(colour: bool) -> FlowParams {
    FlowParams { colour, noise_levels: noise_levels(colour) as f32, ..FlowParams::default() }
}

/// Predicted standard deviation of the flow along either axis, px.
fn predicted(cell_px: f64, colour: bool) -> f64 {
    let view = View { noise_levels: noise_levels(colour), colour, ..View::straight_on(SIZE_PX, 1.0).unwrap() };
    let pattern = Pattern { motif: Motif::Colour { cell_mm: cell_px }, ..Pattern::default() };
    let affine = params(colour).affine;
    let row_step = if colour { affine.colour_row_step } else { 1 };
    let coupling = Coupling {
        stride_px: 8.0,
        curvature_px: f64::from(affine.curvature_px),
        row_step,
        strong_gradient: f64::from(STRONG_GRADIENT),
    };
    let [u, v] = coupling.deviation_px(&trackability(&pattern, &view).unwrap()).unwrap();
    (0.5 * (u * u + v * v)).sqrt()
}

struct Bench {
    renderer: SheetRenderer,
    estimator: FlowEstimator,
}

impl Bench {
    fn new(cell_px: f64, colour: bool) -> Self {
        let [width, height] = SIZE_PX;
        let sheet = Sheet { width, height, cell_size_px: cell_px, noise_levels: NOISE_LEVELS, ..Sheet::default() };
        let estimator = FlowEstimator::new(width, height, &params(colour)).unwrap();
        Self { renderer: SheetRenderer::new(&sheet).unwrap(), estimator }
    }

    /// The flow between two noisy frames.
    fn flow(&mut self, motion: &Motion, seed: u64) -> Estimate {
        let [width, height] = SIZE_PX;
        let [reference, current] = [(&Motion::STILL, 2 * seed), (motion, 2 * seed + 1)].map(|(motion, seed)| {
            let mut picture = self.estimator.picture();
            let frame = self.renderer.render(motion, Light::EVEN, seed).unwrap();
            picture.load(&Pixels::Rgb8(frame), Rect::whole(width, height)).unwrap();
            picture
        });
        let mut prepared = self.estimator.reference();
        self.estimator.prepare(&reference, &mut prepared);
        let mut estimate = Estimate::new(width, height);
        let mut start = FlowField::zero(width, height);
        for _ in 0..PASSES {
            self.estimator.estimate(&prepared, &current, Start::Flow(&start), &mut estimate);
            start.copy_from(&estimate.flow);
        }
        estimate
    }

    /// Standard deviation of the flow along either axis, px: the differences between frames of one motion.
    fn measured(&mut self, motion: &Motion, first_seed: u64) -> f64 {
        let flows: Vec<_> = (0..REPEATS).map(|k| self.flow(motion, first_seed + k)).collect();
        let (mut sum, mut count) = (0.0, 0.0);
        for y in BORDER_PX..SIZE_PX[1] - BORDER_PX {
            for x in BORDER_PX..SIZE_PX[0] - BORDER_PX {
                assert!(flows.iter().all(|flow| flow.valid.at(x, y) == 1), "({x}, {y}) is not measured");
                sum += spread(&flows, |flow| &flow.flow.u, x, y) + spread(&flows, |flow| &flow.flow.v, x, y);
                count += 2.0;
            }
        }
        (sum / count).sqrt()
    }
}

/// Variance of a component at a pixel over all flows.
fn spread(flows: &[Estimate], component: impl Fn(&Estimate) -> &Image<f32>, x: usize, y: usize) -> f64 {
    let values = || flows.iter().map(|flow| f64::from(component(flow).at(x, y)));
    let mean = values().sum::<f64>() / flows.len() as f64;
    values().map(|value| (value - mean).powi(2)).sum::<f64>() / (flows.len() - 1) as f64
}

/// Ranks of the values.
fn ranks(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| values.iter().filter(|other| *other < value).count() as f64).collect()
}

/// Spearman's correlation.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let squares = ranks(a).iter().zip(ranks(b)).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

#[test]
fn predicted_noise_is_measured_for_every_cell_size() {
    for colour in [true, false] {
        let (mut predictions, mut measurements) = (Vec::new(), Vec::new());
        for cell_px in CELLS_PX {
            let predicted = predicted(cell_px, colour);
            let mut bench = Bench::new(cell_px, colour);
            let motions = [Motion::STILL, Motion::shift(0.37)];
            let measured = motions.map(|motion| bench.measured(&motion, 100));
            println!("colour {colour}, cells of {cell_px} px: predicted {predicted:.5} px, measured {measured:.5?} px");
            for measured in measured {
                let ratio = measured / predicted;
                assert!(
                    (0.75..1.33).contains(&ratio),
                    "cells of {cell_px} px: {measured} px, predicted {predicted} px"
                );
            }
            predictions.push(predicted);
            measurements.push(0.5 * (measured[0] + measured[1]));
        }
        let correlation = rank_correlation(&predictions, &measurements);
        println!("colour {colour}: rank correlation {correlation:.3}");
        assert!(correlation > 0.8, "rank correlation {correlation}: {predictions:?} and {measurements:?}");
    }
}
