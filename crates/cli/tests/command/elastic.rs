//! Tracking with a profile of camera and gel: depth from elasticity, with contact, displacement and force.

use std::fs;

use serde_json::Value;

use crate::workbench::Workbench;

const SENSOR: &str = "[camera]\nfocal_length_px = [128.0, 128.0]\nprincipal_point_px = [63.5, 47.5]\n\
                      translation_mm = [0.0, 0.0, 25.0]\n\
                      [gel]\nsize_mm = [30.0, 30.0]\nthickness_mm = 10.0\npoissons_ratio = 0.48\n";
/// A press that is solved in a second, in small images.
const PRESS: &str = "[indenter]\nshape = 'sphere'\nradius_mm = 8.0\n\
    [motion]\nframes = 4\nkeyframes = [{ at = 3, depth_mm = 1.5 }]\n\
    [mesh]\nresolution = 'draft'\n\
    [camera]\nfocal_length_px = [200.0, 200.0]\n\
    [render]\nwidth = 240\nheight = 220\n";

fn sensed(frames: u32) -> Workbench {
    let bench = Workbench::new();
    bench.press(frames);
    bench.write("sensor.toml", SENSOR);
    bench
}

#[test]
fn contact_and_where_it_holds_are_written_beside_depth() {
    let bench = sensed(2);
    let ended = bench.run("track press --out run --profile sensor.toml").expect_done();
    assert!(ended.out.contains("deepest  frame ") && ended.out.contains(" mm²"), "{}", ended.out);
    for name in ["flow", "depth", "valid"] {
        assert!(bench.path(&format!("run/{name}.npy")).exists(), "{name}.npy");
    }
    for name in ["contact", "depth_valid"] {
        let (shape, values) = bench.array::<u8>(&format!("{name}.npy"));
        assert_eq!(shape, [2, 96, 128], "{name}");
        assert!(values.iter().all(|&value| value < 2), "{name}");
    }
    for name in ["density", "displacement", "traction", "depth_deviation"] {
        assert!(!bench.path(&format!("run/{name}.npy")).exists(), "{name}.npy was not asked for");
    }
    assert!(!bench.column("contact_area_mm2")[0].is_empty());
    assert!(bench.column("force_z_n").iter().all(String::is_empty), "no force without Young's modulus");
}

#[test]
fn displacement_and_traction_are_written_where_they_are_asked_for() {
    let bench = sensed(2);
    let all = "--fields displacement,traction,depth_deviation --set gel.youngs_modulus_mpa=0.6 --json";
    let ended = bench.run(&format!("track press --out run --profile sensor.toml {all}")).expect_done();
    let summary: Value = serde_json::from_str(&ended.out).unwrap();
    assert!(summary["deepest"]["contact_area_mm2"].is_number(), "{summary}");
    assert_eq!(bench.array::<f32>("displacement.npy").0, [2, 96, 128, 3]);
    assert_eq!(bench.array::<f32>("depth_deviation.npy").0, [2, 96, 128]);
    let (shape, _) = bench.array::<f32>("traction.npy");
    let record: toml::Table = fs::read_to_string(bench.path("run/run.toml")).unwrap().parse().unwrap();
    let number = |key: &str| record["traction"][key].as_integer().unwrap() as u64;
    assert_eq!(shape, [2, number("rows"), number("columns"), 3]);
    assert!(record["traction"]["cell_mm"].as_float().unwrap() > 0.0);
    assert!(!bench.path("run/depth.npy").exists() && bench.path("run/contact.npy").exists());
    assert!(!bench.column("force_z_n")[0].is_empty() && !bench.column("torque_z_nmm")[0].is_empty());
}

#[test]
fn a_field_that_cannot_be_had_is_named() {
    let bench = sensed(2);
    let track = |options: &str| bench.run(&format!("track press --out run {options}"));
    track("--profile sensor.toml --fields traction").expect_failure("no gel.youngs_modulus_mpa", "--set gel.youngs");
    track("--fields displacement").expect_failure(
        "needs elastic depth, but the profile (--profile) has no [camera], no [gel]",
        "give the profile [camera]",
    );
    track("--profile sensor.toml --set depth.method=density --fields contact")
        .expect_failure("contact was requested", "leave contact out of --fields");
    track("--profile sensor.toml --set depth.method=density --fields depth")
        .expect_failure("but no depth.density", "calibrate depth");
    bench.write("bare.toml", "[depth]\nmethod = 'elastic'");
    track("--profile bare.toml").expect_failure("needs [camera]", "calibrate camera");
    assert!(!bench.path("run").exists());
}

#[test]
fn a_simulated_press_is_tracked_with_elastic_depth_and_scored_over_the_whole_image() {
    let bench = Workbench::new();
    bench.write("press.toml", PRESS);
    // Cells of 2.4 px: finer ones are not tracked, and a flow that is none is a misfit.
    bench.run("simulate press.toml --out sim --set pattern.cell_mm=0.3").expect_done();
    let profile: toml::Table = fs::read_to_string(bench.path("sim/profile.toml")).unwrap().parse().unwrap();
    let method = profile.get("depth").and_then(|depth| depth.get("method"));
    assert!(method.is_none() && profile.contains_key("gel"), "the method is left open: {profile}");
    bench.run("track sim/frames --out run --profile sim/profile.toml --fields flow,depth,displacement").expect_done();
    let ended = bench.run("evaluate run sim --json").expect_done();
    let report: Value = serde_json::from_str(&ended.out).unwrap();
    let fields = report["fields"].as_array().unwrap();
    for name in ["flow", "depth", "displacement", "contact"] {
        assert!(fields.contains(&Value::from(name)), "{name} is not compared");
    }
    let deepest = &report["per_frame"][3];
    assert!(deepest["depth_mm"]["everywhere"]["mean"].is_number(), "{deepest}");
    assert!(deepest["depth_where_valid_mm"]["everywhere"]["mean"].is_number(), "{deepest}");
    assert!(deepest["depth_pixels"]["everywhere"]["compared"].is_number(), "{deepest}");
    assert!(bench.run("evaluate run sim").expect_done().out.contains("Depth where flow valid, mm"));
}
