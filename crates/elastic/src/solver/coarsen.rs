//! Coarsening along one axis: which nodes are kept, and how the others are interpolated.

use super::stencil::{REACH, Rows};
use super::{Grid, Stencil};
use fearless_simd::dispatch;
use rayon::prelude::*;

/// Drops every other line along an axis; a dropped line is interpolated linearly from its neighbours.
#[derive(Debug, Clone)]
pub(crate) struct Coarsening {
    /// 0 for x, 1 for y, 2 for z.
    axis: usize,
    fine: Grid,
    pub(crate) coarse: Grid,
    /// For each fine line the coarse lines it is interpolated from, with weights; a weight of zero where there is only
    /// one.
    parents: Vec<[(usize, f32); 2]>,
    /// For each coarse line the fine lines interpolated from it, with weights.
    children: Vec<Vec<(usize, f32)>>,
}

impl Coarsening {
    /// Coarsens `axis` of a grid with lines at `lines`, mm. If there is a bonded line at `bonded` after them, the last
    /// dropped line is also interpolated from that, which does not move.
    ///
    /// Returns the coarse lines as well.
    pub(crate) fn new(fine: Grid, axis: usize, lines: &[f64], bonded: Option<f64>) -> (Self, Vec<f64>) {
        let last = lines.len() - 1;
        // A free last line must be kept; a bonded one after it fixes the field there.
        let stays = |line: usize| line.is_multiple_of(2) || line == last && bonded.is_none();
        let kept: Vec<usize> = (0..=last).filter(|&line| stays(line)).collect();
        let parents: Vec<_> = (0..=last)
            .map(|line| {
                let after = kept.partition_point(|&kept| kept < line);
                if kept.get(after) == Some(&line) {
                    return [(after, 1.0), (after, 0.0)];
                }
                let before = after - 1;
                let (low, high) = (lines[kept[before]], kept.get(after).map_or(bonded, |&kept| Some(lines[kept])));
                let share = high.map_or(0.0, |high| (lines[line] - low) / (high - low)) as f32;
                match kept.get(after) {
                    Some(_) => [(before, 1.0 - share), (after, share)],
                    None => [(before, 1.0 - share), (before, 0.0)],
                }
            })
            .collect();
        let mut children = vec![Vec::new(); kept.len()];
        for (line, parents) in parents.iter().enumerate() {
            for &(parent, share) in parents.iter().filter(|(_, share)| *share > 0.0) {
                children[parent].push((line, share));
            }
        }
        let mut coarse = fine;
        coarse.nodes[axis] = kept.len();
        let coarse_lines = kept.iter().map(|&line| lines[line]).collect();
        (Self { axis, fine, coarse, parents, children }, coarse_lines)
    }

    /// Fine place of the line `line` along the axis, for the coarse node `(i, j, k)`.
    fn fine_index(&self, node: [usize; 3], line: usize) -> usize {
        let mut node = node;
        node[self.axis] = line;
        self.fine.index(node[0], node[1], node[2])
    }

    /// `coarse = Iᵀ fine`.
    pub(crate) fn restrict_into(&self, fine: &[[f32; 3]], coarse: &mut [[f32; 3]]) {
        let (slab, [nx, ny, nz]) = (self.coarse.slab(), self.coarse.nodes);
        let slabs = coarse[slab..].par_chunks_mut(slab).take(ny).enumerate();
        slabs.with_min_len(self.coarse.least_slabs()).for_each(|(j, coarse)| {
            for (k, i) in (0..nz).flat_map(|k| (0..nx).map(move |i| (k, i))) {
                let node = [i, j, k];
                let mut sum = [0.0; 3];
                for &(line, share) in &self.children[node[self.axis]] {
                    let value = fine[self.fine_index(node, line)];
                    sum = [0, 1, 2].map(|c| sum[c] + share * value[c]);
                }
                coarse[self.coarse.in_slab(i, k)] = sum;
            }
        });
    }

    /// `fine = I coarse`.
    pub(crate) fn prolong_into(&self, coarse: &[[f32; 3]], fine: &mut [[f32; 3]]) {
        let (slab, [nx, ny, nz]) = (self.fine.slab(), self.fine.nodes);
        let slabs = fine[slab..].par_chunks_mut(slab).take(ny).enumerate();
        slabs.with_min_len(self.fine.least_slabs()).for_each(|(j, fine)| {
            for (k, i) in (0..nz).flat_map(|k| (0..nx).map(move |i| (k, i))) {
                let mut node = [i, j, k];
                let [(first, first_share), (second, second_share)] = self.parents[node[self.axis]];
                let mut value = |line| {
                    node[self.axis] = line;
                    coarse[self.coarse.index(node[0], node[1], node[2])]
                };
                let (a, b) = (value(first), value(second));
                fine[self.fine.in_slab(i, k)] = [0, 1, 2].map(|c| first_share * a[c] + second_share * b[c]);
            }
        });
    }

    /// `coarse = Iᵀ fine I`.
    pub(crate) fn galerkin_into(&self, fine: &Stencil, coarse: &mut Stencil) {
        let (slab, [nx, ny, nz]) = (self.coarse.slab(), self.coarse.nodes);
        let slabs = coarse.rows[slab..].par_chunks_mut(slab).take(ny).enumerate();
        slabs.with_min_len(self.coarse.least_slabs()).for_each(|(j, rows)| {
            for (k, i) in (0..nz).flat_map(|k| (0..nx).map(move |i| (k, i))) {
                let rows = &mut rows[self.coarse.in_slab(i, k)];
                dispatch!(fine.simd, _ => self.galerkin_rows(fine, [i, j, k], rows));
            }
        });
    }

