//! The difference between the influence of a layer with a bonded base and that of a half-space.
//!
//! The difference of the reduced compliances falls with `e^{−2q}`, so its transform back into space is smooth: with
//! `ρ = r / thickness` and φ the angle of the offset, a point force displaces by `1 / 2πμ·thickness` times
//!
//! ```text
//! zz: ∫ ΔN J0(qρ) dq        xz: −cos φ ∫ ΔC J1(qρ) dq
//! xx, yy: ∫ ½ (ΔL + ΔS) J0(qρ) dq ∓ cos 2φ ∫ ½ (ΔL − ΔS) J2(qρ) dq        xy: −sin 2φ ∫ ½ (ΔL − ΔS) J2(qρ) dq
//! ```
//!
//! The four integrals are tabulated over ρ. A uniform cell instead of a point multiplies by `e^{−(k·side)²/24}`, to the
//! fourth order in `side / thickness`.

use super::compliance::Reduced;
use super::half_space::Influence;

/// Differences are below 1e-15 beyond.
const LAST_Q: f64 = 20.0;
/// Distance in thicknesses beyond which a bonded layer is assumed not to move: influence falls with `e^{−0.8 ρ}` or
/// faster and is below 1e-7 of that at one thickness.
pub(super) const REACH: f64 = 24.0;
/// Spacing of the table: cubic interpolation is then exact to 1e-8.
const STEP: f64 = 0.02;
/// Gauss–Legendre points and weights on (−1, 1), the positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// The four integrals: of N, of ½(L + S), of ½(L − S) and of C.
type Integrals = [f64; 4];

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Remainder {
    thickness_mm: f64,
    area_mm2: f64,
    table: Vec<Integrals>,
}

impl Remainder {
    /// For offsets up to `reach_mm`.
    pub(super) fn new(thickness_mm: f64, nu: f64, cell_mm: f64, reach_mm: f64) -> Self {
        let last = (reach_mm / thickness_mm).min(REACH);
        let side = cell_mm / thickness_mm;
        // A panel for each half period of the fastest Bessel function.
        let panels = (LAST_Q * (last + 2.0) / std::f64::consts::PI).ceil() as usize;
        let points = quadrature(panels, nu, side);
        // From one step below zero to two above the last.
        let entries = (last / STEP).ceil() as usize + 4;
        let table = (0..entries).map(|index| integrals(&points, (index as f64 - 1.0) * STEP)).collect();
        Self { thickness_mm, area_mm2: cell_mm * cell_mm, table }
    }

    /// The term added to the influence of a half-space's cell, times μ, mm; none out of the base's reach, where nothing
    /// moves.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> Option<Influence> {
        let r = x.hypot(y);
        let rho = r / self.thickness_mm;
        if rho >= REACH {
            return None;
        }
        let (cos, sin) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
        let [normal, mean, spread, coupling] = self.interpolate(rho);
        let (cos_twice, sin_twice) = (cos * cos - sin * sin, 2.0 * cos * sin);
        let scale = self.area_mm2 / (std::f64::consts::TAU * self.thickness_mm);
        Some(Influence {
            xx: scale * (mean - cos_twice * spread),
            xy: -scale * sin_twice * spread,
            yy: scale * (mean + cos_twice * spread),
            xz: -scale * cos * coupling,
            yz: -scale * sin * coupling,
            zz: scale * normal,
        })
    }

    /// Cubic through the four nearest entries.
    fn interpolate(&self, rho: f64) -> Integrals {
        let place = rho / STEP;
        let index = (place as usize).min(self.table.len() - 4);
        let t = place - index as f64;
        let weights = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        let nearest = &self.table[index..index + 4];
        std::array::from_fn(|i| nearest.iter().zip(weights).map(|(entry, weight)| weight * entry[i]).sum())
    }
}

/// Points q and the differences there, times their weights.
fn quadrature(panels: usize, nu: f64, side: f64) -> Vec<(f64, Integrals)> {
    let half = 0.5 * LAST_Q / panels as f64;
    let deep = Reduced::half_space(nu);
    let nodes = GAUSS.into_iter().flat_map(|(x, weight)| [(x, weight), (-x, weight)]);
    (0..panels)
        .flat_map(|panel| nodes.clone().map(move |(x, weight)| (half * (2.0 * panel as f64 + 1.0 + x), half * weight)))
        .map(|(q, weight)| {
            let weight = weight * (-(q * side).powi(2) / 24.0).exp();
            let near = Reduced::at(q, nu);
            let (longitudinal, transverse) = (near.longitudinal - deep.longitudinal, near.transverse - deep.transverse);
            let differences = [
                near.normal - deep.normal,
                0.5 * (longitudinal + transverse),
                0.5 * (longitudinal - transverse),
                near.coupling - deep.coupling,
            ];
            (q, differences.map(|difference| weight * difference))
        })
        .collect()
}

fn integrals(points: &[(f64, Integrals)], rho: f64) -> Integrals {
    points.iter().fold([0.0; 4], |sum, &(q, [normal, mean, spread, coupling])| {
        let x = q * rho;
        let (zeroth, first) = (libm::j0(x), libm::j1(x));
        // The recurrence cancels for small arguments, where the series is short.
        let second = if x.abs() < 0.1 { x * x / 8.0 * (1.0 - x * x / 12.0) } else { 2.0 * first / x - zeroth };
        [sum[0] + normal * zeroth, sum[1] + mean * zeroth, sum[2] + spread * second, sum[3] + coupling * first]
    })
}
