//! Scenes that are simulated into folders, and scenes that are tracked while they are simulated.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use image::GrayImage;
use serde_json::Value;

use crate::workbench::{Ended, Workbench};

/// A press that is solved quickly, in small images.
const PRESS: &str = "[indenter]\nshape = 'sphere'\nradius_mm = 8.0\n\
    [motion]\nframes = 4\nkeyframes = [{ at = 3, depth_mm = 1.5 }]\n\
    [mesh]\ncells = [12, 12, 3]\n\
    [camera]\nfocal_length_px = [100.0, 100.0]\n\
    [render]\nwidth = 120\nheight = 110\n";

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).unwrap()
}

/// Every file of a folder, by its path from there.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            files.extend(self::files(&path).into_iter().map(|(inner, bytes)| (name.join(inner), bytes)));
        } else {
            files.insert(name, fs::read(path).unwrap());
        }
    }
    files
}

/// A bench with the press simulated into `sim`.
fn pressed(options: &str) -> Workbench {
    pressed_on(Workbench::new(), options)
}

fn pressed_on(bench: Workbench, options: &str) -> Workbench {
    bench.write("press.toml", PRESS);
    bench.run(&format!("simulate press.toml --out sim {options}")).expect_done();
    bench
}

fn force(bench: &Workbench, frame: usize) -> [f64; 3] {
    let table = fs::read_to_string(bench.path("sim/truth/force.csv")).unwrap();
    let row = table.lines().nth(1 + frame).unwrap();
    let values: Vec<f64> = row.split(',').map(|value| value.parse().unwrap()).collect();
    [values[2], values[3], values[4]]
}

#[test]
fn the_folder_has_the_documented_files() {
    let bench = pressed("");
    let expected = [
        "frames/000000.png",
        "frames/000001.png",
        "frames/000002.png",
        "frames/000003.png",
        "preview.png",
        "profile.toml",
        "scene.toml",
        "truth/contact.npy",
        "truth/depth.npy",
        "truth/displacement.npy",
        "truth/flow.npy",
        "truth/force.csv",
        "truth/visible.npy",
    ];
    let found = files(&bench.path("sim"));
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.map(PathBuf::from).iter().collect::<Vec<_>>());
    let (shape, flow) = bench.array_at::<f32>("sim/truth/flow.npy");
    assert_eq!(shape, [4, 110, 120, 2]);
    assert_eq!(bench.array_at::<f32>("sim/truth/displacement.npy").0, [4, 110, 120, 3]);
    let (shape, depth) = bench.array_at::<f32>("sim/truth/depth.npy");
    assert_eq!(shape, [4, 110, 120]);
    assert_eq!(bench.array_at::<u8>("sim/truth/contact.npy").0, [4, 110, 120]);
    assert_eq!(bench.array_at::<u8>("sim/truth/visible.npy").0, [4, 110, 120]);
    let frame = image::open(bench.path("sim/frames/000003.png")).unwrap();
    assert_eq!((frame.width(), frame.height(), frame.color().has_color()), (120, 110, true));
    let table = fs::read_to_string(bench.path("sim/truth/force.csv")).unwrap();
    let mut rows = table.lines();
    assert_eq!(rows.next(), Some("frame,depth_mm,force_x_n,force_y_n,force_z_n,torque_z_nmm"));
    assert_eq!((rows.next(), rows.count()), (Some("0,0,0,0,0,0"), 3));

    assert!(depth[..110 * 120].iter().all(|&depth| depth == 0.0), "the first frame is at rest");
    let middle = 3 * 110 * 120 + 55 * 120 + 60;
    assert!((depth[middle] - 1.5).abs() < 0.1, "{} mm deep", depth[middle]);
    assert!(flow[2 * middle].abs() < 1.0, "the middle stays in the middle");
    assert!(force(&bench, 3)[2] > force(&bench, 1)[2] && force(&bench, 1)[2] > 0.0);
    assert!(bench.array_at::<u8>("sim/truth/contact.npy").1[middle] == 1);
}

#[test]
fn a_scene_gives_the_same_bytes_again() {
    let bench = pressed("--set render.seed=3");
    let first = files(&bench.path("sim"));
    bench.run("simulate press.toml --out again --set render.seed=3").expect_done();
    assert!(files(&bench.path("again")) == first, "from the cache");
    bench.run("simulate sim/scene.toml --out again --overwrite --no-cache").expect_done();
    assert!(files(&bench.path("again")) == first, "from the scene that was written, solved again");
    let mut alone = bench.command("simulate press.toml --out alone --set render.seed=3 --no-cache");
    assert!(alone.env("RAYON_NUM_THREADS", "1").output().unwrap().status.success());
    assert!(files(&bench.path("alone")) == first, "on one thread");
    bench.run("simulate press.toml --out again --overwrite --seed 4").expect_done();
    let other = files(&bench.path("again"));
    let image = Path::new("frames/000001.png");
    assert!(other[image] != first[image], "another seed, another pattern");
    assert!(other[Path::new("truth/depth.npy")] == first[Path::new("truth/depth.npy")]);
}

