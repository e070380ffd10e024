//! `calibrate` without a subcommand: guides the user from an empty folder to a profile.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use image::DynamicImage;
use serde_json::Value;

use crate::workbench::{Ended, Workbench, save};

/// A scene with a small image; `rest` is the other part of the scene.
fn scene(rest: &str) -> String {
    format!(
        "[camera]\nfocal_length_px = [133.0, 133.0]\nrotation_rad = [0.03, -0.02, 0.01]\n\
         [pattern]\ncell_mm = 0.6\n[render]\nwidth = 160\nheight = 120\n{rest}"
    )
}

/// The board at so many places along x, from there to there.
fn board(images: usize, slide_mm: f64) -> String {
    scene(&format!(
        "[gel]\nsize_mm = [70.0, 60.0]\n[motion]\nkind = 'rigid'\nframes = {images}\n\
         keyframes = [{{ at = {}, shear_mm = [{slide_mm}, 0.0] }}]\n",
        images - 1
    ))
}

/// The untouched gel of the presses.
fn rest() -> String {
    scene(
        "[gel]\nsize_mm = [36.0, 30.0]\n[motion]\nkind = 'rigid'\nframes = 10\nkeyframes = [{ at = 9, shear_mm = [0.0, 0.0] }]\n",
    )
}

/// A square pressed in on a coarse mesh.
fn press(centre_mm: [f64; 2], depth_mm: f64) -> String {
    scene(&format!(
        "[gel]\nsize_mm = [36.0, 30.0]\n[indenter]\nshape = 'rectangle'\nsize_mm = [6.0, 6.0]\n[mesh]\ncells = [18, 15, 3]\n\
         [motion]\ncentre_mm = {centre_mm:?}\nframes = 5\nkeyframes = [{{ at = 4, depth_mm = {depth_mm:?} }}]\n"
    ))
}

fn simulate(bench: &Workbench, name: &str, scene: &str) {
    bench.write("scene.toml", scene);
    let _ = fs::remove_dir_all(bench.path(&format!("sensor/{name}")));
    bench.run(&format!("simulate scene.toml --out sensor/{name}")).expect_done();
}

fn guide(bench: &Workbench, options: &str) -> Ended {
    bench.run(&format!("calibrate --folder sensor {options}"))
}

/// The state of every step.
fn states(bench: &Workbench) -> Vec<String> {
    let result: Value = serde_json::from_str(&guide(bench, "--json").out).unwrap();
    let steps = result["steps"].as_array().unwrap().iter();
    steps.map(|step| format!("{} {}", step["name"].as_str().unwrap(), step["state"].as_str().unwrap())).collect()
}

fn expect(ended: &Ended, texts: &[&str]) {
    for text in texts {
        assert!(ended.out.contains(text), "no \"{text}\" in {}", ended.out);
    }
}

#[test]
fn a_person_is_led_from_an_empty_folder_to_a_profile() {
    let bench = Workbench::new();
    expect(
        &guide(&bench, "").expect_done(),
        &[
            "next      still",
            "-         board",
            "-         press-3",
            "into sensor/still",
            "Then: fingervision calibrate --folder sensor",
        ],
    );
    assert!(bench.path("sensor/still").is_dir());

    simulate(&bench, "still", &rest());
    let ended = guide(&bench, "").expect_done();
    expect(
        &ended,
        &["done      still     10 images", "noise 2.0 levels", "next      board", "21 images", "into sensor/board"],
    );

    simulate(&bench, "board", &board(8, 3.5));
    let ended = guide(&bench, "");
    expect(&ended, &["redo      board     8 images", "Again: board", "Replace what is in sensor/board"]);
    ended.expect_failure("board: 8 images; required: at least 21", "20 equal steps");
    simulate(&bench, "board", &board(21, -10.0));
    guide(&bench, "").expect_failure("board: the board moves towards", "--direction");
    simulate(&bench, "board", &board(21, 10.0));
    expect(
        &guide(&bench, "").expect_done(),
        &["done      board     21 images", "next      distance", "--distance-mm 25±0.5"],
    );

    let ended = guide(&bench, "--distance-mm 25±0.5").expect_done();
    expect(&ended, &["done      distance  25 ± 0.5 mm", "next      press-1", "depth.csv", "into sensor/press-1"]);
    assert!(bench.path("sensor/press-1").is_dir());

    simulate(&bench, "press-1", &press([0.0, 0.0], 2.0));
    simulate(&bench, "press-2", &press([4.0, 0.0], 2.0));
    simulate(&bench, "press-3", &press([-6.0, 4.0], 2.0));
    fs::rename(bench.path("sensor/press-2/truth"), bench.path("truth")).unwrap();
    let ended = guide(&bench, "");
    expect(&ended, &["done      press-1", "redo      press-2", "done      press-3"]);
    ended.expect_failure("press-2: it has no depth.csv", "write depth.csv beside the images");
    fs::rename(bench.path("truth"), bench.path("sensor/press-2/truth")).unwrap();

    let ended = guide(&bench, "").expect_done();
    expect(&ended, &["camera    residual 0.0", "depth     error 0.1", "fingervision track RECORDING"]);
    let profile = fs::read_to_string(bench.path("sensor/sensor.toml")).unwrap();
    assert!(profile.contains("[camera]") && profile.contains("[depth]"), "{profile}");
    assert!(profile.contains("noise_levels = "), "the noise that was measured: {profile}");
    bench.run("track sensor/press-1/frames --profile sensor/sensor.toml --out run").expect_done();
    let deepest: f64 = bench.column("max_depth_mm")[4].parse().unwrap();
    assert!((deepest - 2.0).abs() < 0.3, "{deepest} mm instead of 2 mm");
    // What is calibrated stays so, and says the same again.
    assert_eq!(states(&bench).iter().filter(|state| state.ends_with(" done")).count(), 6);
    assert_eq!(fs::read_to_string(bench.path("sensor/sensor.toml")).unwrap(), profile);
    expect_nothing_left(&bench, &profile);
}

