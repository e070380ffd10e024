//! Every shape against its definition.

use std::path::Path;

use fingervision_elastic::{GelBlock, Relief, ReliefPoint};

use super::{Indenter, IndenterRelief, IndenterShape};

const GEL: GelBlock =
    GelBlock { size_mm: [30.0, 30.0], thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: None };

pub(super) fn relief(shape: IndenterShape) -> IndenterRelief {
    Indenter::new(shape).relief(Path::new(".")).unwrap()
}

/// Points all over a square of this half-width, mm.
pub(super) fn points(half_mm: f64, count: u32) -> impl Iterator<Item = [f64; 2]> {
    (1..=count).map(move |n| [0.618_034, 0.754_878].map(|step| 2.0 * half_mm * ((f64::from(n) * step).fract() - 0.5)))
}

/// Slope and curvature at a point against differences of height and slope.
pub(super) fn assert_derivatives(at: impl Fn([f64; 2]) -> ReliefPoint, point: [f64; 2], tolerance: f64) {
    let step = 1e-6;
    let here = at(point);
    let [xx, xy, yy] = here.curvature_per_mm;
    for (axis, bend) in [(0, [xx, xy]), (1, [xy, yy])] {
        let beside = |sign: f64| at([0, 1].map(|n| point[n] + if n == axis { sign * step } else { 0.0 }));
        let (before, after) = (beside(-1.0), beside(1.0));
        let slope = (after.height_mm - before.height_mm) / (2.0 * step);
        assert!((here.slope[axis] - slope).abs() < tolerance, "slope at {point:?}: {here:?} but {slope}");
        for other in 0..2 {
            let curve = (after.slope[other] - before.slope[other]) / (2.0 * step);
            let scale = 1.0 + curve.abs();
            assert!((bend[other] - curve).abs() < tolerance * scale, "curvature at {point:?}: {here:?} but {curve}");
        }
    }
}

fn shapes() -> Vec<IndenterShape> {
    vec![
        IndenterShape::Circle { radius_mm: 4.0 },
        IndenterShape::Rectangle { size_mm: [10.0, 5.0] },
        IndenterShape::Triangle { side_mm: 8.0 },
        IndenterShape::Polygon { points_mm: l_shape() },
        IndenterShape::Crossing { bar_mm: [12.0, 2.4] },
        IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 },
        IndenterShape::Sphere { radius_mm: 6.0 },
        IndenterShape::Pins { radius_mm: 0.6, centres_mm: vec![[-3.0, -2.0], [0.0, 2.5], [3.0, -1.0]] },
        IndenterShape::Letter { text: "A".into(), height_mm: 7.0 },
        IndenterShape::Letter { text: "g8".into(), height_mm: 6.0 },
    ]
}

fn l_shape() -> Vec<[f64; 2]> {
    vec![[-3.0, -4.0], [0.0, -4.0], [0.0, 1.0], [4.0, 1.0], [4.0, 3.5], [-3.0, 3.5]]
}

/// The height that the definition gives at a distance from the face, with the usual fillet and wall.
fn height_at(d: f64) -> f64 {
    let (r, s) = (0.3_f64, 3.0_f64);
    let from = r * s / (1.0 + s * s).sqrt();
    if d <= from { r - (r * r - d * d).sqrt() } else { r - (r * r - from * from).sqrt() + s * (d - from) }
}

/// Whether a point lies in a shape, said once more in the plainest way.
fn is_in(shape: &IndenterShape, [x, y]: [f64; 2]) -> bool {
    match shape {
        IndenterShape::Circle { radius_mm } => x.hypot(y) <= *radius_mm,
        IndenterShape::Rectangle { size_mm: [a, b] } => 2.0 * x.abs() <= *a && 2.0 * y.abs() <= *b,
        IndenterShape::Triangle { side_mm } => {
            let (base, side) = (side_mm / 12.0_f64.sqrt(), side_mm / 3.0_f64.sqrt());
            y <= base && y >= 3.0_f64.sqrt() * x.abs() - side
        }
        IndenterShape::Polygon { .. } => {
            (-3.0..=0.0).contains(&x) && (-4.0..=3.5).contains(&y)
                || (-3.0..=4.0).contains(&x) && (1.0..=3.5).contains(&y)
        }
        IndenterShape::Crossing { bar_mm: [l, w] } => {
            let [x, y] = [2.0 * x.abs(), 2.0 * y.abs()];
            x <= *l && y <= *w || x <= *w && y <= *l
        }
        IndenterShape::Ring { inner_radius_mm, outer_radius_mm } => {
            (*inner_radius_mm..=*outer_radius_mm).contains(&x.hypot(y))
        }
        IndenterShape::Pins { radius_mm, centres_mm } => {
            centres_mm.iter().any(|[u, v]| (x - u).hypot(y - v) <= *radius_mm)
        }
        other => panic!("{other:?} has no plain form"),
    }
}

