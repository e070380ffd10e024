//! Searches the areas of a picture that a warm start has lost.
//!
//! Along a rim single patches fail, because the surface is steep there; a search cannot find them. If a patch fails
//! together with its neighbours, a whole area has moved too far for the Gauss–Newton steps. Only such areas are
//! searched.

use crate::affine::grid::{PatchGrid, STRIDE};
use crate::affine::patches::{AffinePatches, AffineReference};
use crate::search::local::Cells;
use crate::search::{InverseSearch, SearchReference};
use crate::{FlowField, Picture};

/// A failed patch is a core of a lost area if at least this many of the 3×3 patches around it failed, itself included.
/// Along a tracked rim one row of patches fails; along a lost rim two rows do.
const LEAST_FAILED: usize = 6;

/// Distance from a core, in patches, up to which failed patches belong to its area.
const AREA: usize = 2;

/// Least part of the cores that a search must find. If it finds fewer, the next frame is not searched, which halves the
/// cost of an area that stays hidden.
const LEAST_FOUND: f32 = 0.25;

/// Largest number of retries, in which failed patches start from the prediction of their neighbours.
const MOST_RETRIES: usize = 6;

/// Another retry follows only if at most this part of the failed patches still fail.
const STILL_FAILED: f32 = 0.9;

/// The lost areas of a picture and scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Recovery {
    grid: PatchGrid,
    /// Patches that failed.
    failed: Vec<bool>,
    /// The failed patches that are cores of a lost area.
    is_core: Vec<bool>,
    cells: Cells,
    /// Whether the next frame is not searched, because the last search found too little.
    skips_next: bool,
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
            skips_next: false,
        }
    }

    /// Forgets the previous frames.
    pub(crate) fn restart(&mut self) {
        self.skips_next = false;
    }

    /// Finds the lost areas after a warm start; returns their area, px², and whether [`Recovery::run`] is to search them.
    pub(crate) fn find(&mut self, patches: &AffinePatches, reference: &AffineReference) -> (f32, bool) {
        let lost = self.find_cores(patches, reference);
        (area_px2(lost), lost > 0 && !std::mem::take(&mut self.skips_next))
    }

    /// Searches the lost areas that were found after a warm start from `guess`, and refines the patches from the result.
    /// Returns the area that is still lost, px².
    pub(crate) fn run(
        &mut self,
        (searched, reference): (&SearchReference, &AffineReference),
        current: &Picture,
        guess: &FlowField,
        search: &mut InverseSearch,
        patches: &mut AffinePatches,
    ) -> f32 {
        let lost = self.cores();
        let Self { grid, failed, is_core, cells, .. } = self;
        cells.mark(|node| failed[node] && grid.around(node, AREA).any(|near| is_core[near]));
        search.search_lost(searched, current, cells, guess);
        let finest = search.finest_level(current);
        let nodes = cells.is_lost().iter().enumerate().filter(|(_, lost)| **lost);
        let found = nodes.filter_map(|(node, _)| {
            let (i, j) = (node % grid.columns, node / grid.columns);
            Some((node, search.motion_at(finest, (PatchGrid::centre(i), PatchGrid::centre(j)), STRIDE)?))
        });
        patches.refine_found(reference, current, found);
        let mut left = self.find_cores(patches, reference);
        self.skips_next = left as f32 > (1.0 - LEAST_FOUND) * lost as f32;
        if self.skips_next {
            return area_px2(left);
        }
        let mut failed = self.failed();
        for _ in 0..MOST_RETRIES {
            patches.retry(reference, current);
            left = self.find_cores(patches, reference);
            let before = std::mem::replace(&mut failed, self.failed());
            if left == 0 || failed as f32 > STILL_FAILED * before as f32 {
                break;
            }
        }
        area_px2(left)
    }

    /// The area that is lost in the current state of the patches, px².
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
            *core = failed[node] && grid.around(node, 1).filter(|&near| failed[near]).count() >= LEAST_FAILED;
        }
        self.cores()
    }

    /// Number of cores of lost areas.
    fn cores(&self) -> usize {
        self.is_core.iter().filter(|core| **core).count()
    }
}

/// The area of a number of patches, px²: each counts as a square whose side is the stride.
fn area_px2(patches: usize) -> f32 {
    (patches * STRIDE * STRIDE) as f32
}
