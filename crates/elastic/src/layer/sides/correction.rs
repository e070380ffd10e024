//! The effect of the sides, prepared for use.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use super::mesh::CoarseMesh;
use super::near::Near;
use super::parity::Parity;
use super::quarter::difference;
use super::waves::EndlessMesh;
use crate::GelBlock;
use crate::layer::Layer;

/// Rows of a matrix whose products are summed at once.
const ROWS: usize = 8;

/// From forces on the nodes of a block's coarse surface to their displacements, minus the part computed on the grid of
/// cells.
#[derive(Debug)]
pub(super) struct Correction {
    pub(super) nodes: [usize; 2],
    pub(super) cell_mm: [f64; 2],
    /// The part computed on the grid of cells.
    pub(super) near: Near,
    parts: Vec<Part>,
    simd: Level,
}

/// One parity.
#[derive(Debug)]
struct Part {
    /// For each unknown, the values of the field that it represents: place in the nodal vector, factor.
    fields: Vec<[(usize, f32); 4]>,
    /// Symmetric, times the shear modulus, 1/mm; rows and columns padded with zeros.
    matrix: Vec<f32>,
    size: usize,
}

/// Scratch memory for one parity's forces and displacements.
#[derive(Debug, Clone)]
pub(super) struct Scratch([Vec<f32>; 2]);

/// The corrections in use, each with its block.
static IN_USE: Mutex<Vec<(GelBlock, Weak<Correction>)>> = Mutex::new(Vec::new());

impl Correction {
    /// The correction of a block: the one that is in use for this block, if there is any.
    pub(super) fn shared(block: &GelBlock, layer: &Layer) -> Arc<Self> {
        // It does not depend on Young's modulus.
        let block = GelBlock { youngs_modulus_mpa: None, ..*block };
        let in_use = || IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |known: &[(GelBlock, Weak<Self>)]| {
            known.iter().find(|(other, _)| *other == block).and_then(|(_, correction)| correction.upgrade())
        };
        if let Some(found) = find(&in_use()) {
            return found;
        }
        let new = Arc::new(Self::new(&block, layer));
        let mut known = in_use();
        // Another thread may have been faster.
        find(&known).unwrap_or_else(|| {
            known.retain(|(_, correction)| correction.strong_count() > 0);
            known.push((block, Arc::downgrade(&new)));
            new
        })
    }

    fn new(block: &GelBlock, layer: &Layer) -> Self {
        let mesh = CoarseMesh::new(block);
        let near = Near::new(&mesh);
        let mut endless = EndlessMesh::new(&mesh);
        endless.leave_far(&mesh, layer, near);
        let parts = Parity::ALL.par_iter().map(|&parity| Part::new(&mesh, &endless, parity)).collect();
        Self { nodes: mesh.nodes(), cell_mm: [mesh.cell_mm[0], mesh.cell_mm[1]], near, parts, simd: Level::new() }
    }

    pub(super) fn scratch(&self) -> Scratch {
        let largest = self.parts.iter().map(|part| part.size).max().unwrap_or(0);
        Scratch([(); 2].map(|()| vec![0.0; largest]))
    }

    /// Displacements times the shear modulus, of all nodes row by row, `(x, y, z)` each.
    pub(super) fn displacement_into(&self, forces: &[f32], displacement: &mut [f32], scratch: &mut Scratch) {
        displacement.fill(0.0);
        for part in &self.parts {
            dispatch!(self.simd, _ => part.add(forces, displacement, scratch));
        }
    }
}

impl Part {
    fn new(mesh: &CoarseMesh, endless: &EndlessMesh, parity: Parity) -> Self {
        let unknowns = parity.unknowns(mesh.half());
        let (half, columns) = (mesh.half().map(usize::cast_signed), mesh.nodes()[0]);
        let fields = unknowns.iter().map(|unknown| {
            parity.field(unknown).map(|(node, value)| {
                let [i, j] = [0, 1].map(|axis| (half[axis] + node[axis]).cast_unsigned());
                (3 * (j * columns + i) + unknown.axis, value as f32)
            })
        });
        let size = unknowns.len().next_multiple_of(ROWS);
        let mut matrix = vec![0.0; size * size];
        let difference = difference(mesh, endless, parity);
        for (target, row) in matrix.chunks_exact_mut(size).zip(difference.chunks_exact(unknowns.len())) {
            for (target, value) in target.iter_mut().zip(row) {
                *target = *value as f32;
            }
        }
        Self { fields: fields.collect(), matrix, size }
    }

    #[inline(always)]
    fn add(&self, forces: &[f32], displacement: &mut [f32], Scratch([from, to]): &mut Scratch) {
        let size = self.size;
        let (from, to) = (&mut from[..size], &mut to[..size]);
        from.fill(0.0);
        to.fill(0.0);
        for (from, field) in from.iter_mut().zip(&self.fields) {
            *from = field.iter().map(|&(place, factor)| factor * forces[place]).sum();
        }
        let rows = self.matrix.chunks_exact(ROWS * size).zip(from.chunks_exact(ROWS));
        // A contact leaves most of the gel free.
        for (rows, from) in rows.filter(|(_, from)| from.iter().any(|&force| force != 0.0)) {
            let row: [&[f32]; ROWS] = std::array::from_fn(|n| &rows[n * size..][..size]);
            for column in 0..size {
                let mut sum = to[column];
                for n in 0..ROWS {
                    sum += from[n] * row[n][column];
                }
                to[column] = sum;
            }
        }
        for (to, field) in to.iter().zip(&self.fields) {
            for &(place, factor) in field {
                displacement[place] += factor * to;
            }
        }
    }
}
