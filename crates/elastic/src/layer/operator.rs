//! The compliance of a layer on a grid.

use fingervision_fourier::Complex64;

use super::half_space::{Influence, influence};
use super::remainder::{REACH, Remainder};
use super::symbol::Symbol;
use super::transform::{Transform, good_length};
use super::{Layer, LayerError, SurfaceGrid};

/// From tractions on a grid of cells to the displacements of their centres.
///
/// Each cell has uniform traction; the surface outside the grid is free and the layer has infinite extent. The sum over
/// cells is a convolution, done by Fourier transform on a grid padded with zeros to `cells + reach` along each axis,
/// where the reach is that of the kernel: `cells − 1`, or 24 thicknesses where that is less, beyond which a bonded layer
/// does not move. So the periodic images of the transform never touch the grid and the sum is exact. The kernel is the
/// closed form of a half-space plus the smooth remainder that a base adds.
///
/// Made once per layer and grid: it owns plans and scratch memory, and no call allocates.
#[derive(Debug)]
pub struct LayerOperator {
    grid: SurfaceGrid,
    transform: Transform<f64>,
    compliance: Symbol,
    stiffness: Symbol,
    spectra: [Vec<Complex64>; 3],
}

impl LayerOperator {
    /// The operator of a layer on a grid.
    ///
    /// # Errors
    ///
    /// [`LayerError`] if the grid is impossible or its cells are wider than half the layer's thickness.
    pub fn new(layer: &Layer, grid: SurfaceGrid) -> Result<Self, LayerError> {
        let Symbols { transform, compliance, stiffness } =
            Symbols::new(layer, grid, REACH * layer.thickness_mm, |_| 1.0)?;
        let spectra = [(); 3].map(|()| transform.spectrum());
        Ok(Self { grid, transform, compliance, stiffness, spectra })
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> SurfaceGrid {
        self.grid
    }

    /// Displacement `(x, y, z)`, mm, of each cell's centre under traction `(x, y, z)`, `MPa`, row by row. The
    /// operator is symmetric and positive definite.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn displacement_into(&mut self, traction_mpa: &[[f64; 3]], displacement_mm: &mut [[f64; 3]]) {
        self.convolve(Kernel::Compliance, traction_mpa, displacement_mm);
    }

    /// As [`LayerOperator::displacement_into`] for pressure alone: the displacement in depth by traction in depth, at a
    /// third of the cost. The other components of traction are not read, those of displacement not written.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn depth_into(&mut self, traction_mpa: &[[f64; 3]], displacement_mm: &mut [[f64; 3]]) {
        self.convolve_normal(Kernel::Compliance, traction_mpa, displacement_mm);
    }

    /// The traction of an infinite wave for a given displacement, cut off at the grid's border: an approximate inverse,
    /// symmetric and positive definite, for conjugate gradients.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn precondition_into(&mut self, displacement_mm: &[[f64; 3]], traction_mpa: &mut [[f64; 3]]) {
        self.convolve(Kernel::Stiffness, displacement_mm, traction_mpa);
    }

    /// As [`LayerOperator::precondition_into`] for the components in depth alone.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn precondition_depth_into(&mut self, displacement_mm: &[[f64; 3]], traction_mpa: &mut [[f64; 3]]) {
        self.convolve_normal(Kernel::Stiffness, displacement_mm, traction_mpa);
    }

    fn convolve(&mut self, kernel: Kernel, from: &[[f64; 3]], to: &mut [[f64; 3]]) {
        for axis in 0..3 {
            self.load(axis, from);
        }
        match kernel {
            Kernel::Compliance => self.compliance.multiply(&mut self.spectra),
            Kernel::Stiffness => self.stiffness.multiply(&mut self.spectra),
        }
        for axis in 0..3 {
            self.store(axis, to);
        }
    }

    fn convolve_normal(&mut self, kernel: Kernel, from: &[[f64; 3]], to: &mut [[f64; 3]]) {
        self.load(2, from);
        match kernel {
            Kernel::Compliance => self.compliance.multiply_normal(&mut self.spectra[2]),
            Kernel::Stiffness => self.stiffness.multiply_normal(&mut self.spectra[2]),
        }
        self.store(2, to);
    }

    fn load(&mut self, axis: usize, from: &[[f64; 3]]) {
        let SurfaceGrid { columns, rows, .. } = self.grid;
        assert_eq!(from.len(), self.grid.len(), "one entry a cell");
        let value = |column: usize, row: usize| from[row * columns + column][axis];
        self.transform.forward_into((columns, rows), value, &mut self.spectra[axis]);
    }

    fn store(&mut self, axis: usize, to: &mut [[f64; 3]]) {
        let SurfaceGrid { columns, rows, .. } = self.grid;
        assert_eq!(to.len(), self.grid.len(), "one entry a cell");
        self.transform.inverse_into(rows, &mut self.spectra[axis], |row, values| {
            for (target, value) in to[row * columns..][..columns].iter_mut().zip(values) {
                target[axis] = *value;
            }
        });
    }
}

