//! How far the cells of a grid are from the nearest marked one.

/// Distance of each cell from the nearest one that is marked, in cells, to a tenth (a chamfer of 3 and 4 thirds of a cell,
/// [Borgefors1986]); large where none is.
pub(super) fn distance_into(columns: usize, marks: &[bool], distance: &mut [f32]) {
    const FAR: f32 = 1e6;
    for (distance, &mark) in distance.iter_mut().zip(marks) {
        *distance = if mark { 0.0 } else { FAR };
    }
    let rows = distance.len() / columns;
    relax_along(&mut distance[..columns]);
    for row in 1..rows {
        let (above, below) = distance.split_at_mut(row * columns);
        relax(&mut below[..columns], &above[(row - 1) * columns..]);
    }
    for row in (1..rows).rev() {
        let (above, below) = distance.split_at_mut(row * columns);
        relax(&mut above[(row - 1) * columns..], &below[..columns]);
    }
}

/// Lowers the distances of a row of cells to what the row beside it and then its own cells allow.
fn relax(row: &mut [f32], beside: &[f32]) {
    const DIAGONAL: f32 = 4.0 / 3.0;
    for (distance, &beside) in row.iter_mut().zip(beside) {
        *distance = distance.min(beside + 1.0);
    }
    for (distance, &beside) in row[1..].iter_mut().zip(beside) {
        *distance = distance.min(beside + DIAGONAL);
    }
    for (distance, &beside) in row.iter_mut().zip(&beside[1..]) {
        *distance = distance.min(beside + DIAGONAL);
    }
    relax_along(row);
}

fn relax_along(row: &mut [f32]) {
    for at in 1..row.len() {
        row[at] = row[at].min(row[at - 1] + 1.0);
    }
    for at in (1..row.len()).rev() {
        row[at - 1] = row[at - 1].min(row[at] + 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_is_that_of_the_nearest_mark_to_a_tenth() {
        let (columns, rows) = (31, 23);
        let places = [(4, 5), (20, 17)];
        let marks: Vec<_> =
            (0..columns * rows).map(|cell| places.contains(&(cell % columns, cell / columns))).collect();
        let mut distance = vec![0.0; marks.len()];
        distance_into(columns, &marks, &mut distance);
        for (cell, &found) in distance.iter().enumerate() {
            let to = |&(x, y): &(usize, usize)| {
                ((cell % columns) as f32 - x as f32).hypot((cell / columns) as f32 - y as f32)
            };
            let truth = places.iter().map(to).fold(f32::INFINITY, f32::min);
            assert!((found - truth).abs() <= 0.1 * truth, "{found} instead of {truth}");
        }
        distance_into(columns, &vec![false; marks.len()], &mut distance);
        assert!(distance.iter().all(|&far| far > 1e5), "nothing is marked");
    }
}
