//! Profiles that are wrong, and values set on the command line.

use std::fs;

use crate::workbench::Workbench;

/// A run with a profile of this text.
fn with_profile(text: &str) -> crate::workbench::Ended {
    let bench = Workbench::new();
    bench.press(2);
    bench.write("sensor.toml", text);
    let ended = bench.run("track press --out run --profile sensor.toml");
    assert!(!bench.path("run").exists(), "nothing is begun");
    ended
}

#[test]
fn an_unknown_key_is_named_with_its_line() {
    let ended = with_profile("name = 'a'\n[flow]\nfinest_levl = 1");
    ended.expect_failure("sensor.toml, line 3: unknown key flow.finest_levl", "did you mean flow.finest_level?");
}

#[test]
fn an_impossible_value_is_named() {
    let ended = with_profile("[gel]\nsize_mm = [30, 30]\nthickness_mm = -10\npoissons_ratio = 0.48");
    ended.expect_failure("gel.thickness_mm = -10.0 is impossible: it must be a finite length above 0 mm", "in mm");
    with_profile("[flow]\nnoise_levels = -1").expect_failure("flow.noise_levels = -1", "0.01 to 64");
}

#[test]
fn a_wrong_type_is_named() {
    let ended = with_profile("[density]\nsigma_px = 'two'");
    ended.expect_failure("sensor.toml, line 2: density.sigma_px: invalid type: string \"two\"", "without quotes");
}

#[test]
fn a_profile_that_is_no_toml_is_named() {
    with_profile("[gel\n").expect_failure("sensor.toml, line 1: ", "TOML");
}

#[test]
fn a_profile_that_is_not_there_is_named() {
    let bench = Workbench::new();
    bench.press(2);
    let ended = bench.run("track press --out run --profile nowhere.toml");
    ended.expect_failure("cannot read the profile nowhere.toml: no such file", "fingervision profile new");
}

#[test]
fn a_region_outside_the_frame_is_named() {
    let ended = with_profile("[image]\nregion_of_interest = [15, 15, 610, 450]");
    ended.expect_failure("[15, 15, 610, 450] reaches outside the frames of 128x96 px", "[0, 0, 128, 96]");
}

#[test]
fn the_region_is_what_is_tracked() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run("track press --out run --set image.region_of_interest=[10,8,100,64]").expect_done();
    assert_eq!(bench.array::<f32>("flow.npy").0, [2, 64, 100, 2]);
}

#[test]
fn a_value_that_was_set_is_in_the_record_of_the_run() {
    let bench = Workbench::new();
    bench.press(2);
    bench.write("sensor.toml", "name = \"left index\"");
    bench
        .run("track press --out run --profile sensor.toml --set flow.noise_levels=1.5 --set density.sigma_px=2.5")
        .expect_done();
    let record: toml::Table = fs::read_to_string(bench.path("run/run.toml")).unwrap().parse().unwrap();
    assert_eq!(record["version"].as_str(), Some(env!("CARGO_PKG_VERSION")));
    assert_eq!(
        record["source"].as_str(),
        Some("press: 2 images, 128x96 px 8-bit colour, nominally 30 frames per second")
    );
    let profile = record["profile"].as_table().unwrap();
    assert_eq!(profile["name"].as_str(), Some("left index"));
    assert_eq!(profile["flow"]["noise_levels"].as_float(), Some(1.5));
    assert_eq!(profile["density"]["sigma_px"].as_float(), Some(2.5));
    assert_eq!(profile["references"]["policy"].as_str(), Some("anchored"), "defaults are written out");
}

#[test]
fn a_wrong_value_on_the_command_line_is_named() {
    let bench = Workbench::new();
    bench.press(2);
    let set = |assignment: &str| bench.run(&format!("track press --out run --set {assignment}"));
    set("flow.finest_levl=1").expect_failure("unknown key flow.finest_levl", "did you mean flow.finest_level?");
    set("gel.poissons_ratio=0.4").expect_failure("gel: missing field", "all keys of the table");
    set("density.sigma_px=0").expect_failure("density.sigma_px = 0", "1.5 to 8 px");
}

#[test]
fn an_unusual_value_is_noted() {
    let bench = Workbench::new();
    bench.press(2);
    bench.write(
        "sensor.toml",
        "[camera]\nfocal_length_px = [400.0, 200.0]\nprincipal_point_px = [320, 240]\ntranslation_mm = [0, 0, 25]\n",
    );
    let ended = bench.run("track press --out run --profile sensor.toml --fields flow").expect_done();
    assert!(ended.errors.contains("means that pixels are not square"), "{}", ended.errors);
}
