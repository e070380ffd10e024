//! Gauss–Newton over Poisson's ratio and thickness.
//!
//! With p = (ν, ln thickness), the residual of a cell is `(b − U − a d) / σ`: the measurement of the camera minus the
//! prediction of elasticity for the gel in contact, over the expected error of both. Derivatives are finite differences
//! about a gel near by, computed again where the fit moves away from it. A step that does not lower the cost is halved.

use fingervision_elastic::GelBlock;
use fingervision_image::Image;

use super::forward::{Explained, Models};
use super::look::{Look, SECTORS};
use super::thresholds::THRESHOLDS;
use super::{GelFitError, Unknowns};

/// Steps of the derivatives, of ν and of ln thickness: large compared with the solver's tolerance, small compared with
/// the curvature.
const DIFFERENCE: [f64; 2] = [0.01, 0.02];
/// Steps below which the fit has converged.
const SETTLED: [f64; 2] = [5e-4, 1e-3];
/// Range in which the derivatives are reused.
const NEAR: [f64; 2] = [0.03, 0.08];
/// The largest steps.
const LARGEST: [f64; 2] = [0.08, 0.2];
const MOST_STEPS: usize = 20;
const MOST_HALVINGS: usize = 4;

/// The result of a fit.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    pub(super) gel: GelBlock,
    /// The gel's prediction for every frame.
    pub(super) explained: Vec<Explained>,
    /// Covariance of (ν, ln thickness) from the scatter of the residuals; zero for fixed values.
    pub(super) covariance: [[f64; 2]; 2],
    /// Correlation of both from the curvature of the cost at its minimum; none where one is fixed.
    pub(super) correlation: Option<f64>,
    /// Change of the force over the modulus with either, for each frame, mm².
    pub(super) force_slopes: Vec<[f64; 2]>,
}

/// The derivatives of all residuals about a gel.
struct Slopes {
    about: GelBlock,
    /// For each frame, cell and axis: by ν and by ln thickness, with the sign of the prediction.
    rows: Vec<Vec<[[f64; 2]; 2]>>,
    force: Vec<[f64; 2]>,
    matrix: [[f64; 2]; 2],
}

/// The state of a fit.
pub(super) struct Fit<'a> {
    looks: &'a [Look],
    models: &'a mut Models,
    free: [bool; 2],
    thicknesses_mm: [f64; 2],
}

/// Root mean square of the unexplained motion of a frame, as a part of the depth.
pub(super) fn unexplained(look: &Look, explained: &Explained) -> f64 {
    let scale = look.weight_per_mm * look.depth_mm;
    (square_sum(look, explained) / (2 * look.around.len()) as f64).sqrt() / scale
}

/// The unexplained motion of a frame over the surface, as parts of the depth, in a square picture; not a number where it
/// is not compared.
pub(super) fn unexplained_map(look: &Look, explained: &Explained) -> Image<f32> {
    let (columns, rows) = (look.grid.columns, look.grid.rows);
    let side = columns.max(rows);
    let mut map = Image::filled(side, side, f32::NAN);
    let scale = look.weight_per_mm * look.depth_mm;
    for (&(cell, _), [x, y]) in look.around.iter().zip(residuals(look, explained)) {
        let (column, row) = (cell % columns + (side - columns) / 2, cell / columns + (side - rows) / 2);
        map.row_mut(row)[column] = (x.hypot(y) / scale) as f32;
    }
    map
}

/// The same over all frames, each with its weight.
pub(super) fn unexplained_by(looks: &[Look], explained: &[Explained]) -> f64 {
    let depth = |look: &Look| 2.0 * look.around.len() as f64 * (look.weight_per_mm * look.depth_mm).powi(2);
    (cost(looks, explained) / looks.iter().map(depth).sum::<f64>()).sqrt()
}

impl<'a> Fit<'a> {
    pub(super) fn new(looks: &'a [Look], models: &'a mut Models, start: &GelBlock, unknowns: Unknowns) -> Self {
        let free = [unknowns.poissons_ratio, unknowns.thickness];
        let thicknesses_mm = [start.thickness_mm / THRESHOLDS.most_factor, start.thickness_mm * THRESHOLDS.most_factor];
        Self { looks, models, free, thicknesses_mm }
    }

