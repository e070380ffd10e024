//! The tractions that cause the displacement of the gel in contact.
//!
//! In contact the displacement is known, outside it the traction is zero. With C the compliance of the block's surface,
//! `(C t)` equals the displacement at the cells in contact. This is solved for t by conjugate gradients, preconditioned
//! with the stiffness of a layer, starting from the tractions of the previous frame.

use fingervision_elastic::BlockOperator;

/// Tractions in units of the shear modulus and the displacement that they cause, with the scratch memory to find them.
#[derive(Debug)]
pub struct Tractions {
    operator: BlockOperator,
    traction: Vec<[f32; 3]>,
    displacement_mm: Vec<[f32; 3]>,
    residual: Vec<[f32; 3]>,
    preconditioned: Vec<[f32; 3]>,
    direction: Vec<[f32; 3]>,
    image: Vec<[f32; 3]>,
}

/// When the iteration ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Residual displacement relative to the prescribed one, both as root mean squares, dimensionless.
    pub tolerance: f64,
    /// Largest number of iterations of conjugate gradients.
    pub most_iterations: usize,
}

impl Tractions {
    /// A gel at rest.
    #[must_use]
    pub fn new(operator: BlockOperator) -> Self {
        let zero = vec![[0.0; 3]; operator.grid().len()];
        Self {
            operator,
            traction: zero.clone(),
            displacement_mm: zero.clone(),
            residual: zero.clone(),
            preconditioned: zero.clone(),
            direction: zero.clone(),
            image: zero,
        }
    }

    /// Forgets the previous frames.
    pub(super) fn rest(&mut self) {
        self.traction.fill([0.0; 3]);
        self.displacement_mm.fill([0.0; 3]);
    }

    /// Tractions `(x, y, z)` of the cells, in units of the shear modulus.
    #[must_use]
    pub fn traction(&self) -> &[[f32; 3]] {
        &self.traction
    }

    /// The displacement `(x, y, z)` of the cells' centres that they cause, mm.
    #[must_use]
    pub fn displacement_mm(&self) -> &[[f32; 3]] {
        &self.displacement_mm
    }

    /// Finds the part of the displacement that the tractions along the normal cause.
    pub(super) fn find_normal(&mut self) {
        for (normal, traction) in self.direction.iter_mut().zip(&self.traction) {
            *normal = [0.0, 0.0, traction[2]];
        }
        self.operator.displacement_into(&self.direction, &mut self.image);
    }

    /// That part, `(x, y, z)` of the cells' centres, mm, as [`Self::find_normal`] found it last.
    pub(super) fn by_normal_mm(&self) -> &[[f32; 3]] {
        &self.image
    }

    /// Solves for the tractions that give the cells in contact these displacements, mm; values elsewhere are not read.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn hold(&mut self, in_contact: &[bool], wanted_mm: &[[f32; 3]], limits: Limits) {
        let restrict = |field: &mut [[f32; 3]]| {
            for (value, &held) in field.iter_mut().zip(in_contact) {
                if !held {
                    *value = [0.0; 3];
                }
            }
        };
        restrict(&mut self.traction);
        self.operator.displacement_into(&self.traction, &mut self.displacement_mm);
        for (residual, (wanted, moved)) in self.residual.iter_mut().zip(wanted_mm.iter().zip(&self.displacement_mm)) {
            *residual = [0, 1, 2].map(|axis| wanted[axis] - moved[axis]);
        }
        restrict(&mut self.residual);
        let size: f64 = in_contact.iter().zip(wanted_mm).filter(|(held, _)| **held).map(|(_, w)| square(w)).sum();
        let limit = limits.tolerance.powi(2) * size;
        let mut slope = f64::INFINITY;
        self.direction.fill([0.0; 3]);
        for _ in 0..limits.most_iterations {
            if dot(&self.residual, &self.residual) <= limit {
                break;
            }
            self.operator.precondition_into(&self.residual, &mut self.preconditioned);
            restrict(&mut self.preconditioned);
            let next = dot(&self.residual, &self.preconditioned);
            let share = (next / slope) as f32;
            slope = next;
            for (direction, preconditioned) in self.direction.iter_mut().zip(&self.preconditioned) {
                *direction = [0, 1, 2].map(|axis| preconditioned[axis] + share * direction[axis]);
            }
            self.operator.displacement_into(&self.direction, &mut self.image);
            let length = (slope / dot(&self.direction, &self.image)) as f32;
            add_scaled(&mut self.traction, length, &self.direction);
            add_scaled(&mut self.displacement_mm, length, &self.image);
            add_scaled(&mut self.residual, -length, &self.image);
            restrict(&mut self.residual);
        }
    }
}

fn square(value: &[f32; 3]) -> f64 {
    value.iter().map(|&value| f64::from(value) * f64::from(value)).sum()
}

fn dot(left: &[[f32; 3]], right: &[[f32; 3]]) -> f64 {
    left.iter().zip(right).map(|(l, r)| f64::from(l[0] * r[0] + l[1] * r[1] + l[2] * r[2])).sum()
}

fn add_scaled(to: &mut [[f32; 3]], scale: f32, from: &[[f32; 3]]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = [0, 1, 2].map(|axis| to[axis] + scale * from[axis]);
    }
}