#[test]
fn a_solved_press_is_taken_from_the_cache() {
    let bench = pressed_on(Workbench::with_empty_cache(), "");
    let press = |options: &str| {
        let ended = bench.run(&format!("simulate press.toml --out sim --overwrite --json {options}")).expect_done();
        json(&ended)["press"].as_str().unwrap().to_owned()
    };
    assert_eq!(press(""), "cache");
    assert_eq!(press("--set render.noise_levels=0 --set camera.focal_length_px=[90,90]"), "cache");
    assert_eq!(press("--set gel.poissons_ratio=0.3"), "solved");
    assert_eq!(press("--frames 3"), "solved");
    assert_eq!(press("--no-cache"), "solved");
    let entry = |bytes: u8| {
        for entry in fs::read_dir(bench.path("cache")).unwrap() {
            fs::write(entry.unwrap().path(), [bytes; 100]).unwrap();
        }
    };
    entry(0);
    let ended = bench.run("simulate press.toml --out sim --overwrite").expect_done();
    assert!(
        ended.errors.contains("in the cache of solved presses is damaged; the press was solved again"),
        "{ended:?}"
    );
    assert_eq!(press(""), "cache");
    let doctor = json(&bench.run("doctor --json").expect_done());
    assert_eq!(doctor["cache"]["presses"], 3, "{doctor}");
}

#[test]
fn a_press_that_finds_no_rest_keeps_the_frames_before() {
    let bench = Workbench::new();
    bench.write("press.toml", PRESS);
    let course = "--set motion.keyframes=[{at=1,depth_mm=1},{at=3,depth_mm=9.9}]";
    let ended = bench.run(&format!("simulate press.toml --out sim --set gel.poissons_ratio=0.4999 {course}"));
    let ended = ended.expect_failure("did not converge", "press less deep");
    assert!(ended.errors.contains(" of 4 frames are written"), "{ended:?}");
    let (shape, _) = bench.array_at::<f32>("sim/truth/depth.npy");
    assert!((2..4).contains(&shape[0]), "{shape:?}");
    assert_eq!(fs::read_dir(bench.path("sim/frames")).unwrap().count() as u64, shape[0]);
}

#[test]
fn only_the_truth_is_written_where_that_is_asked() {
    let bench = pressed("--truth-only");
    assert!(!bench.path("sim/frames").exists());
    assert_eq!(bench.array_at::<f32>("sim/truth/depth.npy").0[0], 4);
}

#[test]
fn frames_are_tracked_with_the_profile_beside_them_or_as_they_are_simulated() {
    let bench = pressed("");
    bench.run("track sim/frames --profile sim/profile.toml --out run --fps 50").expect_done();
    let offline = fs::read(bench.path("run/flow.npy")).unwrap();
    let times = bench.column("capture_time_s");
    let ended = bench.run("track sim:press.toml?fps=50 --out run --overwrite").expect_done();
    assert!(ended.out.contains("4 frames of 120x110 px"), "{}", ended.out);
    assert!(fs::read(bench.path("run/flow.npy")).unwrap() == offline, "live and offline are the same");
    assert_eq!((bench.column("capture_time_s"), times[1].as_str()), (times.clone(), "0.02"));
    let record = fs::read_to_string(bench.path("run/run.toml")).unwrap();
    assert!(record.contains("sim:press.toml?fps=50: 4 images, 120x110 px 8-bit colour"), "{record}");
    assert!(record.contains("focal_length_px = [100.0, 100.0]"), "the scene's camera is known: {record}");
    bench.run("track sim:leter --out run2").expect_failure("no scene leter", "did you mean letter?");
    bench.run("track sim:letter?speed=2 --out run2").expect_failure("the option speed=2", "fps=RATE");
}

#[test]
fn the_board_slides_by_half_a_millimetre_a_frame() {
    let bench = Workbench::new();
    let ended = bench.run("simulate board --out sim --set render.width=60 --set render.height=50").expect_done();
    assert!(ended.out.contains("next     fingervision calibrate camera sim/frames --step-mm 0.5 "), "{}", ended.out);
    let (shape, moved) = bench.array_at::<f32>("sim/truth/displacement.npy");
    assert_eq!(shape, [21, 50, 60, 3]);
    for frame in 0..21 {
        let found = &moved[frame * 50 * 60 * 3..][..3];
        let expected = 0.5 * frame as f32;
        assert!((found[0] - expected).abs() < 1e-5 && found[1] == 0.0 && found[2] == 0.0, "{found:?} in {frame}");
    }
    assert!(fs::read_to_string(bench.path("sim/profile.toml")).unwrap().contains("k1 = -0.08"));
}

