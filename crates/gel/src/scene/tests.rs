#![expect(clippy::float_cmp, reason = "a value that is read is the one that is written")]

use std::fs;

use fingervision_elastic::{ContactLaw, Law};

use super::*;
use crate::{IndenterShape, Motif};

const WHOLE: &str = r#"
name = "all of it"
about = "every table with a value of its own"
[camera]
focal_length_px = [410.0, 405.0]
principal_point_px = [100.0, 101.0]
distortion = { k1 = -0.01 }
rotation_rad = [0.01, 0.0, 0.0]
translation_mm = [0.5, 0.0, 24.0]
[gel]
size_mm = [28.0, 26.0]
thickness_mm = 9.0
poissons_ratio = 0.35
youngs_modulus_mpa = 0.2
[material]
law = "linear"
[contact]
law = { friction = 0.8 }
[indenter]
shape = "ring"
inner_radius_mm = 2.0
outer_radius_mm = 4.0
fillet_mm = 0.2
[motion]
centre_mm = [1.0, -1.0]
frames = 11
keyframes = [{ at = 5, depth_mm = 0.5, tilt_rad = [0.02, 0.0] }, { at = 10, shear_mm = [0.3, 0.1], twist_rad = 0.05 }]
[pattern]
cell_mm = 0.2
seed = 7
[render]
width = 200
height = 160
noise_levels = 0.0
[mesh]
resolution = "draft"
"#;

/// The message and the hint of what `text` is refused for.
fn refusal(text: &str) -> (String, String) {
    let error = Scene::from_toml(text).unwrap_err();
    (error.to_string(), error.hint().unwrap_or_default())
}

#[test]
fn every_table_is_read() {
    let scene = Scene::from_toml(WHOLE).unwrap();
    assert_eq!(scene.camera().principal_point_px, [100.0, 101.0]);
    assert!((scene.camera().distortion.k1 + 0.01).abs() < 1e-12);
    assert_eq!((scene.gel.size_mm, scene.gel.youngs_modulus_mpa), ([28.0, 26.0], Some(0.2)));
    assert_eq!((scene.material.law, scene.contact.law), (Law::Linear, ContactLaw::Friction(0.8)));
    assert_eq!(scene.indenter.shape, IndenterShape::Ring { inner_radius_mm: 2.0, outer_radius_mm: 4.0 });
    assert_eq!((scene.motion.frames, scene.motion.keyframes.len()), (11, 2));
    assert_eq!(scene.pattern.motif, Motif::Colour { cell_mm: 0.2 });
    assert_eq!((scene.render.width, scene.mesh.resolution), (200, Resolution::Draft));
}

#[test]
fn missing_values_are_those_of_the_default_sensor() {
    let scene = Scene::from_toml("").unwrap();
    assert_eq!(scene, Scene::default());
    let gel = GelBlock { size_mm: [30.0; 2], thickness_mm: 10.0, poissons_ratio: 0.48, youngs_modulus_mpa: Some(0.6) };
    assert_eq!((scene.gel, scene.material.law, scene.contact.law), (gel, Law::NeoHookean, ContactLaw::Stick));
    let camera = scene.camera();
    assert_eq!((camera.focal_length_px, camera.principal_point_px), ([400.0; 2], [239.5; 2]));
    assert_eq!(camera.translation_mm, [0.0, 0.0, 25.0]);
    assert_eq!((scene.render.width, scene.render.height, scene.motion.frames), (480, 480, 21));
    assert_eq!(scene.pattern.motif, Motif::Colour { cell_mm: 0.1 });
    let seen = (scene.render.blur_px, scene.render.shading, scene.render.noise_levels);
    assert_eq!(seen, (0.7, 0.15, 2.0));
    assert!((scene.motion.largest_depth_mm() - 2.0).abs() < 1e-12);
}

