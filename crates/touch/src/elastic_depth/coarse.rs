//! A grid of larger cells over the surface, because tractions need fewer cells than depth.

use fingervision_elastic::SurfaceGrid;

/// A grid with the cells of the surface's grid, or with cells of twice their side. The two grids share their centre.
#[derive(Debug, Clone, Copy)]
pub struct CoarseGrid {
    surface: SurfaceGrid,
    /// Cells of the surface along the side of a cell, 1 or 2.
    part: usize,
    /// The grid itself.
    pub grid: SurfaceGrid,
}

impl CoarseGrid {
    /// Each cell covers `part` by `part` cells of the surface; if their number is odd, the outer cells on both sides
    /// reach beyond it.
    #[must_use]
    pub fn new(surface: SurfaceGrid, part: usize) -> Self {
        let SurfaceGrid { columns, rows, cell_mm } = surface;
        let grid =
            SurfaceGrid { columns: columns.div_ceil(part), rows: rows.div_ceil(part), cell_mm: part as f64 * cell_mm };
        Self { surface, part, grid }
    }

    /// The surface's cells around the centre of each cell: four, two of them twice, or one four times. Its centre is
    /// the mean of theirs.
    pub fn around(self) -> impl Iterator<Item = Around> {
        let Self { surface, part, grid } = self;
        (0..grid.len()).map(move |cell| {
            let [left, right] = beside(cell % grid.columns, part, surface.columns);
            let [above, below] = beside(cell / grid.columns, part, surface.rows);
            let at = |column: usize, row: usize| row * surface.columns + column;
            Around([at(left, above), at(right, above), at(left, below), at(right, below)])
        })
    }

    /// Interpolates values of the cells to the surface's cells: linear between centres and constant beyond the outer
    /// ones.
    pub(super) fn to_surface(self, values: &[[f32; 3]], target: &mut [[f32; 3]]) {
        let Self { surface, grid, .. } = self;
        for (row, target) in target.chunks_exact_mut(surface.columns).enumerate() {
            let (above, down) = self.between(row, surface.rows, grid.rows);
            let below = (above + 1).min(grid.rows - 1);
            for (column, target) in target.iter_mut().enumerate() {
                let (left, along) = self.between(column, surface.columns, grid.columns);
                let right = (left + 1).min(grid.columns - 1);
                let at = |column: usize, row: usize, axis: usize| values[row * grid.columns + column][axis];
                *target = [0, 1, 2].map(|axis| {
                    let upper = at(left, above, axis) + along * (at(right, above, axis) - at(left, above, axis));
                    let lower = at(left, below, axis) + along * (at(right, below, axis) - at(left, below, axis));
                    upper + down * (lower - upper)
                });
            }
        }
    }

    /// Along an axis of `fine` surface cells and `count` of these cells: the cell before the centre of a surface cell,
    /// and the distance from its centre towards the next one, 0 to 1.
    fn between(self, at: usize, fine: usize, count: usize) -> (usize, f32) {
        let place = (at as f64 - 0.5 * (fine as f64 - 1.0)) / self.part as f64 + 0.5 * (count as f64 - 1.0);
        let place = place.clamp(0.0, (count - 1) as f64);
        (place as usize, place.fract() as f32)
    }
}

/// Cells of the surface around a centre.
#[derive(Debug, Clone, Copy)]
pub struct Around([usize; 4]);

impl Around {
    /// The mean of the cells' values; if all four are the same cell, its value to the bit.
    #[must_use]
    pub fn mean(self, of: impl Fn(usize) -> f32) -> f32 {
        let [a, b, c, d] = self.0.map(of);
        0.25 * ((a + b) + (c + d))
    }
}

/// The indices, among `count` cells, of the two cells on both sides of the centre of the larger cell `at`, which is
/// `part` cells long; the same index twice if that centre is the centre of a cell.
fn beside(at: usize, part: usize, count: usize) -> [usize; 2] {
    let first = part * at;
    // The middle of an odd number of cells is the middle of one cell.
    [first, first + usize::from(part == 2 && count.is_multiple_of(2))]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(columns: usize, rows: usize) -> SurfaceGrid {
        SurfaceGrid { columns, rows, cell_mm: 0.5 }
    }

    #[test]
    fn centres_lie_amid_the_cells_around_them() {
        for (part, columns, rows) in [(1, 7, 8), (1, 8, 7), (2, 7, 8), (2, 8, 7)] {
            let surface = surface(columns, rows);
            let coarse = CoarseGrid::new(surface, part);
            let centres: Vec<_> = surface.centres_mm().collect();
            for (around, centre) in coarse.around().zip(coarse.grid.centres_mm()) {
                let mean = [0, 1].map(|axis| around.mean(|cell| centres[cell][axis] as f32));
                let is_there = (0..2).all(|axis| (f64::from(mean[axis]) - centre[axis]).abs() < 1e-6);
                assert!(is_there, "part {part} of {columns}x{rows}: {mean:?}, not {centre:?}");
            }
        }
    }

    #[test]
    fn what_is_linear_comes_to_the_surface_as_it_is() {
        for (part, columns, rows) in [(1, 7, 8), (2, 7, 8), (2, 9, 5)] {
            let surface = surface(columns, rows);
            let coarse = CoarseGrid::new(surface, part);
            let plane = |[x, y]: [f64; 2]| [1.0 + x as f32, y as f32, (x - 2.0 * y) as f32];
            let values: Vec<_> = coarse.grid.centres_mm().map(plane).collect();
            let mut target = vec![[f32::NAN; 3]; surface.len()];
            coarse.to_surface(&values, &mut target);
            let [widest, highest] =
                [coarse.grid.columns, coarse.grid.rows].map(|count| 0.5 * (count as f64 - 1.0) * coarse.grid.cell_mm);
            for (value, [x, y]) in target.iter().zip(surface.centres_mm()) {
                // Beyond the outer centres the value is constant.
                let expected = plane([x.clamp(-widest, widest), y.clamp(-highest, highest)]);
                assert!((0..3).all(|axis| (value[axis] - expected[axis]).abs() < 1e-5), "{value:?}, not {expected:?}");
            }
        }
    }
}
