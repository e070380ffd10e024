use crate::{Camera, CameraParams, Distortion, Projection, Radial};

const PINHOLE: CameraParams = CameraParams {
    focal_length_px: [400.0, 400.0],
    principal_point_px: [239.5, 239.5],
    distortion: Distortion { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, radial: Radial::Brown },
    rotation_rad: [0.0; 3],
    translation_mm: [0.0, 0.0, 25.0],
};

/// A skewed camera behind a strong lens: the corners of 640×480 px move by more than 40 px.
const STRONG: CameraParams = CameraParams {
    focal_length_px: [410.0, 395.0],
    principal_point_px: [322.0, 236.0],
    distortion: Distortion { k1: -0.25, k2: 0.06, p1: 0.004, p2: -0.006, radial: Radial::Brown },
    rotation_rad: [0.1, -0.15, 0.3],
    translation_mm: [0.7, -0.4, 25.0],
};

fn lenses() -> Vec<Distortion> {
    let brown = STRONG.distortion;
    vec![
        Distortion::default(),
        brown,
        Distortion { k1: 0.4, k2: 0.1, p1: -0.01, p2: 0.01, ..brown },
        Distortion { k1: -0.12, k2: 0.0, ..brown },
        Distortion { k1: 0.1, k2: -0.08, p1: 0.0, p2: 0.002, radial: Radial::Printed },
        Distortion { k1: -0.1, k2: 0.15, p1: 0.001, p2: 0.0, radial: Radial::Printed },
    ]
}

/// Points all over a gel of 30×30 mm, pressed in and bulging.
fn points() -> impl Iterator<Item = [f64; 3]> {
    let ends = [-15.0, -6.0, 0.5, 15.0];
    let heights = [-1.0, 0.0, 3.0];
    ends.into_iter().flat_map(move |x| ends.into_iter().flat_map(move |y| heights.map(move |z| [x, y, z])))
}

#[test]
fn pressing_brings_the_surface_nearer_and_outward() {
    let camera = Camera::new(&PINHOLE).unwrap();
    assert_eq!(camera.ray([239.5; 2]).map(|ray| ray.origin_mm), Some([0.0, 0.0, 25.0]));
    assert_eq!(camera.project([0.0; 3]), Some([239.5, 239.5]));
    // x to the right, y down, and 20 mm away from the camera where 5 mm are pressed in.
    assert_eq!(camera.project([5.0, 2.5, 0.0]), Some([319.5, 279.5]));
    assert_eq!(camera.project([5.0, 2.5, 5.0]), Some([339.5, 289.5]));
    let projection = camera.project_with_jacobian([5.0, 2.5, 0.0]).unwrap();
    assert!(projection.by_point[0][2] > 0.0 && projection.by_point[1][2] > 0.0);
}

#[test]
fn a_turned_camera_keeps_the_mirror_and_its_place() {
    for rotation_rad in [[0.0; 3], [0.3, 0.0, 0.0], STRONG.rotation_rad] {
        let camera = Camera::new(&CameraParams { rotation_rad, ..STRONG }).unwrap();
        let [by_u, by_v] = camera.project_with_jacobian([0.0; 3]).unwrap().by_point;
        assert!(by_u[0] * by_v[1] - by_u[1] * by_v[0] > 0.0, "x and y keep their sense");
        // The camera stands where every ray begins: the ray through a point leads there.
        let point = [3.0, -4.0, 1.0];
        let ray = camera.ray(camera.project(point).unwrap()).unwrap();
        let distance: f64 = (0..3).map(|i| (point[i] - ray.origin_mm[i]).powi(2)).sum::<f64>().sqrt();
        for axis in 0..3 {
            assert!((ray.origin_mm[axis] + distance * ray.direction[axis] - point[axis]).abs() < 1e-10);
        }
        assert!(ray.direction[2] < 0.0 && camera.position_mm()[2] > 0.0);
    }
}

#[test]
fn a_rotation_about_the_axis_turns_the_gel_in_the_image() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let camera = Camera::new(&CameraParams { rotation_rad: [0.0, 0.0, quarter], ..PINHOLE }).unwrap();
    // From x towards y, as seen in the image.
    let [u, v] = camera.project([5.0, 0.0, 0.0]).unwrap();
    assert!((u - 239.5).abs() < 1e-9 && (v - 319.5).abs() < 1e-9, "{u} {v}");
}