#[test]
fn heights_follow_from_the_distance_to_the_face() {
    let step = 0.02;
    for shape in shapes()
        .into_iter()
        .filter(|shape| !matches!(shape, IndenterShape::Sphere { .. } | IndenterShape::Letter { .. }))
    {
        let relief = relief(shape.clone());
        let lattice = (-350..=350).flat_map(|row| (-350..=350).map(move |column| [column, row].map(f64::from)));
        let lattice = lattice.map(|place| place.map(|value| value * step));
        let face: Vec<_> = lattice.filter(|&point| is_in(&shape, point)).collect();
        for point in points(8.0, 120) {
            assert_eq!(relief.is_face(point[0], point[1]), is_in(&shape, point), "{shape:?} at {point:?}");
            let brute = face.iter().map(|face| (face[0] - point[0]).hypot(face[1] - point[1])).fold(f64::MAX, f64::min);
            let brute = if is_in(&shape, point) { 0.0 } else { brute };
            let height = relief.at(point[0], point[1]).height_mm;
            // The lattice misses the face's border by up to a diagonal of its step.
            let range = height_at((brute - 1.5 * step).max(0.0))..=height_at(brute) + 1e-9;
            assert!(range.contains(&height), "{shape:?} at {point:?}: {height}, not in {range:?}");
        }
    }
}

#[test]
fn heights_beside_straight_and_round_edges_are_exact() {
    let check = |shape: IndenterShape, point: [f64; 2], distance: f64| {
        let relief = relief(shape.clone());
        let (height, expected) = (relief.at(point[0], point[1]).height_mm, height_at(distance));
        assert!((height - expected).abs() < 1e-12, "{shape:?} at {point:?}: {height} instead of {expected}");
    };
    for d in [0.0, 0.1, 0.28, 0.7, 1.2] {
        check(IndenterShape::Circle { radius_mm: 4.0 }, [0.6 * (4.0 + d), 0.8 * (4.0 + d)], d);
        check(IndenterShape::Rectangle { size_mm: [10.0, 5.0] }, [2.0, -2.5 - d], d);
        check(IndenterShape::Rectangle { size_mm: [10.0, 5.0] }, [5.0 + 0.6 * d, 2.5 + 0.8 * d], d);
        check(IndenterShape::Crossing { bar_mm: [12.0, 2.4] }, [6.0 + d, 1.0], d);
        check(IndenterShape::Crossing { bar_mm: [12.0, 2.4] }, [-3.5, 1.2 + d], d);
        check(IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 }, [0.0, 2.5 - d], d);
        check(IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 }, [-4.0 - d, 0.0], d);
    }
    // In the triangle's corner at the top, and the middle of a ring.
    check(IndenterShape::Triangle { side_mm: 8.0 }, [0.0, -8.0 / 3.0_f64.sqrt() - 0.4], 0.4);
    check(IndenterShape::Ring { inner_radius_mm: 2.5, outer_radius_mm: 4.0 }, [0.0, 0.0], 2.5);
}

#[test]
fn a_sphere_is_round_until_its_wall_begins() {
    let relief = relief(IndenterShape::Sphere { radius_mm: 6.0 });
    let from = 18.0 / 10.0_f64.sqrt();
    for point in points(9.0, 200) {
        let rho = point[0].hypot(point[1]);
        let cap = |rho: f64| 6.0 - (36.0 - rho * rho).sqrt();
        let expected = if rho <= from { cap(rho) } else { cap(from) + 3.0 * (rho - from) };
        let height = relief.at(point[0], point[1]).height_mm;
        assert!((height - expected).abs() < 1e-12, "{point:?}: {height} instead of {expected}");
    }
    assert_derivatives(|[x, y]| relief.at(x, y), [0.0, 0.0], 1e-6);
}

