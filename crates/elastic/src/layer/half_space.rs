//! The displacement of a half-space's surface by uniform traction on a square cell.
//!
//! Point forces (Boussinesq, Cerruti; Johnson, *Contact mechanics*, §3.2 and §3.6) integrated over the cell: with μ the
//! shear modulus and r the distance, force along β displaces along α by
//!
//! ```text
//! z by z: (1 − ν) / 2πμr      x by x: ((1 − ν) / r + ν x² / r³) / 2πμ      x by y: ν x y / 2πμr³
//! x by z: −(1 − 2ν) x / 4πμr²      z by x: (1 − 2ν) x / 4πμr²
//! ```
//!
//! The integral of each over a rectangle is the second difference of a primitive over its corners (A. E. H. Love, *The
//! stress produced in a semi-infinite solid by pressure on part of the boundary*, 1929, for pressure).

/// Displacement along the first axis at an offset `(x, y)` from a cell with unit traction along the second. The other
/// components follow from symmetry: `yx = xy`, `zx = −xz`, `zy = −yz`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Influence {
    pub(super) xx: f64,
    pub(super) xy: f64,
    pub(super) yy: f64,
    pub(super) xz: f64,
    pub(super) yz: f64,
    pub(super) zz: f64,
}

impl Influence {
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
            xz: self.xz + other.xz,
            yz: self.yz + other.yz,
            zz: self.zz + other.zz,
        }
    }

    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            xx: self.xx * factor,
            xy: self.xy * factor,
            yy: self.yy * factor,
            xz: self.xz * factor,
            yz: self.yz * factor,
            zz: self.zz * factor,
        }
    }
}

/// The influence of a cell of side `cell_mm`, times μ, mm. The offset must not lie on the prolongation of a cell's side.
pub(super) fn influence([x, y]: [f64; 2], cell_mm: f64, nu: f64) -> Influence {
    let half = 0.5 * cell_mm;
    let over_cell = |primitive: fn(f64, f64) -> f64| {
        let along = |x: f64| primitive(x, y + half) - primitive(x, y - half);
        along(x + half) - along(x - half)
    };
    // ∬ y²/r³ and ∬ x²/r³, whose sum is ∬ 1/r.
    let squares = [over_cell(|x, y| x * (y / x.abs()).asinh()), over_cell(|x, y| y * (x / y.abs()).asinh())];
    let inverse = squares[0] + squares[1];
    let product = over_cell(|x, y| -x.hypot(y));
    let radial_x = over_cell(|x, y| y * x.hypot(y).ln() + x * (y / x).atan());
    let radial_y = over_cell(|x, y| x * x.hypot(y).ln() + y * (x / y).atan());
    let circle = std::f64::consts::TAU;
    let coupling = -0.5 * (1.0 - 2.0 * nu) / circle;
    Influence {
        xx: ((1.0 - nu) * inverse + nu * squares[1]) / circle,
        xy: nu * product / circle,
        yy: ((1.0 - nu) * inverse + nu * squares[0]) / circle,
        xz: coupling * radial_x,
        yz: coupling * radial_y,
        zz: (1.0 - nu) * inverse / circle,
    }
}
