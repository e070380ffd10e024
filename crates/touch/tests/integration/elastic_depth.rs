//! Depth, contact and force from elasticity, against presses whose truth is known.

use std::f32::consts::TAU;

use fingervision_elastic::GelBlock;
use fingervision_flow::FlowField;
use fingervision_gel::{Scene, Simulation};
use fingervision_image::Image;
use fingervision_optics::{Camera, CameraParams};
use fingervision_touch::{ElasticDepth, ElasticFields, ElasticMode, ElasticParams};

use crate::solved::solve;

const SIZE: (usize, usize) = (240, 240);

/// A frame of a press, by default its last, and an inverse for its gel and camera.
struct Press {
    flow: FlowField,
    deviation: Image<f32>,
    valid: Image<u8>,
    depth_mm: Image<f32>,
    lateral_mm: Image<[f32; 3]>,
    contact: Image<u8>,
    force_n: [f64; 3],
    gel: GelBlock,
    camera: Camera,
}

impl Press {
    /// The last frame of a scene that is solved on the draft mesh.
    fn new(indenter: &str, law: &str, motion: &str) -> Self {
        let [last] = Self::frames(indenter, law, motion, [4]);
        last
    }

    /// Some of its five frames.
    fn frames<const N: usize>(indenter: &str, law: &str, motion: &str, frames: [usize; N]) -> [Self; N] {
        let text = format!(
            "name = 'press'\n[camera]\nfocal_length_px = [200.0, 200.0]\n[contact]\nlaw = '{law}'\n[indenter]\n{indenter}\n\
             [motion]\nframes = 5\n{motion}\n[render]\nwidth = 240\nheight = 240\n[mesh]\nresolution = 'draft'\n"
        );
        let scene = Scene::from_toml(&text).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        solve(&mut simulation);
        frames.map(|frame| Self::frame(&mut simulation, &scene, frame))
    }

    fn frame(simulation: &mut Simulation, scene: &Scene, frame: usize) -> Self {
        let force_n = simulation.states()[frame].force_n;
        let truth = simulation.truth(frame).unwrap();
        let part = |axis: usize| Image::from_fn(SIZE.0, SIZE.1, |x, y| truth.flow.at(x, y)[axis]);
        let flow = FlowField { u: part(0), v: part(1) };
        let valid = Image::from_fn(SIZE.0, SIZE.1, |x, y| u8::from(truth.flow.at(x, y)[0].is_finite()));
        Self {
            flow,
            deviation: Image::filled(SIZE.0, SIZE.1, 0.02),
            valid,
            depth_mm: truth.depth.clone(),
            lateral_mm: truth.displacement.clone(),
            contact: truth.contact.clone(),
            force_n,
            gel: scene.gel,
            camera: Camera::new(&scene.camera()).unwrap(),
        }
    }

    fn inverse(&self, mode: ElasticMode) -> ElasticDepth {
        ElasticDepth::new(&self.camera, &self.gel, SIZE, &ElasticParams { mode, ..ElasticParams::default() }).unwrap()
    }

    /// Mean error of depth over the image, mm, and the overlap of contact.
    fn judge(&self, fields: &ElasticFields) -> (f64, f64) {
        let depths = fields.depth_mm.values().iter().zip(self.depth_mm.values());
        let error: f64 = depths.map(|(found, truth)| f64::from((found - truth).abs())).sum();
        let contacts = fields.contact.values().iter().zip(self.contact.values());
        let count = |holds: fn(u8, u8) -> bool| contacts.clone().filter(|(a, b)| holds(**a, **b)).count() as f64;
        (error / (SIZE.0 * SIZE.1) as f64, count(|a, b| a & b == 1) / count(|a, b| a | b == 1))
    }
}

fn stuck_circle() -> Press {
    Press::new("shape = 'circle'\nradius_mm = 4.0", "stick", "keyframes = [{ at = 4, depth_mm = 1.5 }]")
}

fn close(found: f32, wanted: f64, relative: f64) -> bool {
    (f64::from(found) - wanted).abs() <= relative * wanted.abs()
}

