//! Height maps and meshes, written by the test and read back.

use std::fs;
use std::path::Path;

use fingervision_elastic::Relief;
use png::{BitDepth, ColorType};
use stl_io::{Normal, Triangle, Vertex};
use tempfile::TempDir;

use super::tests::{assert_derivatives, points, relief};
use super::{Indenter, IndenterError, IndenterRelief, IndenterShape};

fn write_png(folder: &TempDir, size: [u32; 2], colour: ColorType, depth: BitDepth, data: &[u8]) {
    let mut encoder = png::Encoder::new(fs::File::create(folder.path().join("map.png")).unwrap(), size[0], size[1]);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
}

fn map(folder: &TempDir, size_mm: [f64; 2], height_mm: f64) -> Result<IndenterRelief, IndenterError> {
    let shape = IndenterShape::HeightMap { file: "map.png".into(), size_mm, height_mm };
    Indenter::new(shape).relief(folder.path())
}

/// A ball of radius 6 mm in the positive corner of space, drawn from its top down, z up.
fn ball(rows: u32) -> Vec<Triangle> {
    let columns = 2 * rows;
    let vertex = |row: u32, column: u32| {
        let (sin, cos) = (std::f64::consts::PI * f64::from(row) / f64::from(rows)).sin_cos();
        let (east, north) = (std::f64::consts::TAU * f64::from(column % columns) / f64::from(columns)).sin_cos();
        let sin = if row.is_multiple_of(rows) { 0.0 } else { sin };
        Vertex::new([10.0 + 6.0 * sin * east, 7.0 + 6.0 * sin * north, 9.0 + 6.0 * cos].map(|value| value as f32))
    };
    let normal = Normal::new([0.0; 3]);
    let faces = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let halves = faces.flat_map(|(row, column)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(r, s)| vertex(row + r, column + s));
        [Triangle { normal, vertices: [a, b, c] }, Triangle { normal, vertices: [a, c, d] }]
    });
    halves.filter(|Triangle { vertices: [a, b, c], .. }| a != b && b != c && c != a).collect()
}

fn write_stl(folder: &TempDir, triangles: &[Triangle]) {
    stl_io::write_stl(&mut fs::File::create(folder.path().join("body.stl")).unwrap(), triangles.iter()).unwrap();
}

fn stl(folder: &TempDir) -> Result<IndenterRelief, IndenterError> {
    Indenter::new(IndenterShape::Stl { file: "body.stl".into(), scale: 1.0 }).relief(folder.path())
}

#[test]
fn the_first_row_of_a_height_map_is_the_top() {
    let folder = TempDir::new().unwrap();
    // White only in the upper right quarter.
    let pixels: Vec<u8> = (0..16 * 16).map(|n| if n / 16 < 8 && n % 16 >= 8 { 255 } else { 0 }).collect();
    write_png(&folder, [16, 16], ColorType::Grayscale, BitDepth::Eight, &pixels);
    let relief = map(&folder, [8.0, 6.0], 2.0).unwrap();
    let height = |x: f64, y: f64| relief.at(x, y).height_mm;
    assert!(height(2.0, -1.5).abs() < 1e-9 && relief.is_face(2.0, -1.5));
    for [x, y] in [[-2.0, -1.5], [2.0, 1.5], [-2.0, 1.5]] {
        assert!((height(x, y) - 2.0).abs() < 1e-9, "{x}, {y}: {}", height(x, y));
    }
    // The image fills its size: at its right side, 4 mm, the wall begins.
    assert!((height(5.5, -1.5) - 4.5).abs() < 0.06, "{}", height(5.5, -1.5));
    let half = relief.half_extent_mm();
    assert!((half[0] - 5.0).abs() < 0.15 && (half[1] - 4.0).abs() < 0.15, "{half:?}");
}

#[test]
fn sixteen_bits_keep_their_steps() {
    let folder = TempDir::new().unwrap();
    // A slope along y: white at the top, black at the bottom.
    let values = (0..64_u32).flat_map(|row| std::iter::repeat_n(65535 - 1000 * row, 64));
    let bytes: Vec<u8> = values.flat_map(|value| (value as u16).to_be_bytes()).collect();
    write_png(&folder, [64, 64], ColorType::Grayscale, BitDepth::Sixteen, &bytes);
    let relief = map(&folder, [6.4, 6.4], 2.0).unwrap();
    let expected = 2.0 * 1000.0 / 65535.0 / 0.1;
    for y in [-2.0, -0.33, 0.0, 1.71] {
        let here = relief.at(0.4, y);
        assert!((here.slope[1] - expected).abs() < 1e-9 && here.slope[0].abs() < 1e-9, "{y}: {here:?}");
    }
}

