//! Presses into a linear block of a known gel. Their measurements are computed with the same elasticity, on cells of
//! half the width.

use fingervision_elastic::{BlockOperator, GelBlock, SurfaceGrid};
use fingervision_touch::{Cells, Limits, Seen, Strain, Tractions};

use super::look::{Known, Look};
use super::{GelFitError, GelPress, GelReport, Unknowns, fit_determined};

const GEL: GelBlock =
    GelBlock { size_mm: [20.0, 20.0], thickness_mm: 10.0, poissons_ratio: 0.45, youngs_modulus_mpa: Some(0.3) };
const GRID: SurfaceGrid = SurfaceGrid { columns: 80, rows: 80, cell_mm: 0.25 };
const ALL: Unknowns = Unknowns { poissons_ratio: true, thickness: true, youngs_modulus: true };
const DISTANCE_MM: f64 = 20.0;

/// The measurement of a gel that sticks to a disc, pressed 0.5 mm deep, with the force on it.
struct Pressed {
    seen: Vec<Seen>,
    touches: Vec<bool>,
    depth_mm: Vec<f32>,
    force_n: f64,
}

fn press(radius_mm: f64, [x, y]: [f64; 2]) -> Pressed {
    let mut tractions = Tractions::new(BlockOperator::new(&GEL, GRID).unwrap());
    let touches: Vec<bool> = GRID.centres_mm().map(|[i, j]| (i - x).hypot(j - y) < radius_mm).collect();
    let limits = Limits { tolerance: 1e-4, most_iterations: 100 };
    tractions.hold(&touches, &vec![[0.0, 0.0, 0.5]; GRID.len()], limits);
    let moved = tractions.displacement_mm();
    let see = |([x, y], [u, v, depth]): ([f64; 2], &[f32; 3])| {
        let slope = [x, y].map(|at| (at / DISTANCE_MM) as f32);
        Seen { apparent_mm: [u + slope[0] * depth, v + slope[1] * depth], slope, trust: 1.0, deviation_mm: 0.0 }
    };
    let pushed: f64 = tractions.traction().iter().map(|traction| f64::from(traction[2])).sum();
    let shear_mpa = 0.3 / (2.0 * (1.0 + GEL.poissons_ratio));
    let [_, _, stiffened] = Strain::of(GRID, &touches, moved, GEL.thickness_mm).stiffening();
    Pressed {
        seen: GRID.centres_mm().zip(moved).map(see).collect(),
        depth_mm: moved.iter().map(|[_, _, depth]| *depth).collect(),
        touches,
        force_n: stiffened * shear_mpa * pushed * GRID.cell_area_mm2(),
    }
}

fn look(pressed: &Pressed, press: usize, gel: &GelBlock, force_n: Option<f64>) -> Look {
    let Pressed { seen, touches, depth_mm, .. } = pressed;
    let cells = Cells { grid: GRID, seen, without_drag: None, touches, depth_mm, mm_per_px: 0.06 };
    Look::new(&cells, Known { press, frame: 0, depth_mm: 0.5, force_n }, gel).unwrap()
}

fn fit(start: GelBlock, unknowns: Unknowns, has_forces: bool) -> Result<GelReport, GelFitError> {
    fit_to(&presses(), start, unknowns, has_forces)
}

fn presses() -> [Pressed; 2] {
    [press(2.0, [0.0, 0.0]), press(1.5, [3.0, -2.0])]
}

fn fit_to(
    pressed: &[Pressed],
    start: GelBlock,
    unknowns: Unknowns,
    has_forces: bool,
) -> Result<GelReport, GelFitError> {
    let find = |gel: &GelBlock| {
        let force = |pressed: &Pressed| has_forces.then_some(pressed.force_n);
        Ok(pressed.iter().enumerate().map(|(n, pressed)| look(pressed, n, gel, force(pressed))).collect())
    };
    let press = |name: &str| GelPress { name: name.into(), frames: Vec::new(), size: (1, 1), was_released: false };
    fit_determined(&[press("a"), press("b")], start, unknowns, find)
}

