//! A tracked press compared with its truth, and comparisons that are refused.

use std::fs;

use fingervision_sink::{ArrayWriter, Element};
use serde_json::Value;

use crate::workbench::{AMPLITUDE_PX, SIZE, Workbench, press_motion};

const FRAMES: u32 = 5;

/// A recording `press`, the truth of its flow in `simulation`, and a made-up depth that goes with it.
fn simulated() -> Workbench {
    let bench = Workbench::new();
    bench.press(FRAMES);
    bench.folder("simulation/truth");
    let along = |frame: u32| f64::from(frame) / f64::from(FRAMES - 1);
    array(&bench, "flow", |frame, x, y| {
        let (u, v) = press_motion().at(along(frame)).displacement(x as f64, y as f64);
        [u as f32, v as f32]
    });
    let is_touched = |x: usize, y: usize| (x as f64 - 63.5).hypot(y as f64 - 47.5) < 25.0;
    array(&bench, "depth", |frame, x, y| if is_touched(x, y) { along(frame) as f32 } else { 0.0 });
    array(&bench, "contact", |frame, x, y| u8::from(frame > 0 && is_touched(x, y)));
    array(&bench, "visible", |_, x, _| u8::from(x > 0));
    let profile = "[camera]\nfocal_length_px = [400.0, 400.0]\nprincipal_point_px = [63.5, 47.5]\n\
                   translation_mm = [0.0, 0.0, 25.0]\n";
    bench.write("simulation/profile.toml", profile);
    bench
}

fn array<T: Element>(bench: &Workbench, name: &str, value: impl Fn(u32, usize, usize) -> T) {
    let (width, height) = SIZE;
    let path = bench.path(&format!("simulation/truth/{name}.npy"));
    let mut writer = ArrayWriter::create(&path, width, height).unwrap();
    for frame in 0..FRAMES {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values: Vec<T> = pixels.map(|(x, y)| value(frame, x, y)).collect();
        writer.write(values.into_iter()).unwrap();
    }
}

fn evaluated(bench: &Workbench, arguments: &str) -> Value {
    serde_json::from_str(&bench.run(arguments).expect_done().out).unwrap()
}

#[test]
fn a_tracked_press_is_compared_with_its_truth() {
    let bench = simulated();
    // A constant depth of 0.25 mm has known errors, whatever the flow.
    bench.write("sensor.toml", "[depth]\ndensity = { slope_mm = 0.0, intercept_mm = 0.25 }");
    bench.run("track press --out run --profile sensor.toml").expect_done();
    let report = evaluated(&bench, "evaluate run simulation --json");
    assert_eq!((&report["frames"], &report["deepest_frame"]), (&Value::from(5), &Value::from(4)));
    assert_eq!(report["fields"], serde_json::json!(["flow", "depth"]));
    let deepest = &report["per_frame"][4];
    let flow = &deepest["flow_px"]["everywhere"];
    let mean = flow["mean"].as_f64().unwrap();
    assert!(mean > 0.0 && mean < 0.1, "the flow of {AMPLITUDE_PX} px is off by {mean} px");
    assert!(flow["correlation"].as_f64().unwrap() > 0.99, "{flow}");
    let inside = &deepest["depth_mm"]["inside"];
    assert_eq!((inside["bias"].as_f64(), inside["largest"].as_f64()), (Some(-0.75), Some(0.75)), "{inside}");
    assert_eq!(deepest["depth_mm"]["outside"]["mean"].as_f64(), Some(0.25));
    assert_eq!(deepest["pixels"]["everywhere"]["hidden"], 96);

    let picture = image::open(bench.path("run/evaluation/evaluation.png")).unwrap();
    assert_eq!((report["picture"].as_str(), picture.width()), (Some("run/evaluation/evaluation.png"), 1600));
}

#[test]
fn the_table_names_every_region_and_where_the_picture_is() {
    let bench = simulated();
    bench.run("track press --out run").expect_done();
    let ended = bench.run("evaluate run simulation/truth --out pictures").expect_done();
    for expected in [
        "frame 4, the deepest",
        "mean of 5 frames",
        "inside contact",
        "within 1 mm of border",
        "outside",
        "note      depth.npy is only in the truth: it is not compared",
        "picture   pictures/evaluation.png",
    ] {
        assert!(ended.out.contains(expected), "no \"{expected}\" in {}", ended.out);
    }
    assert!(!ended.out.contains("NaN") && ended.errors.is_empty(), "{ended:?}");
    assert!(bench.path("pictures/evaluation.png").exists() && !bench.path("run/evaluation").exists());
    assert_eq!(bench.run("evaluate run simulation --quiet").expect_done().out, "");
}

#[test]
fn a_run_on_a_region_is_compared_there() {
    let bench = simulated();
    bench.run("track press --out run --set image.region_of_interest=[10,8,100,64]").expect_done();
    let report = evaluated(&bench, "evaluate run simulation --json");
    assert_eq!(report["region"], serde_json::json!([10, 8, 100, 64]));
    let mean = report["mean"]["flow_px"]["everywhere"]["mean"].as_f64().unwrap();
    assert!(mean < 0.1, "off by {mean} px: is the truth cropped?");
}

#[test]
fn the_truth_of_another_scene_is_refused() {
    let bench = Workbench::new();
    bench.write("disc.toml", "name = \"disc\"\n[motion]\nkind = \"rigid\"\nframes = 2\n");
    let small = "--set render.width=120 --set render.height=90";
    bench.run(&format!("simulate board --frames 2 --out board {small}")).expect_done();
    bench.run(&format!("simulate disc.toml --out disc {small}")).expect_done();
    bench.run("track board/frames --out run --fields flow").expect_done();
    let ended = bench.run("evaluate run disc");
    ended.expect_failure("tracked from the scene \"board\", but disc is the truth of \"disc\"", "\"board\"");
    bench.run("evaluate run board").expect_done();
}

#[test]
fn what_cannot_be_compared_is_named() {
    let bench = simulated();
    bench.run("evaluate run simulation").expect_failure("run: there is no such folder", "track --out");
    bench.run("track press --out run").expect_done();
    bench.run("evaluate simulation run").expect_failure("simulation: it contains neither", "give the run first");
    bench.run("evaluate run run/nowhere").expect_failure("run/nowhere: there is no such folder", "simulate --out");
    bench.write("taken", "a file");
    bench.run("evaluate run simulation --out taken").expect_failure("taken/evaluation.png", "choose another");

    fs::remove_file(bench.path("press/0004.png")).unwrap();
    bench.run("track press --out run --overwrite").expect_done();
    bench.run("evaluate run simulation").expect_failure("run/flow.npy contains 4 frames", "--common-frames");
    let report = evaluated(&bench, "evaluate run simulation --json --common-frames");
    assert_eq!(report["frames"], 4);

    let path = bench.path("simulation/truth/flow.npy");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    bench.run("evaluate run simulation").expect_failure("truth/flow.npy: the header states 5 frames", "cut short");
}
