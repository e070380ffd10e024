//! Images of the simulated board.

use std::ops::ControlFlow;

use fingervision_calibrate::camera::{BoardFlow, BoardTracker, FitOptions, fit_camera};
use fingervision_flow::FlowParams;
use fingervision_gel::{PressCache, Scene, Simulation};
use fingervision_image::{Frame, Rect};

use super::world::{ALONG_X, distance_known, flow_error_px};

/// The flow of the ready-made board: 21 images of 480×480 px with noise of 2 grey levels.
fn simulated(scene: &Scene) -> BoardFlow {
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(())).unwrap();
    let (width, height) = simulation.size();
    let mut tracker = BoardTracker::new(Rect::whole(width, height), true, &FlowParams::default()).unwrap();
    for index in 0..simulation.states().len() {
        let pixels = simulation.frame(index).unwrap().clone();
        tracker.push(&Frame { sequence: index as u64, capture_time_s: 0.0, pixels }).unwrap();
    }
    tracker.finish(ALONG_X, None).unwrap()
}

#[test]
fn the_simulated_board_gives_the_camera_that_saw_it() {
    let scene = Scene::find("board").unwrap();
    let fit = fit_camera(&[simulated(&scene)], &distance_known(25.0), FitOptions::default()).unwrap();
    let truth = scene.camera();
    let error_px = flow_error_px(&fit.params, &truth, ALONG_X);
    let (ratio, test) =
        (fit.table.after.mean_px / fit.table.before.mean_px, fit.table.test.mean_px / fit.table.after.mean_px);
    println!("flow off by {error_px:.5} px, after / before {ratio:.4}, test / after {test:.3}");
    assert!(error_px <= 0.02, "flow off by {error_px} px");
    assert!(ratio <= 0.45, "after {ratio} of before");
    assert!((test - 1.0).abs() <= 0.1, "test is {test} of after");
    let focal_error = fit.params.focal_length_px[0] / truth.focal_length_px[0] - 1.0;
    assert!(focal_error.abs() < 0.01, "focal length off by {focal_error}");
    for (found, expected) in fit.params.rotation_rad.into_iter().zip(truth.rotation_rad) {
        assert!((found - expected).abs() < 0.005, "turned by {found} instead of {expected} rad");
    }
}
