//! Interpolation between a grid of cells and the coarse nodes.

use super::correction::Correction;
use crate::SurfaceGrid;

/// The two nodes next to a cell, and its distance from the first as a fraction.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    node: usize,
    share: f32,
}

/// Bilinear weights between cells and nodes.
#[derive(Debug)]
pub(super) struct Lattice {
    columns: Vec<Place>,
    rows: Vec<Place>,
    /// Nodes along x.
    width: usize,
    area_mm2: f32,
    /// One value `(x, y, z)` for each node along x.
    line: Vec<[f32; 3]>,
}

impl Lattice {
    pub(super) fn new(grid: SurfaceGrid, correction: &Correction) -> Self {
        let places = |count: usize, axis: usize| {
            let (nodes, spacing) = (correction.nodes[axis], correction.cell_mm[axis]);
            let last = (nodes - 1) as f64;
            let place = move |index: usize| {
                let centre = (index as f64 - 0.5 * (count as f64 - 1.0)) * grid.cell_mm;
                let at = (centre / spacing + 0.5 * last).clamp(0.0, last);
                let node = (at as usize).min(nodes - 2);
                Place { node, share: (at - node as f64) as f32 }
            };
            (0..count).map(place).collect()
        };
        let width = correction.nodes[0];
        let (columns, rows) = (places(grid.columns, 0), places(grid.rows, 1));
        Self { columns, rows, width, area_mm2: grid.cell_area_mm2() as f32, line: vec![[0.0; 3]; width] }
    }

    /// Distributes the force on each cell to the nodes around it.
    pub(super) fn forces_into(&mut self, traction: &[[f32; 3]], forces: &mut [f32]) {
        let (forces, _) = forces.as_chunks_mut::<3>();
        forces.fill([0.0; 3]);
        for (row, traction) in self.rows.iter().zip(traction.chunks_exact(self.columns.len())) {
            self.line.fill([0.0; 3]);
            for (place, traction) in self.columns.iter().zip(traction) {
                add(&mut self.line[place.node], 1.0 - place.share, traction);
                add(&mut self.line[place.node + 1], place.share, traction);
            }
            let (first, second) = forces[row.node * self.width..][..2 * self.width].split_at_mut(self.width);
            for (force, line) in first.iter_mut().zip(&self.line) {
                add(force, self.area_mm2 * (1.0 - row.share), line);
            }
            for (force, line) in second.iter_mut().zip(&self.line) {
                add(force, self.area_mm2 * row.share, line);
            }
        }
    }

    /// Adds to each cell the interpolated value of its nodes.
    pub(super) fn add_displacement(&mut self, nodes: &[f32], displacement: &mut [[f32; 3]]) {
        let (nodes, _) = nodes.as_chunks::<3>();
        for (row, displacement) in self.rows.iter().zip(displacement.chunks_exact_mut(self.columns.len())) {
            let (first, second) = nodes[row.node * self.width..][..2 * self.width].split_at(self.width);
            for (line, (first, second)) in self.line.iter_mut().zip(first.iter().zip(second)) {
                *line = [0, 1, 2].map(|axis| first[axis] + row.share * (second[axis] - first[axis]));
            }
            for (place, displacement) in self.columns.iter().zip(displacement) {
                add(displacement, 1.0 - place.share, &self.line[place.node]);
                add(displacement, place.share, &self.line[place.node + 1]);
            }
        }
    }
}

#[inline(always)]
fn add(target: &mut [f32; 3], factor: f32, value: &[f32; 3]) {
    for (target, value) in target.iter_mut().zip(value) {
        *target += factor * value;
    }
}
