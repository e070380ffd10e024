//! The compliance at one wavenumber.

use crate::{BlockError, GelBlock};
use fingervision_fourier::Complex64;
use thiserror::Error;

/// An elastic layer without end along x and y, bonded at its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Infinite for a half-space.
    pub(super) thickness_mm: f64,
    pub(super) shear_modulus_mpa: f64,
    pub(super) poissons_ratio: f64,
}

/// An impossible layer or grid.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LayerError {
    /// A value of the block is impossible.
    #[error(transparent)]
    Block(#[from] BlockError),
    /// The block has no Young's modulus.
    #[error("youngs_modulus_mpa is missing: without it there is no force")]
    NoModulus,
    /// A grid without cells or with cells of size zero.
    #[error("a grid of {columns}x{rows} cells of {cell_mm} mm: one cell or more of a finite size above 0 mm is needed")]
    Grid {
        /// Cells along x.
        columns: usize,
        /// Cells along y.
        rows: usize,
        /// Side of a cell, mm.
        cell_mm: f64,
    },
    /// Cells that are too coarse for the layer.
    #[error("cells of {cell_mm} mm are too coarse for a layer of {thickness_mm} mm: half of that is the most")]
    Coarse {
        /// Side of a cell, mm.
        cell_mm: f64,
        /// Thickness of the layer, mm.
        thickness_mm: f64,
    },
}

/// Displacement of the surface by a wave of traction, mm/`MPa`; see the equations of the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveCompliance {
    /// L: displacement along the wave by traction along it.
    pub longitudinal: f64,
    /// S: displacement across the wave by traction across it.
    pub transverse: f64,
    /// N: displacement in depth by pressure.
    pub normal: f64,
    /// C: displacement along the wave by pressure, towards the pressed places; and in depth by traction along the wave.
    pub coupling: f64,
}

impl Layer {
    /// The layer with a block's material and thickness, as if the sides were far away.
    ///
    /// # Errors
    ///
    /// [`LayerError`] if a value of the block is impossible or its Young's modulus is missing.
    pub fn new(block: &GelBlock) -> Result<Self, LayerError> {
        block.validate()?;
        let modulus = block.youngs_modulus_mpa.ok_or(LayerError::NoModulus)?;
        let shear_modulus_mpa = modulus / (2.0 * (1.0 + block.poissons_ratio));
        Ok(Self { thickness_mm: block.thickness_mm, shear_modulus_mpa, poissons_ratio: block.poissons_ratio })
    }

    /// The layer of a block, with a shear modulus of 1 `MPa`: tractions are then in units of the shear modulus.
    ///
    /// # Errors
    ///
    /// [`LayerError::Block`] if a value of the block is impossible.
    pub(super) fn of_unit_modulus(block: &GelBlock) -> Result<Self, LayerError> {
        block.validate()?;
        let GelBlock { thickness_mm, poissons_ratio, .. } = *block;
        Ok(Self { thickness_mm, shear_modulus_mpa: 1.0, poissons_ratio })
    }

    /// The half-space of a block's material: a layer whose base is infinitely far below.
    ///
    /// # Errors
    ///
    /// As [`Layer::new`].
    pub fn half_space(block: &GelBlock) -> Result<Self, LayerError> {
        Ok(Self { thickness_mm: f64::INFINITY, ..Self::new(block)? })
    }

    /// Distance from the surface to the base, mm; infinite for a half-space.
    #[must_use]
    pub fn thickness_mm(&self) -> f64 {
        self.thickness_mm
    }

    /// Shear modulus μ, `MPa`.
    #[must_use]
    pub fn shear_modulus_mpa(&self) -> f64 {
        self.shear_modulus_mpa
    }

    /// Poisson's ratio ν, dimensionless.
    #[must_use]
    pub fn poissons_ratio(&self) -> f64 {
        self.poissons_ratio
    }

