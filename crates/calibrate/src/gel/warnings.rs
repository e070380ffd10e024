//! Warnings about presses and the gel that was fitted to them.

use fingervision_elastic::GelBlock;
use fingervision_optics::Camera;
use fingervision_touch::ElasticParams;

use super::GelPress;
use super::estimate::GelEstimate;
use super::press_report::GelPressReport;
use super::thresholds::THRESHOLDS;

/// The warnings about the presses and the fit.
pub(super) fn of_presses(
    presses: &[GelPress],
    reports: &[GelPressReport],
    unexplained: f64,
    [ratio, _, modulus]: &[GelEstimate; 3],
) -> Vec<String> {
    let released = presses.iter().filter(|press| press.was_released).map(of_release);
    let misfit = (unexplained > THRESHOLDS.usual_unexplained).then(|| of_misfit(unexplained));
    let is_at_end = ratio.value.is_some_and(|ratio| ratio > THRESHOLDS.end_of_ratios);
    let at_end = is_at_end
        .then(|| "Poisson's ratio is at the upper end of its range, 0.499: the gel is nearly incompressible".into());
    released
        .chain(misfit)
        .chain(reports.iter().filter_map(of_depths))
        .chain(at_end)
        .chain(of_modulus(modulus))
        .collect()
}

/// The warnings about the gel and the camera alone.
pub(super) fn of_sensor(camera: &Camera, gel: &GelBlock, params: ElasticParams) -> Option<String> {
    params.is_outside_training(camera, gel).then(|| {
        "gel and camera are outside the network's training range: depth and contact are less accurate, \
         and the gel is fitted to them"
            .into()
    })
}

fn of_release(press: &GelPress) -> String {
    format!(
        "{}: its first motion is that of a release: begin the recording before the indenter touches the gel",
        press.name
    )
}

fn of_misfit(unexplained: f64) -> String {
    format!(
        "the residual is {:.1} % of the depth, usual is at most {:.0} %: check that the gel is bonded to a flat window, and check \
         the camera's calibration and the depths",
        100.0 * unexplained,
        100.0 * THRESHOLDS.usual_unexplained
    )
}

/// A depth in the images that differs much from the known one.
fn of_depths(press: &GelPressReport) -> Option<String> {
    let deepest = press.frames.iter().max_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm))?;
    let factor = deepest.found_mm / deepest.depth_mm;
    (!(1.0 / THRESHOLDS.most_depth_factor..THRESHOLDS.most_depth_factor).contains(&factor)).then(|| {
        format!(
            "{}: the known depth is {:.2} mm, the depth in its images {:.2} mm: check its depths, and the distance in [camera]",
            press.name, deepest.depth_mm, deepest.found_mm
        )
    })
}

/// A modulus that differs much from the profile's.
fn of_modulus(modulus: &GelEstimate) -> Option<String> {
    let (before, now) = modulus.before.zip(modulus.value)?;
    (now.max(before) > THRESHOLDS.most_stiffer * now.min(before)).then(|| {
        format!("Young's modulus changes from {before:.4} to {now:.4} MPa: are the forces in N? (1 g is 0.00981 N)")
    })
}
