//! The positions of the patches.
//!
//! Patches are `WINDOW` px wide and lie every `STRIDE` px, so their windows overlap by half and every pixel belongs to
//! four of them, except along the border. The grid starts half a stride outside the image: patch `(i, j)` covers the
//! *padded* columns `[STRIDE·i, STRIDE·i + WINDOW)`, where padded column `X` is image column `X − MARGIN`; its centre,
//! the *node*, lies at image column `STRIDE·i + STRIDE/2 − ½`.

/// Distance between neighbouring patches, px.
pub(crate) const STRIDE: usize = 8;
/// Width and height of a patch, px.
pub(crate) const WINDOW: usize = 2 * STRIDE;
/// Padded column of the image's first column.
pub(crate) const MARGIN: usize = STRIDE / 2;
/// Pixels that a kernel processes together; padded rows are a multiple of it.
pub(crate) const LANES: usize = 16;

/// The grid of patches over an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PatchGrid {
    /// Image columns, px.
    pub(crate) width: usize,
    /// Image rows, px.
    pub(crate) height: usize,
    /// Patches in a row.
    pub(crate) columns: usize,
    /// Patches in a column.
    pub(crate) rows: usize,
}

impl PatchGrid {
    /// The grid over an image of this size.
    pub(crate) fn over(width: usize, height: usize) -> Self {
        Self { width, height, columns: width.div_ceil(STRIDE), rows: height.div_ceil(STRIDE) }
    }

    /// Number of patches.
    pub(crate) fn nodes(&self) -> usize {
        self.columns * self.rows
    }

    /// Number of patches, rounded up to whole registers: the length of every plane over the nodes.
    pub(crate) fn plane_len(&self) -> usize {
        self.nodes().next_multiple_of(LANES)
    }

    /// Rows of a padded image.
    pub(crate) fn padded_height(&self) -> usize {
        STRIDE * (self.rows + 1)
    }

    /// Columns of a padded row, a multiple of [`LANES`].
    pub(crate) fn padded_width(&self) -> usize {
        (STRIDE * (self.columns + 1)).next_multiple_of(LANES)
    }

    /// The nodes at most `distance` columns and rows away from a node, itself included.
    pub(crate) fn around(self, node: usize, distance: usize) -> impl Iterator<Item = usize> {
        around((self.columns, self.rows), node, distance)
    }

    /// Image coordinate of node `i` along either axis, px.
    pub(crate) fn centre(i: usize) -> f32 {
        (STRIDE * i + MARGIN) as f32 - 0.5
    }
}

/// The nodes of a grid at most `distance` columns and rows away from a node, itself included.
pub(crate) fn around((columns, rows): (usize, usize), node: usize, distance: usize) -> impl Iterator<Item = usize> {
    let (i, j) = (node % columns, node / columns);
    let span = |place: usize, count: usize| place.saturating_sub(distance)..(place + distance + 1).min(count);
    let (beside, rows) = (span(i, columns), span(j, rows));
    rows.flat_map(move |row| beside.clone().map(move |column| row * columns + column))
}

/// Weight of the window along one axis, dimensionless, 1 at the centre: a raised cosine.
pub(crate) fn window_weights() -> [f32; WINDOW] {
    std::array::from_fn(|k| {
        let phase = std::f32::consts::PI * offset(k) * STRIDE as f32 / (WINDOW + 1) as f32;
        phase.cos().powi(2)
    })
}

/// Distance of the window's pixel `k` from its centre along one axis, in strides.
pub(crate) fn offset(k: usize) -> f32 {
    (k as f32 + 0.5 - STRIDE as f32) / STRIDE as f32
}
