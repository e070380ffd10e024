//! Coupled affine patches from the coarsest level to full size.

mod blur;
mod output;
mod prediction;

use self::blur::MotionBlur;

use super::bonds::Stiffness;
use super::fine::{FinePatches, FineTemplate};
use super::grid::PatchGrid;
use super::nodes::NodeField;
use super::noise::{self, Noise, Residuals};
use super::products::Current;
use super::refinement::Refinement;
use super::template::Template;
use crate::search::local::CellMotion;
use crate::{Estimate, FlowField, FlowParams, Picture, Team, ValidityParams};
use fearless_simd::Level;
use std::slice::from_ref;

/// The reference on every level.
#[derive(Debug, Clone)]
pub(crate) struct AffineReference {
    /// Grey, level 0 to the coarsest. Level 0 has every other row, for the first step at full size. Without colour it
    /// shares the pixels of `full`.
    grey: Vec<Template>,
    /// Level 0 for all other steps: in colour if the pictures have colour.
    full: Template,
    fine: FineTemplate,
    /// Part of the patches that have texture, 0 to 1.
    pub(crate) textured: f32,
    /// Mean grey level.
    mean_level: f32,
    /// Standard deviation of the noise that fits the texture, grey levels.
    texture_noise: f32,
    /// The noise that all templates are prepared for.
    noise: Noise,
}

impl AffineReference {
    /// The gain that makes the mean of a picture equal to the reference's. The patches eliminate any other change of
    /// light, but their steps have the full length only if the gains are equal.
    fn gain(&self, current: &Picture) -> f32 {
        (self.mean_level.max(1.0) / current.matched_mean().max(1.0)).clamp(0.1, 10.0)
    }
}

/// The patches of every level and their scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct AffinePatches {
    params: FlowParams,
    /// Level 0 to the coarsest.
    levels: Vec<LevelState>,
    fine: FinePatches,
    blur: MotionBlur,
    /// Whether areas of this picture were searched.
    is_searched: bool,
    residuals: Residuals,
    variance: Vec<f32>,
    steps: Vec<f32>,
    rings: Vec<usize>,
    ranks: Vec<f32>,
    simd: Level,
}

#[derive(Debug, Clone)]
struct LevelState {
    refinement: Refinement,
    field: NodeField,
    before: NodeField,
    change: NodeField,
}

impl LevelState {
    /// Steps at full size with all that the pictures have; `current` is the picture and its gain.
    fn take_full_steps(
        &mut self,
        params: &FlowParams,
        template: &Template,
        (current, gain): (&Picture, f32),
        steps: usize,
    ) {
        let count = (steps, params.affine.iterations);
        match &current.colour {
            Some(channels) => self.take_steps(&params.validity, template, Current::colour(channels, gain), count),
            None => self.take_steps(&params.validity, template, Current::grey(current.grey.level(0), gain), count),
        }
    }

    /// Steps at full size, with additional ones while patches still move. Patches that fail in one step have no weight in
    /// the next.
    fn take_steps<const CHANNELS: usize>(
        &mut self,
        rules: &ValidityParams,
        template: &Template,
        current: Current<'_, CHANNELS>,
        (steps, iterations): (usize, usize),
    ) {
        let Self { refinement, field, .. } = self;
        for step in 0..steps + MORE_STEPS {
            if step >= steps && !refinement.is_moving() {
                break;
            }
            refinement.step(template, current, field, iterations);
            refinement.judge(template, field, rules);
        }
    }
}

/// Largest number of additional steps at full size.
const MORE_STEPS: usize = 4;

/// Conjugate-gradient iterations of a step at full size that others follow.
const QUICK_ITERATIONS: usize = 3;

/// Farthest that a failed patch may lie from the prediction of its neighbours, px. The weak coupling of a rough field moves
/// such patches by some px in every step, and in every frame anew.
const FARTHEST_FAILED_PX: f32 = 2.0;

