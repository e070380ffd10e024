//! The fitted values of a gel, and whether the presses determine them.

use serde::Serialize;

use super::modulus::Modulus;
use super::thresholds::THRESHOLDS;

/// One value of the gel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GelEstimate {
    /// Its key in the profile's `[gel]`.
    pub key: &'static str,
    /// The profile's value.
    pub before: Option<f64>,
    /// The fitted value; the profile's value where it is fixed, none where there is neither.
    pub value: Option<f64>,
    /// Its standard deviation, including the error of the linear model; none where it is fixed.
    pub deviation: Option<f64>,
    /// The part of it from the scatter between presses, or around contact where they are few.
    pub scatter: Option<f64>,
    /// Whether the presses determine it: only then is it written.
    pub is_determined: bool,
    /// A remark.
    pub remark: String,
}

/// Why the surface may not determine the gel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Why {
    /// Whether it does not determine the gel even if the deviations are small.
    is_certain: bool,
    text: &'static str,
}

impl Why {
    pub(super) fn new(is_wide: bool, is_alike: bool) -> Self {
        let text = if is_wide {
            "every contact is wider than the gel is thick, and the gel beside it hardly moves: use a smaller indenter"
        } else if is_alike {
            "Poisson's ratio and thickness move the surface in the same way here: press farther from the middle, or fix one that you measured"
        } else {
            "the presses contradict each other or contain too little information: check their depths, or press at other places and with other shapes"
        };
        Self { is_certain: is_wide || is_alike, text }
    }

    /// The same for Young's modulus, whose deviation includes that of the surface.
    pub(super) fn of_forces(self) -> Self {
        Self { is_certain: false, ..self }
    }
}

pub(super) fn estimate(
    key: &'static str,
    before: Option<f64>,
    value: Option<f64>,
    deviation: Option<(f64, f64)>,
    limit: f64,
    why: Why,
) -> GelEstimate {
    let is_determined = deviation.is_some_and(|(all, _)| all <= limit) && !why.is_certain;
    let remark = match deviation {
        None => "fixed at the profile's value".into(),
        Some(_) if is_determined => "determined".into(),
        Some(_) => format!("not determined: {}", why.text),
    };
    let (deviation, scatter) = (deviation.map(|(all, _)| all), deviation.map(|(_, scatter)| scatter));
    GelEstimate { key, before, value, deviation, scatter, is_determined, remark }
}

/// Young's modulus; `is_asked` is whether it was requested, `has_forces` whether it could be fitted.
pub(super) fn modulus_estimate(
    before: Option<f64>,
    stiff: Option<Modulus>,
    (is_asked, has_forces): (bool, bool),
    model: f64,
    why: Why,
) -> GelEstimate {
    let key = "youngs_modulus_mpa";
    let unknown = |remark: &str| GelEstimate { remark: remark.into(), ..estimate(key, before, before, None, 0.0, why) };
    match stiff {
        Some(stiff) if stiff.youngs_modulus_mpa > 0.0 => {
            let value = stiff.youngs_modulus_mpa;
            let deviations = (value * stiff.deviation.hypot(model), value * stiff.deviation);
            estimate(key, before, Some(value), Some(deviations), value * THRESHOLDS.determined[2], why)
        }
        Some(_) => unknown("not determined: the forces are negative; a press is a positive force. Not changed"),
        None if is_asked => unknown("not determined: the forces are all zero; not changed"),
        None if has_forces => unknown("fixed at the profile's value"),
        None => unknown("not determined: there are no forces; not changed"),
    }
}
