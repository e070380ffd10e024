//! Presses with a known solution.

use super::{Press, PressError, PressSetup};
use crate::layer::{ContactParams, LayerContact};
use crate::{BlockMesh, ContactLaw, GelBlock, Law, Layer, Pose, Relief, ReliefPoint};
use crate::{SurfaceGrid, graded_lines};

const GEL: GelBlock =
    GelBlock { size_mm: [30.0, 30.0], thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: Some(0.6) };

/// A round flat face with a fillet and a wall of slope 3.
struct Punch {
    radius_mm: f64,
}

impl Relief for Punch {
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint {
        let (fillet, slope) = (0.3, 3.0_f64);
        let radius = x_mm.hypot(y_mm);
        let distance = radius - self.radius_mm;
        if distance <= 0.0 {
            return ReliefPoint { height_mm: 0.0, slope: [0.0; 2], curvature_per_mm: [0.0; 3] };
        }
        let end = fillet * slope / (1.0 + slope * slope).sqrt();
        let depth = |at: f64| (fillet * fillet - at * at).sqrt();
        let (height, first, second) = if distance < end {
            let depth = depth(distance);
            (fillet - depth, distance / depth, fillet * fillet / depth.powi(3))
        } else {
            (fillet - depth(end) + slope * (distance - end), slope, 0.0)
        };
        radial([x_mm, y_mm], radius, [height, first, second])
    }

    fn half_extent_mm(&self) -> [f64; 2] {
        [self.radius_mm + 1.0; 2]
    }
}

/// A punch that stands beside the indenter's origin.
struct Beside {
    punch: Punch,
    to_the_right_mm: f64,
}

impl Relief for Beside {
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint {
        self.punch.at(x_mm - self.to_the_right_mm, y_mm)
    }

    fn half_extent_mm(&self) -> [f64; 2] {
        let [x, y] = self.punch.half_extent_mm();
        [x + self.to_the_right_mm, y]
    }
}

struct Ball {
    radius_mm: f64,
}

impl Relief for Ball {
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint {
        let radius = x_mm.hypot(y_mm);
        let squared = self.radius_mm.powi(2) - radius * radius;
        if squared <= 0.0 {
            return ReliefPoint { height_mm: f64::INFINITY, slope: [0.0; 2], curvature_per_mm: [0.0; 3] };
        }
        let depth = squared.sqrt();
        let curvature = self.radius_mm.powi(2) / depth.powi(3);
        radial([x_mm, y_mm], radius, [self.radius_mm - depth, radius / depth, curvature])
    }

    fn half_extent_mm(&self) -> [f64; 2] {
        [self.radius_mm; 2]
    }
}

/// A relief that depends on the distance from the axis alone: height, slope and curvature along it.
fn radial([x, y]: [f64; 2], radius: f64, [height_mm, first, second]: [f64; 3]) -> ReliefPoint {
    if radius <= 0.0 {
        return ReliefPoint { height_mm, slope: [0.0; 2], curvature_per_mm: [second, 0.0, second] };
    }
    let ([ex, ey], around) = ([x / radius, y / radius], first / radius);
    let curvature_per_mm =
        [second * ex * ex + around * ey * ey, (second - around) * ex * ey, second * ey * ey + around * ex * ex];
    ReliefPoint { height_mm, slope: [first * ex, first * ey], curvature_per_mm }
}

fn mesh(block: &GelBlock, fine_mm: f64, spacing_mm: f64, growth: f64) -> BlockMesh {
    let across = |size: f64| graded_lines([-0.5 * size, 0.5 * size], [-fine_mm, fine_mm], spacing_mm, growth);
    let down = graded_lines([0.0, block.thickness_mm], [0.0, 2.0 * spacing_mm], spacing_mm, growth);
    BlockMesh::new(across(block.size_mm[0]), across(block.size_mm[1]), down)
}

fn setup(block: GelBlock, law: Law, contact: ContactLaw) -> PressSetup {
    PressSetup { block, law, contact }
}

fn deep(depth_mm: f64) -> Pose {
    Pose { depth_mm, ..Pose::default() }
}

