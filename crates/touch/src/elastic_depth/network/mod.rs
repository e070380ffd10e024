//! The network trained on simulated presses: estimates where the gel is touched, and how deep.
//!
//! A convolutional network of the U-Net type ([Ronneberger2015]). Its inputs are the apparent motion of the surface and
//! the slopes of the rays, in mm, at three resolutions; its outputs are depth, contact and the expected error of the
//! depth at every cell. It was trained only on presses of random bodies, gels and cameras by our own simulator
//! (`learn/`), none of them a ready-made scene. Presses that are sheared or twisted are seen twice: whole, and without the
//! displacement by shear and twist, with other weights; of the second estimate only depth is used.
//!
//! The order of sums is fixed, but multiply and add are fused where the processor supports it: one machine always gives
//! the same bits, instruction sets differ in the last ones.

mod convolution;
mod finish;
mod global_context;
#[cfg(test)]
mod golden;
mod plane;
mod shape;
mod symmetry;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod weights_tests;
mod winograd;

use fearless_simd::Level;
use fingervision_elastic::GelBlock;
use fingervision_flow::Team;

use convolution::Convolution;
use finish::Activation;
use global_context::GlobalContext;
use plane::Plane;
use shape::{LANES, Shape};
pub(super) use symmetry::Symmetry;

/// The weights and biases of [`Weights`], as `learn/export.py` writes them: three numbers of channels as little-endian u32, then f32.
const FILES: [&[u8]; 2] =
    [include_bytes!("../../../weights/contact.bin"), include_bytes!("../../../weights/without-drag.bin")];
/// Inputs at every cell: apparent motion (x, y), slope of the ray (x, y), divergence of the motion.
pub(super) const INPUTS: usize = 5;
/// Inputs that are the same for all cells: Poisson's ratio and thickness.
pub(super) const CONSTANTS: usize = 2;
/// Side of the gel that all gels are scaled to, mm.
pub(super) const SIZE_MM: f64 = 30.0;

/// The inputs that are the same for all cells, for a gel scaled to a side of [`SIZE_MM`].
pub(super) fn constants(poissons_ratio: f64, thickness_mm: f64) -> [f32; CONSTANTS] {
    [(poissons_ratio - 0.42) * 8.0, (thickness_mm - 10.0) / 3.0].map(|value| value as f32)
}

/// The training range of gel and camera in words, as tested by `Sensor::is_in_training_range`.
pub const TRAINING_RANGE: &str = "nearly square gels 0.2 to 0.5 of their side thick, of Poisson's ratio 0.29 to 0.5, seen from 0.4 to \
                               1.4 of their side";

/// A gel and its distance from the camera, scaled to a longer side of [`SIZE_MM`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sensor {
    pub(super) poissons_ratio: f64,
    pub(super) thickness_mm: f64,
    /// The shorter side.
    pub(super) shorter_mm: f64,
    /// Distance from the camera to the gel.
    pub(super) distance_mm: f64,
}

impl Sensor {
    /// A gel at this distance, mm, scaled: elasticity has no length scale.
    pub(super) fn new(gel: &GelBlock, distance_mm: f64) -> Self {
        let [width_mm, height_mm] = gel.size_mm;
        let scale = SIZE_MM / width_mm.max(height_mm);
        Self {
            poissons_ratio: gel.poissons_ratio,
            thickness_mm: gel.thickness_mm * scale,
            shorter_mm: width_mm.min(height_mm) * scale,
            distance_mm: distance_mm * scale,
        }
    }

    /// Whether the network can be used for such a gel.
    pub(super) fn network_applies(&self) -> bool {
        (0.29..=0.5).contains(&self.poissons_ratio) && (6.0..=15.0).contains(&self.thickness_mm)
    }

    /// Whether gel and distance are inside the training range.
    pub(super) fn is_in_training_range(&self) -> bool {
        self.network_applies() && self.shorter_mm >= 0.9 * SIZE_MM && (12.0..=42.0).contains(&self.distance_mm)
    }
}