#[test]
fn a_part_of_a_table_leaves_the_rest_of_it() {
    let scene = Scene::from_toml("[gel]\npoissons_ratio = 0.35\n[camera]\nfocal_length_px = [500, 500]").unwrap();
    assert_eq!(scene.gel, GelBlock { poissons_ratio: 0.35, ..Scene::default().gel });
    assert_eq!(scene.camera.translation_mm, [0.0, 0.0, 25.0]);
}

#[test]
fn the_principal_point_follows_the_size_of_the_image() {
    let scene = Scene::from_toml("[render]\nwidth = 640\nheight = 480").unwrap();
    assert_eq!(scene.camera().principal_point_px, [319.5, 239.5]);
}

#[test]
fn what_is_written_is_read_back() {
    for scene in [Scene::default(), Scene::from_toml(WHOLE).unwrap()] {
        let text = scene.to_toml();
        let again = Scene::from_toml(&text).unwrap();
        let camera = CameraTable { principal_point_px: Some(scene.camera().principal_point_px), ..scene.camera };
        assert_eq!(again, Scene { camera, ..scene }, "{text}");
        assert_eq!(again.to_toml(), text);
    }
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_a_like_one() {
    let (error, hint) = refusal("name = 'a'\n[gel]\nthicknes_mm = 9");
    assert_eq!(
        (error.as_str(), hint.as_str()),
        ("line 3: unknown key gel.thicknes_mm", "did you mean gel.thickness_mm?")
    );
    let (error, hint) = refusal("[lens]");
    assert_eq!(error, "line 1: unknown key lens");
    assert!(hint.starts_with("a scene has the keys name, about, camera"), "{hint}");
    let (error, _) = refusal("[motion]\nkeyframes = [\n{ at = 1 },\n{ at = 2, dept_mm = 1 }]");
    assert_eq!(error, "line 4: unknown key motion.keyframes[1].dept_mm");
    let (error, hint) = refusal("[indenter]\nshape = 'circle'\nradius_mm = 3\nside_mm = 4");
    assert!(error.contains("unknown key indenter.side_mm"), "{error}");
    assert!(hint.contains("radius_mm"), "{hint}");
}

#[test]
fn an_impossible_value_is_named_with_its_line_value_and_what_is_possible() {
    for (text, message) in [
        ("[gel]\npoissons_ratio = 0.5", "line 2: gel.poissons_ratio = 0.5 is impossible: it must be 0 to below 0.5"),
        (
            "\n[gel]\nthickness_mm = 0",
            "line 3: gel.thickness_mm = 0.0 is impossible: it must be a finite length above 0 mm",
        ),
        ("[gel]\nyoungs_modulus_mpa = -1", "line 2: gel.youngs_modulus_mpa = -1.0 is impossible"),
        ("[camera]\ntranslation_mm = [0, 0, -25]", "line 2: camera.translation_mm = [0.0, 0.0, -25.0] is impossible"),
        ("[contact]\nlaw = { friction = -0.5 }", "line 2: contact.law.friction = -0.5 is impossible"),
        (
            "[motion]\nkeyframes = [{ at = 1, depth_mm = -1 }]",
            "line 2: motion.keyframes[0].depth_mm = -1.0 is impossible",
        ),
        ("[motion]\nkeyframes = [{ at = 1, depth_mm = 10 }]", "it must be less than the gel's thickness of 10 mm"),
        ("[motion]\nframes = 1", "line 2: motion.frames = 1 is impossible: it must be 2 to 100000 frames"),
        ("[motion]\ncentre_mm = [16, 0]", "line 2: motion.centre_mm = [16.0, 0.0] is impossible"),
        ("[pattern]\ncell_mm = 0", "line 2: pattern.cell_mm = 0 is impossible"),
        ("[render]\nshading = 2", "line 2: render.shading = 2 is impossible: it must be 0 to 1"),
        ("[mesh]\ncells = [1000, 1000, 10]", "line 2: mesh.cells = [1000, 1000, 10] is impossible"),
        ("[indenter]\nshape = 'circle'\nradius_mm = -4", "line 3: indenter.radius_mm = -4.0 is impossible"),
    ] {
        let (error, hint) = refusal(text);
        assert!(error.contains(message), "{error}, expected {message}");
        assert!(!hint.is_empty(), "{error}");
    }
}

#[test]
fn an_indenter_that_does_not_fit_is_named_with_both_sizes() {
    let (error, hint) = refusal("[indenter]\nshape = 'rectangle'\nsize_mm = [40, 5]");
    assert!(error.starts_with("line 3: indenter.size_mm = "), "{error}");
    assert!(error.contains("the gel 30 by 30 mm"), "{error}");
    assert!(hint.contains("smaller"), "{hint}");
    let (error, _) = refusal("[motion]\ncentre_mm = [13, 0]");
    assert!(error.starts_with("line 2: motion.centre_mm = "), "{error}");
}

#[test]
fn a_wrong_type_is_named_with_its_line() {
    let (error, _) = refusal("[gel]\nsize_mm = 30");
    assert!(error.starts_with("line 2: gel.size_mm: invalid type"), "{error}");
    let (error, hint) = refusal("[contact]\nlaw = 'glue'");
    assert!(error.starts_with("line 2: contact.law: unknown variant `glue`"), "{error}");
    assert_eq!(hint, "possible values: stick, late-stick, frictionless, friction");
    let (error, _) = refusal("[indenter]\nshape = 'sphere'");
    assert!(error.contains("indenter: missing radius_mm"), "{error}");
    let (error, _) = refusal("[gel\n");
    assert!(error.starts_with("line 1: "), "{error}");
}

#[test]
fn files_are_sought_from_the_scenes_folder_and_can_be_taken_along() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, "\n[indenter]\nshape = 'height-map'\nfile = 'maps/coin.png'\nsize_mm = [8, 8]\nheight_mm = 1")
        .unwrap();
    let error = Scene::load(&path).unwrap_err().to_string();
    assert!(error.contains("scene.toml, line 4: indenter.file: cannot read"), "{error}");
    assert!(error.ends_with("maps/coin.png: no such file"), "{error}");

    let file = folder.path().join("maps/coin.png");
    fs::create_dir(folder.path().join("maps")).unwrap();
    let encoder = png::Encoder::new(fs::File::create(&file).unwrap(), 2, 2);
    encoder.write_header().unwrap().write_image_data(&[0, 128, 200, 255]).unwrap();
    let scene = Scene::load(&path).unwrap();
    assert_eq!(scene.file(), Some(file.as_path()));
    let (beside, taken) = scene.with_file_beside();
    assert_eq!((beside.file(), taken.as_deref()), (Some(Path::new("indenter.png")), Some(file.as_path())));
}