#[test]
fn the_gel_is_recovered_from_a_start_far_off() {
    let start = GelBlock { thickness_mm: 11.5, poissons_ratio: 0.37, youngs_modulus_mpa: Some(0.6), ..GEL };
    let report = fit(start, ALL, true).unwrap();
    let [ratio, thickness, modulus] = [0, 1, 2].map(|i| report.estimates[i].value.unwrap());
    assert!((ratio - 0.45).abs() < 0.01, "Poisson's ratio {ratio}, {report}");
    assert!((thickness / 10.0 - 1.0).abs() < 0.02, "thickness {thickness} mm, {report}");
    assert!((modulus / 0.3 - 1.0).abs() < 0.03, "Young's modulus {modulus} MPa, {report}");
    assert!(report.unexplained < 0.2 * report.unexplained_before, "{report}");
    let table = report.table().unwrap();
    assert_eq!(
        [table.poissons_ratio, table.thickness_mm, table.youngs_modulus_mpa],
        [Some(ratio), Some(thickness), Some(modulus)]
    );
    let map = &report.residual;
    assert_eq!(map.unexplained.len(), map.poissons_ratios.len() * map.thicknesses_mm.len());
    assert!(map.unexplained.iter().all(|node| *node > 0.999 * report.unexplained), "no gel is better: {map:?}");
}

#[test]
fn fixed_values_stay_and_without_forces_the_modulus_is_unchanged() {
    let start = GelBlock { poissons_ratio: 0.4, youngs_modulus_mpa: None, ..GEL };
    let unknowns = Unknowns { thickness: false, youngs_modulus: false, ..ALL };
    let report = fit(start, unknowns, false).unwrap();
    let table = report.table().unwrap();
    assert!((table.poissons_ratio.unwrap() - 0.45).abs() < 0.01, "{report}");
    assert_eq!((table.thickness_mm, table.youngs_modulus_mpa), (None, None));
    assert!(
        report.estimates[1].remark.contains("fixed") && report.estimates[2].remark.contains("no forces"),
        "{report}"
    );
}

#[test]
fn undetermined_values_are_fixed_while_the_rest_is_fitted() {
    let start = GelBlock { thickness_mm: 10.8, poissons_ratio: 0.43, youngs_modulus_mpa: Some(0.6), ..GEL };
    // A wide contact leaves little around it: Poisson's ratio and thickness change that in the same way.
    let wide = [press(5.0, [0.0, 0.0])];
    let report = fit_to(&wide, start, ALL, true).unwrap();
    assert!(report.estimates[..2].iter().all(|estimate| estimate.remark.contains("in the same way")), "{report}");
    let forces_alone = Unknowns { youngs_modulus: true, ..Unknowns::NONE };
    let held = fit_to(&wide, start, forces_alone, true).unwrap();
    assert!(held.estimates[0].remark.contains("fixed"), "{held}");
    assert_eq!(report.table(), held.table());
    assert!(report.table().unwrap().youngs_modulus_mpa.is_some(), "{report}");
}

#[test]
fn motion_that_no_gel_makes_is_refused_with_what_to_check() {
    let mut pressed = presses();
    for pressed in &mut pressed {
        for (seen, [_, y]) in pressed.seen.iter_mut().zip(GRID.centres_mm()) {
            seen.apparent_mm[0] += 0.1 * y.sin() as f32;
        }
    }
    let error = fit_to(&pressed, GEL, ALL, true).unwrap_err();
    assert!(matches!(error, GelFitError::Misfit { .. } | GelFitError::Open { .. }), "{error}");
    assert!(error.hint().is_some_and(|hint| hint.contains("check the depths")), "{:?}", error.hint());
}

#[test]
fn a_contact_as_wide_as_the_gel_leaves_nothing_around_it() {
    let wide = press(8.0, [0.0, 0.0]);
    assert!(look(&wide, 0, &GEL, None).around.len() < super::THRESHOLDS.least_around);
    let small = press(2.5, [0.0, 0.0]);
    assert!(look(&small, 0, &GEL, None).around.len() > super::THRESHOLDS.least_around);
}

#[test]
fn depths_in_contact_are_brought_to_the_known_one() {
    let mut pressed = press(2.5, [0.0, 0.0]);
    for depth in &mut pressed.depth_mm {
        *depth *= 0.8;
    }
    let look = look(&pressed, 0, &GEL, None);
    assert!((look.found_mm - 0.4).abs() < 1e-3, "{}", look.found_mm);
    let deepest = look.held_mm.iter().zip(&look.touches).filter(|(_, touches)| **touches).map(|(held, _)| held[2]);
    let deepest = deepest.fold(0.0, f32::max);
    assert!((deepest - 0.5).abs() < 5e-3, "{deepest} mm");
}
