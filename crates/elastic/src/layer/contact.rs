//! A rigid body pressed into a layer: the reference solution for tests of the elements and of the block.

use super::{Layer, LayerError, LayerOperator, SurfaceGrid};

/// Termination of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactParams {
    /// The residual displacement in contact, relative to the wanted one (both as root mean squares), below which
    /// conjugate gradients end, dimensionless.
    pub(crate) tolerance: f64,
    /// The most iterations for one contact region.
    pub(crate) most_iterations: usize,
    /// The most contact regions tried by a frictionless press.
    pub(crate) most_regions: usize,
}

impl Default for ContactParams {
    fn default() -> Self {
        Self { tolerance: 1e-8, most_iterations: 500, most_regions: 50 }
    }
}

/// The outcome of a press. Fields are row by row, one entry per cell.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LayerPress {
    /// Traction of the body on the gel, `MPa`.
    pub(crate) traction_mpa: Vec<[f64; 3]>,
    /// Displacement of each cell's centre, mm.
    pub(crate) displacement_mm: Vec<[f64; 3]>,
    /// Whether a cell touches.
    pub(crate) in_contact: Vec<bool>,
    /// Force of the body on the gel, N.
    pub(crate) force_n: [f64; 3],
    /// Iterations of conjugate gradients over all regions.
    pub(crate) iterations: usize,
    /// Contact regions tried; 1 where the region was given.
    pub(crate) regions: usize,
    /// Whether residual and region converged.
    pub(crate) has_converged: bool,
}

/// Presses rigid bodies into a layer: finds the tractions on a contact region that cause given displacements there,
/// zero elsewhere, by conjugate gradients preconditioned with the stiffness of waves.
#[derive(Debug)]
pub(crate) struct LayerContact {
    operator: LayerOperator,
    residual: Vec<[f64; 3]>,
    preconditioned: Vec<[f64; 3]>,
    direction: Vec<[f64; 3]>,
    image: Vec<[f64; 3]>,
}

/// Which components are unknown in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Held {
    /// Only depth: no shear force acts on a point.
    Depth,
    /// All three.
    All,
}

impl LayerContact {
    /// Contact of a layer on a grid.
    ///
    /// # Errors
    ///
    /// As [`LayerOperator::new`].
    pub(crate) fn new(layer: &Layer, grid: SurfaceGrid) -> Result<Self, LayerError> {
        let zero = vec![[0.0; 3]; grid.len()];
        Ok(Self {
            operator: LayerOperator::new(layer, grid)?,
            residual: zero.clone(),
            preconditioned: zero.clone(),
            direction: zero.clone(),
            image: zero,
        })
    }

    /// The grid.
    #[must_use]
    pub(crate) fn grid(&self) -> SurfaceGrid {
        self.operator.grid()
    }

    /// Presses a frictionless body in: where the gel touches it, it has the wanted depth, mm, and a positive pressure;
    /// elsewhere it is deeper than wanted and free. `f64::NEG_INFINITY` outside the outline of the body. For a flat punch the
    /// wanted depth is the same everywhere, for a relief it is `depth − height`.
    ///
    /// Begins with all cells of positive wanted depth, then alternately drops those that pull and adds those where gel
    /// and body would overlap, until there are none.
    ///
    /// # Panics
    ///
    /// If there is not one wanted depth per cell, or one is infinite or not a number.
    pub(crate) fn press_frictionless(&mut self, wanted_depth_mm: &[f64], params: &ContactParams) -> LayerPress {
        assert_eq!(wanted_depth_mm.len(), self.grid().len(), "one wanted depth a cell");
        assert!(wanted_depth_mm.iter().all(|depth| *depth < f64::INFINITY), "a wanted depth is finite");
        let wanted: Vec<_> = wanted_depth_mm.iter().map(|&depth| [0.0, 0.0, depth]).collect();
        let mut press = self.begin(wanted_depth_mm.iter().map(|&depth| depth > 0.0).collect());
        let mut has_settled = false;
        while !has_settled && press.regions < params.most_regions {
            press.regions += 1;
            let is_solved = self.solve(Held::Depth, &wanted, &mut press, params);
            self.operator.depth_into(&press.traction_mpa, &mut press.displacement_mm);
            has_settled = !revise(&mut press, wanted_depth_mm);
            press.has_converged = has_settled && is_solved;
        }
        self.finish(press)
    }

    /// Prescribes displacements `(x, y, z)`, mm, in a region, as of a body that the gel sticks to. Displacements
    /// outside the region are not read.
    ///
    /// # Panics
    ///
    /// If there is not one entry per cell.
    pub(crate) fn press_stuck(
        &mut self,
        region: &[bool],
        displacement_mm: &[[f64; 3]],
        params: &ContactParams,
    ) -> LayerPress {
        assert_eq!((region.len(), displacement_mm.len()), (self.grid().len(), self.grid().len()), "one entry a cell");
        let mut press = self.begin(region.to_vec());
        press.regions = 1;
        press.has_converged = self.solve(Held::All, displacement_mm, &mut press, params);
        self.finish(press)
    }