/// The matrices of a layer on a padded grid, with the transform that they belong to.
pub(super) struct Symbols {
    pub(super) transform: Transform<f64>,
    pub(super) compliance: Symbol,
    pub(super) stiffness: Symbol,
}

impl Symbols {
    /// For the layer's influence times a share of it, a function of the offset that is even along both axes and zero
    /// from `reach_mm` on along either.
    pub(super) fn new(
        layer: &Layer,
        grid: SurfaceGrid,
        reach_mm: f64,
        share: impl Fn([f64; 2]) -> f64,
    ) -> Result<Self, LayerError> {
        grid.validate()?;
        let SurfaceGrid { columns, rows, cell_mm } = grid;
        let thickness_mm = layer.thickness_mm;
        if 2.0 * cell_mm > thickness_mm {
            return Err(LayerError::Coarse { cell_mm, thickness_mm });
        }
        // A float too large for an integer becomes the largest one.
        let reach = ((reach_mm / cell_mm).ceil() as usize).saturating_add(1);
        let kernel = [columns, rows].map(|count| count.min(reach));
        let padded = |count: usize, kernel: usize| good_length(count + kernel - 1);
        let mut transform = Transform::new(padded(columns, kernel[0]), padded(rows, kernel[1]));
        let influence = influence_of(layer, cell_mm, cell_mm * (kernel[0] as f64).hypot(kernel[1] as f64));
        let at_cell = |column: usize, row: usize| {
            let offset = [column, row].map(|count| count as f64 * cell_mm);
            influence(offset).times(share(offset))
        };
        let compliance = Symbol::of_influence(&mut transform, (kernel[0], kernel[1]), at_cell);
        let stiffness = Symbol::of_stiffness(&transform, layer, cell_mm);
        Ok(Self { transform, compliance, stiffness })
    }
}

/// Which matrices a convolution multiplies by.
#[derive(Clone, Copy)]
enum Kernel {
    Compliance,
    Stiffness,
}

/// The influence of a cell at an offset in mm, mm/MPa, for offsets up to `reach_mm`.
pub(super) fn influence_of(layer: &Layer, cell_mm: f64, reach_mm: f64) -> impl Fn([f64; 2]) -> Influence {
    let Layer { thickness_mm, shear_modulus_mpa, poissons_ratio } = *layer;
    let base = thickness_mm.is_finite().then(|| Remainder::new(thickness_mm, poissons_ratio, cell_mm, reach_mm));
    move |offset| {
        let deep = influence(offset, cell_mm, poissons_ratio);
        let whole = match &base {
            None => deep,
            Some(base) => base.at(offset).map_or_else(Influence::default, |remainder| deep.plus(remainder)),
        };
        whole.times(1.0 / shear_modulus_mpa)
    }
}
