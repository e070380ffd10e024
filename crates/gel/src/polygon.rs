//! Convex polygons cut along grid lines.

/// A point of the plane.
pub(crate) type Point = [f64; 2];

/// Splits a polygon at the line where coordinate `axis` equals `at` (Sutherland and Hodgman, both sides at once).
pub(crate) fn cut(polygon: &[Point], axis: usize, at: f64, below: &mut Vec<Point>, beyond: &mut Vec<Point>) {
    below.clear();
    beyond.clear();
    for (index, &point) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (from, to) = (point[axis] - at, next[axis] - at);
        if from <= 0.0 {
            below.push(point);
        }
        if from >= 0.0 {
            beyond.push(point);
        }
        if from * to < 0.0 {
            let share = from / (from - to);
            let mut crossing = [0, 1].map(|axis| point[axis] + share * (next[axis] - point[axis]));
            crossing[axis] = at;
            below.push(crossing);
            beyond.push(crossing);
        }
    }
}

/// Area, positive when the corners run clockwise on screen (x right, y down).
pub(crate) fn signed_area(polygon: &[Point]) -> f64 {
    let Some((&[x0, y0], rest)) = polygon.split_first() else { return 0.0 };
    let triangle = |pair: &[Point]| (pair[0][0] - x0) * (pair[1][1] - y0) - (pair[1][0] - x0) * (pair[0][1] - y0);
    0.5 * rest.windows(2).map(triangle).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_fill_the_whole() {
        let quad = [[0.3, 0.2], [1.9, -0.1], [2.4, 1.7], [-0.2, 2.1]];
        let (mut below, mut beyond) = (Vec::new(), Vec::new());
        for (axis, at) in [(0, 1.0), (1, 1.0), (0, 0.3), (1, 5.0)] {
            cut(&quad, axis, at, &mut below, &mut beyond);
            let sum = signed_area(&below) + signed_area(&beyond);
            assert!((sum - signed_area(&quad)).abs() < 1e-14);
        }
    }
}
