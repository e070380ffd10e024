//! The interface of patterns whose colour is averaged over an area: cells of one colour each.

/// A plane of cells of one colour each.
pub(crate) trait Cells {
    /// Red, green and blue of a cell, in grey levels.
    fn at(&self, column: i64, row: i64) -> [f32; 3];
}