#[test]
fn a_stuck_face_is_found_with_its_depth_and_force() {
    let press = stuck_circle();
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.025 && overlap > 0.8, "{error_mm} mm, {overlap}");
    let centre = fields.depth_mm.at(120, 120);
    assert!((centre - 1.5).abs() < 0.02, "{centre} mm deep");
    let force = fields.force_n.unwrap();
    assert!(close(force[2], press.force_n[2], 0.08), "{force:?} {:?}", press.force_n);
    assert!(force[0].hypot(force[1]) < 0.05 * force[2], "{force:?}");
    assert!(!fields.is_misfit && !fields.is_cut && !fields.is_beyond_linear);

    let mut displacement = [0, 1, 2].map(|_| Image::filled(SIZE.0, SIZE.1, 0.0));
    inverse.displacement_into(&press.flow, &mut displacement);
    let ((mut lateral, mut count), truth) = ((0.0, 0.0), &press.lateral_mm);
    for (index, truth) in truth.values().iter().enumerate().filter(|(index, _)| press.valid.values()[*index] == 1) {
        lateral += f64::from((displacement[0].values()[index] - truth[0]).abs());
        count += 1.0;
    }
    assert!(lateral / count < 0.01, "{} mm along x", lateral / count);
}

#[test]
fn a_ball_that_slides_is_found_with_its_force() {
    let press =
        Press::new("shape = 'sphere'\nradius_mm = 6.0", "frictionless", "keyframes = [{ at = 4, depth_mm = 1.5 }]");
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.03 && overlap > 0.7, "{error_mm} mm, {overlap}");
    assert!(close(fields.force_n.unwrap()[2], press.force_n[2], 0.15), "{:?} {:?}", fields.force_n, press.force_n);
}

#[test]
fn a_face_that_slides_and_spreads_is_not_taken_for_one_that_sticks() {
    let mut press = stuck_circle();
    // Like gel that spreads evenly under a face: in the image it grows by another tenth, as if it came closer.
    for y in 0..SIZE.1 {
        for x in (0..SIZE.0).filter(|&x| press.contact.at(x, y) == 1) {
            let away = [x, y].map(|at| at as f32 - 119.5);
            press.flow.u.row_mut(y)[x] += 0.1 * away[0];
            press.flow.v.row_mut(y)[x] += 0.1 * away[1];
        }
    }
    let mut inverse = press.inverse(ElasticMode::Exact);
    let centre = inverse.solve(&press.flow, &press.deviation, &press.valid).depth_mm.at(120, 120);
    assert!(centre < 2.5, "{centre} mm deep, 3.5 as one that sticks");
}

#[test]
fn shear_force_is_found_from_a_face_that_is_dragged() {
    let motion = "keyframes = [{ at = 2, depth_mm = 1.0 }, { at = 4, shear_mm = [1.0, 0.0] }]";
    let press = Press::new("shape = 'rectangle'\nsize_mm = [6.0, 6.0]", "stick", motion);
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    let force = fields.force_n.unwrap();
    assert!(close(force[0], press.force_n[0], 0.1), "{force:?} {:?}", press.force_n);
    assert!(close(force[2], press.force_n[2], 0.1), "{force:?} {:?}", press.force_n);
    assert!(!fields.is_beyond_linear, "the depth of a face that sticks does not depend on shear");
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.01 && overlap > 0.8, "{error_mm} mm, {overlap}");
}

#[test]
fn a_ball_that_is_dragged_is_not_taken_for_a_deeper_one() {
    let motion = "keyframes = [{ at = 2, depth_mm = 0.8 }, { at = 4, shear_mm = [1.5, 0.0] }]";
    let press = Press::new("shape = 'sphere'\nradius_mm = 12.0", "stick", motion);
    let mut exact = press.inverse(ElasticMode::Exact);
    let fields = exact.solve(&press.flow, &press.deviation, &press.valid);
    assert!(fields.is_beyond_linear, "shear that is large relative to the depth");
    let (error_mm, overlap) = press.judge(fields);
    assert!(error_mm < 0.018 && overlap > 0.7, "{error_mm} mm, {overlap}");
    // Live mode takes the motion of contact from the previous frame. Without that its error is 0.021 mm.
    let mut live = press.inverse(ElasticMode::Live);
    for _ in 0..8 {
        live.solve(&press.flow, &press.deviation, &press.valid);
    }
    let (error_mm, _) = press.judge(live.fields());
    assert!(error_mm < 0.019, "{error_mm} mm");
}