    /// The compliance for waves of this wavenumber, 1/mm, not negative. For a half-space it is infinite at zero: the
    /// displacement by uniform traction has no limit.
    #[must_use]
    pub fn wave_compliance(&self, wavenumber_per_mm: f64) -> WaveCompliance {
        let q = wavenumber_per_mm * self.thickness_mm;
        let (reduced, scale) = if q > 0.0 {
            (Reduced::at(q, self.poissons_ratio), 1.0 / (self.shear_modulus_mpa * wavenumber_per_mm))
        } else {
            // Uniform traction: shear by h / μ, compression by h / (λ + 2μ). The product of 0 and ∞ is not a number.
            (Reduced::slope(self.poissons_ratio), self.thickness_mm / self.shear_modulus_mpa)
        };
        WaveCompliance {
            longitudinal: scale * reduced.longitudinal,
            transverse: scale * reduced.transverse,
            normal: scale * reduced.normal,
            coupling: if q > 0.0 { scale * reduced.coupling } else { 0.0 },
        }
    }

    /// The matrix `U(k)` from traction `(x, y, z)` to displacement `(x, y, z)` for waves `e^{i (kx x + ky y)}`, mm/MPa:
    /// Hermitian and positive definite.
    #[must_use]
    pub fn compliance(&self, wavenumber_per_mm: [f64; 2]) -> [[Complex64; 3]; 3] {
        let [kx, ky] = wavenumber_per_mm;
        let k = kx.hypot(ky);
        let WaveCompliance { longitudinal, transverse, normal, coupling } = self.wave_compliance(k);
        let (x, y) = if k > 0.0 { (kx / k, ky / k) } else { (1.0, 0.0) };
        let real = |value: f64| Complex64::new(value, 0.0);
        let imaginary = |value: f64| Complex64::new(0.0, value);
        let xy = if k > 0.0 { x * y * (longitudinal - transverse) } else { 0.0 };
        [
            [real(x * x * longitudinal + y * y * transverse), real(xy), imaginary(x * coupling)],
            [real(xy), real(y * y * longitudinal + x * x * transverse), imaginary(y * coupling)],
            [imaginary(-x * coupling), imaginary(-y * coupling), real(normal)],
        ]
    }
}

/// Compliances times μk: functions of `q = k · thickness` and ν alone, dimensionless.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reduced {
    pub(super) longitudinal: f64,
    pub(super) transverse: f64,
    pub(super) normal: f64,
    pub(super) coupling: f64,
}

/// Beyond this q the effect of the base is less than 1e-250.
const DEEP: f64 = 300.0;

impl Reduced {
    /// Above zero; to rounding for every q and ν: numerator and denominator are multiplied by `e^{−2q}` and where terms
    /// of `2κ sinh 2q − 4q` cancel they are summed as a series.
    pub(super) fn at(q: f64, nu: f64) -> Self {
        if q > DEEP {
            return Self::half_space(nu);
        }
        let kappa = 3.0 - 4.0 * nu;
        let fade = (-2.0 * q).exp();
        let rise = -(-4.0 * q).exp_m1();
        let denominator = kappa * (1.0 + fade * fade) + (kappa * kappa + 1.0 + 4.0 * q * q) * fade;
        let incompressible = if q < 0.5 { 2.0 * fade * sinh_minus(2.0 * q) } else { rise - 4.0 * q * fade };
        let half = -(-2.0 * q).exp_m1();
        Self {
            longitudinal: (1.0 - nu) * (kappa * rise + 4.0 * q * fade) / denominator,
            transverse: q.tanh(),
            normal: (1.0 - nu) * (2.0 * (1.0 - 2.0 * nu) * rise + incompressible) / denominator,
            coupling: (0.5 * (1.0 - 2.0 * nu) * kappa * half * half - 2.0 * q * q * fade) / denominator,
        }
    }

    /// The limit of short waves.
    pub(super) fn half_space(nu: f64) -> Self {
        Self { longitudinal: 1.0 - nu, transverse: 1.0, normal: 1.0 - nu, coupling: 0.5 * (1.0 - 2.0 * nu) }
    }

    /// The derivative by q at zero.
    fn slope(nu: f64) -> Self {
        let normal = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu));
        Self { longitudinal: 1.0, transverse: 1.0, normal, coupling: 0.0 }
    }
}

/// `sinh x − x` for x up to 1, by its series.
fn sinh_minus(x: f64) -> f64 {
    let squared = x * x;
    let tail = [156.0, 110.0, 72.0, 42.0, 20.0].into_iter().fold(1.0, |sum, divisor| 1.0 + squared / divisor * sum);
    x * squared / 6.0 * tail
}
