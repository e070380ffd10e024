//! Finer patches where the flow is rough.
//!
//! Around the border of a contact the flow changes within a few pixels, and a window of 16 px contains two motions.
//! There, patches with windows of 8 px every 4 px replace the coarse ones. They start from the coarse flow, take
//! Gauss–Newton steps together, and give displacement, deviation and validity. After a search, failed patches also try
//! the motions of matched ones. Their unknowns and equations are those of the coarse patches. The computing time grows
//! with the number of fine patches, not with the size of the picture.

mod cell;
mod field;
mod grid;
mod node;
mod propagation;
mod relax;
mod template;

pub(crate) use self::propagation::CoarseMotions;
pub(crate) use self::template::FineTemplate;

use self::cell::residuals;
use self::field::FineField;
use self::grid::{CornerWeights, FineGrid, STRIDE};
use self::node::FineNode;
use self::propagation::Propagation;
use self::relax::{Blocks, NONE, Relaxation};
use super::bonds::Stiffness;
use super::grid::PatchGrid;
use super::judge::FLOOR_VARIANCE;
use super::noise::Noise;
use super::products::Current;
use super::template::Template;
use crate::{Estimate, FlowField, ValidityParams};
use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;

/// Gauss–Seidel sweeps of a step.
const SWEEPS: usize = 6;

/// How often failed patches take motions from around them after a search; a step follows each time.
const PROPAGATIONS: usize = 2;

/// Variance that a patch gets from rough flow, relative to the squared roughness; measured on simulated presses.
const ROUGH_PATCH: f32 = 0.03;

/// Square of the error that remains after the last step, relative to the square of this step: at a rim steps hardly get shorter. Measured
/// on simulated presses: 0.4 to 1 on colour patterns, 2 and more on speckle, where other terms cover the rest.
const REMAINING_ERROR: f32 = 1.5;

/// Least variance of the noise that a patch's residual can show, relative to that in the parameters.
const LEAST_NOISE: f32 = 0.5;

/// Largest part of the coarse patches that is refined. It limits the computing time of a frame. If more patches have a
/// large deviation, the cause is blur or noise, not a rim.
const MOST_REFINED: f32 = 0.3;

/// A patch whose middle is nearer to the border of the current image, px, lies partly outside and is not valid.
const INNER_PX: f32 = 2.0;

/// A coarse patch that should be refined.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rough {
    /// Its variance, px². Those with the largest are refined.
    pub(crate) variance: f32,
    /// The square of its error that blur causes, px². A smaller window shows less of blur, but does not correct it.
    pub(crate) blur_error: f32,
}

/// How the patches are matched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort<'a> {
    /// Number of steps from the coarse flow.
    pub(crate) steps: usize,
    /// After a search: the coarse patches, whose motions failed patches try.
    pub(crate) coarse: Option<CoarseMotions<'a>>,
    /// How likely it is that a patch with low contrast and a large residual is blurred, 0 to 1.
    pub(crate) blur_likelihood: f32,
}

/// The fine patches of a picture and their scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct FinePatches {
    grid: FineGrid,
    coarse: PatchGrid,
    level: Level,
    stiffness: Stiffness,
    weights: Box<CornerWeights<6>>,
    field: FineField,
    /// The coarse patches that may be refined, with their indices.
    rough: Vec<(Rough, usize)>,
    /// For every node of the grid, its index in `nodes`, or [`NONE`].
    index: Vec<u32>,
    nodes: Vec<FineNode>,
    blocks: Blocks,
    has_cell: Vec<bool>,
    /// The cells around the nodes, each by the node at its lower right corner.
    cells: Vec<usize>,
}

/// Largest number of coarse patches that are refined.
fn most_refined(coarse: PatchGrid) -> usize {
    (MOST_REFINED * coarse.nodes() as f32) as usize
}

