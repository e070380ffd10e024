//! A sparse matrix whose rows reach the 26 neighbours of a node of a structured grid.

use super::{Field, Grid, Real};
use rayon::prelude::*;

/// Coefficients that one component of a row has: 27 nodes of three components.
pub(crate) const REACH: usize = 81;

/// The three rows of a node, one after the other. Within a row come the neighbours' components: y slowest, then z, then
/// x, as they lie in memory.
pub(crate) type Rows<T> = [[T; REACH]; 3];

/// Place in a row of the first component of the neighbour `step` nodes away along x, y and z, each −1, 0 or 1.
pub(crate) fn column([dx, dy, dz]: [isize; 3]) -> usize {
    (27 * (dy + 1) + 9 * (dz + 1) + 3 * (dx + 1)).unsigned_abs()
}

/// Place in a row of a node's own first component.
pub(crate) const OWN: usize = 39;

/// A matrix over the nodes of a grid, with three components a node.
#[derive(Debug, Clone)]
pub(crate) struct Stencil<T> {
    pub(crate) grid: Grid,
    pub(crate) rows: Vec<Rows<T>>,
}

impl<T: Real> Stencil<T> {
    pub(crate) fn zero(grid: Grid) -> Self {
        Self { grid, rows: vec![[[T::ZERO; REACH]; 3]; grid.len()] }
    }

    /// `product = A · factor`.
    pub(crate) fn multiply_into(&self, factor: &[[T; 3]], product: &mut Field<T>) {
        let slab = self.grid.slab();
        product[slab..].par_chunks_mut(slab).take(self.grid.nodes[1]).enumerate().for_each(|(j, product)| {
            let start = (j + 1) * slab;
            for place in self.grid.slab_nodes() {
                product[place] = self.row_product(start + place, factor);
            }
        });
    }

    /// A node's three rows times a field.
    #[inline]
    pub(crate) fn row_product(&self, node: usize, factor: &[[T; 3]]) -> [T; 3] {
        let near = neighbourhood(self.grid, node, factor);
        let [x, y, z] = &self.rows[node];
        [dot(x, &near), dot(y, &near), dot(z, &near)]
    }

    /// The block by which a node acts on itself.
    pub(crate) fn own_block(&self, node: usize) -> [[T; 3]; 3] {
        self.rows[node].map(|row| [row[OWN], row[OWN + 1], row[OWN + 2]])
    }
}

/// The components of a node's 27 neighbours in the order of a row.
#[inline]
pub(crate) fn neighbourhood<T: Real>(grid: Grid, node: usize, field: &[[T; 3]]) -> [T; REACH] {
    let mut near = [T::ZERO; REACH];
    let (slab, row) = (grid.slab(), grid.row());
    for (along_y, near) in near.as_chunks_mut::<27>().0.iter_mut().enumerate() {
        for (along_z, near) in near.as_chunks_mut::<9>().0.iter_mut().enumerate() {
            let first = node + along_y * slab + along_z * row - slab - row - 1;
            near.copy_from_slice(field[first..first + 3].as_flattened());
        }
    }
    near
}

/// Scalar product, in eight interleaved sums.
#[inline]
pub(super) fn dot<T: Real>(a: &[T; REACH], b: &[T; REACH]) -> T {
    let mut sums = [T::ZERO; 8];
    let ((a_lanes, [a_last]), (b_lanes, [b_last])) = (a.as_chunks::<8>(), b.as_chunks::<8>()) else { return T::ZERO };
    for (a, b) in a_lanes.iter().zip(b_lanes) {
        for lane in 0..8 {
            sums[lane] = sums[lane] + a[lane] * b[lane];
        }
    }
    let [s0, s1, s2, s3, s4, s5, s6, s7] = sums;
    ((s0 + s4) + (s1 + s5)) + ((s2 + s6) + (s3 + s7)) + *a_last * *b_last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_block_lies_in_the_middle() {
        assert_eq!(column([0, 0, 0]), OWN);
        assert_eq!((column([-1, -1, -1]), column([1, 1, 1])), (0, 78));
    }

    #[test]
    fn a_row_reaches_the_neighbour_it_names() {
        let grid = Grid { nodes: [3, 4, 2] };
        let mut matrix = Stencil::<f64>::zero(grid);
        let node = grid.index(1, 2, 0);
        matrix.rows[node][2][column([-1, 1, 1]) + 1] = 2.0;
        let mut field = vec![[0.0; 3]; grid.len()];
        field[grid.index(0, 3, 1)] = [5.0, 7.0, 11.0];
        let mut product = vec![[0.0; 3]; grid.len()];
        matrix.multiply_into(&field, &mut product);
        assert_eq!(product[node].map(f64::to_bits), [0.0, 0.0, 14.0].map(f64::to_bits));
    }
}