#[test]
fn a_sphere_on_a_deep_block_is_hertz() {
    let block =
        GelBlock { size_mm: [100.0, 100.0], thickness_mm: 80.0, poissons_ratio: 0.35, youngs_modulus_mpa: Some(0.6) };
    let (radius, depth) = (4.0, 0.03_f64);
    let contact_radius = (radius * depth).sqrt();
    let spacing = contact_radius / 10.0;
    let ball = Ball { radius_mm: radius };
    let setup = setup(block, Law::Linear, ContactLaw::Frictionless);
    let mesh = mesh(&block, 1.2 * contact_radius, spacing, 1.4);
    let mut press = Press::new(&setup, mesh, &ball, [0.0, 0.0]).unwrap();
    let state = press.step(&deep(depth)).unwrap();
    let modulus = 0.6 / (1.0 - 0.35 * 0.35);
    let force = 4.0 / 3.0 * modulus * radius.sqrt() * depth.powf(1.5);
    assert!((state.force_n[2] / force - 1.0).abs() < 0.02, "{} N, Hertz {force} N", state.force_n[2]);
    // A node in touch stands for a cell; the outermost ones carry part of theirs: area weighted by Hertz' pressure.
    let largest = state.traction_mpa.iter().map(|traction| traction[2]).fold(0.0, f64::max);
    let mean_radius = (1.5 * state.force_n[2] / (std::f64::consts::PI * largest)).sqrt();
    assert!((mean_radius / contact_radius - 1.0).abs() < 0.02, "{mean_radius} mm, Hertz {contact_radius} mm");
}

#[test]
fn forces_balance_and_work_is_stored() {
    let punch = Punch { radius_mm: 4.0 };
    for contact in [ContactLaw::Stick, ContactLaw::Frictionless] {
        let setup = setup(GEL, Law::NeoHookean, contact);
        let mut press = Press::new(&setup, mesh(&GEL, 5.0, 0.9, 1.4), &punch, [0.0, 0.0]).unwrap();
        let (mut work, mut before) = (0.0, 0.0);
        for step in 1..=20 {
            let force = press.step(&deep(0.1 * f64::from(step))).unwrap().force_n;
            work += 0.05 * (before + force[2]);
            before = force[2];
            let base = press.report().base_force_n;
            for c in 0..3 {
                assert!((force[c] + base[c]).abs() < 1e-4 * force[2], "{contact:?}: {force:?} N on {base:?} N");
            }
        }
        let stored = press.report().energy_nmm;
        assert!((work / stored - 1.0).abs() < 3e-3, "{contact:?}: work {work} N mm, stored {stored} N mm");
        // No node of the flat face lifts off or goes in.
        let state = press.surface();
        let nodes = state.y_mm.iter().flat_map(|y| state.x_mm.iter().map(move |x| (x, y)));
        for ((x, y), displacement) in nodes.zip(&state.displacement_mm) {
            if (x + displacement[0]).hypot(y + displacement[1]) < 3.9 {
                assert!((displacement[2] - 2.0).abs() < 5e-3, "({x}, {y}): {} mm", displacement[2]);
            }
        }
    }
}

#[test]
fn a_face_without_friction_presses_and_slides() {
    // Nodes sit on the fillet, where the face bends most, and snap off it as it slides; a rest is sought 40 times.
    let punch = Punch { radius_mm: 4.0 };
    let setup = setup(GEL, Law::NeoHookean, ContactLaw::Frictionless);
    let mut press = Press::new(&setup, mesh(&GEL, 5.5, 0.75, 1.6), &punch, [0.0, 0.0]).unwrap();
    let pressing = (1..=3).map(|step| deep(0.2 * f64::from(step)));
    let sliding = (1..=3).map(|step| Pose { shear_mm: [0.15 * f64::from(step), 0.0], ..deep(0.6) });
    let iterations: Vec<usize> = pressing
        .chain(sliding)
        .map(|pose| {
            press.step(&pose).unwrap();
            press.report().newton_iterations
        })
        .collect();
    assert!(iterations[..3].iter().all(|&iterations| iterations <= 6), "{iterations:?}");
    assert!(iterations.iter().all(|&iterations| iterations <= 25), "{iterations:?}");
}

#[test]
fn a_deep_face_without_friction_neither_folds_nor_tears() {
    let punch = Punch { radius_mm: 3.0 };
    let setup = setup(GEL, Law::NeoHookean, ContactLaw::Frictionless);
    let mut press = Press::new(&setup, mesh(&GEL, 4.5, 0.6, 1.5), &punch, [0.0, 0.0]).unwrap();
    for step in 1..=5 {
        press.step(&deep(0.52 * f64::from(step))).unwrap();
    }
    let state = press.surface();
    assert!(state.force_n[0].hypot(state.force_n[1]) < 1e-3 * state.force_n[2], "{:?} N", state.force_n);
    // The face neither folds nor tears: cells keep three quarters of their width, and none grows by half.
    let columns = state.x_mm.len();
    for (row, y) in state.y_mm.iter().enumerate() {
        for (column, x) in state.x_mm.iter().enumerate().filter(|(_, x)| x.hypot(*y) < 2.5) {
            let at = |column: usize| state.x_mm[column] + state.displacement_mm[row * columns + column][0];
            let share = (at(column) - at(column - 1)) / (x - state.x_mm[column - 1]);
            assert!((0.75..1.5).contains(&share), "({x}, {y}): a cell has {share} of its width");
        }
    }
}