#[test]
fn a_scene_is_found_by_name_or_file() {
    assert_eq!(Scene::find("circle").unwrap().name, "circle");
    let error = Scene::find("circel").unwrap_err();
    assert_eq!(error.to_string(), "no scene circel: it is neither a file nor a ready-made scene");
    assert_eq!(error.hint().unwrap(), "did you mean circle?");
    let error = Scene::find("my/scene.toml").unwrap_err();
    assert_eq!(error.to_string(), "cannot read the scene my/scene.toml: no such file");
    assert!(error.hint().unwrap().contains("--list"));
}

#[test]
fn values_are_set_by_their_paths() {
    let mut scene = Scene::default();
    scene
        .set_all([("gel.poissons_ratio", "0.35"), ("motion.frames", "5"), ("contact.law", "{ friction = 0.4 }")])
        .unwrap();
    assert!((scene.gel.poissons_ratio - 0.35).abs() < 1e-12);
    assert_eq!((scene.motion.frames, scene.contact.law), (5, ContactLaw::Friction(0.4)));
    let before = scene.clone();
    let error = scene.set_all([("gel.poisons_ratio", "0.35")]).unwrap_err();
    assert_eq!(error.to_string(), "unknown key gel.poisons_ratio");
    assert!(scene.set_all([("gel.poissons_ratio", "0.6")]).is_err());
    assert_eq!(scene, before);
}