#[test]
fn random_scenes_are_the_same_for_the_same_seed() {
    let bench = Workbench::new();
    let options = "--truth-only --frames 2 --set mesh.cells=[12,12,3] --set render.width=40 --set render.height=40";
    let ended = bench.run(&format!("simulate --random 2 --seed 7 --out a {options}")).expect_done();
    assert_eq!(ended.out.lines().count(), 2, "{}", ended.out);
    bench.run(&format!("simulate --random 3 --seed 7 --out b --no-cache {options}")).expect_done();
    let (a, b) = (files(&bench.path("a")), files(&bench.path("b")));
    assert_eq!(a.keys().filter(|path| path.ends_with("scene.toml")).count(), 2);
    assert!(a.iter().all(|(path, bytes)| b[path] == *bytes));
    let scene = Path::new("scene.toml");
    assert!(b[&Path::new("scene-0001").join(scene)] != b[&Path::new("scene-0002").join(scene)]);
}

#[test]
fn the_file_of_an_indenter_is_taken_along() {
    let bench = Workbench::with_empty_cache();
    let scene = PRESS.replace(
        "shape = 'sphere'\nradius_mm = 8.0",
        "shape = 'height-map'\nfile = 'coin.png'\nsize_mm = [8, 8]\nheight_mm = 1.0",
    );
    bench.write("press.toml", &scene);
    let missing = bench.run("simulate press.toml --out sim");
    missing.expect_failure("press.toml, line 3: indenter.file: cannot read", "relative to the scene's folder");
    assert!(!bench.path("sim").exists());
    GrayImage::from_fn(20, 20, |x, y| [(10 * x + y) as u8].into()).save(bench.path("coin.png")).unwrap();
    bench.run("simulate press.toml --out sim").expect_done();
    fs::remove_file(bench.path("coin.png")).unwrap();
    let ended = bench.run("simulate sim/scene.toml --out again --json").expect_done();
    assert_eq!(json(&ended)["press"], "cache", "the same body wherever its file lies");
    assert!(files(&bench.path("again")) == files(&bench.path("sim")));
}

#[test]
fn an_interrupted_simulation_keeps_what_was_written() {
    let bench = Workbench::new();
    let arguments = "simulate board --out sim --frames 3000 --set render.width=40 --set render.height=30";
    let mut child = bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let table = bench.path("sim/truth/force.csv");
    while !fs::read_to_string(&table).is_ok_and(|table| table.lines().count() > 2) {
        assert!(child.try_wait().unwrap().is_none(), "the simulation ended before it was interrupted");
        std::thread::yield_now();
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let ended = Ended::from(child.wait_with_output().unwrap());
    ended.expect_failure_with(130, "of 3000 frames", "the frames written so far can be used");
    let (shape, _) = bench.array_at::<f32>("sim/truth/depth.npy");
    assert_eq!(fs::read_to_string(&table).unwrap().lines().count() as u64, 1 + shape[0]);
    assert!(bench.path("sim/preview.png").exists());
}

#[test]
fn ready_made_scenes_are_listed() {
    let bench = Workbench::new();
    let text = bench.run("simulate --list").expect_done().out;
    assert_eq!(text.lines().count(), 23);
    assert!(text.lines().any(|line| line.starts_with("letter ") && line.contains("the letter R")), "{text}");
    let list = json(&bench.run("simulate --list --json").expect_done());
    assert_eq!(list[0]["name"], "circle");
}

#[test]
fn what_cannot_be_is_named_before_anything_is_written() {
    let bench = Workbench::new();
    bench.write("press.toml", "[gel]\npoissons_ratio = 0.5\n");
    bench.write("key.toml", "\n[indenter]\nshape = 'circle'\nradius_mm = 3\nfilet_mm = 0.3\n");
    for (arguments, error, hint) in [
        ("press.toml", "press.toml, line 2: gel.poissons_ratio = 0.5 is impossible", "below 0.5"),
        ("key.toml", "key.toml, line 5: unknown key indenter.filet_mm", "did you mean indenter.fillet_mm?"),
        ("circel", "no scene circel", "did you mean circle?"),
        ("away.toml", "cannot read the scene away.toml: no such file", "--list"),
        ("circle --set gel.thickness_mm=0", "gel.thickness_mm = 0.0 is impossible", "above 0 mm"),
        ("circle --set indenter.radius_mm=16", "indenter.radius_mm = 16", "smaller indenter"),
        ("circle --set motion.keyframes=[{at=1,depth_mm=-1}]", "motion.keyframes[0].depth_mm = -1.0", "0 mm or more"),
        ("circle --set motion.depth=2", "unknown key motion.depth", "motion has the keys"),
        ("circle --frames 1", "motion.frames = 1 is impossible", "2 to 100000"),
    ] {
        bench.run(&format!("simulate {arguments} --out sim")).expect_failure(error, hint);
        assert!(!bench.path("sim").exists(), "{arguments}");
    }
}

#[test]
fn a_previous_simulation_is_replaced_only_when_asked() {
    let bench = pressed("--set motion.frames=5");
    bench.run("simulate press.toml --out sim").expect_failure("sim contains a previous simulation", "--overwrite");
    bench.run("simulate press.toml --out sim --overwrite").expect_done();
    assert_eq!(fs::read_dir(bench.path("sim/frames")).unwrap().count(), 4, "no frame of the longer one is left");
    bench.folder("other");
    bench.write("other/notes.txt", "mine");
    bench.run("simulate press.toml --out other --overwrite").expect_failure("not a simulation", "choose a new");
}
