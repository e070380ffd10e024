//! `profile new`, `show` and `check`, and a run's own record as profile.

use std::fs;
use std::path::Path;

use fingervision_gel::Motion;
use fingervision_touch::Profile;
use serde_json::Value;

use crate::workbench::{Ended, Workbench, picture, save};

const KNOWN: &str = "--image-size 640x480 --region-of-interest 15,15,610,450 --distance-mm 25 --view-width-mm 38.125 \
                     --gel-size-mm 30,30 --thickness-mm 10";

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {ended:?}"))
}

#[test]
fn a_new_profile_contains_the_known_values_and_explains_the_others() {
    let bench = Workbench::new();
    let ended = bench.run(&format!("profile new --out sensor.toml {KNOWN}")).expect_done();
    assert!(ended.errors.contains("note: no gel.youngs_modulus_mpa: no force"), "{}", ended.errors);
    assert!(ended.out.contains("fingervision profile check sensor.toml"), "{}", ended.out);
    let profile = Profile::load(&bench.path("sensor.toml")).unwrap();
    let camera = profile.camera.unwrap();
    assert_eq!((camera.focal_length_px, camera.principal_point_px), ([400.0; 2], [304.5, 224.5]));
    assert_eq!(profile.gel.map(|gel| gel.size_mm), Some([30.0; 2]));
    assert!(fs::read_to_string(bench.path("sensor.toml")).unwrap().contains("# youngs_modulus_mpa = 0.6"));
    bench.run("profile check sensor.toml").expect_done();
}

#[test]
fn a_new_profile_replaces_a_file_only_on_request() {
    let bench = Workbench::new();
    bench.run("profile new --out sensor.toml").expect_done();
    let ended = bench.run("profile new --out sensor.toml --thickness-mm 8 --gel-size-mm 20,20");
    ended.expect_failure("sensor.toml exists already", "--overwrite");
    assert_eq!(Profile::load(&bench.path("sensor.toml")).unwrap().gel, None, "the file is as it was");
    bench.run("profile new --out sensor.toml --thickness-mm 8 --gel-size-mm 20,20 --overwrite").expect_done();
    assert!(Profile::load(&bench.path("sensor.toml")).unwrap().gel.is_some());
    let ended = bench.run("profile new --out nowhere/sensor.toml");
    ended.expect_failure("cannot write the profile nowhere/sensor.toml", "in an existing folder");
}

#[test]
fn a_new_profile_that_cannot_be_is_not_written() {
    let bench = Workbench::new();
    let ended = bench.run("profile new --out sensor.toml --image-size 320x240 --region-of-interest 15,15,610,450");
    ended.expect_failure("reaches outside the frames of 320x240 px", "[0, 0, 320, 240]");
    let ended = bench.run("profile new --out sensor.toml --gel-size-mm 30,30 --thickness-mm 10000");
    ended.expect_failure("gel.thickness_mm = 10000.0 is impossible", "");
    let ended = bench.run("profile new --out sensor.toml --distance-mm 25 --view-width-mm 30");
    ended.expect_failure("--view-width-mm 30 gives no focal length", "--image-size");
    assert!(!bench.path("sensor.toml").exists());
}

#[test]
fn show_lists_the_quantities_that_a_profile_enables() {
    let bench = Workbench::new();
    bench.run(&format!("profile new --out sensor.toml {KNOWN}")).expect_done();
    let text = bench.run("profile show sensor.toml").expect_done().out;
    for line in [
        "tracked         610x450 px at (15, 15)",
        "depth           elastic",
        "force           no",
        "pixel           0.0625 mm",
        "field of view   38.1 x 28.1 mm",
        "training range  inside",
        "policy = \"anchored\"",
    ] {
        assert!(text.contains(line), "no \"{line}\" in {text}");
    }
    let shown = json(&bench.run("profile show sensor.toml --set gel.youngs_modulus_mpa=0.6 --json").expect_done());
    assert_eq!((&shown["has_force"], &shown["depth"]), (&true.into(), &"elastic".into()));
    assert_eq!(shown["profile"]["density"]["sigma_px"].as_f64(), Some(2.0));
    let toml = bench.run("profile show sensor.toml --toml").expect_done().out;
    assert_eq!(Profile::from_toml(&toml).unwrap(), Profile::load(&bench.path("sensor.toml")).unwrap());
    bench.run("profile show nowhere.toml").expect_failure("nowhere.toml: no such file", "");
}

