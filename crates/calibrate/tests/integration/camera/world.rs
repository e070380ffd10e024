//! Boards whose camera is known.

use fingervision_calibrate::camera::{BoardFlow, GRID, Node, Prior, Priors, Slide, Unknown, board_flow};
use fingervision_optics::{Camera, CameraParams};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

pub(crate) const SIZE: (usize, usize) = (480, 480);
pub(crate) const MIDDLE_PX: [f64; 2] = [239.5; 2];
pub(crate) const ALONG_X: Slide = Slide { step_mm: 0.5, direction_rad: 0.0 };
pub(crate) const ALONG_Y: Slide = Slide { step_mm: 0.5, direction_rad: std::f64::consts::FRAC_PI_2 };

/// A number between -1 and 1.
pub(crate) fn uniform(random: &mut Pcg64Mcg) -> f64 {
    f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Nearly normal noise of deviation 1: twelve uniform numbers have the variance 4.
fn normal(random: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| uniform(random)).sum::<f64>() / 2.0
}

/// Every pixel of the grid.
pub(crate) fn grid() -> impl Iterator<Item = ([usize; 2], [f64; 2])> {
    let px = |place: usize, size: usize| ((2 * place + 1) * size / (2 * GRID)) as f64;
    (0..GRID * GRID).map(move |node| {
        let place = [node % GRID, node / GRID];
        (place, [px(place[0], SIZE.0), px(place[1], SIZE.1)])
    })
}

/// The flow that a camera sees, with noise on each component.
pub(crate) fn seen_by(camera: &Camera, slide: Slide, noise_px: f64, random: &mut Pcg64Mcg) -> BoardFlow {
    let nodes = grid().map(|(place, px)| {
        let flow = board_flow(camera, px, slide.step_vector_mm()).unwrap();
        Node { place, px, flow_px: flow.map(|value| value + noise_px * normal(random)) }
    });
    BoardFlow { size: SIZE, images: 21, slide, usual_px: [8.0, 0.0], nodes: nodes.collect() }
}

/// Mean distance between the flows of two cameras on the grid, px.
pub(crate) fn flow_error_px(params: &CameraParams, truth: &CameraParams, slide: Slide) -> f64 {
    let [camera, truth] = [params, truth].map(|params| Camera::new(params).unwrap());
    let lengths: Vec<f64> = grid()
        .map(|(_, px)| {
            let [a, b] = [&camera, &truth].map(|camera| board_flow(camera, px, slide.step_vector_mm()).unwrap());
            (a[0] - b[0]).hypot(a[1] - b[1])
        })
        .collect();
    lengths.iter().sum::<f64>() / lengths.len() as f64
}

/// The prior of a distance measured to half a millimetre.
pub(crate) fn distance_known(distance_mm: f64) -> Priors {
    let mut priors = Priors::weak(SIZE.0, MIDDLE_PX);
    priors.give(Unknown::Distance, Prior { value: distance_mm, deviation: 0.5 });
    priors
}
