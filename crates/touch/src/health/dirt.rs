//! Finds what stands still while the gel moves behind it: dirt, hairs, scratches and reflections on the optics.
//!
//! They match the reference if they were there when it was taken, so their flow is too small and looks right. The image is divided
//! into cells. A cell is suspicious if its flow is much smaller than that around it, which is about the same on all sides.
//! Gel hardly ever moves like this. Then its pixels are compared with the reference: a pixel stands still if its level is that of the
//! reference at the same place, and not that at the place from which the gel around it has come. A cell is dirty if some pixels stand
//! still again after the gel has moved further, or if more of them stand still once where the flow is valid and the motion is large.
//!
//! A cell remains dirty until there is a new reference. Its flow and that of the cells around it are not valid; they are replaced by
//! values between those of the cells beside them, valid or not. Cells closer to the border than the places around them are not
//! compared, and dirt that hides these places, too, is not found.

mod around;
mod hidden;
#[cfg(test)]
mod tests;

use around::{AROUND, Suspicion, suspicion};
use fingervision_flow::Estimate;
use fingervision_image::{Between, Image};
use hidden::Hidden;

use super::thresholds::THRESHOLDS;
use super::{difference, length2};

/// Side of a cell, px.
const CELL: usize = 8;
/// In how many frames a cell is compared at most.
const MOST_COMPARISONS: usize = 6;
/// The count of a pixel that has clearly changed: it is never counted again.
const HAS_CHANGED: u8 = 0x80;

/// A cell of the image.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    /// Motion of the gel around it in the frames in which it was compared, px; the first `comparisons` count.
    motions: [[f32; 2]; MOST_COMPARISONS],
    comparisons: usize,
    is_dirty: bool,
}

/// The cells of an image.
#[derive(Debug)]
pub(super) struct Dirt {
    columns: usize,
    rows: usize,
    /// Two levels that differ by less are the same, grey levels.
    same_levels: f32,
    /// Grey levels of the reference.
    reference: Image<f32>,
    /// In how many comparisons each pixel stood still, or [`HAS_CHANGED`].
    still: Image<u8>,
    cells: Vec<Cell>,
    /// Dirty cells and those around them.
    is_hidden: Vec<bool>,
    hidden: Vec<Hidden>,
}

impl Dirt {
    /// For images of this size, px, with noise of this standard deviation, grey levels.
    pub(super) fn new((width, height): (usize, usize), noise_levels: f32) -> Self {
        let (columns, rows) = (width / CELL, height / CELL);
        Self {
            columns,
            rows,
            same_levels: THRESHOLDS.same_noise * noise_levels,
            reference: Image::filled(width, height, 0.0),
            still: Image::filled(width, height, 0),
            cells: vec![Cell::default(); columns * rows],
            is_hidden: vec![false; columns * rows],
            hidden: Vec::with_capacity(columns * rows),
        }
    }

    /// Begins again with this reference, to which the flow of the next frames is relative.
    pub(super) fn take_reference(&mut self, grey: &Image<f32>) {
        self.reference.copy_from(grey);
        self.restart();
    }

    /// Forgets what was found.
    pub(super) fn restart(&mut self) {
        self.still.values_mut().fill(0);
        self.cells.fill(Cell::default());
        self.is_hidden.fill(false);
        self.hidden.clear();
    }

    /// Whether enough is hidden for a report.
    pub(super) fn is_large(&self) -> bool {
        let dirty = || self.cells.iter().filter(|cell| cell.is_dirty).count();
        self.part() >= THRESHOLDS.least_damaged_part && dirty() >= THRESHOLDS.least_damaged
    }

    /// The part of the image that dirt hides, 0 to 1.
    pub(super) fn part(&self) -> f32 {
        self.hidden.len() as f32 / self.cells.len().max(1) as f32
    }