#[test]
fn a_height_map_of_a_disc_is_nearly_the_circle() {
    let folder = TempDir::new().unwrap();
    let radius = |n: u32, axis: u32| f64::from(n) * 12.0 / 600.0 - 6.0 + 0.01 * f64::from(axis);
    let pixels: Vec<u8> =
        (0..600 * 600_u32).map(|n| if radius(n % 600, 1).hypot(radius(n / 600, 1)) <= 4.0 { 255 } else { 0 }).collect();
    write_png(&folder, [600, 600], ColorType::Grayscale, BitDepth::Eight, &pixels);
    let (map, circle) = (map(&folder, [12.0, 12.0], 8.0).unwrap(), relief(IndenterShape::Circle { radius_mm: 4.0 }));
    for point in points(6.0, 2000) {
        let [map, circle] = [&map, &circle].map(|relief| relief.at(point[0], point[1]).height_mm);
        // On the wall the circle's fillet has gained r (√(1 + s²) − 1) = 0.65 mm; nodes and pixels add some 0.06 mm ·
        // s.
        assert!((map - circle).abs() < 0.83 || circle > 7.0, "{point:?}: {map} and {circle}");
        assert!(point[0].hypot(point[1]) > 3.6 || map < 1e-6, "{point:?}: {map}");
    }
}

#[test]
fn smooth_surfaces_of_files_keep_to_the_slope_of_the_wall() {
    let folder = TempDir::new().unwrap();
    let pixels: Vec<u8> = (0..80 * 60_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    write_png(&folder, [80, 60], ColorType::Grayscale, BitDepth::Eight, &pixels);
    let relief = map(&folder, [8.0, 6.0], 1.5).unwrap();
    let mut steepest = 0.0_f64;
    for point in points(6.0, 20_000) {
        let here = relief.at(point[0], point[1]);
        steepest = steepest.max(here.slope[0].hypot(here.slope[1]));
        assert!(here.height_mm > -1e-3, "{point:?}: {here:?}");
    }
    assert!(steepest > 2.5 && steepest < 3.03, "{steepest}");
    for point in points(6.0, 300) {
        assert_derivatives(|[x, y]| relief.at(x, y), point, 1e-4);
    }
}

#[test]
fn an_image_that_is_not_grey_is_refused() {
    let folder = TempDir::new().unwrap();
    let refusal = || map(&folder, [8.0, 6.0], 1.0).unwrap_err();
    assert!(refusal().to_string().ends_with("map.png: no such file"), "{}", refusal());
    assert_eq!(refusal().hint(), "paths are relative to the scene's folder");
    for (colour, channels, kind) in [
        (ColorType::Rgb, 3, "an image in colour"),
        (ColorType::Rgba, 4, "an image in colour with transparency"),
        (ColorType::GrayscaleAlpha, 2, "an image in grey with transparency"),
    ] {
        write_png(&folder, [4, 4], colour, BitDepth::Eight, &vec![9; 16 * channels]);
        assert!(refusal().to_string().ends_with(kind), "{}", refusal());
        assert!(refusal().hint().contains("8 or 16 bit grey without transparency"));
    }
    write_png(&folder, [1, 4], ColorType::Grayscale, BitDepth::Eight, &[9; 4]);
    assert!(refusal().to_string().contains("it has 1x4 px"), "{}", refusal());
    write_png(&folder, [64, 64], ColorType::Grayscale, BitDepth::Eight, &[9; 64 * 64]);
    let whole = fs::read(folder.path().join("map.png")).unwrap();
    for length in [0, 20, 40, whole.len() - 16] {
        fs::write(folder.path().join("map.png"), &whole[..length]).unwrap();
        assert!(refusal().to_string().contains("map.png is not a height map"), "{length}: {}", refusal());
    }
    fs::write(folder.path().join("map.png"), b"P5 4 4 255 not a png at all").unwrap();
    assert!(refusal().to_string().contains("is not a height map"), "{}", refusal());
}

#[test]
fn a_mesh_of_a_ball_is_the_sphere() {
    let folder = TempDir::new().unwrap();
    write_stl(&folder, &ball(150));
    let (mesh, sphere) = (stl(&folder).unwrap(), relief(IndenterShape::Sphere { radius_mm: 6.0 }));
    let mut worst = 0.0_f64;
    for point in points(4.2, 3000) {
        let [mesh, sphere] = [&mesh, &sphere].map(|relief| relief.at(point[0], point[1]));
        let slope = (mesh.slope[0] - sphere.slope[0]).hypot(mesh.slope[1] - sphere.slope[1]);
        // Where the wall begins, the curvature jumps and the mesh is rounded.
        let is_cap = point[0].hypot(point[1]) < 5.4;
        let error = (mesh.height_mm - sphere.height_mm).abs();
        worst = worst.max(if is_cap { error } else { 0.5 * error });
        assert!(slope < if is_cap { 0.03 } else { 0.2 }, "{point:?}: {mesh:?} and {sphere:?}");
    }
    assert!(worst < 0.01, "{worst}");
    let [half, expected] = [&mesh, &sphere].map(|relief| relief.half_extent_mm()[0]);
    assert!((half - expected).abs() < 0.06, "{half} instead of {expected}");
}

#[test]
fn the_top_of_a_mesh_is_seen_with_y_up() {
    let folder = TempDir::new().unwrap();
    // A wedge over x 0 to 6 and y 0 to 4: the edge at y = 4 is the top.
    let [a, b, c, d] = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [6.0, 4.0, 0.0], [0.0, 4.0, 0.0]].map(Vertex::new);
    let [e, f] = [[6.0, 4.0, 2.0], [0.0, 4.0, 2.0]].map(Vertex::new);
    let faces = [[a, c, b], [a, d, c], [a, b, e], [a, e, f], [b, c, e], [c, d, f], [c, f, e], [d, a, f]];
    let wedge = faces.map(|vertices| Triangle { normal: Normal::new([0.0; 3]), vertices });
    write_stl(&folder, &wedge);
    let relief = stl(&folder).unwrap();
    for [x, y] in [[0.0, 0.0], [1.5, -1.0], [-2.0, 1.0]] {
        let here = relief.at(x, y);
        // The smooth edge lies a little below the sharp one.
        assert!((here.slope[1] - 0.5).abs() < 1e-6 && here.slope[0].abs() < 1e-6, "{x}, {y}: {here:?}");
        assert!((here.height_mm - 0.5 * (y + 2.0)).abs() < 0.15, "{x}, {y}: {here:?}");
    }
}