#[test]
fn every_ready_made_scene_is_itself() {
    for ready in ReadyMade::ALL {
        let scene = ready.scene();
        assert_eq!(scene.name, ready.name);
        assert!(!scene.about.is_empty() && !scene.about.contains('\n'), "{}", ready.name);
        let end = scene.motion.keyframes.last().unwrap().at;
        assert!((end - (scene.motion.frames - 1) as f64).abs() < 1e-12, "{}: places are frame numbers", ready.name);
        assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap().motion, scene.motion, "{}", ready.name);
    }
}

#[test]
fn the_comparable_scenes_have_the_published_sizes() {
    let shape = |name: &str| Scene::find(name).unwrap().indenter.shape;
    assert_eq!(shape("circle"), IndenterShape::Circle { radius_mm: 4.0 });
    assert_eq!(shape("rectangle"), IndenterShape::Rectangle { size_mm: [10.0, 5.0] });
    assert_eq!(shape("crossing"), IndenterShape::Crossing { bar_mm: [12.0, 2.4] });
    assert_eq!(shape("sphere"), IndenterShape::Sphere { radius_mm: 6.0 });
    assert_eq!(shape("press-then-shear"), IndenterShape::Rectangle { size_mm: [6.0, 6.0] });
    for name in ["circle", "rectangle", "crossing", "triangle", "sphere"] {
        let scene = Scene::find(name).unwrap();
        let rest = Scene { name: scene.name, about: scene.about, indenter: scene.indenter, ..Scene::default() };
        assert_eq!(Scene::find(name).unwrap(), rest, "{name} is the default sensor's");
    }
}

#[test]
fn random_scenes_can_be_and_are_the_same_for_the_same_seed() {
    let scenes: Vec<Scene> = RandomScenes::new(5).take(40).collect();
    for scene in &scenes {
        scene.validate().unwrap_or_else(|error| panic!("{error} in\n{}", scene.to_toml()));
        let depth = scene.motion.largest_depth_mm();
        assert!(
            (0.3..=2.0).contains(&depth) && (0.3..=0.49).contains(&scene.gel.poissons_ratio),
            "{}",
            scene.to_toml()
        );
        assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap().indenter, scene.indenter);
    }
    assert_eq!(RandomScenes::new(5).nth(20).unwrap(), scenes[20]);
    assert_ne!(RandomScenes::new(6).next().unwrap().indenter, scenes[0].indenter);
}

/// A sweep that was named by its seed shall stay what it was.
#[test]
fn the_first_random_scene_is_as_it_was() {
    let scene = RandomScenes::new(1).next().unwrap();
    assert_eq!(scene.indenter.shape, IndenterShape::Ring { inner_radius_mm: 2.442, outer_radius_mm: 4.357 });
    assert_eq!((scene.gel.poissons_ratio, scene.contact.law), (0.359, ContactLaw::Friction(0.406)));
    assert_eq!((scene.motion.centre_mm, scene.motion.largest_depth_mm()), ([0.463, 3.996], 0.568));
    assert_eq!((scene.pattern.seed, scene.render.seed), (1_507_592_291, 105_927_356));
}

#[test]
fn a_board_is_seen_without_solving() {
    let mut scene = Scene::find("board").unwrap();
    (scene.render.width, scene.render.height) = (48, 40);
    let mut simulation = Simulation::new(&scene).unwrap();
    let press = simulation.solve(&PressCache::OFF, &mut |_| unreachable!("nothing is solved")).unwrap();
    assert_eq!((press.states.len(), press.origin), (21, Origin::Rigid));
    let frames: Vec<_> = (0..21).map(|frame| simulation.frame(frame).unwrap().clone()).collect();
    assert_eq!(frames[0].size(), (48, 40));
    assert_eq!(*simulation.frame(7).unwrap(), frames[7], "frames are the same in any order");
    assert_ne!(frames[0], frames[20]);
}
