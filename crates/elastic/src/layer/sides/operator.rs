//! The compliance of a block on a grid.

use std::sync::Arc;

use fearless_simd::{Level, dispatch};
use fingervision_fourier::Complex32;

use super::correction::{Correction, Scratch};
use super::lattice::Lattice;
use crate::GelBlock;
use crate::layer::operator::Symbols;
use crate::layer::symbol::Symbol;
use crate::layer::transform::Transform;
use crate::layer::{Layer, LayerError, SurfaceGrid};

/// From tractions on the cells of a block's surface to the displacements of their centres, including the free sides.
///
/// The sum of an infinite layer, as in [`crate::LayerOperator`], and the effect of the sides, by finite elements on a
/// coarse mesh. Tractions are **in units of the shear modulus**, so that a gel of unknown stiffness has an operator, too.
/// The grid is centred on the surface and should cover exactly that: beyond a side the correction is continued as a
/// constant and has no meaning.
///
/// Small strain. The coarse cell next to a side (an eighth of the thickness wide, or a 24th of the block's longer side
/// if that is more) is not resolved. Single precision inside. Made once per block and grid. Operators of one block share most of their
/// memory; no call allocates.
#[derive(Debug)]
pub struct BlockOperator {
    layer: Layer,
    grid: SurfaceGrid,
    correction: Arc<Correction>,
    lattice: Lattice,
    transform: Transform<f32>,
    compliance: Matrices,
    stiffness: Matrices,
    spectra: [Vec<Complex32>; 3],
    forces: Vec<f32>,
    moved: Vec<f32>,
    scratch: Scratch,
    simd: Level,
}

impl BlockOperator {
    /// The operator of a block on a grid. Young's modulus is not read.
    ///
    /// # Errors
    ///
    /// [`LayerError`] if the block or the grid is impossible or the cells are wider than half the thickness.
    pub fn new(block: &GelBlock, grid: SurfaceGrid) -> Result<Self, LayerError> {
        let layer = Layer::of_unit_modulus(block)?;
        // An impossible grid is reported before the work.
        grid.validate()?;
        Self::assemble(layer, grid, Correction::shared(block, &layer))
    }

    /// The operator of the same block on another grid, in a fraction of the time.
    ///
    /// # Errors
    ///
    /// [`LayerError`] if the grid is impossible or its cells are wider than half the thickness.
    pub fn on_grid(&self, grid: SurfaceGrid) -> Result<Self, LayerError> {
        Self::assemble(self.layer, grid, Arc::clone(&self.correction))
    }

    fn assemble(layer: Layer, grid: SurfaceGrid, correction: Arc<Correction>) -> Result<Self, LayerError> {
        let near = correction.near;
        let symbols = Symbols::new(&layer, grid, near.reach_mm, |offset| near.share(offset))?;
        let transform = Transform::new(symbols.transform.width(), symbols.transform.height());
        let nodal = || vec![0.0; 3 * correction.nodes[0] * correction.nodes[1]];
        Ok(Self {
            layer,
            grid,
            lattice: Lattice::new(grid, &correction),
            compliance: Matrices::new(&symbols.compliance),
            stiffness: Matrices::new(&symbols.stiffness),
            spectra: [(); 3].map(|()| transform.spectrum()),
            transform,
            forces: nodal(),
            moved: nodal(),
            scratch: correction.scratch(),
            correction,
            simd: Level::new(),
        })
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> SurfaceGrid {
        self.grid
    }

    /// Displacement `(x, y, z)`, mm, of each cell's centre under traction `(x, y, z)`, in units of the shear modulus,
    /// row by row. The operator is symmetric.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn displacement_into(&mut self, traction: &[[f32; 3]], displacement_mm: &mut [[f32; 3]]) {
        self.convolve(Kernel::Compliance, traction, displacement_mm);
        self.lattice.forces_into(traction, &mut self.forces);
        self.correction.displacement_into(&self.forces, &mut self.moved, &mut self.scratch);
        self.lattice.add_displacement(&self.moved, displacement_mm);
    }

    /// The traction, in units of the shear modulus, that an infinite layer would need for a displacement, cut off at the
    /// grid's border: an approximate inverse, symmetric and positive definite, for conjugate gradients.
    ///
    /// # Panics
    ///
    /// If a field does not have one entry per cell.
    pub fn precondition_into(&mut self, displacement_mm: &[[f32; 3]], traction: &mut [[f32; 3]]) {
        self.convolve(Kernel::Stiffness, displacement_mm, traction);
    }

    fn convolve(&mut self, kernel: Kernel, from: &[[f32; 3]], to: &mut [[f32; 3]]) {
        let SurfaceGrid { columns, rows, .. } = self.grid;
        assert!(from.len() == self.grid.len() && to.len() == self.grid.len(), "one entry a cell");
        for (axis, spectrum) in self.spectra.iter_mut().enumerate() {
            let value = |column: usize, row: usize| from[row * columns + column][axis];
            self.transform.forward_into((columns, rows), value, spectrum);
        }
        let matrices = match kernel {
            Kernel::Compliance => &self.compliance,
            Kernel::Stiffness => &self.stiffness,
        };
        dispatch!(self.simd, _ => matrices.multiply(&mut self.spectra));
        for (axis, spectrum) in self.spectra.iter_mut().enumerate() {
            self.transform.inverse_into(rows, spectrum, |row, values| {
                for (target, value) in to[row * columns..][..columns].iter_mut().zip(values) {
                    target[axis] = *value;
                }
            });
        }
    }
}

/// Which matrices a convolution multiplies by.
#[derive(Clone, Copy)]
enum Kernel {
    Compliance,
    Stiffness,
}

/// A [`Symbol`] in single precision: xx, xy, yy, xz, yz, zz.
#[derive(Debug)]
struct Matrices(Vec<[f32; 6]>);

impl Matrices {
    fn new(symbol: &Symbol) -> Self {
        let single = symbol.entries().iter().map(|m| [m.xx, m.xy, m.yy, m.xz, m.yz, m.zz].map(|value| value as f32));
        Self(single.collect())
    }

    #[inline(always)]
    fn multiply(&self, [x, y, z]: &mut [Vec<Complex32>; 3]) {
        for (&[xx, xy, yy, xz, yz, zz], ((x, y), z)) in self.0.iter().zip(x.iter_mut().zip(y).zip(z)) {
            let (a, b, c) = (*x, *y, *z);
            *x = Complex32::new(a.re * xx + b.re * xy - c.im * xz, a.im * xx + b.im * xy + c.re * xz);
            *y = Complex32::new(a.re * xy + b.re * yy - c.im * yz, a.im * xy + b.im * yy + c.re * yz);
            *z = Complex32::new(c.re * zz + a.im * xz + b.im * yz, c.im * zz - a.re * xz - b.re * yz);
        }
    }
}