/// The residual of a frame counts as noise if at least this part of the patches match.
const LEAST_MATCHED: f32 = 0.9;

/// Least width and height of a level that holds patches, px.
const LEAST_SIZE: usize = 16;

impl AffinePatches {
    pub(crate) fn new(width: usize, height: usize, params: &FlowParams, simd: Level) -> Self {
        let affine = &params.affine;
        let stiffness = Stiffness {
            continuity: affine.continuity_px.powi(-2),
            curvature: affine.curvature_px.powi(-2),
            tolerance: affine.bond_tolerance,
        };
        let level = |level: usize| {
            let grid = PatchGrid::over(width >> level, height >> level);
            LevelState {
                refinement: Refinement::new(grid, simd, stiffness),
                field: NodeField::zero(grid),
                before: NodeField::zero(grid),
                change: NodeField::zero(grid),
            }
        };
        let levels: Vec<_> = (0..=coarsest_level(width, height, params)).map(level).collect();
        let nodes = levels[0].field.grid.plane_len();
        let empty = full_template(levels[0].field.grid, params);
        let blur = MotionBlur::new(empty, &levels[0].refinement, Noise::of(params.noise_levels));
        Self {
            blur,
            is_searched: false,
            residuals: Residuals::default(),
            params: *params,
            levels,
            fine: FinePatches::new(width, height, simd, stiffness),
            variance: vec![0.0; nodes],
            steps: vec![0.0; nodes],
            rings: vec![0; nodes],
            ranks: Vec::with_capacity(nodes),
            simd,
        }
    }

    /// An empty reference.
    pub(crate) fn reference(&self) -> AffineReference {
        let levels = self.levels.iter().enumerate();
        let grey = levels.map(|(level, LevelState { field, .. })| match (level, self.params.colour) {
            (0, false) => Template::sharing(field.grid, 1, 2),
            (0, true) => Template::sparse(field.grid, 1, 2),
            _ => Template::new(field.grid, 1, 1),
        });
        AffineReference {
            grey: grey.collect(),
            full: full_template(self.levels[0].field.grid, &self.params),
            fine: FineTemplate::new(self.levels[0].field.grid.width, self.levels[0].field.grid.height),
            textured: 0.0,
            mean_level: 0.0,
            texture_noise: self.params.noise_levels,
            noise: Noise::of(self.params.noise_levels),
        }
    }

    /// Whether a reference is for pictures with the same channels.
    pub(crate) fn fits(&self, reference: &AffineReference) -> bool {
        reference.full.channels() == if self.params.colour { 3 } else { 1 }
    }

    /// Prepares a new reference.
    pub(crate) fn prepare(&self, picture: &Picture, reference: &mut AffineReference) {
        reference.mean_level = picture.matched_mean();
        for (level, template) in reference.grey.iter_mut().enumerate().skip(1) {
            template.prepare(self.simd, from_ref(picture.grey.level(level)));
        }
        let first = &mut reference.grey[0];
        let shares_pixels = !self.params.colour;
        if shares_pixels {
            first.release();
        }
        let channels = picture.channels();
        reference.full.prepare(self.simd, channels);
        if shares_pixels {
            first.prepare_from(self.simd, &reference.full);
        } else {
            first.prepare(self.simd, from_ref(picture.grey.level(0)));
        }
        self.fine.prepare(&reference.full, channels.len(), &mut reference.fine);
        let levels = self.params.noise_levels;
        reference.texture_noise = noise::for_texture(levels, reference.full.squared_gradients(levels));
        self.complete(reference, self.residuals.noise(reference.texture_noise));
    }

    /// Adapts a reference to the noise that the last frames showed, if it is prepared for another one.
    pub(crate) fn adapt(&self, reference: &mut AffineReference) {
        let levels = self.residuals.noise(reference.texture_noise);
        if noise::is_different(reference.noise.coupling, levels) {
            self.complete(reference, levels);
        }
    }