#[test]
fn friction_carries_its_coefficient_times_the_normal_force() {
    let (punch, coefficient) = (Punch { radius_mm: 4.0 }, 0.3);
    let setup = setup(GEL, Law::NeoHookean, ContactLaw::Friction(coefficient));
    let mut press = Press::new(&setup, mesh(&GEL, 5.0, 0.9, 1.5), &punch, [0.0, 0.0]).unwrap();
    press.step(&deep(0.15)).unwrap();
    let mut ratio = 0.0;
    for step in 1..=6 {
        let pose = Pose { shear_mm: [0.15 * f64::from(step), 0.0], ..deep(0.15) };
        let force = press.step(&pose).unwrap().force_n;
        ratio = force[0] / force[2];
    }
    assert!((ratio / coefficient - 1.0).abs() < 0.02, "shear over normal force: {ratio}");
}

#[test]
fn torque_is_about_the_centre_of_contact_and_not_the_indenters_origin() {
    let indenter = Beside { punch: Punch { radius_mm: 2.0 }, to_the_right_mm: 3.0 };
    let setup = setup(GEL, Law::NeoHookean, ContactLaw::Stick);
    let mut press = Press::new(&setup, mesh(&GEL, 6.0, 1.0, 1.5), &indenter, [-3.0, 0.0]).unwrap();
    press.step(&deep(0.4)).unwrap();
    let state = press.step(&Pose { shear_mm: [0.0, 0.4], ..deep(0.4) }).unwrap();
    let arm_mm = state.torque_nmm[2] / state.force_n[1];
    assert!(state.force_n[1] > 0.5 && arm_mm.abs() < 0.3, "{:?} N, an arm of {arm_mm} mm", state.force_n);
}

#[test]
fn a_stuck_face_turns_the_gel_with_it() {
    let punch = Punch { radius_mm: 3.0 };
    let setup = setup(GEL, Law::NeoHookean, ContactLaw::Stick);
    let mut press = Press::new(&setup, mesh(&GEL, 4.0, 1.0, 1.5), &punch, [1.0, -2.0]).unwrap();
    press.step(&deep(0.5)).unwrap();
    let state = press.step(&Pose { twist_rad: 0.1, ..deep(0.5) }).unwrap();
    assert!(state.torque_nmm[2] > 1.0, "{:?}", state.torque_nmm);
    let nodes = state.y_mm.iter().flat_map(|y| state.x_mm.iter().map(move |x| [x - 1.0, y + 2.0]));
    for ([x, y], displacement) in nodes.zip(&state.displacement_mm).filter(|([x, y], _)| x.hypot(*y) < 2.9) {
        let turned = [x * 0.1_f64.cos() - y * 0.1_f64.sin() - x, x * 0.1_f64.sin() + y * 0.1_f64.cos() - y];
        for c in 0..2 {
            assert!((displacement[c] - turned[c]).abs() < 0.01, "({x}, {y}): {displacement:?}, {turned:?}");
        }
    }
}