    fn begin(&self, in_contact: Vec<bool>) -> LayerPress {
        let zero = vec![[0.0; 3]; self.grid().len()];
        LayerPress {
            traction_mpa: zero.clone(),
            displacement_mm: zero,
            in_contact,
            force_n: [0.0; 3],
            iterations: 0,
            regions: 0,
            has_converged: false,
        }
    }

    fn finish(&mut self, mut press: LayerPress) -> LayerPress {
        self.operator.displacement_into(&press.traction_mpa, &mut press.displacement_mm);
        let area = self.grid().cell_area_mm2();
        press.force_n =
            [0, 1, 2].map(|axis| area * press.traction_mpa.iter().map(|traction| traction[axis]).sum::<f64>());
        press
    }

    /// Changes the tractions in contact until the displacements there are as wanted. Returns whether the tolerance was
    /// reached.
    fn solve(&mut self, held: Held, wanted: &[[f64; 3]], press: &mut LayerPress, params: &ContactParams) -> bool {
        let LayerPress { traction_mpa: traction, in_contact, iterations, .. } = press;
        for field in [&mut self.preconditioned, &mut self.direction, &mut self.image] {
            field.fill([0.0; 3]);
        }
        let restrict = |field: &mut [[f64; 3]]| restrict(held, in_contact, field);
        restrict(traction);
        self.apply(held, traction);
        for ((residual, wanted), image) in self.residual.iter_mut().zip(wanted).zip(&self.image) {
            *residual = [0, 1, 2].map(|axis| wanted[axis] - image[axis]);
        }
        restrict(&mut self.residual);
        let mut target = wanted.to_vec();
        restrict(&mut target);
        let limit = params.tolerance.powi(2) * dot(&target, &target);
        let mut slope = f64::INFINITY;
        for _ in 0..params.most_iterations {
            if dot(&self.residual, &self.residual) <= limit {
                return true;
            }
            *iterations += 1;
            slope = self.turn(held, slope);
            restrict(&mut self.direction);
            let direction = std::mem::take(&mut self.direction);
            self.apply(held, &direction);
            let step = slope / dot(&direction, &self.image);
            add_scaled(traction, step, &direction);
            restrict(&mut self.image);
            add_scaled(&mut self.residual, -step, &self.image);
            self.direction = direction;
        }
        dot(&self.residual, &self.residual) <= limit
    }

    /// Sets the next direction from the residual; takes the last product of residual and preconditioned residual and
    /// returns the new one.
    fn turn(&mut self, held: Held, last: f64) -> f64 {
        match held {
            Held::Depth => self.operator.precondition_depth_into(&self.residual, &mut self.preconditioned),
            Held::All => self.operator.precondition_into(&self.residual, &mut self.preconditioned),
        }
        let slope = dot(&self.residual, &self.preconditioned);
        let keep = slope / last;
        for (direction, new) in self.direction.iter_mut().zip(&self.preconditioned) {
            *direction = [0, 1, 2].map(|axis| new[axis] + keep * direction[axis]);
        }
        slope
    }

    /// The displacement by a traction, into `image`.
    fn apply(&mut self, held: Held, traction: &[[f64; 3]]) {
        match held {
            Held::Depth => self.operator.depth_into(traction, &mut self.image),
            Held::All => self.operator.displacement_into(traction, &mut self.image),
        }
    }
}

/// Zeroes a field outside contact, and its components along the surface if there is no friction.
fn restrict(held: Held, in_contact: &[bool], field: &mut [[f64; 3]]) {
    for (value, touches) in field.iter_mut().zip(in_contact) {
        *value = match (held, touches) {
            (_, false) => [0.0; 3],
            (Held::Depth, true) => [0.0, 0.0, value[2]],
            (Held::All, true) => *value,
        };
    }
}

/// Drops cells that pull and adds those whose wanted depth the gel does not reach. Returns whether there were any.
fn revise(press: &mut LayerPress, wanted_depth_mm: &[f64]) -> bool {
    let mut has_changed = false;
    let fields = press.traction_mpa.iter().zip(&press.displacement_mm).zip(wanted_depth_mm);
    for (touches, ((traction, displacement), wanted)) in press.in_contact.iter_mut().zip(fields) {
        let should = if *touches { traction[2] > 0.0 } else { displacement[2] < *wanted };
        has_changed |= should != *touches;
        *touches = should;
    }
    has_changed
}

fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}

fn add_scaled(to: &mut [[f64; 3]], factor: f64, from: &[[f64; 3]]) {
    for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
        *to += factor * from;
    }
}
