//! Finds a flat face that the gel sticks to, by its motion alone.
//!
//! The surface is divided into overlapping windows. A rigid motion is fitted to each; the face is given by the motion
//! that matches the largest part of the deep surface within the noise of the flow. The network is not used. Balls and
//! faces on which the gel slides are not found.

use fingervision_elastic::SurfaceGrid;

use super::rigid::{self, AtRest, StuckFace};
use super::surface::{self, Surface};
use super::thresholds::THRESHOLDS;

/// Side of a window, cells.
const WINDOW: usize = 12;
/// Distance between neighbouring windows, cells.
const STEP: usize = 6;
/// Distance between the tested cells along both axes, cells.
const SPARSE: usize = 2;
/// Least number of cells of a face.
const LEAST_CELLS: usize = 60;

/// Conditions for a face, in mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceLimits {
    /// Largest difference of a point from the face's motion.
    tolerance: f64,
    /// Least depth of a face.
    least_depth: f64,
    /// Depth above which the weight of a cell no longer grows.
    counted_depth: f64,
}

impl FaceLimits {
    pub(super) fn new(tolerance_mm: f64, thickness_mm: f64) -> Self {
        Self {
            tolerance: tolerance_mm,
            least_depth: THRESHOLDS.least_face_depth * thickness_mm,
            counted_depth: THRESHOLDS.counted_face_depth * thickness_mm,
        }
    }
}

/// Marks the cells that move with the face; none are left marked if there is no face.
pub(super) fn mark(surface: &Surface, limits: &FaceLimits, touches: &mut [bool], scratch: &mut Scratch) {
    touches.fill(false);
    let mut best: Option<(f64, StuckFace)> = None;
    for (column, row) in windows(surface.grid) {
        collect(surface, (column, row), &mut scratch.cells);
        let Some(face) = rigid::fit(surface, &AtRest, &scratch.cells, limits.tolerance, &mut scratch.distances) else {
            continue;
        };
        if face.residual_mm > limits.tolerance {
            continue;
        }
        let score = score(surface, &face, limits);
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, face));
        }
    }
    let Some((_, face)) = best else { return };
    let moves = |cell: usize| is_on(surface, cell, &face, limits);
    for (cell, touches) in touches.iter_mut().enumerate() {
        *touches = moves(cell);
    }
    open(surface.grid, touches, &mut scratch.marks);
    if touches.iter().filter(|touches| **touches).count() < LEAST_CELLS {
        touches.fill(false);
    }
}

/// Scratch memory of a search.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    cells: Vec<usize>,
    distances: Vec<f64>,
    marks: Vec<bool>,
}

impl Scratch {
    pub(super) fn new(cells: usize) -> Self {
        Self {
            cells: Vec::with_capacity(WINDOW * WINDOW),
            distances: Vec::with_capacity(WINDOW * WINDOW),
            marks: vec![false; cells],
        }
    }
}

/// The upper left cells of all windows.
fn windows(grid: SurfaceGrid) -> impl Iterator<Item = (usize, usize)> {
    let starts = |count: usize| (0..count.saturating_sub(WINDOW - 1)).step_by(STEP);
    starts(grid.rows).flat_map(move |row| starts(grid.columns).map(move |column| (column, row)))
}

fn collect(surface: &Surface, (column, row): (usize, usize), cells: &mut Vec<usize>) {
    cells.clear();
    let columns = surface.grid.columns;
    let window = (row..row + WINDOW)
        .step_by(SPARSE)
        .flat_map(|row| (column..column + WINDOW).step_by(SPARSE).map(move |column| row * columns + column));
    cells.extend(window.filter(|&cell| surface.seen[cell].trust > 0.0));
}

fn is_on(surface: &Surface, cell: usize, face: &StuckFace, limits: &FaceLimits) -> bool {
    surface.seen[cell].trust > 0.0
        && face.motion.apply(surface.centre_mm(cell))[2] > limits.least_depth
        && rigid::distance_mm(surface, &AtRest, cell, &face.motion) < 2.0 * limits.tolerance
}

/// Sum over the cells that move with a face, each weighted by its depth up to a limit, because gel near rest fits many
/// motions.
fn score(surface: &Surface, face: &StuckFace, limits: &FaceLimits) -> f64 {
    let SurfaceGrid { columns, rows, .. } = surface.grid;
    let cells = (0..rows).step_by(SPARSE).flat_map(|row| (0..columns).step_by(SPARSE).map(move |x| row * columns + x));
    cells
        .filter(|&cell| is_on(surface, cell, face, limits))
        .map(|cell| face.motion.apply(surface.centre_mm(cell))[2].min(limits.counted_depth))
        .sum()
}

/// Keeps a mark only where a cell and its four neighbours are marked, or where this holds for one of the neighbours.
fn open(grid: SurfaceGrid, marks: &mut [bool], inner: &mut [bool]) {
    for (cell, inner) in inner.iter_mut().enumerate() {
        *inner =
            marks[cell] && surface::neighbours(grid, cell).is_some_and(|near| near.iter().all(|&near| marks[near]));
    }
    // Cells at the grid's border are not marked, so neighbours across the border do not matter.
    let columns = grid.columns;
    let around = |cell: usize| [cell.wrapping_sub(1), cell + 1, cell.wrapping_sub(columns), cell + columns];
    for (cell, mark) in marks.iter_mut().enumerate() {
        let is_beside = |near: usize| inner.get(near).copied().unwrap_or(false);
        *mark = *mark && (inner[cell] || around(cell).into_iter().any(is_beside));
    }
}