    /// Takes a frame that is neither lost nor blurred and has the reference's light.
    pub(super) fn watch(&mut self, grey: &Image<f32>, estimate: &Estimate) {
        let mut is_new = false;
        for row in AROUND..self.rows.saturating_sub(AROUND) {
            for column in AROUND..self.columns.saturating_sub(AROUND) {
                let cell = self.cells[row * self.columns + column];
                if cell.comparisons == MOST_COMPARISONS || cell.is_dirty {
                    continue;
                }
                let Some(Suspicion { motion, is_valid }) = suspicion(estimate, (column, row)) else { continue };
                let is_further =
                    |before: &[f32; 2]| length2(difference(*before, motion)) >= THRESHOLDS.further_px.powi(2);
                if cell.motions[..cell.comparisons].iter().all(is_further) {
                    is_new |= self.compare(grey, (column, row), motion, is_valid);
                }
            }
        }
        if is_new {
            self.hide_around();
        }
    }

    /// Compares a cell with the reference; returns whether it turns out to be dirty. `motion` is that of the gel around it, px.
    fn compare(&mut self, grey: &Image<f32>, (column, row): (usize, usize), motion: [f32; 2], is_valid: bool) -> bool {
        let (left, top) = (column * CELL, row * CELL);
        let (mut once, mut twice) = (0, 0);
        for y in top..top + CELL {
            for x in left..left + CELL {
                let level = grey.at(x, y);
                let change = (level - self.reference.at(x, y)).abs();
                let is_same = change <= self.same_levels;
                let is_still = is_same && self.cannot_have_come(level, (x, y), motion);
                let still = &mut self.still.row_mut(y)[x];
                if change > THRESHOLDS.changed_levels * self.same_levels {
                    *still = HAS_CHANGED;
                } else if *still != HAS_CHANGED {
                    *still += u8::from(is_still);
                }
                once += usize::from(matches!(*still, 1..HAS_CHANGED));
                twice += usize::from(matches!(*still, 2..HAS_CHANGED));
            }
        }
        let cell = &mut self.cells[row * self.columns + column];
        cell.motions[cell.comparisons] = motion;
        cell.comparisons += 1;
        let is_clear = is_valid && length2(motion) >= THRESHOLDS.clear_px.powi(2);
        cell.is_dirty = is_clear && once >= THRESHOLDS.still_once || twice >= THRESHOLDS.still_twice;
        cell.is_dirty
    }

    /// Whether no gel of this level can have come to a pixel by a motion, px, or by about that motion: the gel in a cell does not move
    /// exactly as that around it.
    fn cannot_have_come(&self, level: f32, (x, y): (usize, usize), motion: [f32; 2]) -> bool {
        let near = (THRESHOLDS.near_motion * length2(motion).sqrt()).min(THRESHOLDS.near_px);
        let least = THRESHOLDS.elsewhere_levels * self.same_levels;
        let about = [(0.0, 0.0), (near, 0.0), (-near, 0.0), (0.0, near), (0.0, -near)];
        about.into_iter().all(|(dx, dy)| {
            let from = (x as f32 - motion[0] + dx, y as f32 - motion[1] + dy);
            let other = Between::clamped(from, self.reference.size()).sample(&self.reference);
            (other - level).abs() > least
        })
    }

    /// Hides the dirty cells and those around them.
    fn hide_around(&mut self) {
        let Self { columns, rows, cells, is_hidden, hidden, .. } = self;
        let (columns, rows) = (*columns, *rows);
        // Cells at the border are not compared, so that all of these exist.
        for cell in (0..cells.len()).filter(|&cell| cells[cell].is_dirty) {
            for near in [cell - columns, cell, cell + columns] {
                is_hidden[near - 1..near + 2].fill(true);
            }
        }
        hidden.clear();
        let is_hidden = |x: usize, y: usize| is_hidden[y * columns + x];
        let places = (0..cells.len()).map(|cell| (cell % columns, cell / columns)).filter(|&(x, y)| is_hidden(x, y));
        hidden.extend(places.map(|place| Hidden::new(place, (columns, rows), is_hidden)));
    }

    /// Replaces the flow that dirt hides by one between those beside it, and marks it as not valid.
    pub(super) fn hide(&self, estimate: &mut Estimate) {
        for hidden in &self.hidden {
            hidden.replace(estimate);
        }
    }
}