#[test]
fn a_ball_that_sticks_keeps_its_depth_while_it_is_dragged() {
    let motion = "keyframes = [{ at = 2, depth_mm = 0.8 }, { at = 4, shear_mm = [1.5, 0.0] }]";
    let [pressed, dragged] = Press::frames("shape = 'sphere'\nradius_mm = 12.0", "stick", motion, [2, 4]);
    // At the rim, contact itself is uncertain.
    let inside_mm = |press: &Press, fields: &ElasticFields| {
        let depths = fields.depth_mm.values().iter().zip(press.depth_mm.values()).filter(|(_, truth)| **truth > 0.4);
        depths.clone().map(|(found, truth)| f64::from((found - truth).abs())).sum::<f64>() / depths.count() as f64
    };
    for mode in [ElasticMode::Exact, ElasticMode::Live] {
        let mut alone = dragged.inverse(mode);
        let alone_mm = inside_mm(&dragged, alone.solve(&dragged.flow, &dragged.deviation, &dragged.valid));
        let mut inverse = dragged.inverse(mode);
        let before_mm = inside_mm(&pressed, inverse.solve(&pressed.flow, &pressed.deviation, &pressed.valid));
        let fields = inverse.solve(&dragged.flow, &dragged.deviation, &dragged.valid);
        let followed_mm = inside_mm(&dragged, fields);
        assert!(
            followed_mm < before_mm + 0.005 && followed_mm < 0.7 * alone_mm,
            "{mode:?}: {followed_mm} mm, before {before_mm}, alone {alone_mm}"
        );
        let force_n = fields.force_n.unwrap();
        assert!(close(force_n[2], dragged.force_n[2], 0.12), "{mode:?}: {force_n:?} of {:?}", dragged.force_n);
        // What was known before is forgotten.
        inverse.restart();
        let again_mm = inside_mm(&dragged, inverse.solve(&dragged.flow, &dragged.deviation, &dragged.valid));
        assert!((again_mm - alone_mm).abs() < 1e-12, "{mode:?}: {again_mm} mm after a restart, {alone_mm} mm alone");
    }
}

#[test]
fn the_live_mode_stays_close_to_the_exact_one() {
    let press = stuck_circle();
    let exact = press.inverse(ElasticMode::Exact).solve(&press.flow, &press.deviation, &press.valid).clone();
    let mut live = press.inverse(ElasticMode::Live);
    for _ in 0..12 {
        live.solve(&press.flow, &press.deviation, &press.valid);
    }
    let fields = live.solve(&press.flow, &press.deviation, &press.valid);
    let mean = mean_difference(&fields.depth_mm, &exact.depth_mm);
    assert!(mean < 0.01, "{mean} mm");
    let forces = [fields, &exact].map(|fields| f64::from(fields.force_n.unwrap()[2]));
    assert!((forces[0] - forces[1]).abs() < 0.03 * forces[1], "{forces:?}");
}

#[test]
fn a_mirrored_press_has_the_mirrored_depth() {
    let press = stuck_circle();
    let depth = press.inverse(ElasticMode::Exact).solve(&press.flow, &press.deviation, &press.valid).depth_mm.clone();
    let mirrored =
        |plane: &Image<f32>, sign: f32| Image::from_fn(SIZE.0, SIZE.1, |x, y| sign * plane.at(SIZE.0 - 1 - x, y));
    let flow = FlowField { u: mirrored(&press.flow.u, -1.0), v: mirrored(&press.flow.v, 1.0) };
    let valid = Image::from_fn(SIZE.0, SIZE.1, |x, y| press.valid.at(SIZE.0 - 1 - x, y));
    let mut inverse = press.inverse(ElasticMode::Exact);
    let found = &inverse.solve(&flow, &press.deviation, &valid).depth_mm;
    let mean = mean_difference(found, &mirrored(&depth, 1.0));
    assert!(mean < 1e-3, "{mean} mm");
}

