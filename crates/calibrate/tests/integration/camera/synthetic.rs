//! Flow by formula with noise.

use fingervision_calibrate::camera::{
    BoardError, CameraFit, FitOptions, Prior, Priors, Start, Unknown, Unknowns, fit_camera, unknowns_of,
};
use fingervision_optics::{Camera, CameraParams, Distortion, Radial};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::world::{ALONG_X, ALONG_Y, MIDDLE_PX, SIZE, distance_known, flow_error_px, seen_by, uniform};

/// Noise of a node's component, px.
const NOISE_PX: f64 = 0.02;

/// A camera within 5° and 15 % of the default one.
fn random_camera(random: &mut Pcg64Mcg, radial: Radial) -> CameraParams {
    let mut some = |size: f64| size * uniform(random);
    CameraParams {
        focal_length_px: [400.0 * (1.0 + some(0.15)); 2],
        principal_point_px: [239.5 + some(8.0), 239.5 + some(8.0)],
        distortion: Distortion { k1: some(0.1), k2: some(0.03), p1: some(0.002), p2: some(0.002), radial },
        rotation_rad: [some(5.0), some(5.0), some(5.0)].map(f64::to_radians),
        translation_mm: [some(1.0), some(1.0), 25.0],
    }
}

fn tilted(tilt_deg: f64) -> CameraParams {
    let truth = random_camera(&mut Pcg64Mcg::seed_from_u64(7), Radial::Brown);
    CameraParams { rotation_rad: [tilt_deg.to_radians(), 0.6 * tilt_deg.to_radians(), 0.03], ..truth }
}

fn noise() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(11)
}

/// The error of each unknown, in units of its uncertainty. The position of the origin along the board is not
/// determined.
fn errors_in_uncertainties(fit: &CameraFit, truth: &CameraParams) -> Vec<(&'static str, f64)> {
    let truth: Unknowns = unknowns_of(truth);
    let estimates = fit.knowledge.estimates.iter().zip(truth.iter());
    estimates.filter_map(|(it, truth)| Some((it.name, (it.value - truth) / it.uncertainty?))).collect()
}

#[test]
fn the_published_start_leads_to_every_one_of_20_cameras() {
    for seed in 0..20 {
        let random = &mut Pcg64Mcg::seed_from_u64(seed);
        let truth = random_camera(random, Radial::Brown);
        let flow = seen_by(&Camera::new(&truth).unwrap(), ALONG_X, NOISE_PX, random);
        let options = FitOptions { start: Start::Published, ..FitOptions::default() };
        let fit = fit_camera(&[flow], &distance_known(25.0), options).unwrap();
        let error_px = flow_error_px(&fit.params, &truth, ALONG_X);
        assert!(error_px < 0.005, "seed {seed}: {error_px} px from {truth:?} to {:?}", fit.params);
        let focal_error = fit.params.focal_length_px[0] / truth.focal_length_px[0] - 1.0;
        assert!(focal_error.abs() < 0.01, "seed {seed}: focal length off by {focal_error}");
        for (name, error) in errors_in_uncertainties(&fit, &truth) {
            assert!(error.abs() < 4.5, "seed {seed}: {name} is off by {error} of its uncertainty");
        }
    }
}

#[test]
fn the_printed_form_of_radial_distortion_can_be_fitted() {
    let random = &mut Pcg64Mcg::seed_from_u64(3);
    let truth = random_camera(random, Radial::Printed);
    let flow = seen_by(&Camera::new(&truth).unwrap(), ALONG_X, NOISE_PX, random);
    let options = FitOptions { radial: Radial::Printed, ..FitOptions::default() };
    let fit = fit_camera(&[flow], &distance_known(25.0), options).unwrap();
    let error_px = flow_error_px(&fit.params, &truth, ALONG_X);
    assert!(error_px < 0.005 && fit.params.distortion.radial == Radial::Printed, "{error_px} px, {:?}", fit.params);
}

#[test]
fn where_the_origin_is_along_the_board_changes_no_flow() {
    let truth = tilted(12.0);
    let camera = Camera::new(&truth).unwrap();
    let moved = CameraParams { translation_mm: camera.camera_from_gel([2.0, -1.5, 0.0]), ..truth };
    let error_px = flow_error_px(&moved, &truth, ALONG_X);
    assert!(error_px < 1e-9, "{error_px} px");
    // So it is set to the point that is seen in the middle of the picture.
    let flow = seen_by(&camera, ALONG_X, NOISE_PX, &mut noise());
    let fit = fit_camera(&[flow], &distance_known(25.0), FitOptions::default()).unwrap();
    let [x, y] = Camera::new(&fit.params).unwrap().surface_point(MIDDLE_PX, 0.0).unwrap();
    assert!(fit.origin_is_middle && x.hypot(y) < 1e-9, "the middle sees ({x}, {y}) mm");
}

