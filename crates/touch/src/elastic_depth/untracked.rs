//! The part of contact in which no flow is valid.

use super::nearest::Nearest;
use super::surface::Surface;
use super::thresholds::THRESHOLDS;
use fingervision_elastic::SurfaceGrid;

/// Decides whether contact is tracked well enough for its depth. Owns its scratch memory.
#[derive(Debug)]
pub(super) struct Untracked {
    is_tracked: Vec<bool>,
    nearest: Nearest,
}

impl Untracked {
    /// For surfaces with this grid of cells.
    pub(super) fn new(grid: SurfaceGrid) -> Self {
        Self { is_tracked: vec![false; grid.len()], nearest: Nearest::new((grid.columns, grid.rows)) }
    }

    /// Whether hardly any of the `touched` cells of contact is tracked, or none in a large area of it that the camera sees.
    pub(super) fn is_untracked(&mut self, surface: &Surface, touches: &[bool], touched: usize) -> bool {
        let cells = surface.seen.iter().zip(touches);
        let tracked = cells.filter(|(seen, touches)| **touches && seen.is_tracked()).count();
        let hole_cells = THRESHOLDS.hole_px * surface.mm_per_px / surface.grid.cell_mm;
        // Fewer cells cannot reach as far.
        let may_have_hole = (touched - tracked) as f64 > hole_cells;
        (tracked as f64) < THRESHOLDS.least_tracked * touched as f64
            || may_have_hole && self.has_hole(surface, touches, hole_cells)
    }

    /// Whether a cell of contact is farther than this from each that is tracked, in cells.
    fn has_hole(&mut self, surface: &Surface, touches: &[bool], hole_cells: f64) -> bool {
        let Self { is_tracked, nearest } = self;
        for (is_tracked, seen) in is_tracked.iter_mut().zip(&surface.seen) {
            *is_tracked = seen.is_tracked();
        }
        nearest.find(is_tracked);
        let is_far = |cell: usize| nearest.distance(cell) > hole_cells;
        (0..touches.len()).any(|cell| touches[cell] && surface.is_seen(cell) && is_far(cell))
    }
}