#[test]
fn slopes_and_curvatures_are_the_derivatives_of_the_height() {
    for shape in shapes() {
        let relief = relief(shape.clone());
        let at = |[x, y]: [f64; 2]| relief.at(x, y);
        // Leave out what lies across a jump of the curvature or a ridge: there neighbours differ by more than they do
        // on a smooth part, by some 1e-4 mm times the relative change of the curvature, at most 100/mm.
        let is_smooth = |point: [f64; 2]| {
            let near = (0..8)
                .map(|n| (f64::from(n) * 0.785).sin_cos())
                .map(|(sin, cos)| at([point[0] + 1e-4 * cos, point[1] + 1e-4 * sin]).curvature_per_mm);
            let here = at(point).curvature_per_mm;
            near.into_iter().all(|near| (0..3).all(|n| (near[n] - here[n]).abs() < 0.02 * (1.0 + here[n].abs())))
        };
        let smooth: Vec<_> = points(7.0, 3000).filter(|&point| is_smooth(point)).collect();
        assert!(smooth.len() > 2600, "{shape:?}: {} of 3000 smooth", smooth.len());
        let at_ridge = |point: [f64; 2]| {
            let beside = [[2e-6, 0.0], [0.0, 2e-6]].map(|[x, y]| at([point[0] + x, point[1] + y]).slope);
            beside.iter().any(|slope| (0..2).any(|n| (slope[n] - at(point).slope[n]).abs() > 1e-3))
        };
        for point in smooth.into_iter().filter(|&point| !at_ridge(point)) {
            assert_derivatives(at, point, 1e-6);
        }
    }
}

#[test]
fn no_slope_exceeds_the_wall() {
    for shape in shapes() {
        let relief = relief(shape.clone());
        for point in points(9.0, 5000) {
            let here = relief.at(point[0], point[1]);
            assert!(here.slope[0].hypot(here.slope[1]) <= 3.0 + 1e-12, "{shape:?} at {point:?}: {here:?}");
            let other = [point[1], -0.7 * point[0]];
            let change = (relief.at(other[0], other[1]).height_mm - here.height_mm).abs();
            let way = (other[0] - point[0]).hypot(other[1] - point[1]);
            assert!(change <= 3.0 * way + 1e-12, "{shape:?}: {point:?} to {other:?}: {change} over {way} mm");
        }
    }
}

#[test]
fn the_fillet_joins_the_face_without_a_kink() {
    for shape in shapes() {
        let relief = relief(shape.clone());
        // From the face outwards: the first point off it is as flat as the face.
        for point in points(7.0, 3000) {
            let here = relief.at(point[0], point[1]);
            let slope = here.slope[0].hypot(here.slope[1]);
            let bound = (2.0 * here.height_mm / 0.3).sqrt() + 1e-9;
            assert!(slope <= bound * 1.5 || here.height_mm > 0.05, "{shape:?} at {point:?}: {here:?}");
            assert!(here.height_mm > 0.0 || slope == 0.0, "{shape:?} at {point:?}: {here:?}");
        }
    }
}

#[test]
fn footprints_hold_what_they_say() {
    for rotation_rad in [0.0, 0.4] {
        for shape in shapes() {
            let indenter = Indenter { rotation_rad, ..Indenter::new(shape.clone()) };
            let relief = indenter.relief(Path::new(".")).unwrap();
            let [[left, right], [top, bottom]] = relief.footprint_mm(3.0);
            let half = relief.half_extent_mm();
            let expected = [right.max(-left), bottom.max(-top)];
            assert!((0..2).all(|axis| (half[axis] - expected[axis]).abs() < 1e-12), "{half:?} and {expected:?}");
            for point in points(12.0, 5000).filter(|point| relief.at(point[0], point[1]).height_mm <= 3.0) {
                let is_held = (left..=right).contains(&point[0]) && (top..=bottom).contains(&point[1]);
                assert!(is_held, "{shape:?}: {point:?} beyond {half:?}");
            }
            // The box is tight: the body comes near each of its sides.
            let rim = |x: f64, y: f64| relief.at(x, y).height_mm <= 3.2;
            let sweep = |n: i32| f64::from(n) / 500.0;
            assert!((0..=500).any(|n| rim(left, top + sweep(n) * (bottom - top))), "{shape:?} left");
            assert!((0..=500).any(|n| rim(left + sweep(n) * (right - left), bottom)), "{shape:?} bottom");
        }
    }
}

#[test]
fn a_rotation_turns_from_x_towards_y() {
    let bar = IndenterShape::Rectangle { size_mm: [10.0, 1.0] };
    let relief = Indenter { rotation_rad: 0.5, ..Indenter::new(bar) }.relief(Path::new(".")).unwrap();
    let (sin, cos) = 0.5_f64.sin_cos();
    assert!(relief.is_face(4.5 * cos, 4.5 * sin) && !relief.is_face(4.5 * cos, -4.5 * sin));
}

