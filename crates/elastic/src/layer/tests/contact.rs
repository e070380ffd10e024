use super::circular_punch::force_per_depth;
use super::*;

const FREE: f64 = f64::NEG_INFINITY;

/// Contact on a grid of cells of `radius / cells` that reaches two cells beyond the radius.
fn contact(layer: &Layer, radius_mm: f64, cells: usize) -> LayerContact {
    let count = 2 * cells + 4;
    let grid = SurfaceGrid { columns: count, rows: count, cell_mm: radius_mm / cells as f64 };
    LayerContact::new(layer, grid).unwrap()
}

fn disc(grid: SurfaceGrid, radius_mm: f64) -> Vec<bool> {
    grid.centres_mm().map(|[x, y]| x.hypot(y) < radius_mm).collect()
}

fn flat(region: &[bool], depth_mm: f64) -> Vec<f64> {
    region.iter().map(|&touches| if touches { depth_mm } else { FREE }).collect()
}

#[test]
fn a_flat_circular_punch_meets_its_exact_force() {
    let params = ContactParams::default();
    for nu in [0.0, 0.35, 0.48] {
        for layer in [layer(nu), half_space(nu)] {
            let mut contact = contact(&layer, 4.0, 32);
            let region = disc(contact.grid(), 4.0);
            let free = contact.press_frictionless(&flat(&region, 0.5), &params);
            let held = vec![[0.0, 0.0, 0.5]; region.len()];
            let stuck = contact.press_stuck(&region, &held, &params);
            for (press, expected) in
                [(&free, force_per_depth(&layer, 4.0, false, 12)), (&stuck, force_per_depth(&layer, 4.0, true, 40))]
            {
                assert!(press.has_converged && press.iterations < 20, "{} iterations", press.iterations);
                assert_near(press.force_n[2], 0.5 * expected, 5e-3, &format!("ν {nu}, {layer:?}"));
                assert!(press.force_n[0].abs() + press.force_n[1].abs() < 1e-6);
            }
            check_fields(&free, &region, 0.5);
            check_fields(&stuck, &region, 0.5);
        }
    }
}

fn check_fields(press: &LayerPress, region: &[bool], depth_mm: f64) {
    for (index, touches) in region.iter().enumerate() {
        if *touches {
            assert!((press.displacement_mm[index][2] - depth_mm).abs() < 1e-6 * depth_mm);
        } else {
            assert!(press.traction_mpa[index].iter().all(|value| value.abs() < f64::MIN_POSITIVE));
            assert!(press.displacement_mm[index][2] < depth_mm);
        }
    }
}

#[test]
fn a_stuck_face_moves_as_one() {
    let layer = layer(0.35);
    let mut contact = contact(&layer, 4.0, 16);
    let region = disc(contact.grid(), 4.0);
    // Sideways, and turned about z: the torque of a half-space is 16/3 μ a³ an angle (Reissner, Sagoci), more on a layer.
    let slid = vec![[0.1, 0.0, 0.0]; region.len()];
    let press = contact.press_stuck(&region, &slid, &ContactParams::default());
    assert!(press.has_converged && press.force_n[0] > 0.0 && press.force_n[2].abs() < 1e-6);
    let turned: Vec<_> = contact.grid().centres_mm().map(|[x, y]| [-0.01 * y, 0.01 * x, 0.0]).collect();
    let mut torques = [layer, half_space(0.35)].map(|layer| {
        let mut contact = self::contact(&layer, 4.0, 16);
        let press = contact.press_stuck(&region, &turned, &ContactParams::default());
        for ((displacement, wanted), touches) in press.displacement_mm.iter().zip(&turned).zip(&region) {
            let is_held = (0..3).all(|axis| (displacement[axis] - wanted[axis]).abs() < 1e-7);
            assert!(is_held || !touches);
        }
        let area = contact.grid().cell_area_mm2();
        let centres = contact.grid().centres_mm();
        centres.zip(&press.traction_mpa).map(|([x, y], t)| area * (x * t[1] - y * t[0])).sum::<f64>()
    });
    let expected = 16.0 / 3.0 * layer.shear_modulus_mpa() * 64.0 * 0.01;
    assert_near(torques[1], expected, 2e-2, "torque");
    torques[0] /= torques[1];
    assert!((1.0..1.05).contains(&torques[0]), "a base 10 mm below stiffens by {}", torques[0]);
}

#[test]
fn a_sphere_on_a_half_space_is_that_of_hertz() {
    let (radius, depth) = (10.0, 0.1);
    for nu in [0.0, 0.35, 0.499] {
        let layer = half_space(nu);
        let mut contact = contact(&layer, 1.3, 26);
        let wanted: Vec<_> =
            contact.grid().centres_mm().map(|[x, y]| depth - (x * x + y * y) / (2.0 * radius)).collect();
        let press = contact.press_frictionless(&wanted, &ContactParams::default());
        assert!(press.has_converged && press.regions > 1, "{} regions", press.regions);
        let modulus = 2.0 * layer.shear_modulus_mpa() / (1.0 - nu);
        assert_near(press.force_n[2], 4.0 / 3.0 * modulus * radius.sqrt() * depth.powf(1.5), 1e-2, "force");
        let cells = press.in_contact.iter().filter(|&&touches| touches).count() as f64;
        let contact_radius = (cells * contact.grid().cell_area_mm2() / std::f64::consts::PI).sqrt();
        assert_near(contact_radius, (radius * depth).sqrt(), 1e-2, "contact radius");
        let peak = press.traction_mpa.iter().fold(0.0_f64, |most, t| most.max(t[2]));
        assert_near(peak, 2.0 / std::f64::consts::PI * modulus * (depth / radius).sqrt(), 1e-2, "peak pressure");
        for (index, wanted) in wanted.iter().enumerate() {
            let (pressure, gap) = (press.traction_mpa[index][2], press.displacement_mm[index][2] - wanted);
            assert!(pressure >= 0.0 && gap > -1e-8 && pressure * gap < 1e-8, "cell {index}: {pressure} MPa, {gap} mm");
        }
    }
}

#[test]
fn what_is_not_solved_is_said() {
    let mut contact = contact(&layer(0.35), 4.0, 8);
    let region = disc(contact.grid(), 4.0);
    let hasty = ContactParams { most_iterations: 1, ..ContactParams::default() };
    assert!(!contact.press_frictionless(&flat(&region, 0.5), &hasty).has_converged);
    let held = vec![[f64::NAN; 3]; region.len()];
    assert!(!contact.press_stuck(&region, &held, &ContactParams::default()).has_converged);
    // Out of reach nothing touches, and that is an answer.
    let press = contact.press_frictionless(&flat(&region, -1.0), &ContactParams::default());
    assert!(press.has_converged && press.force_n.iter().all(|force| force.abs() < f64::MIN_POSITIVE));
    // After all that it still works.
    let press = contact.press_frictionless(&flat(&region, 0.5), &ContactParams::default());
    assert_near(press.force_n[2], 0.5 * force_per_depth(&layer(0.35), 4.0, false, 8), 1e-2, "force");
}