impl FinePatches {
    pub(crate) fn new(width: usize, height: usize, level: Level, stiffness: Stiffness) -> Self {
        let grid = FineGrid::over(width, height);
        let coarse = PatchGrid::over(width, height);
        // A coarse patch contains four fine nodes.
        let most = 4 * most_refined(coarse);
        Self {
            grid,
            coarse,
            level,
            stiffness,
            weights: Box::new(grid::window_weights()),
            field: FineField::new(grid),
            rough: Vec::with_capacity(coarse.nodes()),
            index: vec![NONE; grid.nodes()],
            nodes: Vec::with_capacity(most),
            blocks: Blocks::with_capacity(most),
            has_cell: vec![false; grid.nodes()],
            cells: Vec::with_capacity(grid.nodes()),
        }
    }

    /// Prepares a new reference, whose pixels are in `template`.
    pub(crate) fn prepare(&self, template: &Template, channels: usize, fine: &mut FineTemplate) {
        fine.prepare(self.level, template, channels);
    }

    /// Computes what follows from the normal equations and from the noise of both pictures.
    pub(crate) fn complete(&self, fine: &mut FineTemplate, noise: Noise) {
        fine.complete(noise, self.stiffness.curvature);
    }

    /// Refines the flow in `out` at the coarse patches for which `rough` returns a value.
    pub(crate) fn refine<const CHANNELS: usize>(
        &mut self,
        (template, fine): (&Template, &FineTemplate),
        current: Current<'_, CHANNELS>,
        rules: &ValidityParams,
        Effort { steps, coarse, blur_likelihood }: Effort<'_>,
        rough: impl Fn(usize) -> Option<Rough>,
        out: &mut Estimate,
    ) {
        if steps == 0 {
            return;
        }
        self.select(rough);
        if self.nodes.is_empty() {
            return;
        }
        self.field.sample(&out.flow, &mut self.nodes);
        let level = self.level;
        for _ in 0..steps {
            dispatch!(level, simd => self.measure(simd, template, current));
            dispatch!(level, simd => self.step(simd, fine, rules));
        }
        if let Some(coarse) = coarse {
            self.propagate((template, fine), current, rules, coarse);
        }
        self.field.set_twists(&self.cells);
        dispatch!(level, simd => self.write_flow(simd, out));
        self.write_deviation(fine, rules, blur_likelihood, out);
    }

    /// Sets the nodes to be refined and the cells around them.
    fn select(&mut self, is_rough: impl Fn(usize) -> Option<Rough>) {
        let Self { grid, coarse, rough, index, has_cell, nodes, cells, .. } = self;
        rough.clear();
        rough.extend((0..coarse.nodes()).filter_map(|node| Some((is_rough(node)?, node))));
        let most = most_refined(*coarse);
        if rough.len() > most {
            rough.select_nth_unstable_by(most, |a, b| b.0.variance.total_cmp(&a.0.variance).then(a.1.cmp(&b.1)));
            rough.truncate(most);
            rough.sort_unstable_by_key(|(_, node)| *node);
        }
        index.fill(NONE);
        has_cell.fill(false);
        nodes.clear();
        cells.clear();
        for &(Rough { blur_error, .. }, node) in rough.iter() {
            for place in grid.within(node % coarse.columns, node / coarse.columns) {
                index[place] = nodes.len() as u32;
                nodes.push(FineNode::at(place, blur_error));
                for cell in [place, place + 1, place + grid.columns, place + grid.columns + 1] {
                    if !std::mem::replace(&mut has_cell[cell], true) {
                        cells.push(cell);
                    }
                }
            }
        }
    }

    /// Sums the residual over every patch.
    #[inline(always)]
    fn measure<S: Simd, const CHANNELS: usize>(
        &mut self,
        simd: S,
        template: &Template,
        current: Current<'_, CHANNELS>,
    ) {
        self.field.set_twists(&self.cells);
        let Self { grid, weights, field, index, nodes, cells, .. } = self;
        for node in nodes.iter_mut() {
            node.sums.fill(0.0);
        }
        for &cell in cells.iter() {
            let flow = field.flow(simd, cell);
            let sums = residuals(simd, template, current, weights, grid.upper_left(cell), flow);
            for (corner, found) in grid.corners(cell).into_iter().zip(sums) {
                let Some(node) = nodes.get_mut(index[corner] as usize) else { continue };
                for (sum, found) in node.sums.iter_mut().zip(found) {
                    *sum += found;
                }
            }
        }
    }

