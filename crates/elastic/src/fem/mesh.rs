//! The positions of the nodes.

use crate::solver::Grid;

/// A block divided into hexahedra along three families of lines.
///
/// Along z the first line is the surface, the last the bonded base. The nodes lie at the crossings of the lines unless
/// they were moved.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockMesh {
    lines: [Vec<f64>; 3],
    /// Nodes, `[y][z][x]`, including the base.
    nodes: Vec<[f64; 3]>,
}

impl BlockMesh {
    /// A mesh with nodes at the crossings of the lines, mm.
    ///
    /// # Panics
    ///
    /// If an axis has fewer than two lines or they do not ascend.
    #[must_use]
    pub fn new(x_mm: Vec<f64>, y_mm: Vec<f64>, z_mm: Vec<f64>) -> Self {
        let lines = [x_mm, y_mm, z_mm];
        for lines in &lines {
            assert!(lines.len() >= 2 && lines.is_sorted_by(|a, b| a < b), "mesh lines must ascend: {lines:?}");
        }
        let [x, y, z] = &lines;
        let nodes = y.iter().flat_map(|&y| z.iter().flat_map(move |&z| x.iter().map(move |&x| [x, y, z]))).collect();
        Self { lines, nodes }
    }

    /// Lines along x, y and z, mm.
    #[must_use]
    pub fn lines(&self) -> [&[f64]; 3] {
        self.lines.each_ref().map(Vec::as_slice)
    }

    /// Number of elements along x, y and z.
    #[must_use]
    pub fn cells(&self) -> [usize; 3] {
        self.lines.each_ref().map(|lines| lines.len() - 1)
    }

    /// Position of the node at the crossing of line `i` along x, `j` along y and `k` along z, mm.
    #[must_use]
    pub fn node(&self, i: usize, j: usize, k: usize) -> [f64; 3] {
        let [nx, _, nz] = self.lines.each_ref().map(Vec::len);
        self.nodes[(j * nz + k) * nx + i]
    }

    #[cfg(test)]
    pub(crate) fn node_mut(&mut self, i: usize, j: usize, k: usize) -> &mut [f64; 3] {
        let [nx, _, nz] = self.lines.each_ref().map(Vec::len);
        &mut self.nodes[(j * nz + k) * nx + i]
    }

    /// The nodes that can move: all except the base.
    pub(crate) fn free_grid(&self) -> Grid {
        let [nx, ny, nz] = self.lines.each_ref().map(Vec::len);
        Grid { nodes: [nx, ny, nz - 1] }
    }
}

/// Lines from `from` to `to`, mm, at most `spacing_mm` apart between `fine[0]` and `fine[1]` and ever farther outside,
/// each cell at most `growth` times as long as the one before.
#[must_use]
pub fn graded_lines([from, to]: [f64; 2], fine: [f64; 2], spacing_mm: f64, growth: f64) -> Vec<f64> {
    let fine = fine.map(|end| end.clamp(from, to));
    let cells = ((fine[1] - fine[0]) / spacing_mm - 1e-9).ceil().max(1.0);
    let step = (fine[1] - fine[0]) / cells;
    let mut lines: Vec<f64> =
        coarsening_lengths(fine[0] - from, step, growth).iter().rev().map(|l| fine[0] - l).collect();
    lines.extend((0..=cells as usize).map(|n| fine[0] + step * n as f64));
    lines.extend(coarsening_lengths(to - fine[1], step, growth).iter().map(|l| fine[1] + l));
    if let [first, .., last] = lines.as_mut_slice() {
        (*first, *last) = (from, to);
    }
    lines
}

/// Distances at which to cut `length` so that cells grow evenly from `first` by no more than `growth` each.
fn coarsening_lengths(length: f64, first: f64, growth: f64) -> Vec<f64> {
    if length < 1e-9 * first {
        return Vec::new();
    }
    let (mut distances, mut distance, mut cell) = (Vec::new(), 0.0, first);
    while distance < length - 1e-9 * first {
        cell *= growth;
        distance += cell;
        distances.push(distance);
    }
    // The last cell is cut at the end: shrink all of them instead.
    let shrink = length / distance;
    distances.iter().map(|distance| distance * shrink).collect()
}