#[test]
fn a_pixel_is_found_again_behind_its_ray() {
    for distortion in lenses() {
        let camera = Camera::new(&CameraParams { distortion, ..STRONG }).unwrap();
        for row in (0..480).step_by(13).chain([479]) {
            for column in (0..640).step_by(13).chain([639]) {
                let px = [f64::from(column), f64::from(row)];
                for z in [0.0, 2.0] {
                    let [x, y] = camera.surface_point(px, z).unwrap();
                    let [u, v] = camera.project([x, y, z]).unwrap();
                    assert!((u - px[0]).hypot(v - px[1]) < 1e-9, "{distortion:?}: {px:?} came back as {u} {v}");
                }
                let ray = camera.ray(px).unwrap();
                let far: [f64; 3] = std::array::from_fn(|i| ray.origin_mm[i] + 40.0 * ray.direction[i]);
                let [u, v] = camera.project(far).unwrap();
                assert!((u - px[0]).hypot(v - px[1]) < 1e-9, "{distortion:?}: {px:?} came back as {u} {v}");
            }
        }
    }
}

#[test]
fn an_untilted_pinhole_enlarges_alike_everywhere() {
    let camera = Camera::new(&PINHOLE).unwrap();
    for px in [[239.5, 239.5], [0.0, 0.0], [479.0, 120.0]] {
        let growth = camera.area_growth_per_mm(px).unwrap();
        assert!((growth - 2.0 / 25.0).abs() < 1e-14, "{growth} per mm at {px:?}");
    }
}

#[test]
fn the_growth_of_an_area_is_that_of_differences() {
    for distortion in lenses() {
        let camera = Camera::new(&CameraParams { distortion, ..STRONG }).unwrap();
        for px in [[300.0, 250.0], [10.0, 20.0], [600.0, 30.0], [250.0, 470.0]] {
            let [x, y] = camera.surface_point(px, 0.0).unwrap();
            let log_area = |z: f64| {
                let [by_u, by_v] = camera.project_with_jacobian([x, y, z]).unwrap().by_point;
                [(by_u[0] * by_v[1] - by_u[1] * by_v[0]).ln(), 0.0]
            };
            let growth = camera.area_growth_per_mm(px).unwrap();
            assert_slope([growth, 0.0], difference(log_area, 1e-3), &format!("{distortion:?} at {px:?}"));
        }
    }
    // Above the horizon there is no surface.
    let grazing = Camera::new(&CameraParams { rotation_rad: [1.2, 0.0, 0.0], ..PINHOLE }).unwrap();
    assert_eq!([[239.5, -400.0], [239.5, 900.0]].map(|px| grazing.area_growth_per_mm(px).is_some()), [true, false]);
}

/// Central difference of `f` at 0 with error h⁴.
fn difference(f: impl Fn(f64) -> [f64; 2], step: f64) -> [f64; 2] {
    let at = [-2.0, -1.0, 1.0, 2.0].map(|multiple| f(multiple * step));
    [0, 1].map(|i| (at[0][i] - 8.0 * at[1][i] + 8.0 * at[2][i] - at[3][i]) / (12.0 * step))
}

