//! A grid of heights over the indenter's plane, and its processing before it becomes a smooth surface.

/// Distance beyond the edge of the body up to which its walls are represented, mm.
const WALL_HEIGHT_MM: f64 = 8.0;
/// Finest and usual distance between nodes, mm.
const SPACING_MM: [f64; 2] = [0.02, 0.05];
/// Nodes along the longer side, about.
const MOST_NODES: f64 = 1024.0;

/// Heights at the nodes of a square grid whose middle is the origin, mm; infinite outside the outline of the body.
#[derive(Debug, Clone)]
pub(super) struct HeightGrid {
    pub(super) step_mm: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Row-major `[row][column]`.
    pub(super) heights_mm: Vec<f64>,
}

impl HeightGrid {
    /// An empty grid that contains a body of these half-extents and its walls.
    ///
    /// Nodes lie 0.05 mm apart, closer under a fillet below 0.2 mm, wider on a body of more than about 50 mm.
    pub(super) fn around(half_extent_mm: [f64; 2], fillet_mm: f64, wall_slope: f64) -> Self {
        let half = half_extent_mm.map(|half| half + WALL_HEIGHT_MM / wall_slope);
        let [finest, usual] = SPACING_MM;
        let step_mm = (fillet_mm / 4.0).clamp(finest, usual).max(2.0 * half[0].max(half[1]) / MOST_NODES);
        // Two more nodes on each side extend the spline to the edge.
        let [columns, rows] = half.map(|half| 2 * ((half / step_mm).ceil() as usize + 2) + 1);
        Self { step_mm, columns, rows, heights_mm: vec![f64::INFINITY; columns * rows] }
    }

    /// Place of the first node, mm.
    pub(super) fn corner_mm(&self) -> [f64; 2] {
        [self.columns, self.rows].map(|count| -0.5 * (count - 1) as f64 * self.step_mm)
    }

    /// Place of a node, mm.
    pub(super) fn node_mm(&self, column: usize, row: usize) -> [f64; 2] {
        let corner = self.corner_mm();
        [corner[0] + column as f64 * self.step_mm, corner[1] + row as f64 * self.step_mm]
    }

    /// Sets every node.
    pub(super) fn fill(&mut self, height_mm: impl Fn([f64; 2]) -> f64) {
        for node in 0..self.heights_mm.len() {
            self.heights_mm[node] = height_mm(self.node_mm(node % self.columns, node / self.columns));
        }
    }

    /// Widens the body until no slope exceeds `wall_slope`: `h(p) ← min over q of h(q) + s·|p − q|`.
    ///
    /// Every node takes the best of its neighbours' sources, in forward and backward sweeps until none changes
    /// ([Danielsson1980] with heights).
    pub(super) fn limit_slope(&mut self, wall_slope: f64) {
        let rise = wall_slope * self.step_mm;
        let given = self.heights_mm.clone();
        let mut sources: Vec<u32> = (0..given.len() as u32).collect();
        let (columns, rows) = (self.columns, self.rows);
        let mut has_changed = true;
        while has_changed {
            has_changed = false;
            for node in (0..given.len()).chain((0..given.len()).rev()) {
                let [column, row] = [node % columns, node / columns];
                for near_row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
                    for near_column in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                        let source = sources[near_row * columns + near_column] as usize;
                        let [dx, dy] = [source % columns, source / columns].map(|place| place as f64);
                        let way = (dx - column as f64).hypot(dy - row as f64);
                        let height = given[source] + rise * way;
                        if height < self.heights_mm[node] {
                            (self.heights_mm[node], sources[node], has_changed) = (height, source as u32, true);
                        }
                    }
                }
            }
        }
    }

    /// Replaces every height by the mean around it, weighted by a normal distribution of this deviation.
    ///
    /// A mean with non-negative weights makes no slope steeper.
    pub(super) fn smooth(&mut self, deviation_mm: f64) {
        let deviation = deviation_mm / self.step_mm;
        let reach = (4.0 * deviation).ceil() as usize;
        if reach == 0 {
            return;
        }
        let weight = |offset: usize| (-0.5 * (offset as f64 / deviation).powi(2)).exp();
        let weights: Vec<f64> = (0..=2 * reach).map(|place| weight(place.abs_diff(reach))).collect();
        let total: f64 = weights.iter().sum();
        let weights: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
        let mut line = Vec::new();
        for (count, stride, lines) in [(self.columns, 1, self.rows), (self.rows, self.columns, self.columns)] {
            for first in (0..lines).map(|line| if stride == 1 { line * count } else { line }) {
                line.clear();
                line.extend((0..count).map(|node| self.heights_mm[first + node * stride]));
                for node in 0..count {
                    let at = |place: usize| line[(node + place).saturating_sub(reach).min(count - 1)];
                    let mean = weights.iter().enumerate().map(|(place, weight)| weight * at(place)).sum();
                    self.heights_mm[first + node * stride] = mean;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> HeightGrid {
        HeightGrid { step_mm: 0.1, columns: 41, rows: 31, heights_mm: vec![f64::INFINITY; 41 * 31] }
    }

    #[test]
    fn the_slope_limit_is_the_lower_envelope_of_cones() {
        let mut grid = grid();
        let posts = [(7, 5, 0.0), (30, 22, 0.4), (12, 25, 0.1), (33, 4, 1.5), (31, 22, 0.41)];
        for (column, row, height) in posts {
            grid.heights_mm[row * 41 + column] = height;
        }
        grid.limit_slope(2.0);
        for node in 0..grid.heights_mm.len() {
            let [column, row] = [(node % 41) as f64, (node / 41) as f64];
            let cone =
                |&(x, y, height): &(usize, usize, f64)| height + 2.0 * 0.1 * (x as f64 - column).hypot(y as f64 - row);
            let expected = posts.iter().map(cone).fold(f64::INFINITY, f64::min);
            let height = grid.heights_mm[node];
            assert!((height - expected).abs() < 1e-12, "node {column}, {row}: {height} instead of {expected}");
        }
    }

    #[test]
    fn smoothing_keeps_a_plane_and_rounds_a_step() {
        let mut grid = grid();
        grid.fill(|[x, y]| 0.3 * x - 0.2 * y + 2.0);
        let before = grid.clone();
        grid.smooth(0.15);
        let middle = 15 * 41 + 20;
        assert!((grid.heights_mm[middle] - before.heights_mm[middle]).abs() < 1e-12);
        grid.fill(|[x, _]| if x < -1e-9 { 0.0 } else { 1.0 });
        grid.smooth(0.15);
        let mean = 0.5 * (grid.heights_mm[middle] + grid.heights_mm[middle - 1]);
        assert!((mean - 0.5).abs() < 1e-12, "{mean}");
    }
}
