//! Splits a layer's influence into the part for the grid of cells and the part for the coarse nodes.

use std::f64::consts::FRAC_PI_2;

use super::mesh::CoarseMesh;

/// Distances, in elements, up to which the cells compute all and from which on the nodes do.
const FADE: [f64; 2] = [2.0, 8.0];

/// A share of the influence that decreases with the distance along x and along y: from 1 to 0 by the square of a cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    /// Distance along an axis up to which the share is 1, mm.
    whole_mm: f64,
    /// Distance along an axis from which on the share is 0, mm.
    pub(super) reach_mm: f64,
}

impl Near {
    pub(super) fn new(mesh: &CoarseMesh) -> Self {
        let [whole_mm, reach_mm] = FADE.map(|elements| elements * mesh.cell_mm[0].max(mesh.cell_mm[1]));
        Self { whole_mm, reach_mm }
    }

    /// The share at an offset, from 1 to 0.
    pub(super) fn share(self, offset_mm: [f64; 2]) -> f64 {
        let along = |distance: f64| {
            let faded = (distance.abs() - self.whole_mm) / (self.reach_mm - self.whole_mm);
            (FRAC_PI_2 * faded.clamp(0.0, 1.0)).cos().powi(2)
        };
        along(offset_mm[0]) * along(offset_mm[1])
    }
}