    /// Fits a gel to the frames, starting from the given one.
    ///
    /// # Errors
    ///
    /// [`GelFitError::Blind`] and [`GelFitError::Open`], and [`GelFitError::Gel`] for an impossible gel.
    pub(super) fn settle(&mut self, from: &GelBlock) -> Result<Settled, GelFitError> {
        let mut gel = self.bounded(from, [0.0; 2]);
        let mut explained = self.models.explain(&gel, self.looks)?;
        let mut slopes = self.slopes(&gel, &explained)?;
        for _ in 0..MOST_STEPS {
            if is_beyond(change(&slopes.about, &gel), NEAR) {
                slopes = self.slopes(&gel, &explained)?;
            }
            let wanted = self.step(&slopes, &explained)?;
            let next = self.descend(&gel, &explained, wanted)?;
            let moved = next.as_ref().map_or([0.0; 2], |(next, _)| change(&gel, next));
            if let Some(next) = next {
                (gel, explained) = next;
            }
            if is_beyond(moved, SETTLED) {
                continue;
            }
            if self.is_at_end(&gel) {
                break;
            }
            return Ok(Settled {
                covariance: self.covariance(&slopes, &explained),
                correlation: (self.free == [true; 2]).then(|| correlation(slopes.matrix)),
                gel,
                explained,
                force_slopes: slopes.force,
            });
        }
        Err(GelFitError::Open { steps: MOST_STEPS, poissons_ratio: gel.poissons_ratio, thickness_mm: gel.thickness_mm })
    }

    /// The gel after a step, limited to possible gels.
    fn bounded(&self, gel: &GelBlock, [ratio, thickness]: [f64; 2]) -> GelBlock {
        let [thin, thick] = self.thicknesses_mm;
        let mut next = *gel;
        if self.free[0] {
            next.poissons_ratio = (gel.poissons_ratio + ratio).clamp(THRESHOLDS.ratios[0], THRESHOLDS.ratios[1]);
        }
        if self.free[1] {
            next.thickness_mm = (gel.thickness_mm * thickness.exp()).clamp(thin, thick);
        }
        next
    }

    /// Whether the thickness has reached its limits.
    fn is_at_end(&self, gel: &GelBlock) -> bool {
        self.free[1] && self.thicknesses_mm.iter().any(|end| (gel.thickness_mm / end).ln().abs() < 1e-6)
    }

    fn slopes(&mut self, gel: &GelBlock, here: &[Explained]) -> Result<Slopes, GelFitError> {
        // Rounded down: ν stays below ½.
        let beside = [
            GelBlock { poissons_ratio: gel.poissons_ratio - DIFFERENCE[0], ..*gel },
            GelBlock { thickness_mm: gel.thickness_mm * (-DIFFERENCE[1]).exp(), ..*gel },
        ];
        let [ratio, thickness] = beside.map(|gel| self.models.explain(&gel, self.looks));
        let (ratio, thickness) = (ratio?, thickness?);
        let mut slopes = Slopes { about: *gel, rows: Vec::new(), force: Vec::new(), matrix: [[0.0; 2]; 2] };
        for (frame, look) in self.looks.iter().enumerate() {
            let (here, others) = (&here[frame], [&ratio[frame], &thickness[frame]]);
            let slope = |cell: usize, axis: usize, which: usize| {
                let difference = here.apparent_mm[cell][axis] - others[which].apparent_mm[cell][axis];
                difference * look.weight_per_mm / DIFFERENCE[which]
            };
            let row = |cell: usize| [0, 1].map(|axis| [0, 1].map(|which| slope(cell, axis, which)));
            let rows: Vec<_> = (0..look.around.len()).map(row).collect();
            for row in rows.iter().flatten() {
                for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    slopes.matrix[i][j] += row[i] * row[j];
                }
            }
            slopes.rows.push(rows);
            let force = |which: usize| here.force_per_modulus_mm2 - others[which].force_per_modulus_mm2;
            slopes.force.push([0, 1].map(|which| force(which) / DIFFERENCE[which]));
        }
        Ok(slopes)
    }

    /// The Gauss–Newton step.
    fn step(&self, slopes: &Slopes, explained: &[Explained]) -> Result<[f64; 2], GelFitError> {
        let inverse = inverse(slopes.matrix, self.free).ok_or(GelFitError::Blind { free: self.free })?;
        let mut right = [0.0; 2];
        for (look, (explained, rows)) in self.looks.iter().zip(explained.iter().zip(&slopes.rows)) {
            for (residual, row) in residuals(look, explained).zip(rows) {
                right = [0, 1].map(|i| right[i] + row[0][i] * residual[0] + row[1][i] * residual[1]);
            }
        }
        Ok(times(inverse, right))
    }

    /// The gel after a step, halved until the cost is lower; none if it never is.
    fn descend(
        &mut self,
        gel: &GelBlock,
        explained: &[Explained],
        wanted: [f64; 2],
    ) -> Result<Option<(GelBlock, Vec<Explained>)>, GelFitError> {
        let mut scale = wanted.iter().zip(LARGEST).map(|(step, most)| most / step.abs()).fold(1.0, f64::min);
        for _ in 0..=MOST_HALVINGS {
            let next = self.bounded(gel, wanted.map(|step| scale * step));
            let made = self.models.explain(&next, self.looks)?;
            if cost(self.looks, &made) <= cost(self.looks, explained) {
                return Ok(Some((next, made)));
            }
            if !is_beyond(change(gel, &next), SETTLED) {
                break;
            }
            scale *= 0.5;
        }
        Ok(None)
    }

    /// `H⁻¹ (Σ g gᵀ) H⁻¹`, the sum over clusters of correlated residuals: neighbouring cells have similar errors, and
    /// counting them as independent would give far too small a covariance.
    fn covariance(&self, slopes: &Slopes, explained: &[Explained]) -> [[f64; 2]; 2] {
        let Some(inverse) = inverse(slopes.matrix, self.free) else { return [[f64::INFINITY; 2]; 2] };
        let presses = self.looks.iter().map(|look| look.press + 1).max().unwrap_or(0);
        let sectors = if presses < THRESHOLDS.least_presses { SECTORS } else { 1 };
        let mut clusters = vec![[0.0; 2]; presses * sectors];
        for (look, (explained, rows)) in self.looks.iter().zip(explained.iter().zip(&slopes.rows)) {
            let cells = residuals(look, explained).zip(rows).zip(&look.around);
            for ((residual, row), (_, sector)) in cells {
                let cluster = &mut clusters[look.press * sectors + sector % sectors];
                *cluster = [0, 1].map(|i| cluster[i] + row[0][i] * residual[0] + row[1][i] * residual[1]);
            }
        }
        let count = clusters.iter().filter(|cluster| cluster.iter().any(|part| part.abs() > 0.0)).count() as f64;
        let correction = count / (count - 2.0).max(1.0);
        let mut covariance = [[0.0; 2]; 2];
        for cluster in clusters {
            let step = times(inverse, cluster);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                covariance[i][j] += correction * step[i] * step[j];
            }
        }
        covariance
    }
}

