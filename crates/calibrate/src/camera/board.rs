//! Computes the mean flow of a sliding board on a grid.

use std::mem::swap;

use fingervision_flow::{Estimate, FlowEstimator, FlowParams, Picture, Reference, Start};
use fingervision_image::{Frame, Rect};

use super::Slide;
use super::error::{BoardError, LEAST_IMAGES};
use super::steps::{check_slide, median, usual_step};
use super::thresholds::THRESHOLDS;

/// Nodes of the grid along each axis, as published.
pub const GRID: usize = 100;

/// The mean flow at a node of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Column and row in the grid.
    pub place: [usize; 2],
    /// The pixel, in the region of interest.
    pub px: [f64; 2],
    /// The board's mean displacement from image to image there, px.
    pub flow_px: [f64; 2],
}

/// The flow of one slide, averaged over all pairs of neighbouring images.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardFlow {
    /// Columns and rows of the region of interest, px.
    pub size: (usize, usize),
    /// Number of images.
    pub images: usize,
    /// The slide.
    pub slide: Slide,
    /// The flow of the usual step, median over the image, px.
    pub usual_px: [f64; 2],
    /// The nodes that were tracked in enough of the pairs, row by row.
    pub nodes: Vec<Node>,
}

/// Tracks a board from image to image: it takes the frames in order, then gives the mean flow.
///
/// Every pair is matched independently, without a start, so a wrong step does not affect the next. Only valid flow
/// enters a node's mean.
#[derive(Debug)]
pub struct BoardTracker {
    region: Rect,
    estimator: FlowEstimator,
    reference: Reference,
    current: Picture,
    before: Picture,
    estimate: Estimate,
    images: usize,
    /// For each node of the grid its valid flows.
    samples: Vec<Vec<[f32; 2]>>,
    /// Of each pair the median flow, px.
    pairs: Vec<[f64; 2]>,
}

impl BoardTracker {
    /// A tracker for the region of interest of frames in grey or colour.
    ///
    /// # Errors
    ///
    /// [`BoardError::Flow`] for a region too small or parameters out of range.
    pub fn new(region: Rect, is_colour: bool, params: &FlowParams) -> Result<Self, BoardError> {
        let params = FlowParams { colour: params.colour && is_colour, ..*params };
        let estimator = FlowEstimator::new(region.width, region.height, &params)?;
        Ok(Self {
            region,
            reference: estimator.reference(),
            current: estimator.picture(),
            before: estimator.picture(),
            estimate: Estimate::new(region.width, region.height),
            estimator,
            images: 0,
            samples: vec![Vec::new(); GRID * GRID],
            pairs: Vec::new(),
        })
    }

    /// Takes the next image.
    ///
    /// # Errors
    ///
    /// [`BoardError::NoTexture`] and [`BoardError::NoMatch`] if it cannot be tracked, [`BoardError::Image`] if its size
    /// is another.
    pub fn push(&mut self, frame: &Frame) -> Result<(), BoardError> {
        swap(&mut self.current, &mut self.before);
        self.current.load(&frame.pixels, self.region)?;
        self.images += 1;
        if self.images > 1 {
            self.follow()?;
        }
        Ok(())
    }

    /// The flow of the last two images; none before there are two.
    #[must_use]
    pub fn last_pair(&self) -> Option<&Estimate> {
        (self.images > 1).then_some(&self.estimate)
    }

    fn follow(&mut self) -> Result<(), BoardError> {
        let image = self.images - 1;
        self.estimator.prepare(&self.before, &mut self.reference);
        let textured = self.reference.textured();
        if textured < THRESHOLDS.least_textured {
            return Err(BoardError::NoTexture { image, textured });
        }
        self.estimator.estimate(&self.reference, &self.current, Start::Search(None), &mut self.estimate);
        let matched = self.estimate.matched;
        if matched < THRESHOLDS.least_matched {
            return Err(BoardError::NoMatch { image, matched });
        }
        let mut flows = [Vec::new(), Vec::new()];
        let (flow, valid) = (&self.estimate.flow, &self.estimate.valid);
        for (node, samples) in self.samples.iter_mut().enumerate() {
            let [x, y] = pixel([node % GRID, node / GRID], &self.region);
            if valid.at(x, y) != 0 {
                let sample = [flow.u.at(x, y), flow.v.at(x, y)];
                samples.push(sample);
                flows[0].push(f64::from(sample[0]));
                flows[1].push(f64::from(sample[1]));
            }
        }
        if flows[0].is_empty() {
            return Err(BoardError::NoMatch { image, matched: 0.0 });
        }
        self.pairs.push(flows.map(median));
        Ok(())
    }

    /// The mean flow, after the steps have been checked; `known_flow_px` is the flow of the slide predicted by a known
    /// camera, px.
    ///
    /// # Errors
    ///
    /// [`BoardError`] naming what is wrong with the slide.
    pub fn finish(&self, slide: Slide, known_flow_px: Option<[f64; 2]>) -> Result<BoardFlow, BoardError> {
        let images = self.images;
        if images < LEAST_IMAGES {
            return Err(BoardError::TooFewImages { images });
        }
        let usual_px = usual_step(&self.pairs)?;
        check_slide(usual_px, slide, known_flow_px)?;
        let least = (THRESHOLDS.least_pairs * self.pairs.len() as f64).ceil() as usize;
        let nodes = self.samples.iter().enumerate().filter(|(_, samples)| samples.len() >= least);
        let nodes: Vec<Node> = nodes
            .map(|(node, samples)| {
                let place = [node % GRID, node / GRID];
                let px = pixel(place, &self.region).map(|value| value as f64);
                Node { place, px, flow_px: [0, 1].map(|axis| robust_mean(samples.iter().map(|flow| flow[axis]))) }
            })
            .collect();
        let part = nodes.len() as f64 / (GRID * GRID) as f64;
        if part < THRESHOLDS.least_seen {
            return Err(BoardError::TooLittleSeen { part });
        }
        Ok(BoardFlow { size: (self.region.width, self.region.height), images, slide, usual_px, nodes })
    }
}

/// The pixel nearest to the middle of a grid's cell.
pub(super) fn pixel(place: [usize; 2], region: &Rect) -> [usize; 2] {
    let along = |place: usize, size: usize| (2 * place + 1) * size / (2 * GRID);
    [along(place[0], region.width), along(place[1], region.height)]
}

/// The mean of the values near the median.
fn robust_mean(values: impl Iterator<Item = f32>) -> f64 {
    let values: Vec<f64> = values.map(f64::from).collect();
    let middle = median(values.clone());
    // 1.4826 median deviations are a standard deviation of normal noise.
    let deviation = 1.4826 * median(values.iter().map(|value| (value - middle).abs()).collect());
    let limit = THRESHOLDS.outlier_px.max(THRESHOLDS.outlier_deviations * deviation);
    let near: Vec<f64> = values.into_iter().filter(|value| (value - middle).abs() <= limit).collect();
    near.iter().sum::<f64>() / near.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_leaves_out_what_is_far_off() {
        let found = robust_mean([1.0, 1.02, 0.98, 1.0, 7.0].into_iter());
        assert!((found - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn the_grid_lies_within_the_region() {
        let region = Rect { x: 7, y: 9, width: 480, height: 70 };
        assert_eq!((pixel([0, 0], &region), pixel([99, 99], &region)), ([2, 0], [477, 69]));
    }
}
