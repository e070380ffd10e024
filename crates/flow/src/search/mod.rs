//! Dense inverse search with variational refinement: a coarse-to-fine flow that needs no initial flow.
//!
//! At every pyramid level, the inverse search finds the displacements of the reference's patches. Their weighted mean
//! at every pixel is a dense field, which is then refined. The next finer level starts from this field. [Kroeger2016],
//! [Brox2004].

mod dense;
mod densify;
mod differences;
pub(crate) mod local;
mod patches;
mod residual;
mod resize;
mod sweep;
mod variational;

use crate::{FlowError, FlowField, Picture};
use dense::DenseFields;
use fearless_simd::Level;
use patches::{Match, PATCH, PatchLayout, PatchTemplate, SearchRules};
use serde::{Deserialize, Serialize};

pub(crate) use resize::coarse_neighbours;
pub use variational::RefineParams;

/// Parameters of the dense inverse search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SearchParams {
    /// Pyramid level where the search ends; its field is enlarged to full size. 0 is the full size.
    pub finest_level: usize,
    /// Distance between neighbouring patches, px on their level, 1 to 8.
    pub stride: usize,
    /// Largest number of Gauss–Newton steps of a patch.
    pub iterations: usize,
    /// The search of a patch ends when its step is shorter than this, px on its level.
    pub tolerance_px: f32,
    /// Reach of the exhaustive search on the coarsest level, px there; 0 switches it off. It compares every second
    /// patch at all whole-pixel displacements within reach. It is used only if the search without it fails, because the
    /// whole picture moved too far for the steps.
    pub coarse_reach: u16,
    /// Smallest eigenvalue of a textured patch's mean structure tensor, grey levels² per px².
    pub min_texture: f32,
    /// The variational refinement at the end of every level.
    pub refine: RefineParams,
}

impl SearchParams {
    /// The fastest preset: finest level 2, no variational refinement.
    #[must_use]
    pub fn ultrafast() -> Self {
        let refine = RefineParams { passes: 0, ..RefineParams::default() };
        Self { finest_level: 2, stride: 4, iterations: 4, refine, ..Self::medium() }
    }

    /// The preset in between: finest level 2, with variational refinement.
    #[must_use]
    pub fn fast() -> Self {
        Self { finest_level: 2, stride: 4, iterations: 5, ..Self::medium() }
    }

    /// The most accurate preset: finest level 1, denser patches, with variational refinement.
    #[must_use]
    pub fn medium() -> Self {
        Self {
            finest_level: 1,
            stride: 3,
            iterations: 6,
            tolerance_px: 0.01,
            coarse_reach: 0,
            min_texture: 0.5,
            refine: RefineParams::default(),
        }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    ///
    /// [`FlowError::Parameter`] naming the first value that is not.
    pub fn validate(&self) -> Result<(), FlowError> {
        let check = FlowError::check;
        check((1..=PATCH).contains(&self.stride), "search.stride", self.stride as f64, "1 to 8 px")?;
        for (name, count, least, range) in [
            ("search.iterations", self.iterations, 1, "1 to 1000"),
            ("search.refine.passes", self.refine.passes, 0, "0 to 1000"),
            ("search.refine.sweeps", self.refine.sweeps, 0, "0 to 1000"),
        ] {
            check((least..=1000).contains(&count), name, count as f64, range)?;
        }
        check(self.coarse_reach <= 64, "search.coarse_reach", f64::from(self.coarse_reach), "0 to 64 px")?;
        check(self.finest_level <= 8, "search.finest_level", self.finest_level as f64, "0 to 8")?;
        let tolerance = f64::from(self.tolerance_px);
        check(tolerance > 0.0 && tolerance < 1.0, "search.tolerance_px", tolerance, "between 0 and 1 px")?;
        check(
            self.min_texture >= 0.0 && self.min_texture.is_finite(),
            "search.min_texture",
            f64::from(self.min_texture),
            "0 or more",
        )?;
        for (name, weight) in [
            ("search.refine.smoothness_weight", self.refine.smoothness_weight),
            ("search.refine.brightness_weight", self.refine.brightness_weight),
            ("search.refine.gradient_weight", self.refine.gradient_weight),
        ] {
            check(weight >= 0.0 && weight.is_finite(), name, f64::from(weight), "0 or more")?;
        }
        Ok(())
    }
}

impl SearchParams {
    /// The parameters for the patches of a level.
    fn rules(&self, is_exhaustive: bool) -> SearchRules {
        let reach = if is_exhaustive { i32::from(self.coarse_reach) } else { 0 };
        SearchRules { iterations: self.iterations, tolerance: self.tolerance_px, reach }
    }
}

impl Default for SearchParams {
    fn default() -> Self {
        Self::medium()
    }
}

/// The reference on every level of the search.
#[derive(Debug, Clone)]
pub(crate) struct SearchReference {
    /// From the finest level of the search to the coarsest.
    templates: Vec<PatchTemplate>,
}

/// The search and its scratch memory for one picture size.
#[derive(Debug, Clone)]
pub(crate) struct InverseSearch {
    params: SearchParams,
    simd: Level,
    /// From the finest level of the search to the coarsest.
    levels: Vec<SearchLevel>,
    /// The dense fields; absent between the searches of a tracker that seldom searches.
    dense: Option<DenseFields>,
    frequency: Frequency,
}

/// How often a search is run, which decides whether it keeps all its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Frequency {
    /// In every frame: nothing is allocated between them.
    EveryFrame,
    /// At a cold start and after a loss: the memory of the dense fields is returned at the end.
    Seldom,
}

