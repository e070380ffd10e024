//! The position of every patch in the image, and where the surface might occlude itself.

use super::lattice::{Bounds, Lattice};
use super::surface::Surface;

/// Part corners along a tile's side.
const TILE: usize = 16;

/// Length by which patches extend beyond the gel's border, px in the image: every part at the border then has all
/// corners.
const BEYOND_PX: f64 = 1.2;

/// The same, at most, as a share of the patch's width.
const MOST_BEYOND: f64 = 0.5;

/// All patches of a surface, found by place in the image.
#[derive(Debug, Clone)]
pub(crate) struct Patches {
    lattice: Lattice,
    pad_px: f64,
    bounds: Vec<Bounds>,
    /// Patches in each tile: `members[first[tile]..first[tile + 1]]`.
    first: Vec<u32>,
    members: Vec<u32>,
    tiles: [usize; 2],
    /// 1 where some patch does not face the camera everywhere, so that the surface may occlude another part of itself.
    folds: Vec<u8>,
    has_folds: bool,
}

impl Patches {
    /// An empty index. `pad_px` is the largest extension of a patch beyond its corners in the image.
    pub(crate) fn new(lattice: Lattice, pad_px: f64) -> Self {
        let tiles = [lattice.columns, lattice.rows].map(|corners| corners.div_ceil(TILE));
        Self {
            lattice,
            pad_px,
            bounds: Vec::new(),
            first: vec![0; tiles[0] * tiles[1] + 1],
            members: Vec::new(),
            tiles,
            folds: vec![0; lattice.stride * lattice.rows],
            has_folds: false,
        }
    }

    /// Takes the patches of a surface.
    pub(crate) fn take(&mut self, surface: &Surface) {
        if self.has_folds {
            self.folds.fill(0);
            self.has_folds = false;
        }
        self.bounds.clear();
        for patch in 0..surface.patches() {
            let pad_px = self.pad_px + if is_at_border(surface, patch) { BEYOND_PX } else { 0.0 };
            let bounds = self.lattice.bounds(surface.corners(patch), pad_px);
            self.bounds.push(bounds);
            if !bounds.is_outside() && !surface.patch(patch).is_regular {
                self.mark(bounds);
            }
        }
        self.sort_into_tiles();
    }

    /// All patches that may be in the image, with their bounds.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, Bounds)> {
        self.bounds.iter().copied().enumerate().filter(|(_, bounds)| !bounds.is_outside())
    }

    /// Extension of a patch beyond the gel's border at its least and greatest s and t, as shares of its width.
    pub(crate) fn beyond(surface: &Surface, patch: usize) -> [[f64; 2]; 2] {
        if !is_at_border(surface, patch) {
            return [[0.0; 2]; 2];
        }
        let (column, row) = surface.place(patch);
        let (columns, rows) = surface.size();
        let [a, b, c, d] = surface.corners(patch).map(|node| node.px);
        let length = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]).hypot(q[1] - p[1]);
        // An unknown width is treated as zero.
        let share = |width: f64| (BEYOND_PX / width.max(BEYOND_PX / MOST_BEYOND)).min(MOST_BEYOND);
        let across = share(length(a, b).min(length(c, d)));
        let down = share(length(a, c).min(length(b, d)));
        let at = |is_border: bool, share: f64| if is_border { share } else { 0.0 };
        [[at(column == 0, across), at(column + 1 == columns, across)], [at(row == 0, down), at(row + 1 == rows, down)]]
    }

    /// Whether the surface might occlude itself in the part with this upper left corner.
    pub(crate) fn may_fold(&self, column: usize, row: usize) -> bool {
        self.has_folds && self.folds[row * self.lattice.stride + column] != 0
    }

    /// For each part of a row, not zero where the surface might occlude itself; none if it does nowhere.
    pub(crate) fn folds_in(&self, row: usize) -> Option<&[u8]> {
        self.has_folds.then(|| &self.folds[row * self.lattice.stride..][..self.lattice.columns - 1])
    }

    /// Every patch that may overlap a part.
    pub(crate) fn around(&self, part: (usize, usize)) -> impl Iterator<Item = usize> {
        let tile = part.1 / TILE * self.tiles[0] + part.0 / TILE;
        let members = &self.members[self.first[tile] as usize..self.first[tile + 1] as usize];
        members.iter().map(|&patch| patch as usize).filter(move |&patch| self.bounds[patch].touches(part))
    }

    /// Marks the parts in and around the bounds of a patch that does not face the camera.
    fn mark(&mut self, bounds: Bounds) {
        self.has_folds = true;
        let [columns, rows] = bounds.parts(1);
        let columns = columns.start..columns.end.min(self.lattice.columns);
        for row in rows.start..rows.end.min(self.lattice.rows) {
            self.folds[row * self.lattice.stride..][columns.clone()].fill(1);
        }
    }

    /// Lists the patches of every tile, by counting.
    fn sort_into_tiles(&mut self) {
        let Self { bounds, first, members, tiles, .. } = self;
        first.fill(0);
        for bounds in &*bounds {
            each_tile(*bounds, *tiles, |tile| first[tile + 1] += 1);
        }
        for tile in 1..first.len() {
            first[tile] += first[tile - 1];
        }
        members.resize(first[first.len() - 1] as usize, 0);
        // Filled from the end of each tile's list, so that `first` ends at its start again.
        for tile in (1..first.len()).rev() {
            first[tile] = first[tile - 1];
        }
        for (patch, bounds) in bounds.iter().enumerate() {
            each_tile(*bounds, *tiles, |tile| {
                members[first[tile + 1] as usize] = patch as u32;
                first[tile + 1] += 1;
            });
        }
    }
}

/// Whether a patch lies at the gel's border.
fn is_at_border(surface: &Surface, patch: usize) -> bool {
    let ((columns, rows), (column, row)) = (surface.size(), surface.place(patch));
    column == 0 || row == 0 || column + 1 == columns || row + 1 == rows
}

/// Calls back with every tile in which a box overlaps a part.
fn each_tile(bounds: Bounds, tiles: [usize; 2], mut call: impl FnMut(usize)) {
    if bounds.is_outside() {
        return;
    }
    let [columns, rows] = bounds.parts(0).map(|parts| parts.start / TILE..parts.end.div_ceil(TILE));
    for row in rows.start..rows.end.min(tiles[1]) {
        for column in columns.start..columns.end.min(tiles[0]) {
            call(row * tiles[0] + column);
        }
    }
}
