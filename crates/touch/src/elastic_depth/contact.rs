//! Finds where the gel is touched, and how deep.

use fingervision_elastic::{GelBlock, SurfaceGrid};
use fingervision_flow::Team;

use super::coarse::Around;
use super::face_search::{self, FaceLimits, Scratch};
use super::frozen_strain::FrozenStrain;
use super::network::{
    self, CONSTANTS, ContactNetwork, INPUTS, LEAST_SIDE, MULTIPLE, OUTPUTS, Sensor, Symmetry, Weights,
};
use super::network_inputs;
use super::rigid::{self, AtRest, StuckFace};
use super::stuck_shape::{self, StuckShape};
use super::surface::{self, Seen, Surface, WithoutDrag};
use super::thresholds::THRESHOLDS;
use super::{CELLS, ElasticMode, ElasticParams};

/// Rings of cells left out at the border of contact where a face's motion is fitted: the walls do not belong to the
/// face.
const RIM_CELLS: usize = 3;

/// Ratio of the standard deviation of depth to the mean absolute error that the network predicts. It is 1.41 for the
/// Laplace distribution that was assumed in training. On images of another program, 95 % of the errors are within 1.83
/// to 2.39 such deviations, so the value is 13 % larger.
const DEVIATION: f32 = 1.6;
/// Largest number of cells used to fit a face's motion: more cells take time, but do not improve the fit.
const MOST_POINTS: usize = 600;

/// Finds contact in every frame.
#[derive(Debug)]
pub(super) struct ContactFinder {
    /// The network, if it is switched on and applies to the gel.
    network: Option<ContactNetwork>,
    face_scratch: Scratch,
    strain: FrozenStrain,
    /// Whether contact moves with the shape that it had before it was dragged.
    has_shape: bool,
    /// The size of the network's grid: the surface's, padded to a multiple of what the network needs.
    padded: (usize, usize),
    constants: [f32; CONSTANTS],
    /// Mirror images and quarter turns in which the network is evaluated.
    symmetries: Vec<Symmetry>,
    /// Its inputs for the cells of its grid.
    inputs: Vec<[f32; INPUTS]>,
    /// Its estimates for the cells.
    estimated: Vec<[f32; OUTPUTS]>,
    /// Factor from mm to the network's length scale, in which the gel has the side used in training.
    scale: f32,
    /// Thickness of the gel, mm.
    thickness_mm: f64,
    /// Allowed difference between a point of the gel and a stuck face's motion, mm: its least value, and the value in
    /// the last frame.
    least_noise_mm: f64,
    noise_mm: f64,
    /// Whether the deviation of the flow is far larger than that of the training images.
    pub(super) is_flow_uncertain: bool,
    /// Error of depth, mm, caused by the part of the flow's error that the network's estimate does not include.
    flow_deviation_mm: f32,
    /// Whether each cell is touched.
    pub(super) touches: Vec<bool>,
    /// The part of each cell that is touched, 0 to 1; above one half, the cell counts as touched.
    pub(super) share: Vec<f32>,
    /// Depth of each cell, mm.
    pub(super) depth_mm: Vec<f32>,
    /// Depth that the network estimates from the whole motion, mm.
    whole_mm: Vec<f32>,
    /// The same with drag subtracted, where there is any, and its error, one standard deviation.
    network_mm: Vec<f32>,
    network_deviation_mm: Vec<f32>,
    /// Whether a cell moves with a face that the gel sticks to.
    on_face: Vec<bool>,
    /// Standard deviation of the depth of that face, mm.
    face_deviation_mm: f32,
    inner: Vec<usize>,
    eroded: [Vec<bool>; 2],
    scratch: Vec<f64>,
}