    /// Takes note of how well a frame matched its reference.
    pub(crate) fn note_residual(&mut self, matched: &Estimate) {
        if matched.matched >= LEAST_MATCHED && !matched.is_motion_blurred {
            self.residuals.push(matched.residual_levels);
        }
    }

    /// Computes what follows from the normal equations of a reference and from the noise that its coupling is for.
    fn complete(&self, reference: &mut AffineReference, coupling: f32) {
        let noise = Noise { coupling, ..reference.noise };
        reference.noise = noise;
        for (state, template) in self.levels.iter().zip(&mut reference.grey) {
            state.refinement.complete(template, noise);
        }
        self.levels[0].refinement.complete(&mut reference.full, noise);
        self.fine.complete(&mut reference.fine, noise);
        let nodes = &reference.full.own_variance[..self.levels[0].field.grid.nodes()];
        let limit = self.params.validity.max_deviation_px.powi(2);
        let textured = nodes.iter().filter(|&&variance| variance <= limit).count();
        reference.textured = textured as f32 / nodes.len() as f32;
    }

    /// Sets `flow` as the current flow.
    pub(crate) fn start(&mut self, flow: &FlowField) {
        self.blur.begin();
        self.is_searched = false;
        self.levels[0].field.sample(flow);
    }

    /// Finds the motion since the start, from level `coarsest` to full size, with `steps` steps at full size.
    ///
    /// If there are several such steps, the first one uses grey on every other row, at a fraction of the cost. Patches
    /// that fail in it are set to the prediction of their neighbours.
    pub(crate) fn follow(&mut self, reference: &AffineReference, current: &Picture, coarsest: usize, steps: usize) {
        self.descend(reference, current, coarsest);
        self.take_first_step(reference, current, steps);
        if steps > 1 {
            self.take_full_steps(reference, current, steps - 1);
        }
    }

    /// Finds the motion since the start on the coarse levels.
    fn descend(&mut self, reference: &AffineReference, current: &Picture, coarsest: usize) {
        let coarsest = coarsest.min(self.levels.len() - 1);
        let gain = reference.gain(current);
        for level in 1..=coarsest {
            let (fine, coarse) = self.levels.split_at_mut(level);
            coarse[0].field.coarsen(&fine[level - 1].field);
        }
        for level in (1..=coarsest).rev() {
            let LevelState { refinement, field, .. } = &mut self.levels[level];
            let picture = Current::grey(current.grey.level(level), gain);
            refinement.step(&reference.grey[level], picture, field, self.params.affine.iterations);
            let (fine, coarse) = self.levels.split_at_mut(level);
            let (fine, coarse) = (&mut fine[level - 1].field, &mut coarse[0]);
            coarse.before.coarsen(fine);
            coarse.change.set_difference(&coarse.field, &coarse.before);
            fine.add_change(&coarse.change);
        }
    }

    /// The first step at full size.
    fn approach(&mut self, reference: &AffineReference, current: &Picture) {
        self.levels[0].refinement.trust_all();
        let picture = Current::grey(current.grey.level(0), reference.gain(current));
        self.levels[0].take_steps(&self.params.validity, &reference.grey[0], picture, (1, QUICK_ITERATIONS));
        self.fill_failed();
    }

    /// The first of `steps` steps at full size: in grey if others follow, else with all that the pictures have.
    fn take_first_step(&mut self, reference: &AffineReference, current: &Picture, steps: usize) {
        if steps > 1 {
            self.approach(reference, current);
        } else {
            self.levels[0].refinement.trust_all();
            self.take_full_steps(reference, current, 1);
        }
    }

    /// Refines a field found by a search, by steps at full size. Between two steps, failed patches are set to the
    /// prediction of their neighbours and are tried again.
    pub(crate) fn refine(&mut self, reference: &AffineReference, current: &Picture, steps: usize) {
        self.is_searched = true;
        self.follow(reference, current, 1, 2);
        for _ in 1..steps {
            self.retry(reference, current);
        }
    }