#[test]
fn a_fault_makes_a_check_fail() {
    let bench = Workbench::new();
    bench.run(&format!("profile new --out sensor.toml {KNOWN}")).expect_done();
    let sound = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    let wrong = |from: &str, to: &str| {
        assert!(sound.contains(from), "{from}");
        bench.write("wrong.toml", &sound.replace(from, to));
        bench.run("profile check wrong.toml")
    };
    wrong("[30.0, 30.0]", "[30000.0, 30000.0]")
        .expect_failure("gel.size_mm = [30000.0, 30000.0] is impossible", "divide a value in µm by 1000");
    wrong("# youngs_modulus_mpa = 0.6", "youngs_modulus_mpa = 600.0")
        .expect_failure("gel.youngs_modulus_mpa = 600 MPa", "write 0.6 if this is in kPa");
    wrong("[0.0, 0.0, 25.0]", "[300.0, 0.0, 25.0]").expect_failure("does not see the gel", "translation_mm");
    wrong("[400.0, 400.0]", "[4.0, 4.0]").expect_failure("camera.focal_length_px = 4 px", "in px");
    wrong("thickness_mm", "thickness").expect_failure("unknown key gel.thickness", "did you mean");
    let warned = wrong("thickness_mm = 10.0", "thickness_mm = 3.0").expect_done();
    assert!(warned.out.contains("warning") && warned.out.contains("training range"), "{}", warned.out);
    let checked = bench.run("profile check wrong.toml --json").expect_done();
    assert_eq!(json(&checked)["remarks"][0]["weight"], "warning");
}

#[test]
fn a_check_takes_the_size_of_a_recordings_frames() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run(&format!("profile new --out sensor.toml {KNOWN}")).expect_done();
    let ended = bench.run("profile check sensor.toml press");
    let ended = ended.expect_failure("reaches outside the frames of 128x96 px", "[0, 0, 128, 96]");
    assert!(ended.out.contains("frames          128x96 px"), "{}", ended.out);
    bench.write("bare.toml", "name = 'bare'");
    let ended = bench.run("profile check bare.toml press").expect_done();
    assert!(ended.out.contains("missing         no [camera]") && ended.out.contains("no faults"), "{}", ended.out);
}

#[test]
fn the_record_of_a_run_tracks_to_the_same_bytes() {
    let bench = Workbench::new();
    bench.press(3);
    let set = "--set flow.noise_levels=3 --set density.sigma_px=2.3 --set depth.density={slope_mm=2,intercept_mm=0.1}";
    bench.run(&format!("track press --out run {set}")).expect_done();
    let arrays = |run: &str| {
        ["flow", "density", "depth", "valid"].map(|name| fs::read(bench.path(&format!("{run}/{name}.npy"))).unwrap())
    };
    bench.run("track press --out again --profile run/run.toml").expect_done();
    assert!(arrays("run") == arrays("again"), "the runs differ");
    let [before, after] =
        ["run", "again"].map(|run| fs::read_to_string(bench.path(&format!("{run}/run.toml"))).unwrap());
    assert_eq!(before, after);
    bench.run("bench --frames 3 --profile run/run.toml --set image.region_of_interest=[0,0,128,96]").expect_done();
    bench.run("profile check run/run.toml press").expect_done();
}

#[test]
fn a_calibration_leaves_the_record_of_a_run_alone() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run("track press --out run").expect_done();
    let before = fs::read(bench.path("run/run.toml")).unwrap();
    for command in ["depth press", "gel press", "camera press --step-mm 0.5"] {
        let ended = bench.run(&format!("calibrate {command} --profile run/run.toml"));
        ended.expect_failure("run/run.toml is the record of a run", "profile show run/run.toml --toml > sensor.toml");
    }
    assert!(fs::read(bench.path("run/run.toml")).unwrap() == before);
}