impl ContactFinder {
    pub(super) fn new(surface: &Surface, gel: &GelBlock, params: ElasticParams) -> Self {
        let SurfaceGrid { columns, rows, cell_mm } = surface.grid;
        let [columns, rows] = [columns, rows].map(|count| count.next_multiple_of(MULTIPLE).max(LEAST_SIDE));
        let padded = (columns, rows);
        let cells = surface.grid.len();
        let scale = network::SIZE_MM / (cell_mm * CELLS as f64);
        let sensor = Sensor::new(gel, surface.distance_mm());
        let constants = network::constants(sensor.poissons_ratio, sensor.thickness_mm);
        Self {
            network: (params.network && sensor.network_applies()).then(|| ContactNetwork::new(padded)),
            symmetries: match params.mode {
                ElasticMode::Exact => Symmetry::all(padded),
                ElasticMode::Live => vec![Symmetry::PLAIN],
            },
            inputs: vec![[0.0; INPUTS]; padded.0 * padded.1],
            estimated: vec![[0.0; OUTPUTS]; cells],
            face_scratch: Scratch::new(cells),
            strain: FrozenStrain::new(gel.thickness_mm, surface.distance_mm()),
            has_shape: false,
            padded,
            constants,
            scale: scale as f32,
            least_noise_mm: THRESHOLDS.noise_px * surface.mm_per_px,
            noise_mm: THRESHOLDS.noise_px * surface.mm_per_px,
            thickness_mm: gel.thickness_mm,
            is_flow_uncertain: false,
            flow_deviation_mm: 0.0,
            touches: vec![false; cells],
            share: vec![0.0; cells],
            depth_mm: vec![0.0; cells],
            whole_mm: vec![0.0; cells],
            network_mm: vec![0.0; cells],
            network_deviation_mm: vec![0.0; cells],
            on_face: vec![false; cells],
            face_deviation_mm: f32::INFINITY,
            inner: Vec::with_capacity(cells),
            eroded: [vec![false; cells], vec![false; cells]],
            scratch: Vec::with_capacity(cells),
        }
    }

    /// Sets the threads that share the work.
    pub(super) fn share(&mut self, team: &Team) {
        if let Some(network) = &mut self.network {
            network.share(team);
        }
    }

    /// Whether the network estimates depth.
    pub(super) fn uses_network(&self) -> bool {
        self.network.is_some()
    }

    /// Whether the cells around a centre are touched, by the mean of their shares.
    pub(super) fn touches_around(&self, around: Around) -> bool {
        around.mean(|cell| self.share[cell]) > 0.5
    }

    pub(super) fn rest(&mut self) {
        self.touches.fill(false);
        self.share.fill(0.0);
        self.on_face.fill(false);
        self.depth_mm.fill(0.0);
        self.strain.rest();
        self.has_shape = false;
    }

    /// Finds contact and its depth from the surface's whole motion. Needs [`Self::take_noise`] of the same frame.
    pub(super) fn find(&mut self, surface: &Surface) {
        self.strain.begin();
        self.has_shape = false;
        if self.network.is_some() {
            self.look(surface.grid, &surface.seen, Weights::Whole);
            self.take_contact(surface);
            self.take_depth();
            self.hold_to_face(surface);
            return;
        }
        face_search::mark(
            surface,
            &FaceLimits::new(self.noise_mm, self.thickness_mm),
            &mut self.touches,
            &mut self.face_scratch,
        );
        self.hold_to_face(surface);
        // Cells that do not move with the face have no depth.
        self.touches.copy_from_slice(&self.on_face);
        for (share, &touches) in self.share.iter_mut().zip(&self.touches) {
            *share = f32::from(u8::from(touches));
        }
    }

    /// Finds the depth again with the displacement by shear subtracted. Contact does not change, because it is found
    /// better from the whole motion.
    pub(super) fn find_depth(&mut self, surface: &Surface, drag: WithoutDrag<'_>) {
        self.look(surface.grid, drag.seen, Weights::WithoutDrag);
        self.take_depth_without(drag);
        self.hold_to_face(surface);
    }

    /// Gives contact that sticks while it is dragged the depth of its shape before.
    pub(super) fn hold_to_shape(&mut self, surface: &Surface, shape: &mut StuckShape) {
        let Self { touches, inner, whole_mm, depth_mm, network_deviation_mm: deviation_mm, .. } = self;
        let contact = stuck_shape::Contact { touches, inner, whole_mm, depth_mm, deviation_mm };
        self.has_shape = shape.hold(surface, contact, self.noise_mm, self.thickness_mm, &mut self.scratch);
    }

