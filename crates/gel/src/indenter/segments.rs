//! Straight edges, and a grid that finds those near a point.

/// Cells along a side of the grid.
const CELLS: usize = 64;
/// Distance by which the grid extends beyond the edges, mm.
const MARGIN_MM: f64 = 2.0;

/// A straight edge with a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    from: [f64; 2],
    to: [f64; 2],
    along: [f64; 2],
    square: f64,
}

impl Segment {
    pub(super) fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        let along = [to[0] - from[0], to[1] - from[1]];
        Self { from, to, along, square: along[0] * along[0] + along[1] * along[1] }
    }

    /// The nearest point of the edge, and whether that is one of its ends.
    pub(super) fn foot(&self, point: [f64; 2]) -> ([f64; 2], bool) {
        let [x, y] = [point[0] - self.from[0], point[1] - self.from[1]];
        let share = (x * self.along[0] + y * self.along[1]) / self.square;
        let held = share.clamp(0.0, 1.0);
        ([0, 1].map(|axis| self.from[axis] + held * self.along[axis]), !(share > 0.0 && share < 1.0))
    }

    /// The contribution of the edge to the winding number of its loop around a point.
    pub(super) fn winding(&self, point: [f64; 2]) -> i32 {
        // Ends are compared without arithmetic, so that two edges agree about their shared corner.
        let (starts_above, ends_above) = (point[1] < self.from[1], point[1] < self.to[1]);
        if starts_above == ends_above {
            return 0;
        }
        let [x, y] = [point[0] - self.from[0], point[1] - self.from[1]];
        let side = self.along[0] * y - self.along[1] * x;
        match (ends_above, side > 0.0) {
            (true, true) => 1,
            (false, false) if side < 0.0 => -1,
            _ => 0,
        }
    }

    fn distance(&self, point: [f64; 2]) -> f64 {
        let (foot, _) = self.foot(point);
        (point[0] - foot[0]).hypot(point[1] - foot[1])
    }
}

/// Whether closed loops of edges wind around a point: Sunday's count of signed crossings with the ray towards +x.
pub(super) fn is_wound(edges: &[Segment], point: [f64; 2]) -> bool {
    edges.iter().map(|edge| edge.winding(point)).sum::<i32>() != 0
}

/// For each cell of a grid, every edge that is the nearest to some point of the cell.
#[derive(Debug, Clone)]
pub(super) struct SegmentGrid {
    corner_mm: [f64; 2],
    cell_mm: [f64; 2],
    /// Whether a cell lies wholly inside or outside; absent where an edge may cross it.
    inside: Vec<Option<bool>>,
    /// A cell's edges are those from its entry to the next.
    starts: Vec<u32>,
    near: Vec<u32>,
}

impl SegmentGrid {
    /// The grid over edges that lie within an extent.
    pub(super) fn new(edges: &[Segment], extent_mm: [[f64; 2]; 2]) -> Self {
        let corner_mm = extent_mm.map(|[low, _]| low - MARGIN_MM);
        let cell_mm = extent_mm.map(|[low, high]| (high - low + 2.0 * MARGIN_MM) / CELLS as f64);
        let half_diagonal = 0.5 * cell_mm[0].hypot(cell_mm[1]);
        let mut grid = Self { corner_mm, cell_mm, inside: Vec::new(), starts: vec![0], near: Vec::new() };
        let mut distances = vec![0.0; edges.len()];
        for cell in 0..CELLS * CELLS {
            let place = [cell % CELLS, cell / CELLS];
            let centre = [0, 1].map(|axis| corner_mm[axis] + (place[axis] as f64 + 0.5) * cell_mm[axis]);
            for (distance, edge) in distances.iter_mut().zip(edges) {
                *distance = edge.distance(centre);
            }
            let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
            grid.inside.push((nearest > half_diagonal * (1.0 + 1e-9)).then(|| is_wound(edges, centre)));
            // From the centre to any point of the cell, every distance changes by half a diagonal at most.
            let bound = nearest + 2.0 * half_diagonal * (1.0 + 1e-9);
            grid.near
                .extend((0_u32..).zip(&distances).filter(|&(_, &distance)| distance <= bound).map(|(edge, _)| edge));
            grid.starts.push(grid.near.len() as u32);
        }
        grid
    }

    /// Whether the face contains a point; absent where the grid does not decide.
    pub(super) fn is_inside(&self, point: [f64; 2]) -> Option<bool> {
        self.inside[self.cell(point)?]
    }

    /// The edges among which the nearest to a point is; absent outside the grid.
    pub(super) fn near(&self, point: [f64; 2]) -> Option<&[u32]> {
        let cell = self.cell(point)?;
        Some(&self.near[self.starts[cell] as usize..self.starts[cell + 1] as usize])
    }

    fn cell(&self, point: [f64; 2]) -> Option<usize> {
        let [column, row] = [0, 1].map(|axis| (point[axis] - self.corner_mm[axis]) / self.cell_mm[axis]);
        let range = 0.0..CELLS as f64;
        (range.contains(&column) && range.contains(&row)).then(|| row as usize * CELLS + column as usize)
    }
}