/// A guide that is ended while it fits leaves the profile as it is, and no draft of it.
fn expect_nothing_left(bench: &Workbench, profile: &str) {
    let draft = bench.path("sensor/sensor.toml.draft");
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let mut child =
            bench.command("calibrate --folder sensor").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !draft.exists() {
            assert!(child.try_wait().unwrap().is_none(), "the guide ended before it was interrupted");
        }
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{signal}");
        assert!(!draft.exists(), "{signal} leaves a draft");
        assert_eq!(fs::read_to_string(bench.path("sensor/sensor.toml")).unwrap(), profile);
    }
    // One that was killed at once cannot remove it: the next one begins anew.
    fs::write(&draft, "[camera]\nhalf a").unwrap();
    fs::remove_file(bench.path("sensor/sensor.toml")).unwrap();
    guide(bench, "").expect_done();
    assert!(bench.path("sensor/sensor.toml").exists() && !draft.exists());
}

#[test]
fn recordings_that_cannot_be_read_are_to_be_done_again() {
    let bench = Workbench::new();
    bench.folder("sensor/still");
    bench.write("sensor/still/0000.png", "no picture");
    bench.write("sensor/still/0001.png", "no picture");
    guide(&bench, "").expect_failure("still: sensor/still/0000.png: frame 0", "");
    for (number, width) in [(0, 160), (1, 128)] {
        save(&DynamicImage::new_rgb8(width, 120), &bench.path("sensor/still"), number);
    }
    guide(&bench, "").expect_failure("still: sensor/still/0001.png: frame 1", "");
    assert_eq!(states(&bench)[..2], ["still redo", "board later"]);
    bench.write("sensor/sensor.toml", "[image]\nregion_of_interest = [15, 15, 610, 450]\n");
    guide(&bench, "")
        .expect_failure("still: image.region_of_interest = [15, 15, 610, 450] reaches outside", "[0, 0, 160");
}

#[test]
fn answers_are_kept_and_wrong_ones_are_named() {
    let bench = Workbench::new();
    guide(&bench, "--distance-mm 31+-0.5 --step-mm 1 --direction y").expect_done();
    expect(&guide(&bench, "").expect_done(), &["done      distance  31 ± 0.5 mm"]);
    let answers = fs::read_to_string(bench.path("sensor/answers.toml")).unwrap();
    assert!(answers.contains("step_mm = 1.0") && answers.contains("direction_deg = 90.0"), "{answers}");
    bench.write("sensor/answers.toml", "step_mm = -1.0\n");
    guide(&bench, "").expect_failure("sensor/answers.toml: -1 mm is not a length", "remove the file");
    bench.write("sensor/answers.toml", "step = 1.0\n");
    guide(&bench, "").expect_failure("sensor/answers.toml: unknown field `step`", "remove the file");
}

/// A sensor's folder with all that a calibration needs.
fn recorded() -> Workbench {
    let bench = Workbench::new();
    simulate(&bench, "still", &rest());
    simulate(&bench, "board", &board(21, 10.0));
    for (number, centre_mm) in [(1, [0.0, 0.0]), (2, [4.0, 0.0]), (3, [-6.0, 4.0])] {
        simulate(&bench, &format!("press-{number}"), &press(centre_mm, 2.0));
    }
    bench
}

/// Puts other images in the place of those of press-2.
fn reorder(bench: &Workbench, order: &[usize]) {
    let image = |number: usize| bench.path(&format!("sensor/press-2/frames/{number:06}.png"));
    let images: Vec<Vec<u8>> = order.iter().map(|&number| fs::read(image(number)).unwrap()).collect();
    for (number, bytes) in images.into_iter().enumerate() {
        fs::write(image(number), bytes).unwrap();
    }
}