    /// Stores the accuracy of a frame's flow; returns the motion, mm, up to which the gel counts as at rest in this
    /// frame.
    pub(super) fn take_noise(&mut self, surface: &Surface) -> f64 {
        let deviation_mm = surface.typical_deviation_mm(&mut self.scratch);
        self.noise_mm = self.least_noise_mm.max(THRESHOLDS.noise_over_deviation * deviation_mm);
        let covered_mm = THRESHOLDS.training_deviation_px * surface.mm_per_px;
        self.is_flow_uncertain = deviation_mm > THRESHOLDS.most_over_training * covered_mm;
        let beyond_mm = (deviation_mm.powi(2) - covered_mm.powi(2)).max(0.0).sqrt();
        self.flow_deviation_mm = (surface.typical_leverage() * beyond_mm) as f32;
        (THRESHOLDS.still_px * surface.mm_per_px).max(THRESHOLDS.still_over_deviation * deviation_mm)
    }

    /// Allowed difference between a point of the gel and the motion of a face, mm.
    pub(super) fn noise_mm(&self) -> f64 {
        self.noise_mm
    }

    /// Sets depth: in cells that move with a stuck face that of the face, in all others that of the network.
    fn hold_to_face(&mut self, surface: &Surface) {
        self.depth_mm.copy_from_slice(&self.network_mm);
        self.erode(surface.grid);
        let deviation_mm = |face: &StuckFace| {
            rigid::depth_deviation_mm(surface, &AtRest, &self.inner, face, self.noise_mm)
                .filter(|deviation_mm| *deviation_mm <= THRESHOLDS.most_face_deviation * self.thickness_mm)
        };
        let face = rigid::fit(surface, &AtRest, &self.inner, self.noise_mm, &mut self.scratch)
            .filter(|face| face.sticks(self.noise_mm))
            .and_then(|face| Some((face, deviation_mm(&face)?)));
        self.on_face.fill(false);
        let Some((face, deviation_mm)) = face else { return };
        if self.uses_network() {
            let [face_mm, network_mm] = self.mean_depths_mm(surface, &face);
            self.strain.compare(face_mm, network_mm);
            // Gel that slides and spreads evenly under a face.
            if (face_mm - network_mm).abs() > THRESHOLDS.most_change * network_mm {
                return;
            }
        }
        let shift = self.strain.shift();
        let deviation_mm = (THRESHOLDS.face_deviation * self.thickness_mm).max(deviation_mm);
        self.face_deviation_mm = deviation_mm.hypot(shift.deviation_mm) as f32;
        for cell in 0..self.depth_mm.len() {
            if self.touches[cell]
                && rigid::distance_mm(surface, &AtRest, cell, &face.motion) < rigid::tolerance_mm(self.noise_mm)
            {
                self.on_face[cell] = true;
                self.depth_mm[cell] = (face.motion.apply(surface.centre_mm(cell))[2] + shift.mm) as f32;
            }
        }
    }

    /// Mean depth of a face, mm, by its motion and as the network estimates it.
    fn mean_depths_mm(&self, surface: &Surface, face: &StuckFace) -> [f64; 2] {
        let depths = |cell: usize| [face.motion.apply(surface.centre_mm(cell))[2], f64::from(self.network_mm[cell])];
        let sums =
            self.inner.iter().map(|&cell| depths(cell)).fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
        sums.map(|sum| sum / self.inner.len() as f64)
    }

    /// Expected error of the depth of a cell, mm, one standard deviation; `around_mm` is its depth if it is not touched
    /// and the network is not used.
    pub(super) fn deviation_mm(&self, cell: usize, around_mm: f32) -> f32 {
        match (self.on_face[cell], self.uses_network()) {
            (true, _) => self.face_deviation_mm,
            (false, true) => self.network_deviation_mm[cell].hypot(self.flow_deviation_mm),
            (false, false) => {
                let [least, by_depth] = THRESHOLDS.free_deviation;
                (least * self.thickness_mm + by_depth * f64::from(around_mm.abs())) as f32
            }
        }
    }

    /// Mean deviation of the depth in contact relative to its mean.
    pub(super) fn relative_deviation(&self) -> f64 {
        let touched = || (0..self.depth_mm.len()).filter(|&cell| self.touches[cell]);
        let depth_mm: f64 = touched().map(|cell| f64::from(self.depth_mm[cell])).sum();
        touched().map(|cell| f64::from(self.deviation_mm(cell, 0.0))).sum::<f64>() / depth_mm
    }

    /// Takes back what this frame says about the strain of a face.
    pub(super) fn discard_strain(&mut self) {
        self.strain.discard();
    }