#[test]
fn a_camera_too_far_for_perspective_takes_no_depth_from_it() {
    let mut press = stuck_circle();
    let far = CameraParams {
        focal_length_px: press.camera.params().focal_length_px.map(|length| 1000.0 * length),
        translation_mm: press.camera.params().translation_mm.map(|length| 1000.0 * length),
        ..*press.camera.params()
    };
    // With so distant a camera, a face would have to come a thousand times closer to grow in the image by perspective.
    press.camera = Camera::new(&far).unwrap();
    let mut inverse = press.inverse(ElasticMode::Exact);
    let depths = &inverse.solve(&press.flow, &press.deviation, &press.valid).depth_mm;
    let deepest = depths.values().iter().copied().fold(0.0, f32::max);
    // Measured: 1.504 mm, of which 1.5 mm are true.
    assert!((deepest - 1.5).abs() < 0.05, "{deepest} mm");
}

/// Mean absolute difference of two maps.
fn mean_difference(left: &Image<f32>, right: &Image<f32>) -> f64 {
    let differences = left.values().iter().zip(right.values()).map(|(a, b)| f64::from((a - b).abs()));
    differences.sum::<f64>() / left.values().len() as f64
}

#[test]
fn without_the_network_a_stuck_face_is_found_by_its_motion() {
    let press = stuck_circle();
    let params = ElasticParams { network: false, ..ElasticParams::default() };
    let mut inverse = ElasticDepth::new(&press.camera, &press.gel, SIZE, &params).unwrap();
    let (error_mm, overlap) = press.judge(inverse.solve(&press.flow, &press.deviation, &press.valid));
    assert!(error_mm < 0.03 && overlap > 0.6, "{error_mm} mm, {overlap}");
}

#[test]
fn an_untouched_gel_has_no_depth() {
    let press = stuck_circle();
    let still = FlowField::zero(SIZE.0, SIZE.1);
    let mut inverse = press.inverse(ElasticMode::Exact);
    let pressed = inverse.solve(&press.flow, &press.deviation, &press.valid).contact_area_mm2;
    assert!(pressed > 30.0, "{pressed} mm²");
    let fields = inverse.solve(&still, &press.deviation, &press.valid);
    assert!(fields.depth_mm.values().iter().all(|&depth| depth == 0.0));
    assert_eq!((fields.contact_area_mm2, fields.force_n), (0.0, Some([0.0; 3])));
    assert!(fields.traction_mpa.as_ref().unwrap().traction_mpa.iter().flatten().all(|&traction| traction == 0.0));
}

#[test]
fn gel_that_has_left_the_view_invents_no_contact() {
    let mut press = stuck_circle();
    // No pattern is left there to be tracked.
    for y in 0..SIZE.1 {
        press.flow.u.row_mut(y)[..12].fill(-14.0);
        press.flow.v.row_mut(y)[..12].fill(6.0);
        press.valid.row_mut(y)[..12].fill(0);
    }
    let mut inverse = press.inverse(ElasticMode::Exact);
    let (error_mm, overlap) = press.judge(inverse.solve(&press.flow, &press.deviation, &press.valid));
    assert!(error_mm < 0.025 && overlap > 0.8, "{error_mm} mm, {overlap}");
}

#[test]
fn a_gel_of_unknown_stiffness_has_depth_but_no_force() {
    let mut press = stuck_circle();
    let with = press.inverse(ElasticMode::Exact).solve(&press.flow, &press.deviation, &press.valid).depth_mm.clone();
    press.gel.youngs_modulus_mpa = None;
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    assert_eq!(fields.depth_mm, with);
    assert!(fields.force_n.is_none() && fields.torque_nmm.is_none() && fields.traction_mpa.is_none());
}

#[test]
fn a_motion_that_no_press_makes_is_a_misfit() {
    let press = stuck_circle();
    let mut inverse = press.inverse(ElasticMode::Exact);
    let wave = |along: usize| 4.0 * (TAU * along as f32 / 60.0).sin();
    let flow = FlowField {
        u: Image::from_fn(SIZE.0, SIZE.1, |_, y| wave(y)),
        v: Image::from_fn(SIZE.0, SIZE.1, |x, _| wave(x)),
    };
    let valid = Image::filled(SIZE.0, SIZE.1, 1);
    assert!(inverse.solve(&flow, &press.deviation, &valid).is_misfit);
    // Flow with such a deviation contains no information about the gel.
    let uncertain = Image::filled(SIZE.0, SIZE.1, 6.0);
    let mut inverse = press.inverse(ElasticMode::Exact);
    assert!(!inverse.solve(&flow, &uncertain, &valid).is_misfit);
    assert!(!inverse.solve(&FlowField::zero(SIZE.0, SIZE.1), &press.deviation, &valid).is_misfit, "a gel at rest fits");
}

