//! Flat faces bounded by straight edges, with holes, and the distance of a point from them.

use super::nearest::Nearest;
use super::segments::{Segment, SegmentGrid, is_wound};

/// Loops with more edges than this are searched through a grid.
const FEW_EDGES: usize = 24;

/// A face bounded by closed loops of straight edges.
///
/// A point belongs to it if the total winding number of the loops is not zero; a hole is a loop of opposite orientation.
/// Loops of the same orientation may overlap.
#[derive(Debug, Clone)]
pub(super) struct Outline {
    edges: Vec<Segment>,
    /// Finds the edges near a point; absent if testing all is as fast.
    grid: Option<SegmentGrid>,
    extent_mm: [[f64; 2]; 2],
}

impl Outline {
    /// The face within loops of corners, each closed from its last to its first.
    pub(super) fn new(loops: &[Vec<[f64; 2]>]) -> Self {
        let edges: Vec<Segment> = loops.iter().flat_map(|corners| edges(corners)).collect();
        let corners = loops.iter().flatten();
        let extent_mm = [0, 1].map(|axis| {
            let along = corners.clone().map(|corner| corner[axis]);
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
        });
        let grid = (edges.len() > FEW_EDGES).then(|| SegmentGrid::new(&edges, extent_mm));
        Self { edges, grid, extent_mm }
    }

    /// Smallest and largest coordinate along x and y, mm.
    pub(super) fn extent_mm(&self) -> [[f64; 2]; 2] {
        self.extent_mm
    }

    pub(super) fn contains(&self, point: [f64; 2]) -> bool {
        let [[left, right], [top, bottom]] = self.extent_mm;
        if !(left..=right).contains(&point[0]) || !(top..=bottom).contains(&point[1]) {
            return false;
        }
        let known = self.grid.as_ref().and_then(|grid| grid.is_inside(point));
        known.unwrap_or_else(|| is_wound(&self.edges, point))
    }

    /// The vector from the face to a point; absent on the face.
    pub(super) fn nearest(&self, point: [f64; 2]) -> Option<Nearest> {
        if self.contains(point) {
            return None;
        }
        match self.grid.as_ref().and_then(|grid| grid.near(point)) {
            Some(near) => nearest_of(near.iter().map(|&edge| &self.edges[edge as usize]), point),
            None => nearest_of(self.edges.iter(), point),
        }
    }
}

fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = Segment> {
    let ends = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(ends).map(|(&from, &to)| Segment::new(from, to))
}

fn nearest_of<'a>(edges: impl Iterator<Item = &'a Segment>, point: [f64; 2]) -> Option<Nearest> {
    let mut best = [f64::INFINITY, 0.0, 0.0];
    let mut is_corner = false;
    for edge in edges {
        let (foot, is_end) = edge.foot(point);
        let way = [point[0] - foot[0], point[1] - foot[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        if square < best[0] {
            (best, is_corner) = ([square, way[0], way[1]], is_end);
        }
    }
    let [square, x, y] = best;
    let distance_mm = square.sqrt();
    // Lines of equal distance are straight beside an edge and circular around a corner.
    let bend_per_mm = if is_corner { 1.0 / distance_mm } else { 0.0 };
    (distance_mm > 0.0).then(|| Nearest { distance_mm, away: [x / distance_mm, y / distance_mm], bend_per_mm })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A star with a hole, enough edges for the grid.
    fn star() -> Vec<Vec<[f64; 2]>> {
        let ring = |count: usize, radius: &dyn Fn(usize) -> f64, sense: f64| {
            let corner = |n: usize| {
                let (sin, cos) = (sense * std::f64::consts::TAU * n as f64 / count as f64).sin_cos();
                [radius(n) * cos + 0.3, radius(n) * sin]
            };
            (0..count).map(corner).collect()
        };
        vec![ring(34, &|n| if n % 2 == 0 { 5.0 } else { 3.0 }, 1.0), ring(12, &|_| 1.5, -1.0)]
    }

    fn points() -> impl Iterator<Item = [f64; 2]> {
        (0..4000).map(|n| [0.618_034, 0.754_878].map(|step| 30.0 * ((f64::from(n) * step).fract() - 0.5)))
    }

    #[test]
    fn the_grid_changes_nothing() {
        let with = Outline::new(&star());
        assert!(with.grid.is_some());
        let without = Outline { grid: None, ..with.clone() };
        for point in points().chain(points().map(|point| point.map(|value| value / 3.0))) {
            assert_eq!(with.contains(point), without.contains(point), "{point:?}");
            assert_eq!(with.nearest(point), without.nearest(point), "{point:?}");
        }
    }

    #[test]
    fn the_distance_is_that_to_the_nearest_point_of_the_face() {
        let outline = Outline::new(&star());
        let step = 0.02;
        let lattice = (-300..=300).flat_map(|row| (-300..=300).map(move |column| [column, row].map(f64::from)));
        let face: Vec<_> =
            lattice.map(|point| point.map(|value| value * step)).filter(|&point| outline.contains(point)).collect();
        for point in points().map(|point| point.map(|value| value / 2.0)).take(60) {
            let brute = face.iter().map(|face| (face[0] - point[0]).hypot(face[1] - point[1])).fold(f64::MAX, f64::min);
            let distance = outline.nearest(point).map_or(0.0, |nearest| nearest.distance_mm);
            assert!(distance <= brute + 1e-12 && brute <= distance + 2.0 * step, "{point:?}: {distance} and {brute}");
        }
    }

    #[test]
    fn a_hole_is_no_part_of_the_face() {
        let outline = Outline::new(&star());
        assert!(!outline.contains([0.3, 0.0]) && outline.contains([2.5, 0.0]) && !outline.contains([9.0, 0.0]));
        let nearest = outline.nearest([0.8, 0.0]).unwrap();
        assert!((0.95..1.0).contains(&nearest.distance_mm) && nearest.away[0] < -0.9, "{nearest:?}");
    }
}