    /// Matches failed patches again, with motions from around them.
    fn propagate<const CHANNELS: usize>(
        &mut self,
        (template, fine): (&Template, &FineTemplate),
        current: Current<'_, CHANNELS>,
        rules: &ValidityParams,
        coarse: CoarseMotions<'_>,
    ) {
        let level = self.level;
        for _ in 0..PROPAGATIONS {
            let Self { grid, weights, field, index, nodes, .. } = self;
            let (grid, templates) = (*grid, (template, fine));
            let propagation = Propagation { grid, weights, templates, current, rules, coarse, index };
            if !dispatch!(level, simd => propagation.run(simd, field, nodes)) {
                break;
            }
            dispatch!(level, simd => self.measure(simd, template, current));
            dispatch!(level, simd => self.step(simd, fine, rules));
        }
    }

    /// Solves for the steps of the nodes, decides which patches failed, and adds the steps.
    #[simd]
    fn step<S: Simd>(&mut self, simd: S, fine: &FineTemplate, rules: &ValidityParams) {
        let _ = simd;
        let Self { grid, stiffness, field, index, nodes, blocks, .. } = self;
        let scale = fine.scale;
        for node in nodes.iter_mut() {
            node.form_right(&fine.equations[node.place], scale);
        }
        let relaxation = Relaxation {
            equations: &fine.equations,
            grid: *grid,
            stiffness: *stiffness,
            scale,
            field: field.motions(),
            index,
        };
        relaxation.run(nodes, blocks, SWEEPS);
        for node in nodes.iter_mut() {
            node.judge(&fine.equations[node.place], scale, fine.noise, rules);
        }
        field.compose(nodes);
    }

    #[inline(always)]
    fn write_flow<S: Simd>(&self, simd: S, out: &mut Estimate) {
        for &cell in &self.cells {
            let (left, top) = self.grid.upper_left(cell);
            let [u, v] = self.field.flow(simd, cell);
            for (image, flow) in [(&mut out.flow.u, u), (&mut out.flow.v, v)] {
                for (row, flow) in flow.as_chunks::<STRIDE>().0.iter().enumerate() {
                    image.row_mut(top + row)[left..][..STRIDE].copy_from_slice(flow);
                }
            }
        }
    }

    /// Writes deviation and validity: a pixel takes those of the nearest fine node.
    fn write_deviation(&self, fine: &FineTemplate, rules: &ValidityParams, blur_likelihood: f32, out: &mut Estimate) {
        let expected = self.stiffness.continuity.recip() + self.stiffness.curvature.recip();
        let (right, bottom) = ((self.grid.width - 1) as f32, (self.grid.height - 1) as f32);
        for node in &self.nodes {
            let [u, _, _, v, ..] = node.step;
            let excess = (node.mean_energy / fine.noise.variance()).max(LEAST_NOISE);
            let rough = ROUGH_PATCH * expected * node.roughness;
            let template_variance = fine.equations[node.place].variance;
            let blur = node.blur_error(template_variance, fine.noise.variance(), blur_likelihood);
            let other = rough + blur + REMAINING_ERROR * (u * u + v * v) + FLOOR_VARIANCE;
            let bond = self.stiffness.tolerance / (self.stiffness.tolerance + node.roughness);
            let variance = fine.own_variance(node.place, bond) * excess + other;
            let (left, top) = (STRIDE * (node.place % self.grid.columns), STRIDE * (node.place / self.grid.columns));
            let is_inside = |flow: &FlowField, x: usize, y: usize, margin: f32| {
                let (px, py) = (x as f32 + flow.u.at(x, y), y as f32 + flow.v.at(x, y));
                px >= margin && py >= margin && px <= right - margin && py <= bottom - margin
            };
            let is_whole = is_inside(&out.flow, left + STRIDE / 2, top + STRIDE / 2, INNER_PX);
            let deviation = if node.is_trusted && is_whole { variance.sqrt() } else { f32::INFINITY };
            for y in top..top + STRIDE {
                for x in left..left + STRIDE {
                    let deviation = if is_inside(&out.flow, x, y, 0.0) { deviation } else { f32::INFINITY };
                    out.deviation.row_mut(y)[x] = deviation;
                    out.valid.row_mut(y)[x] = u8::from(deviation <= rules.max_deviation_px);
                }
            }
        }
    }
}