#[test]
fn one_slide_tells_focal_length_and_distance_only_together() {
    let truth = tilted(4.0);
    let flow = seen_by(&Camera::new(&truth).unwrap(), ALONG_X, NOISE_PX, &mut noise());
    let ratio = truth.focal_length_px[0] / truth.translation_mm[2];
    for distance_mm in [20.0, 25.0, 40.0] {
        let fit = fit_camera(std::slice::from_ref(&flow), &distance_known(distance_mm), FitOptions::default()).unwrap();
        let error_px = flow_error_px(&fit.params, &truth, ALONG_X);
        assert!(error_px < 0.01, "believing in {distance_mm} mm: {error_px} px");
        let found = fit.params.translation_mm[2];
        assert!((found - distance_mm).abs() < 0.5, "{distance_mm} mm believed, {found} mm found");
        let found = fit.params.focal_length_px[0] / found;
        assert!((found / ratio - 1.0).abs() < 0.01, "{ratio} and {found} px/mm");
        let blind = &fit.knowledge.blind[0];
        assert!(blind.meaning.starts_with("focal length against distance"), "{blind:?}");
        let distance = fit.knowledge.estimates[Unknown::Distance.index()];
        assert!(distance.determined.unwrap() < 0.2, "{distance:?}");
    }
}

#[test]
fn two_slides_across_a_tilted_board_tell_focal_length_from_distance() {
    let truth = tilted(20.0);
    let camera = Camera::new(&truth).unwrap();
    let random = &mut noise();
    let flows = [ALONG_X, ALONG_Y].map(|slide| seen_by(&camera, slide, NOISE_PX, random));
    let priors = Priors::weak(SIZE.0, MIDDLE_PX);
    let alone = fit_camera(&flows[..1], &priors, FitOptions::default()).unwrap();
    let both = fit_camera(&flows, &priors, FitOptions::default()).unwrap();
    let relative = |fit: &CameraFit| {
        let estimate = fit.knowledge.estimates[Unknown::FocalLength.index()];
        estimate.uncertainty.unwrap() / estimate.value
    };
    assert!(relative(&alone) > 0.2, "one slide: {}", relative(&alone));
    assert!(relative(&both) < 0.02, "two slides: {}", relative(&both));
    assert!(both.knowledge.blind.is_empty() && !alone.knowledge.blind.is_empty(), "{:?}", both.knowledge.blind);
    let focal_error = both.params.focal_length_px[0] / truth.focal_length_px[0] - 1.0;
    assert!(focal_error.abs() < 0.05, "focal length off by {focal_error}");
    let error_px = flow_error_px(&both.params, &truth, ALONG_Y);
    assert!(error_px < 0.005, "{error_px} px");
}

#[test]
fn a_known_focal_length_gives_the_distance() {
    let truth = tilted(4.0);
    let flow = seen_by(&Camera::new(&truth).unwrap(), ALONG_X, NOISE_PX, &mut noise());
    let mut priors = Priors::weak(SIZE.0, MIDDLE_PX);
    priors.give(Unknown::FocalLength, Prior { value: truth.focal_length_px[0], deviation: 2.0 });
    let fit = fit_camera(&[flow], &priors, FitOptions::default()).unwrap();
    let error_mm = fit.params.translation_mm[2] - truth.translation_mm[2];
    assert!(error_mm.abs() < 0.5, "the distance is off by {error_mm} mm");
}

#[test]
fn a_flow_that_no_camera_sees_is_refused() {
    let mut flow = seen_by(&Camera::new(&tilted(3.0)).unwrap(), ALONG_X, NOISE_PX, &mut noise());
    for node in &mut flow.nodes {
        let [x, y] = [0, 1].map(|axis| (node.px[axis] / 20.0).sin());
        node.flow_px = [node.flow_px[0] + 2.0 * y, node.flow_px[1] + 2.0 * x];
    }
    let error = fit_camera(&[flow], &distance_known(25.0), FitOptions::default()).unwrap_err();
    assert!(matches!(error, BoardError::NotConverged { .. }), "{error}");
    assert!(error.hint().unwrap().contains("no profile was written"), "{error}");
}