#[test]
fn a_wrong_input_is_refused_with_what_to_do_and_no_profile_is_written() {
    let bench = recorded();
    let refused = |options: &str, what: &str, hint: &str| {
        guide(&bench, &format!("--distance-mm 25±0.5 {options}")).expect_failure(what, hint);
        assert!(!bench.path("sensor/sensor.toml").exists(), "{what}: a profile was written");
    };
    let depths = |rows: [&str; 5]| bench.write("sensor/press-2/depth.csv", &format!("depth_mm\n{}\n", rows.join("\n")));
    depths(["0", "500", "1000", "1500", "2000"]);
    refused("", "press-2: its largest depth is 2000 mm", "divide the column by 1000");
    depths(["0", "20", "40", "60", "80"]);
    refused("", "press-2: its largest depth is 80 mm", "divide the column by 1000");
    depths(["0", "-0.5", "-1", "-1.5", "-2"]);
    refused("", "press-2: frame 1 is -0.5 mm deep", "reverse the signs");
    depths(["0", "0.5", "1", "1.5", "2"]);
    reorder(&bench, &[0, 4, 3, 1, 2]);
    refused("", "press-2: motion does not grow with depth", "number the images in the order");
    simulate(&bench, "press-2", &press([4.0, 0.0], 2.0));
    reorder(&bench, &[4, 3, 2, 1, 0]);
    refused("", "press-2: in the first image a part of the gel is", "before the indenter touches");
    simulate(&bench, "press-2", &press([4.0, 0.0], 2.0));
    reorder(&bench, &[2, 2, 3, 3, 4]);
    refused("", "press-2: in the first image a part of the gel is", "before the indenter touches");
    simulate(&bench, "press-2", &press([4.0, 0.0], 2.0).replace("[pattern]", "[pattern]\nseed = 9"));
    refused("", "of the first image matches the image of the untouched gel", "a recording of this sensor");
    simulate(&bench, "press-2", &press([4.0, 0.0], 2.0));
    refused("--step-mm 1 --view-mm 30", "but --view-mm is 30 mm", "the step was 0.50 mm");
    refused("--step-mm 0.25 --view-mm 30", "but --view-mm is 30 mm", "the step was 0.50 mm");
    expect(&guide(&bench, "--step-mm 0.5").expect_done(), &["The sensor is calibrated", "done      view      30 mm"]);
}

#[test]
fn a_press_that_is_a_copy_of_another_is_to_be_done_again() {
    let bench = Workbench::new();
    simulate(&bench, "press-1", &press([0.0, 0.0], 2.0));
    simulate(&bench, "press-2", &press([0.0, 0.0], 2.0));
    let ended = guide(&bench, "");
    expect(&ended, &["done      press-1", "redo      press-2   it is a copy of press-1; required: another press"]);
    ended.expect_failure("press-2: it is a copy of press-1; required: another press", "record another press");
}

#[test]
fn a_recording_that_has_not_changed_is_not_checked_again() {
    let bench = Workbench::new();
    simulate(&bench, "still", &rest());
    expect(&guide(&bench, "").expect_done(), &["done      still     10 images"]);
    let checks = fs::read_to_string(bench.path("sensor/checks.json")).unwrap();
    bench.write("sensor/checks.json", &checks.replace("\"images\": 10", "\"images\": 77"));
    expect(&guide(&bench, "").expect_done(), &["done      still     77 images"]);
    let image = bench.path("sensor/still/frames/000003.png");
    let mut other = image::open(&image).unwrap().into_rgb8();
    other.put_pixel(0, 0, image::Rgb([1, 2, 3]));
    other.save(&image).unwrap();
    expect(&guide(&bench, "").expect_done(), &["done      still     10 images"]);
}

#[test]
fn a_gel_that_is_described_gives_elastic_depth() {
    let bench = recorded();
    expect(&guide(&bench, "--distance-mm 25±0.5").expect_done(), &["optional  gel", "--gel-mm WIDTH,HEIGHT,THICKNESS"]);
    let ended = guide(&bench, "--gel-mm 36,30,10 --youngs-modulus-mpa 0.6").expect_done();
    expect(&ended, &["done      gel       36 × 30 × 10 mm, 0.6 MPa", "Depth and contact come from elasticity"]);
    let profile = fs::read_to_string(bench.path("sensor/sensor.toml")).unwrap();
    assert!(profile.contains("[gel]") && profile.contains("size_mm = [36.0, 30.0]"), "{profile}");
    bench.run("track sensor/press-1/frames --profile sensor/sensor.toml --out run").expect_done();
    let force: f64 = bench.column("force_z_n")[4].parse().unwrap();
    assert!(force > 1.0, "{force} N");
}

#[test]
fn a_camera_takes_the_recordings_when_told() {
    let bench = Workbench::new();
    bench.write("scene.toml", &rest());
    let mut command = bench.command("calibrate --folder sensor --camera sim:scene.toml?loop --port 0");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"\n\n\n").unwrap();
    let ended = Ended::from(child.wait_with_output().unwrap()).expect_done();
    expect(&ended, &["Touch nothing. Press Enter to take 30 images", "done      still", "Image 3 of 21: press Enter"]);
    assert!(ended.errors.contains("the camera's image: http://127.0.0.1:"), "{ended:?}");
    let images = |name: &str| fs::read_dir(bench.path(name)).unwrap().count();
    assert_eq!(images("sensor/still"), 30);
    assert_eq!(images("sensor/board"), 0, "a recording that is not complete replaces nothing");
    bench.run("calibrate --folder sensor --camera camera:absent").expect_failure("camera", "");
}
