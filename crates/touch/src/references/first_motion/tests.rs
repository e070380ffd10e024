//! Presses with exact flow on gels from compressible to nearly incompressible, and the same presses as releases.

use std::ops::ControlFlow;

use fingervision_flow::{Estimate, FlowField};
use fingervision_gel::{PressCache, Scene, Simulation};

use super::*;

const SIZE: usize = 240;
/// Images of a press after the untouched one.
const FRAMES: usize = 4;

/// The flows of a press from its untouched image, deeper and deeper.
fn press(poissons_ratio: f64, indenter: &str, centre_mm: [f64; 2], depth_mm: f64) -> Vec<Estimate> {
    let scene = Scene::from_toml(&format!(
        "name = 'press'\n[gel]\npoissons_ratio = {poissons_ratio}\n[indenter]\n{indenter}\n[mesh]\nresolution = 'draft'\n\
         [motion]\ncentre_mm = {centre_mm:?}\nframes = {}\nkeyframes = [{{ at = {FRAMES}, depth_mm = {depth_mm:.1} }}]\n\
         [camera]\nfocal_length_px = [200.0, 200.0]\n[render]\nwidth = {SIZE}\nheight = {SIZE}\n",
        FRAMES + 1
    ))
    .unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(())).unwrap();
    let estimate = |frame| {
        let flow = &simulation.truth(frame).unwrap().flow;
        estimate_of(|x, y| flow.at(x, y))
    };
    (1..=FRAMES).map(estimate).collect()
}

fn estimate_of(flow: impl Fn(usize, usize) -> [f32; 2]) -> Estimate {
    let mut estimate = Estimate::new(SIZE, SIZE);
    estimate.valid.values_mut().fill(1);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let [u, v] = flow(x, y);
            (estimate.flow.u.row_mut(y)[x], estimate.flow.v.row_mut(y)[x]) = (u, v);
        }
    }
    estimate
}

/// The flow from the image that a flow leads to back to the one that it begins in.
fn release(FlowField { u, v }: &FlowField) -> Estimate {
    let last = SIZE - 1;
    estimate_of(|column, row| {
        let here = [column as f32, row as f32];
        let mut from = here;
        for _ in 0..40 {
            let [x, y] = from.map(|at| (at.round().max(0.0) as usize).min(last));
            from = [here[0] - u.at(x, y), here[1] - v.at(x, y)];
        }
        [from[0] - here[0], from[1] - here[1]]
    })
}

fn judge(flow: &Estimate) -> Option<FirstImage> {
    FirstMotion::new([0.5 * (SIZE as f32 - 1.0); 2]).judge(flow)
}

const SQUARE: &str = "shape = 'rectangle'\nsize_mm = [6.0, 6.0]";
const SMALL_SQUARE: &str = "shape = 'rectangle'\nsize_mm = [3.0, 3.0]";
const BALL: &str = "shape = 'sphere'\nradius_mm = 6.0";

#[test]
fn a_press_from_rest_is_never_taken_for_a_release_whatever_the_gel() {
    let presses = [
        (0.3, BALL, [0.0, 0.0]),
        (0.3, SMALL_SQUARE, [0.0, 0.0]),
        (0.35, SQUARE, [0.0, 0.0]),
        (0.35, BALL, [4.5, 4.5]),
        (0.48, BALL, [9.0, 9.0]),
    ];
    for (ratio, indenter, centre_mm) in presses {
        for (number, flow) in press(ratio, indenter, centre_mm, 2.0).iter().enumerate() {
            let found = judge(flow);
            assert_ne!(found, Some(FirstImage::Pressed), "ν {ratio}, {indenter} at {centre_mm:?}, image {number}");
        }
    }
}

#[test]
fn a_release_is_found_at_the_centre_and_at_a_corner() {
    for (ratio, indenter, centre_mm, depth_mm) in
        [(0.48, BALL, [0.0, 0.0], 2.0), (0.48, SQUARE, [4.5, 4.5], 2.0), (0.35, SQUARE, [9.0, 9.0], 1.0)]
    {
        let deepest = press(ratio, indenter, centre_mm, depth_mm).pop().unwrap();
        let place = format!("ν {ratio}, {indenter} at {centre_mm:?}");
        assert_eq!(judge(&release(&deepest.flow)), Some(FirstImage::Pressed), "{place}");
        assert_eq!(judge(&deepest), Some(FirstImage::AtRest), "{place}");
    }
}

#[test]
fn shear_and_rest_say_nothing() {
    assert_eq!(judge(&estimate_of(|_, _| [0.0; 2])), None);
    // A face of 40 px far from the centre that is dragged to it.
    let dragged = estimate_of(|x, y| {
        let distance = (x as f32 - 190.0).hypot(y as f32 - 190.0);
        [-3.0 * (1.0 - (distance - 20.0).max(0.0) / 30.0).max(0.0); 2]
    });
    assert_eq!(judge(&dragged), None);
}
