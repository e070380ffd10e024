//! The results of a gel fit for each press.

use serde::Serialize;

use super::fit::{self, Settled};
use super::forward::Explained;
use super::look::Look;
use super::press::GelPress;

/// The result for one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameReport {
    /// The known depth, mm.
    pub depth_mm: f64,
    /// The depth found in the images before it was scaled to the known one, mm.
    pub found_mm: f64,
    /// The radius of a circle as large as contact, mm.
    pub contact_radius_mm: f64,
    /// Motion around contact that the profile's gel leaves unexplained, root mean square over the depth.
    pub unexplained_before: Option<f64>,
    /// The same by the fitted gel.
    pub unexplained: f64,
    /// Measured normal force, N.
    pub force_n: Option<f64>,
    /// Normal force by the fitted gel, N; none where its modulus is not known.
    pub predicted_force_n: Option<f64>,
}

/// The result for one press.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GelPressReport {
    /// Its name.
    pub name: String,
    /// The frames that were used.
    pub frames: Vec<FrameReport>,
}

/// One report for each press, in the given order.
pub(super) fn press_reports(
    presses: &[GelPress],
    (looks, after): (&[Look], &Settled),
    before: &[(Look, Explained)],
    modulus_mpa: Option<f64>,
) -> Vec<GelPressReport> {
    let unexplained_before = |look: &Look| {
        let same = |other: &Look| other.press == look.press && other.frame == look.frame;
        before.iter().find(|(other, _)| same(other)).map(|(look, made)| fit::unexplained(look, made))
    };
    let report = |(number, press): (usize, &GelPress)| {
        let of = looks.iter().zip(&after.explained).filter(|(look, _)| look.press == number);
        let frame = |(look, made): (&Look, _)| FrameReport {
            depth_mm: look.depth_mm,
            found_mm: look.found_mm,
            contact_radius_mm: look.radius_mm(),
            unexplained_before: unexplained_before(look),
            unexplained: fit::unexplained(look, made),
            force_n: look.force_n,
            predicted_force_n: modulus_mpa.map(|modulus| modulus * made.force_per_modulus_mm2),
        };
        GelPressReport { name: press.name.clone(), frames: of.map(frame).collect() }
    };
    presses.iter().enumerate().map(report).collect()
}
