//! The network's inputs at every cell, from the camera's measurements.

use fingervision_elastic::SurfaceGrid;

use super::network::INPUTS;
use super::surface::Seen;

/// Writes the inputs for a grid of `columns` and `rows`, at least those of the surface; beyond the surface, the inputs are those
/// of its last cells. `scale` is the factor from mm to the network's length scale.
pub(super) fn fill(
    inputs: &mut [[f32; INPUTS]],
    (columns, rows): (usize, usize),
    grid: SurfaceGrid,
    seen: &[Seen],
    scale: f32,
) {
    let cell_mm = grid.cell_mm as f32;
    let line = |row: usize| &seen[row.min(grid.rows - 1) * grid.columns..][..grid.columns];
    for (row, inputs) in inputs.chunks_exact_mut(columns).enumerate() {
        let [above, below] = neighbours(row, rows);
        let down = 1.0 / ((below - above) as f32 * cell_mm);
        let (above, here, below) = (line(above), line(row), line(below));
        let input = |left: &Seen, right: &Seen, across: f32, column: usize| {
            let along_x = (right.apparent_mm[0] - left.apparent_mm[0]) * across;
            let along_y = (below[column].apparent_mm[1] - above[column].apparent_mm[1]) * down;
            let [x, y] = here[column].apparent_mm.map(|value| scale * value);
            let [slope_x, slope_y] = here[column].slope;
            [2.0 * x, 2.0 * y, slope_x, slope_y, 3.0 * (along_x + along_y)]
        };
        let inner = 1..grid.columns - 1;
        for (column, (inputs, beside)) in inner.clone().zip(inputs[inner].iter_mut().zip(here.windows(3))) {
            *inputs = input(&beside[0], &beside[2], 0.5 / cell_mm, column);
        }
        for column in std::iter::once(0).chain(grid.columns - 1..columns) {
            let [left, right] = neighbours(column, columns);
            let across = 1.0 / ((right - left) as f32 * cell_mm);
            let on_surface = |column: usize| column.min(grid.columns - 1);
            inputs[column] = input(&here[on_surface(left)], &here[on_surface(right)], across, on_surface(column));
        }
    }
}

/// The neighbours of a position along an axis of this length; the position itself where there is none.
fn neighbours(at: usize, count: usize) -> [usize; 2] {
    [at.saturating_sub(1), (at + 1).min(count - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_the_divergence_also_at_the_border_and_beyond_the_surface_the_last_cell_repeats() {
        let grid = SurfaceGrid { columns: 5, rows: 4, cell_mm: 0.25 };
        let seen: Vec<Seen> = (0..grid.len())
            .map(|cell| {
                let (x, y) = ((cell % grid.columns) as f32, (cell / grid.columns) as f32);
                Seen { apparent_mm: [0.1 * x + 0.3 * y, 0.2 * y - 0.5 * x], slope: [x, -y], ..Seen::default() }
            })
            .collect();
        let (columns, rows) = (8, 8);
        let mut inputs = vec![[f32::NAN; INPUTS]; columns * rows];
        fill(&mut inputs, (columns, rows), grid, &seen, 2.0);
        for (cell, inputs) in inputs.iter().enumerate() {
            let (column, row) = (cell % columns, cell / columns);
            let last = seen[row.min(3) * grid.columns + column.min(4)];
            let [x, y] = last.apparent_mm;
            assert_eq!(inputs[..4], [4.0 * x, 4.0 * y, last.slope[0], last.slope[1]], "column {column}, row {row}");
            // A difference between a cell and its repetition is half of that between two cells; among repetitions there is none.
            let part = |at: usize, last: usize| if at < last { 1.0 } else { 0.5 * f32::from(u8::from(at == last)) };
            let expected = 3.0 * (part(column, 4) * 0.1 + part(row, 3) * 0.2) / 0.25;
            assert!(
                (inputs[4] - expected).abs() < 1e-5,
                "column {column}, row {row}: {} instead of {expected}",
                inputs[4]
            );
        }
    }
}