    /// Counts a frame without any estimate.
    pub(super) fn skip(&mut self) {
        self.strain.begin();
    }

    /// Whether a face that the gel sticks to was found.
    pub(super) fn has_face(&self) -> bool {
        self.on_face.contains(&true)
    }

    /// Whether contact is known to stick: a face, or a shape that moves as a whole.
    pub(super) fn sticks(&self) -> bool {
        self.has_shape || self.has_face()
    }

    /// Whether contact reaches the border of the visible part of the gel.
    pub(super) fn is_cut(&self, surface: &Surface) -> bool {
        surface.border().any(|cell| self.touches[cell])
    }

    /// Evaluates the network with these weights: the mean over all symmetries in use.
    fn look(&mut self, grid: SurfaceGrid, seen: &[Seen], weights: Weights) {
        let Self { network: Some(network), padded, symmetries, inputs, estimated, constants, scale, .. } = self else {
            return;
        };
        let SurfaceGrid { columns, rows, .. } = grid;
        network_inputs::fill(inputs, *padded, grid, seen, *scale);
        estimated.fill([0.0; OUTPUTS]);
        for symmetry in &*symmetries {
            let input = |column: usize, row: usize| {
                let (column, row) = symmetry.place(*padded, (column, row));
                symmetry.inputs(inputs[row * padded.0 + column])
            };
            network.run(weights, *constants, input, |column, row, outputs| {
                let (column, row) = symmetry.place(*padded, (column, row));
                if column < columns && row < rows {
                    for (sum, output) in estimated[row * columns + column].iter_mut().zip(outputs) {
                        *sum += output;
                    }
                }
            });
        }
        let per_symmetry = 1.0 / self.symmetries.len() as f32;
        self.estimated.as_flattened_mut().iter_mut().for_each(|sum| *sum *= per_symmetry);
    }

    /// Contact as estimated by the network, only where the camera sees the gel at rest.
    fn take_contact(&mut self, surface: &Surface) {
        for (cell, &[depth_mm, odds, _]) in self.estimated.iter().enumerate() {
            let is_estimated = depth_mm > 0.0 && surface.has_pixels(cell);
            let share = if is_estimated { 1.0 / (1.0 + (-odds).exp()) } else { 0.0 };
            (self.share[cell], self.touches[cell]) = (share, share > 0.5);
        }
    }

    fn take_depth(&mut self) {
        for (cell, &[depth_mm, _, error]) in self.estimated.iter().enumerate() {
            (self.whole_mm[cell], self.network_mm[cell]) = (depth_mm / self.scale, depth_mm / self.scale);
            self.network_deviation_mm[cell] = DEVIATION * error.exp() / self.scale;
        }
    }

    /// The depth estimated without drag, and that by drag; where little of the drag was subtracted, mostly the depth estimated from
    /// the whole motion.
    fn take_depth_without(&mut self, drag: WithoutDrag<'_>) {
        for (cell, (&[depth_mm, _, error], dragged_mm)) in self.estimated.iter().zip(drag.dragged_mm).enumerate() {
            let (depth_mm, deviation_mm) =
                (depth_mm / self.scale + dragged_mm[2], DEVIATION * error.exp() / self.scale);
            self.network_mm[cell] += drag.part * (depth_mm - self.network_mm[cell]);
            self.network_deviation_mm[cell] += drag.part * (deviation_mm - self.network_deviation_mm[cell]);
        }
    }

    /// Collects cells in contact that are at least [`RIM_CELLS`] away from its border, evenly where there are too many.
    fn erode(&mut self, grid: SurfaceGrid) {
        let [from, to] = &mut self.eroded;
        from.copy_from_slice(&self.touches);
        for _ in 0..RIM_CELLS {
            for (cell, to) in to.iter_mut().enumerate() {
                *to = from[cell]
                    && surface::neighbours(grid, cell).is_some_and(|near| near.iter().all(|&near| from[near]));
            }
            std::mem::swap(from, to);
        }
        let every = from.iter().filter(|inner| **inner).count().div_ceil(MOST_POINTS).max(1);
        let inner = from.iter().enumerate().filter(|(_, inner)| **inner).map(|(cell, _)| cell);
        self.inner.clear();
        self.inner.extend(inner.step_by(every));
    }
}