    #[inline(always)]
    fn galerkin_rows(&self, fine: &Stencil, node: [usize; 3], sum: &mut Rows) {
        *sum = [[0.0; REACH]; 3];
        let own = node[self.axis];
        for &(line, share) in &self.children[own] {
            let rows = &fine.rows[self.fine_index(node, line)];
            for step in 0..3 {
                // The fine column's line is `line + step − 1`.
                let Some(parents) = (line + step).checked_sub(1).and_then(|column| self.parents.get(column)) else {
                    continue;
                };
                for &(parent, parent_share) in parents.iter().filter(|(_, share)| *share > 0.0) {
                    let steps = [step, parent + 1 - own];
                    add_plane(self.axis, rows, sum, steps, share * parent_share);
                }
            }
        }
    }
}

/// Adds coefficients `from` nodes along an axis (0, 1, 2 for −1, 0, 1) to those that lie `to` nodes along it.
#[inline(always)]
fn add_plane(axis: usize, source: &Rows, sum: &mut Rows, [from, to]: [usize; 2], factor: f32) {
    // Columns run y, z, x: (distance between neighbours along the axis, length of a run of them).
    let (stride, run) = [(3, 3), (27, 27), (9, 9)][axis];
    for (target, source) in sum.iter_mut().zip(source) {
        let groups = target.chunks_exact_mut(3 * stride).zip(source.chunks_exact(3 * stride));
        for (target, source) in groups {
            let target = &mut target[to * stride..][..run];
            for (target, source) in target.iter_mut().zip(&source[from * stride..][..run]) {
                *target += factor * source;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64Mcg;
    use rand_pcg::rand_core::{Rng, SeedableRng};

    fn noise(rng: &mut Pcg64Mcg) -> f32 {
        (rng.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5
    }

    fn random_field(grid: Grid, rng: &mut Pcg64Mcg) -> Vec<[f32; 3]> {
        let mut field = vec![[0.0; 3]; grid.len()];
        for j in 0..grid.nodes[1] {
            for place in grid.slab_nodes() {
                field[(j + 1) * grid.slab() + place] = [(); 3].map(|()| noise(rng));
            }
        }
        field
    }

    /// The components of a node's 27 neighbours in the order of a row.
    fn neighbourhood(grid: Grid, node: usize, field: &[[f32; 3]]) -> [f32; REACH] {
        std::array::from_fn(|column| {
            let (along_y, along_z, along_x) = (column / 27, column / 9 % 3, column / 3 % 3);
            let near = node + along_y * grid.slab() + along_z * grid.row() + along_x;
            field[near - grid.slab() - grid.row() - 1][column % 3]
        })
    }

    /// Random rows whose coefficients towards the empty layer are zero.
    fn random_matrix(grid: Grid, rng: &mut Pcg64Mcg) -> Stencil {
        let mut matrix = Stencil::zero(grid);
        let ones = {
            let mut ones = vec![[0.0_f32; 3]; grid.len()];
            random_field(grid, rng).iter().zip(&mut ones).for_each(|(value, one)| {
                *one = value.map(|value| f32::from(u8::from(value.abs() > 0.0)));
            });
            ones
        };
        for j in 0..grid.nodes[1] {
            for place in grid.slab_nodes() {
                let node = (j + 1) * grid.slab() + place;
                let inside = neighbourhood(grid, node, &ones);
                matrix.rows[node] = [(); 3].map(|()| inside.map(|inside| inside * noise(rng)));
            }
        }
        matrix
    }

    #[test]
    fn the_coarse_matrix_is_the_galerkin_product() {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let fine = Grid { nodes: [6, 5, 4] };
        let lines = [0.0, 0.4, 1.0, 1.3, 2.0, 2.2];
        for (axis, bonded) in [(0, None), (1, None), (2, Some(2.0)), (2, None)] {
            let (coarsening, kept) = Coarsening::new(fine, axis, &lines[..fine.nodes[axis]], bonded);
            assert_eq!(kept.len(), coarsening.coarse.nodes[axis]);
            let matrix = random_matrix(fine, &mut rng);
            let mut coarse = Stencil::zero(coarsening.coarse);
            coarsening.galerkin_into(&matrix, &mut coarse);
            let field = random_field(coarsening.coarse, &mut rng);
            let mut product = vec![[0.0; 3]; coarsening.coarse.len()];
            coarse.multiply_into(&field, &mut product);
            let (mut up, mut image) = (vec![[0.0; 3]; fine.len()], vec![[0.0; 3]; fine.len()]);
            let mut expected = vec![[0.0; 3]; coarsening.coarse.len()];
            coarsening.prolong_into(&field, &mut up);
            matrix.multiply_into(&up, &mut image);
            coarsening.restrict_into(&image, &mut expected);
            for (value, expected) in product.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((value - expected).abs() < 2e-5, "axis {axis}: {value}, expected {expected}");
            }
        }
    }

    #[test]
    fn a_linear_field_survives() {
        let fine = Grid { nodes: [5, 3, 3] };
        let lines = [0.0, 0.4, 1.0, 1.3, 2.0];
        let (coarsening, kept) = Coarsening::new(fine, 0, &lines, None);
        let mut field = vec![[0.0; 3]; coarsening.coarse.len()];
        for (i, line) in kept.iter().enumerate() {
            field[coarsening.coarse.index(i, 1, 1)] = [*line as f32; 3];
        }
        let mut up = vec![[0.0; 3]; fine.len()];
        coarsening.prolong_into(&field, &mut up);
        for (i, line) in lines.iter().enumerate() {
            assert!((f64::from(up[fine.index(i, 1, 1)][0]) - line).abs() < 1e-6);
        }
    }
}
