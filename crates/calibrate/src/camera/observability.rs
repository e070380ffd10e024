//! The unknowns of a camera that a slide determines, and those that it does not.

use nalgebra::{SMatrix, SVector};
use serde::Serialize;

use super::prior::Priors;
use super::unknowns::{UNKNOWNS, Unknown, Unknowns, UnknownsMatrix};

/// All unknowns except the origin along the board, which no slide shows.
const SHOWN: usize = UNKNOWNS - 2;
/// Their indices among all unknowns.
const PLACES: [usize; SHOWN] = [0, 1, 2, 5, 6, 7, 8, 9, 10, 11, 12];
/// Unknowns with less than this part of a direction are not named.
const NAMED_PART: f64 = 0.2;

/// The result for one unknown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name, with its unit.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its standard uncertainty, priors included; absent where the value is a definition.
    pub uncertainty: Option<f64>,
    /// The part of the prior's variance that the slides removed, 0 to 1: near 0 the value is that of the prior.
    pub determined: Option<f64>,
}

/// A combination of unknowns that the slides do not determine: all change together and the flow does not change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlindDirection {
    /// Uncertainty from the slides alone, in typical sizes of the unknowns; absent if it is infinite.
    pub open: Option<f64>,
    /// The unknowns and how they change together, by name.
    pub change: Vec<(&'static str, f64)>,
    /// Its meaning.
    pub meaning: &'static str,
    /// A measurement that would determine it.
    pub remedy: &'static str,
}

/// The result of the fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Knowledge {
    /// Every unknown.
    pub estimates: Vec<Estimate>,
    /// The combinations that the slides alone do not determine, the least determined first.
    pub blind: Vec<BlindDirection>,
}

/// Sizes by which a camera typically differs from another of its kind: the scale for what counts as not determined.
fn typical_sizes(unknowns: &Unknowns, priors: &Priors) -> Unknowns {
    let part = 0.1;
    let (distance, focal) = (part * unknowns[5], part * unknowns[10]);
    let [x, y] = [Unknown::PrincipalX, Unknown::PrincipalY].map(|axis| {
        let prior = priors.of(axis).deviation;
        if prior.is_finite() { prior } else { focal }
    });
    Unknowns::from([[0.1, 0.1, 0.1, 5.0, 5.0, distance, 0.1, 0.1, 0.01, 0.01, focal, x, y]])
}

/// Evaluates the fit at its end by the information of the flows, `JᵀJ` in standard deviations.
///
/// With S the typical sizes, the eigenvalues λ of `S JᵀJ S` show how well the flows alone determine a combination: to
/// 1/√λ typical sizes. Above 1 it is not determined. The uncertainties are those of `(JᵀJ + priors)⁻¹`.
pub(super) fn knowledge(unknowns: &Unknowns, information: &UnknownsMatrix, priors: &Priors) -> Knowledge {
    let sizes = typical_sizes(unknowns, priors);
    let scaled = SMatrix::<f64, SHOWN, SHOWN>::from_fn(|row, column| {
        let (row, column) = (PLACES[row], PLACES[column]);
        information[(row, column)] * sizes[row] * sizes[column]
    });
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let mut order: Vec<usize> = (0..SHOWN).filter(|&index| eigen.eigenvalues[index] < 1.0).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let blind = order.into_iter().map(|index| {
        let vector: SVector<f64, SHOWN> = eigen.eigenvectors.column(index).into();
        // Below this the eigenvalue is rounding.
        let value = eigen.eigenvalues[index];
        let open = (value > 1e-13 * largest).then(|| value.sqrt().recip());
        blind_direction(open, &vector, &sizes)
    });
    Knowledge { estimates: estimates(unknowns, information, priors), blind: blind.collect() }
}

fn estimates(unknowns: &Unknowns, information: &UnknownsMatrix, priors: &Priors) -> Vec<Estimate> {
    let weights = priors.weights();
    let mut precision = SMatrix::<f64, SHOWN, SHOWN>::from_fn(|row, column| information[(PLACES[row], PLACES[column])]);
    for (place, index) in PLACES.into_iter().enumerate() {
        precision[(place, place)] += weights[index].powi(2);
    }
    // Columns differ by many orders of magnitude: the matrix is scaled to ones along its diagonal before it is
    // inverted.
    let scale = precision.diagonal().map(|value| value.sqrt().recip());
    let scaled =
        SMatrix::<f64, SHOWN, SHOWN>::from_fn(|row, column| precision[(row, column)] * scale[row] * scale[column]);
    let inverse = scaled.try_inverse();
    let estimate = |(index, unknown): (usize, Unknown)| {
        let place = PLACES.iter().position(|&shown| shown == index);
        let uncertainty = place.and_then(|place| Some(inverse?[(place, place)].max(0.0).sqrt() * scale[place]));
        let determined = uncertainty.map(|uncertainty| (1.0 - (uncertainty * weights[index]).powi(2)).max(0.0));
        Estimate { name: unknown.name(), value: unknowns[index], uncertainty, determined }
    };
    Unknown::ALL.into_iter().enumerate().map(estimate).collect()
}

fn blind_direction(open: Option<f64>, vector: &SVector<f64, SHOWN>, sizes: &Unknowns) -> BlindDirection {
    let part = |unknowns: &[Unknown]| {
        let places = unknowns.iter().filter_map(|unknown| PLACES.iter().position(|&shown| shown == unknown.index()));
        places.map(|place| vector[place].powi(2)).sum::<f64>()
    };
    let scale = [Unknown::Distance, Unknown::FocalLength];
    let centre = [Unknown::PrincipalX, Unknown::PrincipalY, Unknown::P1, Unknown::P2];
    let radial = [Unknown::K1, Unknown::K2];
    let (meaning, remedy) = if part(&scale) > 0.5 {
        (
            "focal length against distance: a longer lens and a board farther away and more tilted give the same flow; only their ratio is determined",
            "measure one of them and give it, as in --prior distance_mm=25±0.5; a second slide perpendicular to the first helps only if the board is tilted by 15° or more",
        )
    } else if part(&centre) > 0.4 {
        (
            "principal point against tangential distortion and tilt: a shifted lens distorts the flow like a rotated one",
            "give the principal point, as in --prior principal_x_px=240±3, or add a second slide perpendicular to the first",
        )
    } else if part(&radial) > 0.4 {
        (
            "the two radial coefficients against each other: the image does not extend far enough from the axis",
            "extend the region of interest into the corners, or give k2, as in --prior k2=0±0.02",
        )
    } else {
        (
            "a combination of pose and lens that does not change the flow",
            "add a second slide perpendicular to the first, tilt the board, or give a prior for one of these unknowns",
        )
    };
    // The named change with the largest part is positive.
    let sign = vector[vector.icamax()].signum();
    let mut named: Vec<usize> = (0..SHOWN).filter(|&place| vector[place].abs() > NAMED_PART).collect();
    named.sort_by(|&a, &b| vector[b].abs().total_cmp(&vector[a].abs()));
    let change = named.into_iter().map(|place| {
        let index = PLACES[place];
        (Unknown::ALL[index].name(), sign * vector[place] * sizes[index])
    });
    BlindDirection { open, change: change.collect(), meaning, remedy }
}