#[test]
fn the_bench_takes_any_profile_that_can_be_tracked() {
    let bench = Workbench::new();
    let mut texts: Vec<(String, String)> = Vec::new();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    for page in ["docs/hardware.md", "docs/profile.md"] {
        let text = fs::read_to_string(root.join(page)).unwrap();
        let blocks = text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
        texts.extend(blocks.filter(|block| block.contains("[gel]")).map(|block| (page.to_string(), block.to_string())));
    }
    assert_eq!(texts.len(), 2, "the profiles that are printed");
    let sensor = |region: &str, centre: &str| {
        format!(
            "{region}[camera]\nfocal_length_px = [200.0, 200.0]\nprincipal_point_px = {centre}\ntranslation_mm = [0.0, 0.0, 25.0]\n\
             [gel]\nsize_mm = [30.0, 30.0]\nthickness_mm = 10.0\npoissons_ratio = 0.35\nyoungs_modulus_mpa = 0.6"
        )
    };
    texts.push(("no region".into(), sensor("", "[119.5, 119.5]")));
    texts.push(("a small region".into(), sensor("[image]\nregion_of_interest = [600, 500, 90, 70]\n", "[44.5, 34.5]")));
    for (name, text) in texts {
        bench.write("sensor.toml", &text);
        bench.run("profile check sensor.toml").expect_done();
        // A part of the printed images is enough.
        let part = if name.ends_with("region") { "" } else { "--set image.region_of_interest=[0,0,240,180]" };
        let ended = bench.run(&format!("bench --frames 1 --profile sensor.toml --json {part}")).expect_done();
        let report = json(&ended);
        let mean = report["epe_px"]["mean"].as_f64().unwrap();
        assert!(mean < 0.1, "{name}: off by {mean} px on average");
        if name == "no region" {
            assert_eq!(report["size"], serde_json::json!([240, 240]));
        }
    }
    bench.write("sensor.toml", "[image]\nregion_of_interest = [0, 0, 100000, 100000]");
    bench.run("bench --profile sensor.toml").expect_failure("100000x100000 px", "");
}

#[test]
fn a_profile_that_cannot_be_read_or_written_is_named_with_what_to_do() {
    let bench = Workbench::new();
    bench.folder("sensor");
    bench
        .run("profile show sensor")
        .expect_failure("cannot read the profile sensor: is a directory", "name the profile's file");
    fs::write(bench.path("utf16.toml"), b"\xff\xfen\0a\0").unwrap();
    bench.run("profile show utf16.toml").expect_failure("utf16.toml: it is not UTF-8 text", "in UTF-8");
    bench.write("negative.toml", "[image]\nregion_of_interest = [-15, 15, 100, 100]\n");
    let ended = bench.run("profile check negative.toml");
    ended.expect_failure("invalid value: integer `-15`, expected a whole number, 0 or more", "");
    bench
        .run("profile new --out nowhere/a.toml")
        .expect_failure("nowhere/a.toml: there is no such folder", "existing folder");
    bench.write("small.toml", "[image]\nregion_of_interest = [1, 1, 20, 40]\n");
    bench.run("profile check small.toml").expect_failure("image.region_of_interest = 20x40 px", "32 px or more");
}

#[test]
fn a_fingerprint_in_the_profile_tells_another_sensor() {
    let bench = Workbench::new();
    bench.press(3);
    for frame in 0..3 {
        save(&picture(&Motion::STILL, 99, u64::from(frame)).into(), &bench.folder("other"), frame);
    }
    bench.write("sensor.toml", "name = 'left' # index\n");
    let ended = bench.run("profile fingerprint sensor.toml press --json").expect_done();
    let text = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    assert!(text.starts_with("name = 'left' # index\n\n[pattern]\nfingerprint = \""), "{text}");
    assert!(text.contains(json(&ended)["fingerprint"].as_str().unwrap()), "{text}");
    let flagged = |recording: &str| {
        let run = format!("track {recording} --out run --overwrite --profile sensor.toml --json");
        json(&bench.run(&run).expect_done())["flagged"]["other-sensor"].as_u64()
    };
    assert_eq!((flagged("press"), flagged("other")), (None, Some(3)));
    let ended = bench.run("profile fingerprint sensor.toml other").expect_done();
    assert!(ended.out.contains("before   that of another sensor: "), "{}", ended.out);
    assert_eq!((flagged("press"), flagged("other")), (Some(3), None));
}

#[test]
fn a_fingerprint_needs_texture() {
    let bench = Workbench::new();
    let grey = image::GrayImage::from_pixel(96, 64, image::Luma([90]));
    for frame in 0..2 {
        save(&grey.clone().into(), &bench.folder("grey"), frame);
    }
    bench.write("sensor.toml", "name = 'left'\n");
    let ended = bench.run("profile fingerprint sensor.toml grey");
    ended.expect_failure("the first image of grey has too little texture for a fingerprint", "light, focus");
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), "name = 'left'\n");
}
