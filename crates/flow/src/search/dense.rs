//! The dense field that the patches' displacements are turned into, level by level, and its memory.

use super::SearchLevel;
use super::densify::Densifier;
use super::patches::{PATCH, PatchTemplate, SearchRules, fill_unfound};
use super::resize::{double_into, shrink_into};
use super::sweep::sweep;
use super::variational::{RefineParams, VariationalRefinement};
use crate::FlowField;
use fearless_simd::{Level, Simd, dispatch};
use fingervision_image::Image;

/// The dense fields of all levels.
#[derive(Debug, Clone)]
pub(super) struct DenseFields {
    /// The pyramid's level where the search ends.
    finest: usize,
    /// From the finest level of the search to the coarsest.
    levels: Vec<DenseLevel>,
    /// Fields between the finest level and full size, if the finest level is not 0.
    enlarged: Vec<FlowField>,
    refinement: VariationalRefinement,
}

#[derive(Debug, Clone)]
struct DenseLevel {
    flow: FlowField,
    /// The field that the search also tries.
    start: FlowField,
    /// Whether a patch was found or filled.
    filled: Vec<bool>,
    densifier: Densifier,
}

impl DenseFields {
    /// For the levels of a search of pictures of this size; the first of them is level `finest` of the pyramid.
    pub(super) fn new((width, height): (usize, usize), finest: usize, levels: &[SearchLevel]) -> Self {
        let dense = levels.iter().enumerate().map(|(k, level)| {
            let (width, height) = (width >> (finest + k), height >> (finest + k));
            DenseLevel {
                flow: FlowField::zero(width, height),
                start: FlowField::zero(width, height),
                filled: vec![false; level.layout.len()],
                densifier: Densifier::new(width, height),
            }
        });
        Self {
            finest,
            levels: dense.collect(),
            enlarged: (1..finest).rev().map(|level| FlowField::zero(width >> level, height >> level)).collect(),
            refinement: VariationalRefinement::new(width >> finest, height >> finest),
        }
    }

    /// Searches the patches of level `k`, counted from the finest, and refines the dense field. The search begins from the coarser
    /// level's field and tries `start`, if there is one, too.
    pub(super) fn search_level(
        &mut self,
        simd: Level,
        k: usize,
        level: &mut SearchLevel,
        (template, current): (&PatchTemplate, &Image<f32>),
        start: Option<&FlowField>,
        (rules, refine): (SearchRules, &RefineParams),
    ) {
        let (fine, coarse) = self.levels.split_at_mut(k + 1);
        let dense = &mut fine[k];
        match coarse.first() {
            Some(coarse) => double_into(&coarse.flow, &mut dense.flow),
            None => dense.flow.fill(0.0),
        }
        if let Some(start) = start {
            shrink_into(start, self.finest + k, &mut dense.start);
        }
        dispatch!(simd, simd => dense.run(simd, level, (template, current), start.is_some(), rules));
        self.refinement.refine(refine, &template.grey, current, &mut dense.flow);
    }

    /// Writes the field of the finest level at full size.
    pub(super) fn enlarge(&mut self, flow: &mut FlowField) {
        let found = &self.levels[0].flow;
        if self.finest == 0 {
            flow.copy_from(found);
            return;
        }
        let mut from = found;
        for larger in &mut self.enlarged {
            double_into(from, larger);
            from = larger;
        }
        double_into(from, flow);
    }
}

impl DenseLevel {
    /// Searches all patches, each from the coarser level's flow and from the given one, if any. Then computes the dense
    /// field.
    #[inline(always)]
    fn run<S: Simd>(
        &mut self,
        simd: S,
        level: &mut SearchLevel,
        (template, current): (&PatchTemplate, &Image<f32>),
        has_start: bool,
        rules: SearchRules,
    ) {
        let Self { flow, start, .. } = self;
        let SearchLevel { layout, matches } = level;
        let at = |flow: &FlowField, (left, top): (usize, usize)| {
            let (x, y) = (left + PATCH / 2, top + PATCH / 2);
            (flow.u.at(x, y), flow.v.at(x, y))
        };
        sweep(simd, template, current, rules, matches, |corner, starts| {
            starts.add(at(flow, corner));
            if has_start {
                starts.add(at(start, corner));
            }
            true
        });
        fill_unfound(layout, matches, &mut self.filled);
        self.densifier.densify(simd, template, current, matches, flow);
    }
}