#[test]
fn a_face_that_sticks_late_keeps_the_strain_of_its_first_step() {
    let (punch, gel) = (Punch { radius_mm: 3.0 }, GelBlock { poissons_ratio: 0.35, ..GEL });
    let shifts = |contact: ContactLaw, depths_mm: &[f64]| {
        let mut press =
            Press::new(&setup(gel, Law::NeoHookean, contact), mesh(&gel, 4.0, 0.75, 1.5), &punch, [0.0; 2]).unwrap();
        let (last, before) = depths_mm.split_last().unwrap();
        for &depth_mm in before {
            press.step(&deep(depth_mm)).unwrap();
        }
        let state = press.step(&deep(*last)).unwrap();
        let nodes = state.y_mm.iter().flat_map(|y| state.x_mm.iter().map(move |x| [*x, *y]));
        let inner = nodes.zip(&state.displacement_mm).filter(|([x, y], _)| x.hypot(*y) < 2.5);
        inner.map(|(at, moved)| (at[0] * moved[0] + at[1] * moved[1]) / 2.5).collect::<Vec<f64>>()
    };
    let first = shifts(ContactLaw::LateStick, &[0.2]);
    for (late, free) in first.iter().zip(shifts(ContactLaw::Frictionless, &[0.2])) {
        assert!((late - free).abs() < 1e-4, "{late} mm, {free} mm without friction");
    }
    // At this ratio gel is drawn inwards under a face.
    let inwards = first.iter().copied().fold(0.0, f64::min);
    assert!(inwards < -0.005, "{inwards} mm");
    for (late, first) in shifts(ContactLaw::LateStick, &[0.2, 0.6, 1.2]).iter().zip(&first) {
        assert!((late - first).abs() < 1e-4, "{late} mm at the end, {first} mm after the first step");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let punch = Punch { radius_mm: 4.0 };
    let press_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let setup = setup(GEL, Law::NeoHookean, ContactLaw::Stick);
            let mut press = Press::new(&setup, mesh(&GEL, 5.0, 1.5, 1.6), &punch, [0.0, 0.0]).unwrap();
            press.step(&deep(0.3)).unwrap().clone()
        })
    };
    assert_eq!(press_with(1), press_with(3));
}

#[test]
fn what_can_not_be_is_refused() {
    let punch = Punch { radius_mm: 4.0 };
    let small = || mesh(&GEL, 5.0, 2.5, 1.8);
    let bad = setup(GelBlock { poissons_ratio: 0.5, ..GEL }, Law::Linear, ContactLaw::Stick);
    assert!(matches!(Press::new(&bad, small(), &punch, [0.0; 2]), Err(PressError::Block(_))));
    let bad = setup(GEL, Law::Linear, ContactLaw::Friction(-0.1));
    let error = Press::new(&bad, small(), &punch, [0.0; 2]).unwrap_err();
    assert_eq!(error.to_string(), "friction is -0.1: a finite coefficient above 0 is allowed");
    let good = setup(GEL, Law::NeoHookean, ContactLaw::Stick);
    let mut press = Press::new(&good, small(), &punch, [0.0; 2]).unwrap();
    assert!(matches!(press.step(&deep(f64::NAN)), Err(PressError::Pose { .. })));
    // Through the base: the press says how far it came and stays there.
    let Err(PressError::Stalled { reached_mm, .. }) = press.step(&deep(12.0)) else {
        panic!("pressed through the base")
    };
    assert!((0.0..10.0).contains(&reached_mm));
    assert!(press.step(&deep(0.9 * reached_mm)).is_ok());
}

#[test]
fn a_flat_punch_agrees_with_the_layer() {
    for (nu, tolerance) in [(0.35, 0.02), (0.48, 0.03)] {
        let block =
            GelBlock { size_mm: [80.0, 80.0], thickness_mm: 10.0, poissons_ratio: nu, youngs_modulus_mpa: Some(0.6) };
        let grid = SurfaceGrid { columns: 80, rows: 80, cell_mm: 8.0 / 72.0 };
        let region: Vec<bool> = grid.centres_mm().map(|[x, y]| x.hypot(y) < 4.0).collect();
        let depth = 0.01;
        let mut layer = LayerContact::new(&Layer::new(&block).unwrap(), grid).unwrap();
        let params = ContactParams::default();
        let wanted: Vec<f64> = region.iter().map(|in_face| if *in_face { depth } else { f64::NEG_INFINITY }).collect();
        let free = layer.press_frictionless(&wanted, &params).force_n[2];
        let moved: Vec<_> = region.iter().map(|in_face| [0.0, 0.0, if *in_face { depth } else { 0.0 }]).collect();
        let stuck = layer.press_stuck(&region, &moved, &params).force_n[2];
        for (contact, expected) in [(ContactLaw::Frictionless, free), (ContactLaw::Stick, stuck)] {
            let punch = Punch { radius_mm: 4.0 };
            let setup = setup(block, Law::Linear, contact);
            let mut press = Press::new(&setup, mesh(&block, 4.2, 0.2, 1.4), &punch, [0.0, 0.0]).unwrap();
            let force = press.step(&deep(depth)).unwrap().force_n[2];
            assert!((force / expected - 1.0).abs() < tolerance, "ν {nu}, {contact:?}: {force} N, layer {expected} N");
        }
    }
}
