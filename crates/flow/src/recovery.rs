//! Finds again the parts of a picture that the step from the frame before has lost.
//!
//! Patches fail one by one along a rim, where the surface turns away from the camera: no search brings them back. A patch
//! whose neighbours fail as well shows that a whole area has moved too far. Only such areas are searched again.

use crate::affine::grid::{PatchGrid, STRIDE};
use crate::affine::patches::{AffinePatches, AffineReference};
use crate::search::local::Cells;
use crate::search::{InverseSearch, SearchReference};
use crate::{FlowField, Picture};

/// Patches of the 3×3 around a lost area's core that fail at least, itself included: along a rim that is tracked one row of
/// patches fails, along one that is lost two do.
const CORE: usize = 6;

/// Distance from a core, in patches, up to which failed patches belong to its area.
const AREA: usize = 2;

/// Part of the cores that must be found again; with less the next frame is not searched, so that what is hidden for long
/// costs half.
const LEAST_FOUND: f32 = 0.25;

/// How often patches that still fail are tried again from their neighbours, at most.
const MOST_TRIALS: usize = 6;

/// Part of the failed patches that may still fail after a trial for another one to follow.
const STILL_FAILED: f32 = 0.9;

/// The lost areas of a picture and scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Recovery {
    grid: PatchGrid,
    /// Patches that failed.
    failed: Vec<bool>,
    /// Those of them that are the core of a lost area.
    is_core: Vec<bool>,
    cells: Cells,
    /// Whether the last search found too little to be repeated at once.
    rests: bool,
}

impl Recovery {
    /// For pictures of this size.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let grid = PatchGrid::over(width, height);
        Self {
            grid,
            failed: vec![false; grid.nodes()],
            is_core: vec![false; grid.nodes()],
            cells: Cells::new(STRIDE, grid.columns, grid.rows),
            rests: false,
        }
    }

    /// Searches the lost areas again after a step from `guess`, and settles the patches from there. Returns the area that is
    /// still lost, px².
    pub(crate) fn run(
        &mut self,
        (searched, reference): (&SearchReference, &AffineReference),
        current: &Picture,
        guess: &FlowField,
        search: &mut InverseSearch,
        patches: &mut AffinePatches,
    ) -> f32 {
        let lost = self.find_cores(patches, reference);
        if lost == 0 || std::mem::take(&mut self.rests) {
            return area_px2(lost);
        }
        let Self { grid, failed, is_core, cells, .. } = self;
        cells.mark(|node| failed[node] && grid.around(node, AREA).any(|near| is_core[near]));
        search.search_lost(searched, current, cells, guess);
        let finest = search.finest_level(current);
        let nodes = cells.is_lost().iter().enumerate().filter(|(_, lost)| **lost);
        let found = nodes.filter_map(|(node, _)| {
            let (i, j) = (node % grid.columns, node / grid.columns);
            Some((node, search.motion_at(finest, (PatchGrid::centre(i), PatchGrid::centre(j)), STRIDE)?))
        });
        patches.resettle(reference, current, found);
        let mut left = self.find_cores(patches, reference);
        self.rests = left as f32 > (1.0 - LEAST_FOUND) * lost as f32;
        if self.rests {
            return area_px2(left);
        }
        let mut failed = self.failed();
        for _ in 0..MOST_TRIALS {
            patches.retry(reference, current);
            left = self.find_cores(patches, reference);
            let before = std::mem::replace(&mut failed, self.failed());
            if left == 0 || failed as f32 > STILL_FAILED * before as f32 {
                break;
            }
        }
        area_px2(left)
    }

    /// The area that is lost at the patches as they are, px².
    pub(crate) fn lost_px2(&mut self, patches: &AffinePatches, reference: &AffineReference) -> f32 {
        area_px2(self.find_cores(patches, reference))
    }

    /// Number of failed patches.
    fn failed(&self) -> usize {
        self.failed.iter().filter(|failed| **failed).count()
    }

    /// Finds the failed patches and the cores of lost areas; returns the number of cores.
    fn find_cores(&mut self, patches: &AffinePatches, reference: &AffineReference) -> usize {
        let is_lost = patches.is_lost(reference);
        for (node, failed) in self.failed.iter_mut().enumerate() {
            *failed = is_lost(node);
        }
        let Self { grid, failed, is_core, .. } = self;
        for (node, core) in is_core.iter_mut().enumerate() {
            *core = failed[node] && grid.around(node, 1).filter(|&near| failed[near]).count() >= CORE;
        }
        is_core.iter().filter(|core| **core).count()
    }
}

/// The area of a number of patches, px²: each stands for a square of one stride.
fn area_px2(patches: usize) -> f32 {
    (patches * STRIDE * STRIDE) as f32
}