fn assert_slope(given: [f64; 2], expected: [f64; 2], what: &str) {
    for (given, expected) in given.into_iter().zip(expected) {
        assert!((given - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{what}: {given} is not {expected}");
    }
}

#[test]
fn the_jacobian_by_the_point_is_that_of_differences() {
    for distortion in lenses() {
        let camera = Camera::new(&CameraParams { distortion, ..STRONG }).unwrap();
        for point in points() {
            let projection = camera.project_with_jacobian(point).unwrap();
            assert_eq!(Some(projection.px), camera.project(point));
            for axis in 0..3 {
                let moved = |by: f64| {
                    let mut point = point;
                    point[axis] += by;
                    camera.project(point).unwrap()
                };
                let given = [0, 1].map(|i| projection.by_point[i][axis]);
                assert_slope(given, difference(moved, 1e-2), &format!("{distortion:?} {point:?} axis {axis}"));
            }
        }
    }
}

/// Every parameter by its number: focal length, principal point, k1 k2 p1 p2, rotation, translation.
fn parameter(params: &mut CameraParams, index: usize) -> &mut f64 {
    let lens = &mut params.distortion;
    match index {
        0..2 => &mut params.focal_length_px[index],
        2..4 => &mut params.principal_point_px[index - 2],
        4 => &mut lens.k1,
        5 => &mut lens.k2,
        6 => &mut lens.p1,
        7 => &mut lens.p2,
        8..11 => &mut params.rotation_rad[index - 8],
        _ => &mut params.translation_mm[index - 11],
    }
}

#[test]
fn the_jacobian_by_every_parameter_is_that_of_differences() {
    // Rotations at rest, where the series holds, on either side of its end, and large.
    let rotations = [[0.0; 3], [1e-5, 2e-5, 0.0], [0.05, -0.07, 0.03], [0.06, -0.09, 0.03], STRONG.rotation_rad];
    for distortion in lenses() {
        for rotation_rad in rotations {
            let params = CameraParams { distortion, rotation_rad, ..STRONG };
            for point in points().step_by(5) {
                check_parameter_jacobian(&params, point);
            }
        }
    }
}

fn check_parameter_jacobian(params: &CameraParams, point: [f64; 3]) {
    let jacobian = Camera::new(params).unwrap().parameter_jacobian(point).unwrap();
    let row = |i: usize| -> Vec<f64> {
        let (lens, pose) = (jacobian.by_distortion[i], [jacobian.by_rotation[i], jacobian.by_translation[i]]);
        [jacobian.by_focal_length[i].as_slice(), &jacobian.by_principal_point[i], &lens, pose.as_flattened()].concat()
    };
    let rows = [row(0), row(1)];
    for index in 0..14 {
        let step = if (8..11).contains(&index) || (4..8).contains(&index) { 1e-3 } else { 1e-2 };
        let moved = |by: f64| {
            let mut params = *params;
            *parameter(&mut params, index) += by;
            Camera::new(&params).unwrap().project(point).unwrap()
        };
        let what = format!("{:?} {:?} {point:?} parameter {index}", params.distortion, params.rotation_rad);
        assert_slope([rows[0][index], rows[1][index]], difference(moved, step), &what);
    }
}

#[test]
fn distortion_is_the_published_formula() {
    let brown = Distortion { k1: 0.1, k2: 0.2, p1: 0.01, p2: 0.02, radial: Radial::Brown };
    let at = |distortion: Distortion| {
        let camera = Camera::new(&CameraParams { distortion, ..PINHOLE }).unwrap();
        let [u, v] = camera.project([7.5, 10.0, 0.0]).unwrap();
        [(u - 239.5) / 400.0, (v - 239.5) / 400.0]
    };
    // (x, y) = (0.3, 0.4), r = 0.5.
    let tangential = [2.0 * 0.01 * 0.12 + 0.02 * (0.25 + 0.18), 0.01 * (0.25 + 0.32) + 2.0 * 0.02 * 0.12];
    let factors = [(Radial::Brown, 1.0 + 0.1 * 0.25 + 0.2 * 0.0625), (Radial::Printed, 1.0 + 0.1 * 0.25 + 0.2 * 0.5)];
    for (radial, factor) in factors {
        let [x, y] = at(Distortion { radial, ..brown });
        assert!((x - (0.3 * factor + tangential[0])).abs() < 1e-14, "{radial:?}");
        assert!((y - (0.4 * factor + tangential[1])).abs() < 1e-14, "{radial:?}");
    }
}

#[test]
fn beyond_the_fold_nothing_is_projected() {
    // r (1 + k1 r²) turns back at r = 1 / √(−3 k1), where it has reached 2/3 of that.
    let distortion = Distortion { k1: -1.0 / 3.0, ..Distortion::default() };
    let camera = Camera::new(&CameraParams { distortion, ..PINHOLE }).unwrap();
    assert!(camera.project([25.0 * 0.999, 0.0, 0.0]).is_some());
    assert_eq!(camera.project([25.0 * 1.001, 0.0, 0.0]), None);
    let at = |x: f64| camera.ray([239.5 + 400.0 * x, 239.5]);
    assert!(at(2.0 / 3.0 - 1e-9).is_some());
    assert_eq!(at(2.0 / 3.0 + 1e-9), None);
    assert_eq!(at(5.0), None);
    // Beyond the fold the polynomial returns to the image: 1.5 − 1.125 = 0.375 is not what r = 1.5 may give.
    assert_eq!(camera.project([37.5, 0.0, 0.0]), None);
}

#[test]
fn tangential_distortion_ends_the_range_too() {
    for distortion in [
        Distortion { p1: 0.1, ..Distortion::default() },
        Distortion { k1: -0.2, k2: 0.02, p1: 0.03, p2: -0.05, ..Distortion::default() },
        Distortion { k1: 0.5, p1: 0.5, p2: 0.4, ..Distortion::default() },
    ] {
        let camera = Camera::new(&CameraParams { distortion, ..PINHOLE }).unwrap();
        let mut least = f64::INFINITY;
        for angle in (0..3600).map(|tenth| f64::from(tenth).to_radians() / 10.0) {
            for step in 1..4000 {
                let radius = 0.02 * f64::from(step);
                let point = [radius * angle.cos(), radius * angle.sin(), 0.0];
                let Some(Projection { by_point: [u, v], .. }) = camera.project_with_jacobian(point) else { break };
                least = least.min((u[0] * v[1] - u[1] * v[0]) / 256.0);
            }
        }
        assert!(least > 0.0 && least < 0.02, "{distortion:?}: smallest determinant {least}");
    }
}

#[test]
fn what_no_camera_sees_is_none() {
    let camera = Camera::new(&PINHOLE).unwrap();
    assert_eq!(camera.project([0.0, 0.0, 25.0]), None, "the camera itself");
    assert_eq!(camera.project([0.0, 0.0, 26.0]), None, "behind it");
    assert_eq!(camera.project([f64::NAN, 0.0, 0.0]), None);
    assert_eq!(camera.project([0.0, 0.0, f64::NAN]), None);
    assert_eq!(camera.surface_point([100.0, 100.0], 25.0), None, "a plane through the camera");
    assert_eq!(camera.surface_point([100.0, 100.0], 30.0), None, "a plane behind it");
    assert_eq!(camera.ray([f64::NAN, 0.0]), None);
    assert_eq!(camera.ray([f64::INFINITY, 0.0]), None);
    let steep = Camera::new(&CameraParams { rotation_rad: [1.2, 0.0, 0.0], ..PINHOLE }).unwrap();
    assert_eq!(steep.surface_point([239.5, 239.5 + 400.0], 0.0), None, "above the horizon");
    let strong = Camera::new(&STRONG).unwrap();
    assert_eq!(strong.ray([f64::NAN, 0.0]), None);
    assert_eq!(strong.ray([f64::INFINITY, 0.0]), None);
}

#[test]
fn a_pixel_has_its_size_on_the_gel() {
    let camera = Camera::new(&PINHOLE).unwrap();
    for px in [[239.5, 239.5], [10.0, 400.0]] {
        assert!((camera.mm_per_px(px).unwrap() - 0.0625).abs() < 1e-14);
    }
    let strong = Camera::new(&STRONG).unwrap();
    let corner = |u: f64, v: f64| strong.surface_point([u, v], 0.0).unwrap();
    let (right, left, below, above) = (corner(50.5, 60.0), corner(49.5, 60.0), corner(50.0, 60.5), corner(50.0, 59.5));
    let area = (right[0] - left[0]) * (below[1] - above[1]) - (right[1] - left[1]) * (below[0] - above[0]);
    let size = strong.mm_per_px([50.0, 60.0]).unwrap();
    assert!((size - area.sqrt()).abs() < 1e-5 * size, "{size} is not {}", area.sqrt());
}

#[test]
fn an_impossible_camera_is_refused_by_name() {
    let refusal = |params: CameraParams| Camera::new(&params).unwrap_err().to_string();
    assert_eq!(
        refusal(CameraParams { focal_length_px: [0.0, 400.0], ..PINHOLE }),
        "focal_length_px = [0.0, 400.0] is impossible: it must be two lengths above 0 px"
    );
    let with = |distortion| CameraParams { distortion, ..PINHOLE };
    let none = Distortion::default();
    for (params, key) in [
        (CameraParams { focal_length_px: [400.0, f64::NAN], ..PINHOLE }, "focal_length_px"),
        (CameraParams { focal_length_px: [f64::INFINITY, 400.0], ..PINHOLE }, "focal_length_px"),
        (CameraParams { principal_point_px: [f64::NAN, 0.0], ..PINHOLE }, "principal_point_px"),
        (with(Distortion { k1: f64::NAN, ..none }), "distortion.k1"),
        (with(Distortion { k2: f64::INFINITY, ..none }), "distortion.k2"),
        (with(Distortion { p1: f64::NAN, ..none }), "distortion.p1"),
        (with(Distortion { p2: f64::NAN, ..none }), "distortion.p2"),
        (CameraParams { rotation_rad: [0.0, f64::NAN, 0.0], ..PINHOLE }, "rotation_rad"),
        (CameraParams { translation_mm: [0.0, 0.0, 0.0], ..PINHOLE }, "translation_mm"),
        (CameraParams { translation_mm: [0.0, 0.0, f64::NAN], ..PINHOLE }, "translation_mm"),
        (CameraParams { rotation_rad: [3.0, 0.0, 0.0], ..PINHOLE }, "rotation_rad"),
        (CameraParams { rotation_rad: [1.0, 0.0, 0.0], translation_mm: [0.0, 60.0, 25.0], ..PINHOLE }, "rotation_rad"),
    ] {
        let error = params.validate().unwrap_err();
        assert_eq!(error.key, key, "{error}");
    }
}
