//! Mutated scenes, meshes and height maps: a scene, a body or an error, never a panic.

use std::fs;
use std::path::Path;

use fingervision_fuzz::{Form, Parser};
use fingervision_gel::{Indenter, IndenterShape, Scene};

/// The most memory that one file may take, bytes: the grid of the largest body.
const MOST_BYTES: u64 = 512 << 20;

fn scenes() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

#[test]
fn a_mutated_scene_is_read_or_refused() {
    let parser = Parser { name: "scene", form: Form::Text, files: scenes(), inputs: 1500, most_bytes: MOST_BYTES };
    parser.run(|bytes| {
        let Some(scene) = std::str::from_utf8(bytes).ok().and_then(|text| Scene::from_toml(text).ok()) else {
            return false;
        };
        let again = Scene::from_toml(&scene.to_toml()).unwrap_or_else(|error| panic!("written and refused: {error}"));
        assert_eq!(again.to_toml(), scene.to_toml(), "a scene that is written and read again");
        true
    });
}

/// A block of 2 by 1 by 1, its sides in two triangles each.
fn triangles() -> Vec<[[f32; 3]; 3]> {
    let corner = |n: usize| [2.0 * (n & 1) as f32, (n >> 1 & 1) as f32, (n >> 2) as f32];
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|side| side.map(corner))).collect()
}

fn binary_stl() -> Vec<u8> {
    let mut file = vec![0; 80];
    file.extend((triangles().len() as u32).to_le_bytes());
    for triangle in triangles() {
        file.extend([0; 12]);
        file.extend(triangle.iter().flatten().flat_map(|value| value.to_le_bytes()));
        file.extend([0; 2]);
    }
    file
}

fn text_stl() -> Vec<u8> {
    let vertex = |[x, y, z]: [f32; 3]| format!("      vertex {x} {y} {z}\n");
    let facet = |corners: [[f32; 3]; 3]| {
        let corners = corners.map(vertex).concat();
        format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    };
    let facets: String = triangles().into_iter().map(facet).collect();
    format!("solid block\n{facets}endsolid block\n").into_bytes()
}

fn height_map(depth: png::BitDepth, bytes_per_pixel: usize) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 12, 9);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    let pixels: Vec<u8> = (0..12 * 9 * bytes_per_pixel).map(|n| (n * 37) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    file
}

/// Reads the mutations of an indenter's file.
fn run(name: &'static str, form: Form, files: Vec<Vec<u8>>, shape: IndenterShape) {
    let folder = tempfile::tempdir().unwrap();
    // Steep walls and a wide fillet keep the grid of heights small, and with it the time for each input.
    let indenter = Indenter { fillet_mm: 0.2, wall_slope: 20.0, ..Indenter::new(shape) };
    Parser { name, form, files, inputs: 300, most_bytes: MOST_BYTES }.run(|bytes| {
        fs::write(folder.path().join("body"), bytes).unwrap();
        indenter.relief(folder.path()).is_ok()
    });
}

#[test]
fn a_mutated_binary_mesh_is_read_or_refused() {
    run("stl", Form::Binary, vec![binary_stl()], IndenterShape::Stl { file: "body".into(), scale: 1.0 });
}

#[test]
fn a_mutated_mesh_as_text_is_read_or_refused() {
    run("stl as text", Form::Text, vec![text_stl()], IndenterShape::Stl { file: "body".into(), scale: 1.0 });
}

#[test]
fn a_mutated_height_map_is_read_or_refused() {
    let files = vec![height_map(png::BitDepth::Eight, 1), height_map(png::BitDepth::Sixteen, 2)];
    let shape = IndenterShape::HeightMap { file: "body".into(), size_mm: [2.0, 1.5], height_mm: 1.0 };
    run("height map", Form::Binary, files, shape);
}