#[test]
fn an_indenter_that_does_not_fit_is_refused() {
    let on = |shape: IndenterShape, centre: [f64; 2]| {
        Indenter::new(shape).relief_on(&GEL, centre, Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    };
    let wide = on(IndenterShape::Circle { radius_mm: 20.0 }, [0.0; 2]).unwrap_err();
    assert_eq!(
        wide,
        "indenter.radius_mm = 20: the indenter is 42.432 by 42.432 mm wide 3 mm behind its foremost point, the gel 30 by 30 mm"
    );
    let off = on(IndenterShape::Rectangle { size_mm: [6.0, 6.0] }, [13.0, 0.0]).unwrap_err();
    assert!(off.starts_with("motion.centre_mm = [13.0, 0.0]: the indenter's face reaches from x 9.776"), "{off}");
    assert_eq!(on(IndenterShape::Rectangle { size_mm: [6.0, 6.0] }, [11.5, -11.5]), Ok(()));
    assert_eq!(on(IndenterShape::Sphere { radius_mm: 6.0 }, [12.0, 0.0]), Ok(()));
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    let refusal = |shape: IndenterShape| Indenter::new(shape).validate().unwrap_err().to_string();
    assert_eq!(
        refusal(IndenterShape::Circle { radius_mm: 0.0 }),
        "indenter.radius_mm = 0.0 is impossible: it must be a length of 0.01 to 1000 mm"
    );
    assert!(refusal(IndenterShape::Sphere { radius_mm: f64::NAN }).contains("radius_mm = NaN"));
    assert!(refusal(IndenterShape::Rectangle { size_mm: [1.0, -2.0] }).contains("size_mm = [1.0, -2.0]"));
    assert!(refusal(IndenterShape::Triangle { side_mm: f64::INFINITY }).contains("side_mm = inf"));
    assert!(refusal(IndenterShape::Crossing { bar_mm: [2.0, 2.0] }).contains("a length and a smaller width"));
    let ring = IndenterShape::Ring { inner_radius_mm: 4.0, outer_radius_mm: 3.0 };
    assert!(refusal(ring).contains("inner_radius_mm = 4.0 is impossible: it must be less than the outer radius, 3 mm"));
    let no_pin = IndenterShape::Pins { radius_mm: 1.0, centres_mm: vec![] };
    assert!(refusal(no_pin).contains("centres_mm = []"));
    for text in ["", " \t", &"A".repeat(33)] {
        assert!(refusal(IndenterShape::Letter { text: text.into(), height_mm: 5.0 }).contains("indenter.text"));
    }
    assert!(refusal(IndenterShape::Letter { text: "A".into(), height_mm: -1.0 }).contains("height_mm = -1.0"));
    let sharp = Indenter { fillet_mm: 0.0, ..Indenter::default() };
    assert!(sharp.validate().unwrap_err().to_string().contains("fillet_mm = 0.0"));
    let level = Indenter { wall_slope: f64::NAN, ..Indenter::default() };
    assert!(level.validate().unwrap_err().to_string().contains("wall_slope = NaN"));
    let turned = Indenter { rotation_rad: f64::INFINITY, ..Indenter::default() };
    assert!(turned.validate().unwrap_err().to_string().contains("rotation_rad = inf"));
}

#[test]
fn a_polygon_that_meets_itself_is_refused() {
    let refusal = |points: &[[f64; 2]]| {
        let indenter = Indenter::new(IndenterShape::Polygon { points_mm: points.into() });
        indenter.validate().unwrap_err().to_string()
    };
    let bow = refusal(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    assert!(bow.contains("edge 0 and edge 2 meet: [0.0, 0.0] to [2.0, 2.0]"), "{bow}");
    let touching = refusal(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    assert!(touching.contains("edge 0 and edge 2 meet"), "{touching}");
    let folded = refusal(&[[0.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 3.0]]);
    assert!(folded.contains("edge 0 and edge 1 meet"), "{folded}");
    let flat = refusal(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
    assert!(flat.contains("meet"), "{flat}");
    assert!(refusal(&[[0.0, 0.0], [1.0, 0.0]]).contains("three corners or more"));
    assert!(refusal(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]).contains("0.001 mm apart"));
    assert!(refusal(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]).contains("NaN"));
    assert!(Indenter::new(IndenterShape::Polygon { points_mm: l_shape() }).validate().is_ok());
}
