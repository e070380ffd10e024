//! The part of every patch that the current image shows.
//!
//! Pixels that have left the image add nothing to a patch's sums. Divided by the visible part, the sums are those of a
//! whole patch again, to the extent that its texture is alike everywhere.

use super::grid::{MARGIN, PatchGrid, STRIDE, WINDOW, window_weights};
use super::nodes::NodeField;

/// With less than this part of its weight in the image a patch counts as outside.
pub(super) const LEAST_VISIBLE: f32 = 0.5;

/// Weights of a patch summed along one axis.
#[derive(Debug, Clone)]
pub(super) struct VisiblePart {
    /// The weight before each pixel of the window, and that of all.
    before: [f32; WINDOW + 1],
    /// The first pixel of the patches of every column.
    lefts: Vec<f32>,
}

impl VisiblePart {
    /// For the patches of a grid.
    pub(super) fn new(grid: PatchGrid) -> Self {
        let mut before = [0.0; WINDOW + 1];
        for (k, weight) in window_weights().into_iter().enumerate() {
            before[k + 1] = before[k] + weight;
        }
        Self { before, lefts: (0..grid.columns).map(Self::first).collect() }
    }

    /// Writes for every node the part of its patch's weight in the reference that lies in the current image, 0 to 1, and to
    /// `partial` the nodes for which it may be below 1.
    #[expect(clippy::needless_bitwise_bool, reason = "without branches the loop over a row is vectorised")]
    pub(super) fn write(&self, grid: PatchGrid, field: &NodeField, visible: &mut [f32], partial: &mut Vec<usize>) {
        partial.clear();
        let (columns, width, height) = (grid.columns, grid.width as f32, grid.height as f32);
        let (right, bottom) = (width - WINDOW as f32, height - WINDOW as f32);
        let motions = field.planes[0].chunks_exact(columns).zip(field.planes[3].chunks_exact(columns));
        for (row, (visible, (u, v))) in visible.chunks_exact_mut(columns).zip(motions).take(grid.rows).enumerate() {
            let top = Self::first(row);
            // Nearly all patches are whole: a short loop finds the others.
            let mut whole = 0;
            let lefts = self.lefts.iter().zip(u.iter().zip(v));
            for (visible, (left, (u, v))) in visible.iter_mut().zip(lefts) {
                let (x, y) = (left + u, top + v);
                let is_whole = (x >= 0.0) & (x <= right) & (y >= 0.0) & (y <= bottom) & (*left >= 0.0) & (top >= 0.0);
                *visible = if is_whole { 1.0 } else { 0.0 };
                whole += u32::from(is_whole);
            }
            if whole as usize == columns {
                continue;
            }
            for (column, visible) in visible.iter_mut().enumerate().filter(|(_, visible)| **visible <= 0.0) {
                *visible = self.along(self.lefts[column], u[column], width) * self.along(top, v[column], height);
                partial.push(row * columns + column);
            }
        }
    }

    /// The first pixel of a patch along an axis.
    fn first(place: usize) -> f32 {
        (STRIDE * place) as f32 - MARGIN as f32
    }

    /// The part along an axis of `size` pixels of a patch that begins at pixel `first` and moves by `moved` px.
    fn along(&self, first: f32, moved: f32, size: f32) -> f32 {
        // Limits of the pixels that are in the reference, and of those also in the current image, from the window's first.
        let (left, right) = (-first, size - first);
        let (seen_left, seen_right) = (left.max(left - moved), right.min(right - moved));
        let whole = self.weight(right) - self.weight(left);
        let seen = (self.weight(seen_right) - self.weight(seen_left)).max(0.0);
        if whole > 0.0 { seen / whole } else { 0.0 }
    }

    /// The weight of the pixels before a place in the window, linear within a pixel.
    fn weight(&self, place: f32) -> f32 {
        let place = place.clamp(0.0, WINDOW as f32);
        let k = (place as usize).min(WINDOW - 1);
        self.before[k] + (place - k as f32) * (self.before[k + 1] - self.before[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visible(grid: PatchGrid, [u, v]: [f32; 2]) -> Vec<f32> {
        let mut field = NodeField::zero(grid);
        field.planes[0].fill(u);
        field.planes[3].fill(v);
        let mut visible = vec![f32::NAN; grid.nodes()];
        VisiblePart::new(grid).write(grid, &field, &mut visible, &mut Vec::new());
        visible
    }

    #[test]
    fn at_rest_every_patch_is_visible() {
        assert!(visible(PatchGrid::over(45, 37), [0.0, 0.0]).iter().all(|part| (part - 1.0).abs() < 1e-6));
    }

    #[test]
    fn a_patch_that_moves_across_the_border_is_visible_in_part() {
        let grid = PatchGrid::over(64, 64);
        // Patch 4 of a row covers columns 28 to 43: its middle reaches the border after 28 px.
        for (moved, part) in [(20.0, 1.0), (28.0, 0.5), (36.0, 0.0), (40.0, 0.0)] {
            let found = visible(grid, [moved, 0.0])[4 * grid.columns + 4];
            assert!((found - part).abs() < 1e-5, "moved by {moved} px: {found}, not {part}");
            let found = visible(grid, [-3.0, moved])[4 * grid.columns + 4];
            assert!((found - part).abs() < 1e-5, "moved down by {moved} px: {found}, not {part}");
        }
    }

    #[test]
    fn flow_that_is_not_a_number_is_not_visible() {
        assert!(visible(PatchGrid::over(64, 64), [f32::INFINITY, 0.0]).iter().all(|part| *part <= 0.0));
    }
}
