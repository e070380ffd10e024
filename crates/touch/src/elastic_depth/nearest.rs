//! The nearest marked cell of every cell of a grid.

/// Column and row of a cell.
pub(super) type Place = [i32; 2];

/// The value if there is no marked cell: farther from every cell than any cell of the grid.
const NOWHERE: Place = [-20_000, -20_000];

/// Finds the nearest marked cell of every cell (the cell itself if it is marked) by propagating positions from cell to
/// cell ([Danielsson1980]). Occasionally the result is a fraction of a cell farther than the nearest one. If no cell is
/// marked, all results are the same impossible position.
pub(super) fn nearest_into(columns: usize, marks: &[bool], nearest: &mut [Place]) {
    for (cell, (nearest, &mark)) in nearest.iter_mut().zip(marks).enumerate() {
        *nearest = if mark { place(columns, cell) } else { NOWHERE };
    }
    let rows = marks.len() / columns;
    along(&mut nearest[..columns], 0);
    for row in 1..rows {
        let (above, here) = nearest[(row - 1) * columns..(row + 1) * columns].split_at_mut(columns);
        pass(above, here, row);
    }
    for row in (1..rows).rev() {
        let (here, below) = nearest[(row - 1) * columns..(row + 1) * columns].split_at_mut(columns);
        pass(below, here, row - 1);
    }
}

/// Whether a position is that of a cell.
pub(super) fn is_somewhere(place: Place) -> bool {
    place[0] >= 0
}

/// The distance of a cell from a position, in cells; very large for the impossible position.
pub(super) fn distance(columns: usize, cell: usize, from: Place) -> f64 {
    f64::from(squared(place(columns, cell), from)).sqrt()
}

/// The cell at a place.
pub(super) fn cell_at(columns: usize, [column, row]: Place) -> usize {
    row.cast_unsigned() as usize * columns + column.cast_unsigned() as usize
}

fn place(columns: usize, cell: usize) -> Place {
    [number(cell % columns), number(cell / columns)]
}

/// Columns and rows are few.
fn number(index: usize) -> i32 {
    (index as u32).cast_signed()
}

/// Propagates the nearest positions from the row beside a row to it, then along it.
fn pass(beside: &[Place], here: &mut [Place], row: usize) {
    let last = here.len() - 1;
    for (column, nearest) in here.iter_mut().enumerate() {
        let at = [number(column), number(row)];
        if *nearest == at {
            continue; // a marked cell
        }
        let (left, right) = (column.saturating_sub(1), (column + 1).min(last));
        for known in [beside[left], beside[column], beside[right]] {
            *nearest = nearer(at, *nearest, known);
        }
    }
    along(here, row);
}

fn along(cells: &mut [Place], row: usize) {
    let mut known = cells[0];
    for (column, nearest) in cells.iter_mut().enumerate() {
        known = nearer([number(column), number(row)], *nearest, known);
        *nearest = known;
    }
    for (column, nearest) in cells.iter_mut().enumerate().rev() {
        known = nearer([number(column), number(row)], *nearest, known);
        *nearest = known;
    }
}

/// The nearer one of two positions; the first if both are as near. So a marked cell keeps its own.
fn nearer(at: Place, own: Place, known: Place) -> Place {
    if squared(at, known) < squared(at, own) { known } else { own }
}

fn squared(from: Place, to: Place) -> i32 {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_mark_is_found() {
        let (columns, rows) = (37, 29);
        let marks: Vec<_> = (0..columns * rows).map(|cell| (cell * cell) % 53 == 1 && cell % columns > 6).collect();
        let mut nearest = vec![NOWHERE; marks.len()];
        nearest_into(columns, &marks, &mut nearest);
        for (cell, &found) in nearest.iter().enumerate() {
            assert!(marks[cell_at(columns, found)]);
            let marked = (0..marks.len()).filter(|&other| marks[other]);
            let least =
                marked.map(|other| distance(columns, cell, place(columns, other))).fold(f64::INFINITY, f64::min);
            let found = distance(columns, cell, found);
            assert!(found <= least + 0.3, "cell {cell}: {found} instead of {least}");
        }
    }

    #[test]
    fn without_a_mark_there_is_no_nearest() {
        let mut nearest = vec![[0, 0]; 12];
        nearest_into(4, &[false; 12], &mut nearest);
        assert!(nearest.iter().all(|&place| !is_somewhere(place) && distance(4, 5, place) > 1e4));
    }
}
