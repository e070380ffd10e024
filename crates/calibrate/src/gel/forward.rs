//! Predictions of linear elasticity for frames: the motion around contact and the force, for a given gel.

use fingervision_elastic::{BlockOperator, GelBlock, LayerError, SurfaceGrid};
use fingervision_touch::{Limits, Strain, Tractions};

use super::look::Look;

/// Termination of the solver for tractions: well below the effect of a small change of the gel on the motion.
const LIMITS: Limits = Limits { tolerance: 5e-4, most_iterations: 60 };

/// Number of operators that are cached; making one takes as long as the predictions for some fifty frames.
const KEPT: usize = 16;

/// Predictions of gels for frames.
#[derive(Debug)]
pub(super) struct Models {
    grid: SurfaceGrid,
    made: Vec<Model>,
}

/// Predictions of one gel.
#[derive(Debug)]
struct Model {
    gel: GelBlock,
    tractions: Tractions,
}

/// The prediction of a gel for a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Explained {
    /// The apparent motion of each compared cell, mm.
    pub(super) apparent_mm: Vec<[f64; 2]>,
    /// The normal force over Young's modulus, mm².
    pub(super) force_per_modulus_mm2: f64,
}

impl Models {
    pub(super) fn new(grid: SurfaceGrid) -> Self {
        Self { grid, made: Vec::with_capacity(KEPT) }
    }

    /// Predictions of a gel for frames.
    ///
    /// # Errors
    ///
    /// [`LayerError`] if the gel is impossible, or too thin for the cells.
    pub(super) fn explain(&mut self, gel: &GelBlock, looks: &[Look]) -> Result<Vec<Explained>, LayerError> {
        let place = self.made.iter().position(|model| model.gel == *gel);
        let place = if let Some(place) = place { place } else { self.make(gel)? };
        let model = &mut self.made[place];
        Ok(looks.iter().map(|look| model.explain(look)).collect())
    }

    /// Makes a gel's operator, replacing the oldest if the cache is full; returns its index.
    fn make(&mut self, gel: &GelBlock) -> Result<usize, LayerError> {
        let tractions = Tractions::new(BlockOperator::new(gel, self.grid)?);
        if self.made.len() == KEPT {
            self.made.remove(0);
        }
        self.made.push(Model { gel: *gel, tractions });
        Ok(self.made.len() - 1)
    }
}

impl Model {
    /// Prescribes the displacement in contact and returns the resulting prediction.
    fn explain(&mut self, look: &Look) -> Explained {
        self.tractions.hold(&look.touches, &look.held_mm, LIMITS);
        let moved = self.tractions.displacement_mm();
        let apparent = |&(cell, _): &(usize, usize)| {
            let [x, y, depth] = moved[cell].map(f64::from);
            let [a, b] = look.seen[cell].slope.map(f64::from);
            [x + a * depth, y + b * depth]
        };
        let apparent_mm = look.around.iter().map(apparent).collect();
        let pushed: f64 = self.tractions.traction().iter().map(|traction| f64::from(traction[2])).sum();
        let strain = Strain::of(look.grid, &look.touches, &look.held_mm, self.gel.thickness_mm);
        let [_, _, stiffened] = strain.stiffening();
        let shear_over_modulus = 0.5 / (1.0 + self.gel.poissons_ratio);
        let force_per_modulus_mm2 = stiffened * shear_over_modulus * pushed * look.grid.cell_area_mm2();
        Explained { apparent_mm, force_per_modulus_mm2 }
    }
}