    /// Whether each patch has texture, is in the image, and failed.
    pub(crate) fn is_lost<'a>(&'a self, reference: &'a AffineReference) -> impl Fn(usize) -> bool + 'a {
        let limit = self.params.validity.max_deviation_px.powi(2);
        let refinement = &self.levels[0].refinement;
        let own = &reference.full.own_variance;
        move |node| own[node] <= limit && refinement.is_inside[node] && refinement.trust()[node] <= 0.0
    }

    /// Sets patches to the motions that a search found, and takes a step at full size with all patches.
    pub(crate) fn refine_found(
        &mut self,
        reference: &AffineReference,
        current: &Picture,
        found: impl Iterator<Item = (usize, CellMotion)>,
    ) {
        self.is_searched = true;
        let LevelState { refinement, field, .. } = &mut self.levels[0];
        for (node, motion) in found {
            field.set_motion(node, motion);
        }
        refinement.trust_all();
        self.take_full_steps(reference, current, 1);
    }

    /// Sets failed patches to the prediction of their neighbours, and takes a step at full size with all patches.
    pub(crate) fn retry(&mut self, reference: &AffineReference, current: &Picture) {
        self.fill_failed();
        self.levels[0].refinement.trust_all();
        self.take_full_steps(reference, current, 1);
    }

    /// Sets failed patches to the prediction of their neighbours.
    fn fill_failed(&mut self) {
        let LevelState { refinement, field, .. } = &mut self.levels[0];
        field.fill_failed(refinement.trust(), &mut self.rings);
    }

    /// Sets failed patches that strayed from their neighbours to the prediction of these.
    fn recall_failed(&mut self) {
        let LevelState { refinement, field, before, .. } = &mut self.levels[0];
        let trust = refinement.trust();
        if trust[..field.grid.nodes()].contains(&0.0) {
            before.copy_from(field);
            before.fill_failed(trust, &mut self.rings);
            field.recall(trust, before, FARTHEST_FAILED_PX);
        }
    }

    fn take_full_steps(&mut self, reference: &AffineReference, current: &Picture, steps: usize) {
        self.levels[0].take_full_steps(&self.params, &reference.full, (current, reference.gain(current)), steps);
    }

    /// Finds which patches match with the current flow, without changing it.
    pub(crate) fn inspect(&mut self, reference: &AffineReference, current: &Picture) {
        let LevelState { refinement, field, .. } = &mut self.levels[0];
        let template = &reference.full;
        let (gain, iterations) = (reference.gain(current), self.params.affine.iterations);
        match &current.colour {
            Some(channels) => refinement.inspect(template, Current::colour(channels, gain), field, iterations),
            None => refinement.inspect(template, Current::grey(current.grey.level(0), gain), field, iterations),
        }
        refinement.judge(template, field, &self.params.validity);
    }

    /// Sets the threads that share the work at full size.
    pub(crate) fn set_team(&mut self, team: &Team) {
        self.levels[0].refinement.set_team(team);
    }

    /// Forgets the previous frames.
    pub(crate) fn restart(&mut self) {
        self.residuals.restart();
        self.blur.restart();
    }
}

/// An empty template for all that the pictures have.
fn full_template(grid: PatchGrid, params: &FlowParams) -> Template {
    let (channels, row_step) = if params.colour { (3, params.affine.colour_row_step) } else { (1, 1) };
    Template::new(grid, channels, row_step)
}

/// Coarsest level that the patches use on pictures of this size.
pub(crate) fn coarsest_level(width: usize, height: usize, params: &FlowParams) -> usize {
    let deepest = (width.min(height) / LEAST_SIZE).max(1).ilog2() as usize;
    params.affine.coarsest_level.min(deepest)
}
