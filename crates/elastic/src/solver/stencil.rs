//! A sparse matrix whose rows reach the 26 neighbours of a node of a structured grid.

use super::{Field, Grid};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use rayon::prelude::*;

/// Number of coefficients of one component of a row: 27 nodes of three components.
pub(crate) const REACH: usize = 81;

/// The three rows of a node, one after the other. Within a row come the neighbours' components: y slowest, then z, then
/// x, as they lie in memory.
pub(crate) type Rows = [[f32; REACH]; 3];

/// Place in a row of the first component of the neighbour `step` nodes away along x, y and z, each −1, 0 or 1.
pub(crate) fn column([dx, dy, dz]: [isize; 3]) -> usize {
    (27 * (dy + 1) + 9 * (dz + 1) + 3 * (dx + 1)).unsigned_abs()
}

/// Place in a row of a node's own first component.
pub(crate) const OWN: usize = 39;

/// A matrix over the nodes of a grid, with three components per node.
#[derive(Debug, Clone)]
pub(crate) struct Stencil {
    pub(crate) grid: Grid,
    pub(crate) rows: Vec<Rows>,
    pub(super) simd: Level,
}

impl Stencil {
    pub(crate) fn zero(grid: Grid) -> Self {
        Self { grid, rows: vec![[[0.0; REACH]; 3]; grid.len()], simd: Level::new() }
    }

    /// `product = A · factor`.
    pub(crate) fn multiply_into(&self, factor: &Field<f32>, product: &mut Field<f32>) {
        let slab = self.grid.slab();
        let slabs = product[slab..].par_chunks_mut(slab).take(self.grid.nodes[1]).enumerate();
        slabs.with_min_len(self.grid.least_slabs()).for_each(|(j, product)| {
            let start = (j + 1) * slab;
            let slabs = [0, 1, 2].map(|n| &factor[start + n * slab - slab..][..slab]);
            dispatch!(self.simd, simd => {
                for place in self.grid.slab_nodes() {
                    product[place] = row_product(simd, &self.rows[start + place], slabs, self.grid.row(), place);
                }
            });
        });
    }

    /// The diagonal block of a node.
    pub(crate) fn own_block(&self, node: usize) -> [[f32; 3]; 3] {
        self.rows[node].map(|row| [row[OWN], row[OWN + 1], row[OWN + 2]])
    }
}

/// A node's three rows times a field, given as the slab before the node's, its own and the one after; `row` nodes lie
/// between rows of a slab.
#[inline(always)]
pub(super) fn row_product<S: Simd>(
    simd: S,
    rows: &Rows,
    slabs: [&Field<f32>; 3],
    row: usize,
    place: usize,
) -> [f32; 3] {
    // A neighbour's row has nine values: eight lanes, and one.
    let (mut lanes, mut ninths) = ([f32x8::splat(simd, 0.0); 3], [0.0; 3]);
    for (along_y, slab) in slabs.into_iter().enumerate() {
        for along_z in 0..3 {
            let near = slab[place + along_z * row - row - 1..][..3].as_flattened();
            let near_lanes = f32x8::from_slice(simd, &near[..8]);
            let first = 27 * along_y + 9 * along_z;
            for c in 0..3 {
                let factors = &rows[c][first..first + 9];
                lanes[c] += f32x8::from_slice(simd, &factors[..8]) * near_lanes;
                ninths[c] += factors[8] * near[8];
            }
        }
    }
    let sum = |lanes: f32x8<S>| {
        let [s0, s1, s2, s3, s4, s5, s6, s7]: [f32; 8] = lanes.into();
        ((s0 + s4) + (s1 + s5)) + ((s2 + s6) + (s3 + s7))
    };
    [0, 1, 2].map(|c| sum(lanes[c]) + ninths[c])
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
        let mut matrix = Stencil::zero(grid);
        let node = grid.index(1, 2, 0);
        matrix.rows[node][2][column([-1, 1, 1]) + 1] = 2.0;
        let mut field = vec![[0.0; 3]; grid.len()];
        field[grid.index(0, 3, 1)] = [5.0, 7.0, 11.0];
        let mut product = vec![[0.0; 3]; grid.len()];
        matrix.multiply_into(&field, &mut product);
        assert_eq!(product[node].map(f32::to_bits), [0.0, 0.0, 14.0].map(f32::to_bits));
    }
}
