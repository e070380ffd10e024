//! Motion that is a known multiple of what the tractions cause.

use super::*;

const NOISE_MM: f64 = 0.0025;

/// Cells around contact: the force is `force` times, shear `shear` times that of the tractions.
fn far(force: f32, shear: f32) -> FarField {
    let mut far = FarField::default();
    for cell in 0..400_u16 {
        let [x, y] = [cell % 20, cell / 20].map(|at| 0.7 * (f32::from(at) - 9.5));
        let fall = 0.05 / (1.0 + 0.05 * (x * x + y * y));
        let (normal, along) = ([x * fall, y * fall, -0.2 * fall], [2.0 * fall, 0.1 * x * fall, x * fall]);
        let all = [0, 1, 2].map(|axis| normal[axis] + along[axis]);
        let slope = [0.03 * x, 0.03 * y];
        let apparent = |moved: [f32; 3], axis: usize| moved[axis] + slope[axis] * moved[2];
        let apparent_mm = [0, 1].map(|axis| force * apparent(normal, axis) + shear * apparent(along, axis));
        far.add(&Seen { apparent_mm, slope, trust: 1.0, deviation_mm: 0.001 }, all, normal);
    }
    far
}

fn is(found: f64, wanted: f64) -> bool {
    (found - wanted).abs() < 1e-12
}

#[test]
fn the_force_of_the_motion_counts_the_more_the_less_depth_is_known() {
    for force in [0.8, 1.2] {
        let far = far(force, 1.0);
        let [unknown, usual, known] = [1.0, 0.05, 0.001].map(|of| far.correction(Strain::default(), of, NOISE_MM));
        let force = f64::from(force);
        assert!((unknown - force).abs() < 0.01 && (known - 1.0).abs() < 0.01, "{unknown} {known} of {force}");
        assert!((usual - 1.0).abs() > 0.3 * (force - 1.0).abs() && (usual - 1.0).abs() < 0.9 * (force - 1.0).abs());
    }
}

#[test]
fn wrong_shear_hardly_changes_the_force() {
    for shear in [0.9, 1.1] {
        let found = far(1.0, shear).correction(Strain::default(), 1.0, NOISE_MM);
        assert!((found - 1.0).abs() < 0.02, "{found} at {shear} times the shear");
    }
}

#[test]
fn narrow_or_dragged_contact_is_corrected_for_strain() {
    let far = far(1.0, 1.0);
    let narrow = far.correction(Strain { narrowness: 0.1, ..Strain::default() }, 1.0, NOISE_MM);
    let dragged = far.correction(Strain { drag: 0.5, ..Strain::default() }, 1.0, NOISE_MM);
    assert!((narrow - 1.028).abs() < 2e-3 && (dragged - 0.896).abs() < 2e-3, "{narrow} {dragged}");
}

#[test]
fn beyond_the_fitted_presses_the_strain_does_not_grow() {
    let of = |times: f64| {
        let strain = Strain { narrowness: times, drag: 3.0 * times, ..Strain::default() };
        far(1.0, 1.0).correction(strain, 1e6, NOISE_MM)
    };
    assert!((of(1.0) - of(2.0)).abs() < 1e-6, "{} {}", of(1.0), of(2.0));
}

#[test]
fn where_nothing_moves_or_little_is_seen_the_force_stays() {
    assert!(is(FarField::default().correction(Strain::default(), 1.0, NOISE_MM), 1.0));
    let mut few = FarField::default();
    for _ in 0..99 {
        few.add(&Seen { apparent_mm: [0.1; 2], ..Seen::default() }, [0.05; 3], [0.05; 3]);
    }
    assert!(is(few.correction(Strain::default(), 1.0, NOISE_MM), 1.0));
    for deviation in [f64::NAN, f64::INFINITY] {
        assert!(is(far(1.2, 1.0).correction(Strain::default(), deviation, NOISE_MM), 1.0));
    }
    let backwards = far(-1.0, 1.0).correction(Strain::default(), 1.0, NOISE_MM);
    assert!(is(backwards, 1.0), "the gel moves as if it were pulled: the force by depth remains");
    let far_off = far(5.0, 1.0).correction(Strain::default(), 1.0, NOISE_MM);
    assert!(is(far_off, MOST), "{far_off}");
    assert!(!FarField::is_telling(0.4) && FarField::is_telling(0.48));
}

#[test]
fn motion_within_the_error_of_the_flow_says_little() {
    let far = far(1.2, 1.0);
    let [clear, hidden] = [NOISE_MM, 200.0 * NOISE_MM].map(|noise_mm| far.correction(Strain::default(), 0.1, noise_mm));
    assert!(clear > 1.1 && hidden < 1.05, "{clear} {hidden}");
}