#[test]
fn an_open_mesh_is_refused_with_its_edges_counted() {
    let folder = TempDir::new().unwrap();
    let mut triangles = ball(20);
    triangles.remove(300);
    write_stl(&folder, &triangles);
    let error = stl(&folder).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("is not closed: 3 of its 2280 edges belong to an odd number of its 1519"), "{message}");
    assert!(error.hint().starts_with("repair the mesh"));
}

#[test]
fn a_mesh_without_triangles_or_cut_off_is_refused() {
    let folder = TempDir::new().unwrap();
    let refusal = || stl(&folder).unwrap_err().to_string();
    assert!(refusal().ends_with("body.stl: no such file"), "{}", refusal());
    write_stl(&folder, &[]);
    assert!(refusal().ends_with("there are no triangles"), "{}", refusal());
    write_stl(&folder, &ball(20));
    let whole = fs::read(folder.path().join("body.stl")).unwrap();
    for length in [0, 50, 83, 84, 1000, whole.len() - 1] {
        fs::write(folder.path().join("body.stl"), &whole[..length]).unwrap();
        assert!(refusal().contains("it is cut off, or not an STL"), "{length}: {}", refusal());
    }
    let mut broken = whole;
    broken[100..104].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(folder.path().join("body.stl"), broken).unwrap();
    assert!(refusal().ends_with("a coordinate is NaN"), "{}", refusal());
}

#[test]
fn a_mesh_as_text_is_the_same_mesh() {
    let folder = TempDir::new().unwrap();
    let triangles = ball(24);
    write_stl(&folder, &triangles);
    let binary = stl(&folder).unwrap();
    let vertex = |vertex: &Vertex| format!("vertex {} {} {}\n", vertex[0], vertex[1], vertex[2]);
    let facet = |triangle: &Triangle| {
        let corners: String = triangle.vertices.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let facets: String = triangles.iter().map(facet).collect();
    let write = |text: &str| fs::write(folder.path().join("body.stl"), text).unwrap();
    for name in ["", " ball"] {
        write(&format!("solid{name}\n{facets}endsolid{name}\n"));
        let text = stl(&folder).unwrap();
        for point in points(7.0, 200) {
            assert_eq!(text.at(point[0], point[1]), binary.at(point[0], point[1]));
        }
    }
    write(&format!("solid ball\n{facets}"));
    assert!(stl(&folder).unwrap_err().to_string().contains("it is cut off"));
    write(&format!("solid a\n{facets}endsolid a\nsolid b\n{facets}endsolid b\n"));
    assert!(stl(&folder).unwrap_err().to_string().contains("it contains 2 solids"));
}

#[test]
fn a_mesh_far_too_small_or_large_is_refused() {
    let folder = TempDir::new().unwrap();
    write_stl(&folder, &ball(12));
    for scale in [1e-3, 1e3] {
        let indenter = Indenter::new(IndenterShape::Stl { file: "body.stl".into(), scale });
        let error = indenter.relief(folder.path()).unwrap_err().to_string();
        assert!(error.contains("indenter.scale is the file's unit in mm"), "{error}");
    }
    let inch = Indenter::new(IndenterShape::Stl { file: "body.stl".into(), scale: 0.5 });
    let half = inch.relief(folder.path()).unwrap().half_extent_mm();
    let sphere = relief(IndenterShape::Sphere { radius_mm: 3.0 }).half_extent_mm();
    assert!((half[0] - sphere[0]).abs() < 0.1, "{half:?} instead of {sphere:?}");
    assert_eq!(inch.file(), Some(Path::new("body.stl")));
}