/// Depth, the logarithm of the odds of contact, and the logarithm of the expected error of the depth.
pub(super) const OUTPUTS: usize = 3;
/// Sides of the grid must be multiples of this, and at least [`LEAST_SIDE`].
pub(super) const MULTIPLE: usize = 8;
/// The least side of a grid, cells: the coarsest resolution then has as many cells as a layer computes together.
pub(super) const LEAST_SIDE: usize = convolution::CELLS * MULTIPLE;

/// Largest number of channels of a layer that a file of weights may contain.
const MOST_CHANNELS: usize = 4096;

/// The motion that weights were trained for. Both networks have the same layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weights {
    /// All that the camera sees.
    Whole,
    /// What is left after the motion by shear and twist was subtracted.
    WithoutDrag,
}

/// The network with buffers for one grid.
#[derive(Debug, Clone)]
pub(super) struct ContactNetwork {
    level: Level,
    team: Team,
    /// Of each of [`Weights`].
    layers: [Layers; 2],
    input: Plane,
    fine: [Plane; 2],
    middle: [Plane; 2],
    coarse: [Plane; 2],
    middle_lifted: Plane,
    fine_lifted: Plane,
    output: Plane,
}

#[derive(Debug, Clone)]
struct Layers {
    enter: [Convolution; 2],
    down: [Convolution; 2],
    deep: [Convolution; 3],
    whole: GlobalContext,
    up: [Convolution; 3],
    leave: [Convolution; 3],
    output: Convolution,
}

impl ContactNetwork {
    /// Buffers for a grid of cells, both sides multiples of [`MULTIPLE`] and at least [`LEAST_SIDE`].
    pub(super) fn new((columns, rows): (usize, usize)) -> Self {
        let read = FILES.map(|file| Layers::read(file).expect("the weights that are built in are whole"));
        let [fine, middle, coarse] = read[0].0;
        assert_eq!(read[0].0, read[1].0, "both networks use the same buffers");
        assert!(
            read[0].0.iter().all(|channels| channels.is_multiple_of(LANES)),
            "the channels of a cell fill registers"
        );
        let plane = |part: usize, channels: usize| Plane::new((columns / part, rows / part), channels);
        let pair = |part: usize, channels: usize| [plane(part, channels), plane(part, channels)];
        Self {
            level: Level::new(),
            team: Team::default(),
            input: plane(2, 4 * INPUTS + CONSTANTS),
            fine: pair(2, fine),
            middle: pair(4, middle),
            coarse: pair(8, coarse),
            middle_lifted: plane(8, middle),
            fine_lifted: plane(4, fine),
            output: plane(2, (4 * OUTPUTS).next_multiple_of(LANES)),
            layers: read.map(|(_, layers)| layers),
        }
    }

    /// Sets the threads that share the work.
    pub(super) fn share(&mut self, team: &Team) {
        self.team = team.clone();
    }

    /// Depth, mm, the logarithm of the odds of contact and that of the depth's expected error, mm, for every cell;
    /// `input` gives the inputs of a cell `(column, row)`.
    pub(super) fn run(
        &mut self,
        weights: Weights,
        constants: [f32; CONSTANTS],
        input: impl Fn(usize, usize) -> [f32; INPUTS],
        mut write: impl FnMut(usize, usize, [f32; OUTPUTS]),
    ) {
        self.load(constants, input);
        self.forward(weights);
        for row in 0..self.output.rows {
            for (column, cell) in self.output.row(row).chunks_exact(self.output.channels).enumerate() {
                for part in 0..4 {
                    write(
                        2 * column + part % 2,
                        2 * row + part / 2,
                        std::array::from_fn(|output| cell[4 * output + part]),
                    );
                }
            }
        }
    }

    fn load(&mut self, constants: [f32; CONSTANTS], input: impl Fn(usize, usize) -> [f32; INPUTS]) {
        for row in 0..self.input.rows {
            for (column, cell) in self.input.row_mut(row).chunks_exact_mut(4 * INPUTS + CONSTANTS).enumerate() {
                for part in 0..4 {
                    for (channel, value) in input(2 * column + part % 2, 2 * row + part / 2).into_iter().enumerate() {
                        cell[4 * channel + part] = value;
                    }
                }
                cell[4 * INPUTS..].copy_from_slice(&constants);
            }
        }
    }

