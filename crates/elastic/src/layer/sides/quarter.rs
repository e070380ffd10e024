//! The compliance of the surface of a block in its coarse mesh, one parity at a time.
//!
//! With one parity a quarter of the block is enough. Its levels of nodes are coupled only to their neighbours, so they
//! are eliminated from the base up: with `A` the stiffness of a layer of elements within its upper level, `D` within its
//! lower, `U` between them, `S ← A + D − U S⁻¹ Uᵀ`, and the last time without `D`. The surface's compliance is `S⁻¹`.

use super::inverse::invert;
use super::mesh::CoarseMesh;
use super::parity::{Parity, Unknown};
use super::waves::EndlessMesh;

/// Stiffness of one layer of elements.
struct Layer {
    /// Within the upper level.
    upper: Vec<SparseRow>,
    /// Within the upper and the lower level together.
    both: Vec<SparseRow>,
    /// From the lower level to the upper; its entries are not zero and in order.
    coupling: Vec<SparseRow>,
}

/// The entries of a matrix's row that an element touches: column and value.
type SparseRow = Vec<(usize, f64)>;

/// The part for the coarse nodes, `G − G_∞ + C_far`, in the basis of a parity's fields of norm 1: symmetric, times the
/// shear modulus, 1/mm.
pub(super) fn difference(mesh: &CoarseMesh, endless: &EndlessMesh, parity: Parity) -> Vec<f64> {
    let unknowns = parity.unknowns(mesh.half());
    let size = unknowns.len();
    let mut matrix = compliance(mesh, &unknowns);
    for (row, a) in unknowns.iter().enumerate() {
        let place = a.node.map(usize::cast_signed);
        for (column, b) in unknowns[..=row].iter().enumerate() {
            // A quarter of the block contains a quarter of the energy.
            let block = 0.25 * (a.images * b.images).sqrt() * matrix[row * size + column];
            // By symmetry each image of a has the same displacement.
            let endless: f64 = parity
                .field(b)
                .iter()
                .map(|(from, value)| value * endless.at([0, 1].map(|axis| place[axis] - from[axis]), [a.axis, b.axis]))
                .sum();
            let value = block - a.images.sqrt() * endless;
            matrix[row * size + column] = value;
            matrix[column * size + row] = value;
        }
    }
    matrix
}

/// Displacement of a quarter's surface by force there.
fn compliance(mesh: &CoarseMesh, unknowns: &[Unknown]) -> Vec<f64> {
    let (size, layer) = (unknowns.len(), Layer::new(mesh, unknowns));
    let [mut rest, mut next] = [(); 2].map(|()| vec![0.0; size * size]);
    scatter(&layer.both, &mut rest);
    for level in (0..mesh.cells[2] - 1).rev() {
        invert(&mut rest, size);
        scatter(if level > 0 { &layer.both } else { &layer.upper }, &mut next);
        condense(&mut next, &rest, &layer.coupling);
        std::mem::swap(&mut rest, &mut next);
    }
    invert(&mut rest, size);
    rest
}

/// Lower triangle of `target −= U inverse Uᵀ`.
fn condense(target: &mut [f64], inverse: &[f64], coupling: &[SparseRow]) {
    let size = coupling.len();
    let mut product = vec![0.0; size];
    for (row, near) in coupling.iter().enumerate() {
        product.fill(0.0);
        for &(index, factor) in near {
            for (sum, value) in product.iter_mut().zip(&inverse[index * size..][..size]) {
                *sum += factor * value;
            }
        }
        for (value, near) in target[row * size..][..=row].iter_mut().zip(coupling) {
            *value -= near.iter().map(|&(index, factor)| factor * product[index]).sum::<f64>();
        }
    }
}

impl Layer {
    fn new(mesh: &CoarseMesh, unknowns: &[Unknown]) -> Self {
        let (size, half) = (unknowns.len(), mesh.half());
        let value_at = |[i, j]: [usize; 2], axis: usize| 3 * (j * (half[0] + 1) + i) + axis;
        let mut places = vec![None; 3 * (half[0] + 1) * (half[1] + 1)];
        for (index, unknown) in unknowns.iter().enumerate() {
            places[value_at(unknown.node, unknown.axis)] = Some(index);
        }
        let [mut upper, mut lower, mut between] = [(); 3].map(|()| vec![SparseRow::new(); size]);
        for (i, j) in (0..half[1]).flat_map(|j| (0..half[0]).map(move |i| (i, j))) {
            // Component and node of the element's upper or lower face, with the unknown's place.
            let free = (0..12).filter_map(|n: usize| {
                let (axis, node) = (n % 3, n / 3);
                places[value_at([i + (node & 1), j + (node >> 1)], axis)].map(|place| (axis, node, place))
            });
            for (axis_a, a, row) in free.clone() {
                for (axis_b, b, column) in free.clone() {
                    let element = &mesh.element[axis_a][axis_b];
                    add(&mut upper[row], column, element[a][b]);
                    add(&mut lower[row], column, element[a + 4][b + 4]);
                    add(&mut between[row], column, element[a][b + 4]);
                }
            }
        }
        let mut both = upper.clone();
        for (both, lower) in both.iter_mut().zip(&lower) {
            for &(column, value) in lower {
                add(both, column, value);
            }
        }
        for row in &mut between {
            row.retain(|(_, value)| *value != 0.0);
            row.sort_unstable_by_key(|(column, _)| *column);
        }
        Self { coupling: between, upper, both }
    }
}

/// Adds a value to an entry.
fn add(row: &mut SparseRow, column: usize, value: f64) {
    match row.iter_mut().find(|(other, _)| *other == column) {
        Some((_, sum)) => *sum += value,
        None => row.push((column, value)),
    }
}

/// Writes all entries of a matrix.
fn scatter(rows: &[SparseRow], matrix: &mut [f64]) {
    matrix.fill(0.0);
    for (row, values) in rows.iter().zip(matrix.chunks_exact_mut(rows.len())) {
        for &(column, value) in row {
            values[column] = value;
        }
    }
}