/// The patches of a level.
#[derive(Debug, Clone)]
struct SearchLevel {
    layout: PatchLayout,
    matches: Vec<Match>,
}

/// Coarsest pyramid level of a search on pictures of this size: there the longer side is about four patches long.
pub(crate) fn coarsest_level(width: usize, height: usize) -> usize {
    let longer = (width.max(height) / (4 * PATCH)).max(1).ilog2();
    let shorter = (width.min(height) / (PATCH + 1)).max(1).ilog2();
    longer.min(shorter) as usize
}

impl InverseSearch {
    /// A search on pictures of this size, at least 16 px wide and high.
    pub(crate) fn new(width: usize, height: usize, params: SearchParams, frequency: Frequency, simd: Level) -> Self {
        let coarsest = coarsest_level(width, height);
        let finest = params.finest_level.min(coarsest);
        let levels: Vec<_> = (finest..=coarsest)
            .map(|level| {
                let layout = PatchLayout::over(width >> level, height >> level, params.stride);
                let unmatched = Match { u: 0.0, v: 0.0, error: f32::INFINITY };
                SearchLevel { layout, matches: vec![unmatched; layout.len()] }
            })
            .collect();
        let dense = (frequency == Frequency::EveryFrame).then(|| DenseFields::new((width, height), finest, &levels));
        Self { params, simd, levels, dense, frequency }
    }

    pub(crate) fn finest_level(&self, picture: &Picture) -> usize {
        self.params.finest_level.min(coarsest_level(picture.size().0, picture.size().1))
    }

    /// An empty reference.
    pub(crate) fn reference(&self) -> SearchReference {
        SearchReference { templates: self.levels.iter().map(|level| PatchTemplate::new(level.layout)).collect() }
    }

    /// Prepares a new reference.
    pub(crate) fn prepare(&self, picture: &Picture, reference: &mut SearchReference) {
        let finest = self.finest_level(picture);
        for (k, template) in reference.templates.iter_mut().enumerate() {
            template.prepare(picture.grey.level(finest + k), self.params.min_texture);
        }
    }

    /// Writes the flow from the reference to `current` into `flow`, full size. The search also tries the displacements
    /// of `start`, if there is one. With `is_exhaustive`, the coarsest level is searched exhaustively.
    pub(crate) fn flow(
        &mut self,
        reference: &SearchReference,
        current: &Picture,
        start: Option<&FlowField>,
        is_exhaustive: bool,
        flow: &mut FlowField,
    ) {
        let finest = self.finest_level(current);
        let size = current.size();
        let mut dense = self.dense.take().unwrap_or_else(|| DenseFields::new(size, finest, &self.levels));
        for (k, level) in self.levels.iter_mut().enumerate().rev() {
            let is_coarsest = k + 1 == reference.templates.len();
            let rules = (self.params.rules(is_exhaustive && is_coarsest), &self.params.refine);
            let pictures = (&reference.templates[k], current.grey.level(finest + k));
            dense.search_level(self.simd, k, level, pictures, start, rules);
        }
        dense.enlarge(flow);
        self.dense = (self.frequency == Frequency::EveryFrame).then_some(dense);
    }
}