    fn forward(&mut self, weights: Weights) {
        use Activation::{AddGrownAndRectify, Keep, Rectify, RectifyAndAdd};
        let (level, team, layers) = (self.level, &self.team, &mut self.layers[weights as usize]);
        let [fine, fine_kept] = &mut self.fine;
        let [middle, middle_kept] = &mut self.middle;
        let [coarse, coarse_kept] = &mut self.coarse;
        layers.enter[0].apply(level, team, &self.input, fine, Rectify);
        layers.enter[1].apply(level, team, fine, fine_kept, RectifyAndAdd);
        layers.down[0].apply(level, team, fine_kept, middle, Rectify);
        layers.down[1].apply(level, team, middle, middle_kept, RectifyAndAdd);
        layers.deep[0].apply(level, team, middle_kept, coarse, Rectify);
        layers.deep[1].apply(level, team, coarse, coarse_kept, RectifyAndAdd);
        layers.deep[2].apply(level, team, coarse_kept, coarse, RectifyAndAdd);
        layers.whole.apply(coarse);
        layers.up[0].apply(level, team, coarse, &mut self.middle_lifted, Keep);
        layers.up[1].apply(level, team, middle_kept, middle, AddGrownAndRectify(&self.middle_lifted));
        layers.up[2].apply(level, team, middle, middle_kept, RectifyAndAdd);
        layers.leave[0].apply(level, team, middle_kept, &mut self.fine_lifted, Keep);
        layers.leave[1].apply(level, team, fine_kept, fine, AddGrownAndRectify(&self.fine_lifted));
        layers.leave[2].apply(level, team, fine, fine_kept, RectifyAndAdd);
        layers.output.apply(level, team, fine_kept, &mut self.output, Keep);
    }
}

impl Layers {
    /// The three numbers of channels and the layers of a file of weights; none if the file does not contain exactly
    /// these.
    fn read(file: &[u8]) -> Option<([usize; 3], Self)> {
        let (words, []) = file.as_chunks::<4>() else { return None };
        let (sizes, values) = words.split_first_chunk::<3>()?;
        let channels = sizes.map(|word| u32::from_le_bytes(word) as usize);
        if channels.iter().any(|channels| !(1..=MOST_CHANNELS).contains(channels)) {
            return None;
        }
        let values: Vec<f32> = values.iter().map(|&word| f32::from_le_bytes(word)).collect();
        let mut file = Reader(&values);
        let [fine, middle, coarse] = channels;
        let layers = Self {
            enter: [file.layer(4 * INPUTS + CONSTANTS, fine, 3, 1)?, file.layer(fine, fine, 3, 1)?],
            down: [file.layer(fine, middle, 3, 2)?, file.layer(middle, middle, 3, 1)?],
            deep: [
                file.layer(middle, coarse, 3, 2)?,
                file.layer(coarse, coarse, 3, 1)?,
                file.layer(coarse, coarse, 3, 1)?,
            ],
            whole: GlobalContext::new(coarse, file.take(GlobalContext::len(coarse))?),
            up: [
                file.layer(coarse, middle, 1, 1)?,
                file.layer(middle, middle, 3, 1)?,
                file.layer(middle, middle, 3, 1)?,
            ],
            leave: [file.layer(middle, fine, 1, 1)?, file.layer(fine, fine, 3, 1)?, file.layer(fine, fine, 3, 1)?],
            output: file.layer(fine, 4 * OUTPUTS, 1, 1)?,
        };
        file.0.is_empty().then_some((channels, layers))
    }
}

/// The unread part of a weights file.
struct Reader<'a>(&'a [f32]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [f32]> {
        let (own, others) = self.0.split_at_checked(count)?;
        self.0 = others;
        Some(own)
    }

    fn layer(&mut self, inputs: usize, outputs: usize, side: usize, stride: usize) -> Option<Convolution> {
        let shape = Shape { inputs, outputs, side, stride };
        self.take(shape.len()).map(|values| Convolution::new(shape, values))
    }
}
