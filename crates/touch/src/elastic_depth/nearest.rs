//! The nearest marked cell of every cell of a grid.

/// Column and row of a cell.
pub(super) type Place = [isize; 2];

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
    along(columns, marks, nearest, 0);
    for row in 1..rows {
        pass(columns, marks, nearest, row, row - 1);
    }
    for row in (1..rows).rev() {
        pass(columns, marks, nearest, row - 1, row);
    }
}

/// Whether a position is that of a cell.
pub(super) fn is_somewhere(place: Place) -> bool {
    place[0] >= 0
}

/// The distance of a cell from a position, in cells; very large for the impossible position.
pub(super) fn distance(columns: usize, cell: usize, from: Place) -> f64 {
    (squared(place(columns, cell), from) as f64).sqrt()
}

/// The cell at a place.
pub(super) fn cell_at(columns: usize, [column, row]: Place) -> usize {
    row.cast_unsigned() * columns + column.cast_unsigned()
}

fn place(columns: usize, cell: usize) -> Place {
    [(cell % columns).cast_signed(), (cell / columns).cast_signed()]
}

/// Propagates the nearest positions from the neighbouring row to this row, then along this row.
fn pass(columns: usize, marks: &[bool], nearest: &mut [Place], row: usize, beside: usize) {
    for column in 0..columns {
        for other in column.saturating_sub(1)..(column + 2).min(columns) {
            take(columns, marks, nearest, (column, row), beside * columns + other);
        }
    }
    along(columns, marks, nearest, row);
}

fn along(columns: usize, marks: &[bool], nearest: &mut [Place], row: usize) {
    let first = row * columns;
    for column in 1..columns {
        take(columns, marks, nearest, (column, row), first + column - 1);
    }
    for column in (0..columns - 1).rev() {
        take(columns, marks, nearest, (column, row), first + column + 1);
    }
}

/// Copies the nearest position of another cell if it is nearer to the cell at this column and row; marked cells keep
/// their own.
fn take(columns: usize, marks: &[bool], nearest: &mut [Place], (column, row): (usize, usize), other: usize) {
    let cell = row * columns + column;
    if marks[cell] {
        return;
    }
    let (own, known, here) = (nearest[cell], nearest[other], [column.cast_signed(), row.cast_signed()]);
    if squared(here, known) < squared(here, own) {
        nearest[cell] = known;
    }
}

fn squared(from: Place, to: Place) -> isize {
    (to[0] - from[0]).pow(2) + (to[1] - from[1]).pow(2)
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