fn residuals(look: &Look, explained: &Explained) -> impl Iterator<Item = [f64; 2]> {
    let cells = look.around.iter().zip(&explained.apparent_mm);
    cells.map(|(&(cell, _), made)| {
        [0, 1].map(|axis| (f64::from(look.seen[cell].apparent_mm[axis]) - made[axis]) * look.weight_per_mm)
    })
}

fn square_sum(look: &Look, explained: &Explained) -> f64 {
    residuals(look, explained).map(|[x, y]| x * x + y * y).sum()
}

fn cost(looks: &[Look], explained: &[Explained]) -> f64 {
    looks.iter().zip(explained).map(|(look, made)| square_sum(look, made)).sum()
}

/// Difference of a gel from another, in ν and ln thickness.
pub(super) fn change(from: &GelBlock, to: &GelBlock) -> [f64; 2] {
    [to.poissons_ratio - from.poissons_ratio, (to.thickness_mm / from.thickness_mm).ln()]
}

/// Whether either part of a change exceeds its limit.
pub(super) fn is_beyond(change: [f64; 2], limits: [f64; 2]) -> bool {
    change.iter().zip(limits).any(|(change, limit)| change.abs() >= limit)
}

fn times(matrix: [[f64; 2]; 2], vector: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i: usize| matrix[i][0] * vector[0] + matrix[i][1] * vector[1])
}

/// The inverse of the normal matrix over the fitted values, zero elsewhere; none where it is singular.
fn inverse([[a, b], [_, c]]: [[f64; 2]; 2], free: [bool; 2]) -> Option<[[f64; 2]; 2]> {
    match free {
        [true, true] => {
            let determinant = a * c - b * b;
            let inverse = [[c / determinant, -b / determinant], [-b / determinant, a / determinant]];
            (determinant > 1e-6 * a * c).then_some(inverse)
        }
        [true, false] => (a > 0.0).then(|| [[1.0 / a, 0.0], [0.0; 2]]),
        [false, true] => (c > 0.0).then(|| [[0.0; 2], [0.0, 1.0 / c]]),
        [false, false] => Some([[0.0; 2]; 2]),
    }
}

fn correlation([[a, b], [_, c]]: [[f64; 2]; 2]) -> f64 {
    -b / (a * c).sqrt()
}