#[test]
fn depth_is_as_uncertain_as_its_flow() {
    let press = stuck_circle();
    let mut inverse = press.inverse(ElasticMode::Exact);
    let mut at_centre = |deviation_px: f32| {
        let deviation = Image::filled(SIZE.0, SIZE.1, deviation_px);
        inverse.solve(&press.flow, &deviation, &press.valid).deviation_mm.at(20, 120)
    };
    let (certain, usual, uncertain) = (at_centre(0.0), at_centre(0.025), at_centre(0.2));
    assert!((certain - usual).abs() < 1e-6, "{certain} and {usual} mm");
    // 0.2 px are 0.025 mm on the gel, and 0.083 mm of depth where a ray leans by 0.3.
    assert!(uncertain > usual + 0.03 && uncertain < usual + 0.12, "{usual} and {uncertain} mm");
}

#[test]
fn without_the_network_and_without_a_face_nothing_is_known() {
    let press = stuck_circle();
    let params = ElasticParams { network: false, ..ElasticParams::default() };
    let mut inverse = ElasticDepth::new(&press.camera, &press.gel, SIZE, &params).unwrap();
    // No face is stretched along x and compressed along y.
    let flow = FlowField {
        u: Image::from_fn(SIZE.0, SIZE.1, |x, _| 0.1 * (x as f32 - 119.5)),
        v: Image::from_fn(SIZE.0, SIZE.1, |_, y| -0.1 * (y as f32 - 119.5)),
    };
    let fields = inverse.solve(&flow, &press.deviation, &Image::filled(SIZE.0, SIZE.1, 1));
    assert!(fields.deviation_mm.values().iter().all(|deviation| deviation.is_infinite()));
}

#[test]
fn contact_that_was_not_followed_is_flagged() {
    let mut press = stuck_circle();
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    assert!(!fields.is_untracked);
    let contact = fields.contact.clone();
    for (valid, &contact) in press.valid.values_mut().iter_mut().zip(contact.values()) {
        *valid &= 1 - contact;
    }
    assert!(inverse.solve(&press.flow, &press.deviation, &press.valid).is_untracked);
}

#[test]
fn contact_with_a_large_hole_is_flagged_and_with_a_small_one_not() {
    let press = stuck_circle();
    let mut inverse = press.inverse(ElasticMode::Exact);
    // A pixel is 0.125 mm wide, and contact has a radius of 4 mm.
    for (radius_mm, is_untracked) in [(2.0, false), (3.5, true)] {
        let valid = Image::from_fn(SIZE.0, SIZE.1, |x, y| {
            let from_centre_mm = 0.125 * (x as f64 - 119.5).hypot(y as f64 - 119.5);
            press.valid.at(x, y) * u8::from(from_centre_mm > radius_mm)
        });
        let fields = inverse.solve(&press.flow, &press.deviation, &valid);
        assert_eq!(fields.is_untracked, is_untracked, "a hole of radius {radius_mm} mm");
    }
}

#[test]
fn a_flow_with_holes_leaves_no_hole_in_depth_and_frames_do_not_allocate() {
    let mut press = stuck_circle();
    for y in 100..110 {
        press.flow.u.row_mut(y)[90..150].fill(f32::NAN);
        press.valid.row_mut(y)[90..150].fill(0);
    }
    let mut inverse = press.inverse(ElasticMode::Exact);
    let fields = inverse.solve(&press.flow, &press.deviation, &press.valid);
    let force = fields.force_n.unwrap();
    assert!(close(force[2], press.force_n[2], 0.1), "{force:?} {:?}", press.force_n);
    // The hole is in the face, 1.5 mm deep: cells at rest there would be a hole in it.
    for x in 95..145 {
        let depth = fields.depth_mm.at(x, 105);
        assert!((depth - 1.5).abs() < 0.1, "{depth} mm at column {x}");
    }
    let allocations = allocation_counter::measure(|| {
        inverse.solve(&press.flow, &press.deviation, &press.valid);
    });
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}
