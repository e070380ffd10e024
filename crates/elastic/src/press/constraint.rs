//! The constraints of contact on the surface nodes, and their use in a linear solve.

use super::Press;
use super::frame::{Frame, dot};
use super::touch::Touch;
use crate::solver::{Grid, OWN, Stencil, column};
use rayon::prelude::*;

/// The constraint of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Constraint {
    /// Projector onto the free directions.
    pub(super) free: [[f64; 3]; 3],
    /// Prescribed motion along the others, mm.
    pub(super) motion: [f64; 3],
    /// Normal force on a node that slides, N.
    pub(super) push: f64,
    /// Given force along the free directions, N.
    pub(super) drag: [f64; 3],
    /// Stiffness added by friction, N/mm.
    pub(super) friction: [[f64; 3]; 3],
    /// Stiffness added because the face bends, N/mm.
    pub(super) bend: [[f64; 3]; 3],
}

impl Press<'_> {
    /// The constraint of every surface node that has one.
    pub(super) fn constraints(&self, frame: &Frame) -> Vec<Option<Constraint>> {
        let grid = self.assembly.grid;
        let constraint = |(surface, touch): (usize, &Touch)| {
            let place = self.place(surface, &self.displacement);
            match touch {
                Touch::Free => None,
                Touch::Held { anchor } => {
                    let target = frame.gel_from_indenter(*anchor);
                    let motion = [0, 1, 2].map(|c| target[c] - place[c]);
                    Some(Constraint {
                        free: [[0.0; 3]; 3],
                        motion,
                        push: 0.0,
                        drag: [0.0; 3],
                        friction: [[0.0; 3]; 3],
                        bend: [[0.0; 3]; 3],
                    })
                }
                Touch::Sliding | Touch::Frictional(_) => {
                    let gap = frame.gap(self.relief, place)?;
                    let n = gap.normal;
                    let push = dot(&self.forces[grid.on_surface(surface)], &n).max(0.0);
                    let free = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f64::from(u8::from(r == c)) - n[r] * n[c]));
                    let (drag, friction) = match touch {
                        Touch::Frictional(friction) => (friction.drag(), friction.stiffness(&free)),
                        _ => ([0.0; 3], [[0.0; 3]; 3]),
                    };
                    let bend = gap.curvature.map(|row| row.map(|value| -push * value));
                    Some(Constraint { free, motion: n.map(|value| -gap.distance * value), push, drag, friction, bend })
                }
            }
        };
        self.touches.iter().enumerate().map(constraint).collect()
    }
}

/// Projects each constrained node's vector onto its free directions.
pub(super) fn project(grid: Grid, constraints: &[Option<Constraint>], field: &mut [[f32; 3]]) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let value = &mut field[grid.on_surface(surface)];
            *value = constraint.free.map(|row| dot(&row, &value.map(f64::from)) as f32);
        }
    }
}

/// Subtracts the given forces from the nodal forces.
pub(super) fn apply_drag(grid: Grid, constraints: &[Option<Constraint>], forces: &mut [[f64; 3]]) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let value = &mut forces[grid.on_surface(surface)];
            *value = [0, 1, 2].map(|c| value[c] - constraint.drag[c]);
        }
    }
}

/// Adds the contributions of friction and, if `is_bent`, of the bent face to the stiffness.
pub(super) fn add_stiffness(grid: Grid, constraints: &[Option<Constraint>], is_bent: bool, matrix: &mut Stencil) {
    for (surface, constraint) in constraints.iter().enumerate() {
        if let Some(constraint) = constraint {
            let rows = &mut matrix.rows[grid.on_surface(surface)];
            for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                let bend = if is_bent { constraint.bend[r][c] } else { 0.0 };
                rows[r][OWN + c] += (constraint.friction[r][c] + bend) as f32;
            }
        }
    }
}

/// Replaces a matrix `A` by `P A P + d (I − P)`, with `d` each node's own mean stiffness.
pub(super) fn constrain(matrix: &mut Stencil, constraints: &[Option<Constraint>]) {
    let (grid, slab) = (matrix.grid, matrix.grid.slab());
    let [nx, ny, _] = grid.nodes;
    let at = |i: isize, j: isize| {
        let (i, j) = (usize::try_from(i).ok().filter(|i| *i < nx)?, usize::try_from(j).ok().filter(|j| *j < ny)?);
        constraints[j * nx + i].as_ref()
    };
    matrix.rows[slab..].par_chunks_mut(slab).take(ny).enumerate().for_each(|(j, rows)| {
        // Only the surface and the layer below it reach constrained nodes.
        for (k, i) in (0..2.min(grid.nodes[2])).flat_map(|k| (0..nx).map(move |i| (k, i))) {
            let rows = &mut rows[grid.in_slab(i, k)];
            let stiffness = (rows[0][OWN] + rows[1][OWN + 1] + rows[2][OWN + 2]) / 3.0;
            let (i, j) = (i.cast_signed(), j.cast_signed());
            for (dx, dy) in (0..9).map(|n: isize| (n % 3 - 1, n / 3 - 1)) {
                let Some(constraint) = at(i + dx, j + dy) else { continue };
                let first = column([dx, dy, -k.cast_signed()]);
                for row in rows.iter_mut() {
                    let old = [0, 1, 2].map(|c| row[first + c]);
                    for c in 0..3 {
                        row[first + c] = (0..3).map(|m| old[m] * constraint.free[m][c] as f32).sum();
                    }
                }
            }
            if k == 0
                && let Some(constraint) = at(i, j)
            {
                let free = constraint.free.map(|row| row.map(|value| value as f32));
                for c in 0..rows[0].len() {
                    let old = [rows[0][c], rows[1][c], rows[2][c]];
                    for r in 0..3 {
                        rows[r][c] = (0..3).map(|m| free[r][m] * old[m]).sum();
                    }
                }
                for (r, c) in (0..9).map(|n| (n / 3, n % 3)) {
                    rows[r][OWN + c] += stiffness * (f32::from(u8::from(r == c)) - free[r][c]);
                }
            }
        }
    });
}
