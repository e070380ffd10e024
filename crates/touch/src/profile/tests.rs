use std::fs;

use fingervision_optics::Radial;

use super::*;
use crate::{DepthLine, ElasticMode, Fields, PerspectiveGain, Policy};

/// The profile of the documentation, with a value in every table.
fn whole() -> String {
    format!(
        "name = \"left index\"\n{SENSOR}\n\
         [camera.distortion]\nk1 = 0.01\nk2 = 0.0\np1 = 0.0\np2 = 0.0\n\
         [depth]\nmethod = \"elastic\"\ndensity = {{ slope_mm = 15.2, intercept_mm = 0.0 }}\n\
         [flow]\nfinest_level = 1\n\
         [references]\npolicy = \"stack\"\n\
         [density]\nsigma_px = 2.5\n\
         [elastic]\nmode = \"live\"\nnetwork = false\n"
    )
}

/// The message and the hint of what `text` is refused for.
fn refusal(text: &str) -> (String, String) {
    let error = Profile::from_toml(text).unwrap_err();
    (error.to_string(), error.hint().unwrap())
}

#[test]
fn every_part_is_read() {
    let profile = Profile::from_toml(&whole()).unwrap();
    assert_eq!(profile.name, "left index");
    assert_eq!(profile.region((640, 480)).unwrap(), Rect { x: 15, y: 15, width: 610, height: 450 });
    assert!((profile.camera.unwrap().distortion.k1 - 0.01).abs() < 1e-12);
    assert_eq!(profile.gel.unwrap().youngs_modulus_mpa, Some(0.6));
    assert_eq!((profile.depth.method, profile.depth_method()), (Some(DepthMethod::Elastic), DepthMethod::Elastic));
    assert_eq!((profile.elastic.mode, profile.elastic.network), (ElasticMode::Live, false));
    assert_eq!(profile.depth.density, Some(DepthLine { slope_mm: 15.2, intercept_mm: 0.0 }.into()));
    assert_eq!((profile.flow.finest_level, profile.references.policy), (Some(1), Policy::Stack));
    assert!((profile.mm_per_px().unwrap() - 0.0625).abs() < 1e-12);
}

#[test]
fn every_part_may_be_absent() {
    let profile = Profile::from_toml("").unwrap();
    assert_eq!(profile, Profile::default());
    assert_eq!(profile.region((640, 480)).unwrap(), Rect::whole(640, 480));
    assert_eq!(profile.mm_per_px(), None);
}

#[test]
fn depth_is_elastic_with_camera_and_gel_unless_a_method_is_set() {
    let known = Profile::from_toml(&whole().replace("method = \"elastic\"", "")).unwrap();
    assert_eq!((known.depth.method, known.depth_method()), (None, DepthMethod::Elastic));
    let without = |change: fn(&mut Profile)| {
        let mut profile = known.clone();
        change(&mut profile);
        profile.depth_method()
    };
    assert_eq!(without(|profile| profile.camera = None), DepthMethod::Density);
    assert_eq!(without(|profile| profile.gel = None), DepthMethod::Density);
    assert_eq!(without(|profile| profile.set("depth.method", "density").unwrap()), DepthMethod::Density);
    assert!(!known.to_toml().contains("method = \"elastic\""), "what was left open stays open");
}

#[test]
fn elastic_depth_names_the_table_that_it_lacks() {
    let lacking = |change: fn(&mut Profile)| {
        let mut profile = Profile::from_toml(&whole()).unwrap();
        change(&mut profile);
        let error = profile.elastic_sensor().unwrap_err();
        (error.to_string(), error.hint().unwrap())
    };
    let (error, hint) = lacking(|profile| profile.camera = None);
    assert_eq!(error, "depth.method = \"elastic\" needs [camera], which is missing in the profile");
    assert!(hint.contains("calibrate camera"), "{hint}");
    let (error, hint) = lacking(|profile| profile.gel = None);
    assert_eq!(error, "depth.method = \"elastic\" needs [gel], which is missing in the profile");
    assert!(hint.contains("thickness_mm") && hint.contains("depth.method=density"), "{hint}");
    assert!(Profile::from_toml(&whole()).unwrap().elastic_sensor().is_ok());
}

#[test]
fn what_is_written_is_read_back() {
    for profile in [Profile::default(), Profile::from_toml(&whole()).unwrap()] {
        let text = profile.to_toml();
        assert_eq!(Profile::from_toml(&text).unwrap(), profile, "{text}");
    }
}

#[test]
fn the_printed_radial_form_is_read_and_written_only_where_it_is_meant() {
    let brown = Profile::from_toml(&whole()).unwrap();
    let mut printed = brown.clone();
    printed.set("camera.distortion.radial", "printed").unwrap();
    assert_eq!(printed.camera.unwrap().distortion.radial, Radial::Printed);
    assert_eq!(Profile::from_toml(&printed.to_toml()).unwrap(), printed);
    assert!(printed.to_toml().contains("radial") && !brown.to_toml().contains("radial"));
}

#[test]
fn every_value_is_written_out_as_it_was_typed() {
    let text = Profile::from_toml("[references]\nmin_matched = 0.6\n[density]\nsigma_px = 2.3").unwrap().to_toml();
    for line in ["name = \"unnamed\"", "min_matched = 0.6", "sigma_px = 2.3", "policy = \"anchored\""] {
        assert!(text.lines().any(|written| written == line), "no {line} in\n{text}");
    }
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_a_like_one() {
    let (error, hint) = refusal("name = 'a'\n[flow]\n\nfinest_levl = 1");
    assert_eq!(error, "line 4: unknown key flow.finest_levl");
    assert_eq!(hint, "did you mean flow.finest_level?");
    let (error, hint) = refusal("[contacts]");
    assert_eq!(error, "line 1: unknown key contacts");
    assert_eq!(
        hint,
        "a profile has the keys name, capture, image, camera, gel, pattern, depth, flow, references, density, elastic"
    );
    let (error, hint) = refusal("[depth]\nzzz = 1");
    assert_eq!(
        (error.as_str(), hint.as_str()),
        ("line 2: unknown key depth.zzz", "depth has the keys method, density")
    );
}

#[test]
fn a_wrong_type_is_named_with_its_line() {
    let (error, hint) = refusal("[gel]\nsize_mm = [30, 30]\nthickness_mm = 'thick'\npoissons_ratio = 0.4");
    assert_eq!(error, "line 3: gel.thickness_mm: invalid type: string \"thick\", expected a number");
    assert!(hint.contains("without quotes"), "{hint}");
    let (error, _) = refusal("gel = 3");
    assert_eq!(error, "line 1: gel: invalid type: integer `3`, expected a table");
    let (error, _) = refusal("[flow.affine]\nsteps = -1");
    assert_eq!(error, "line 2: flow.affine.steps: invalid value: integer `-1`, expected a whole number, 0 or more");
    let (error, hint) = refusal("[depth]\nmethod = 'elastik'");
    assert_eq!(error, "line 2: depth.method: unknown variant `elastik`, expected `density` or `elastic`");
    assert_eq!(hint, "did you mean elastic?");
    let (_, hint) = refusal("[depth]\nmethod = 'magic'");
    assert_eq!(hint, "possible values: density, elastic");
}

#[test]
fn a_table_without_a_key_is_named() {
    let (error, hint) = refusal("name = 'a'\n[gel]\nthickness_mm = 10");
    assert_eq!(error, "line 2: gel: missing field `size_mm`");
    assert!(hint.contains("all keys"), "{hint}");
}

#[test]
fn what_is_not_toml_is_named_with_its_line() {
    let (error, hint) = refusal("name = 'a'\n[flow\nfinest_level = 1");
    assert!(error.starts_with("line 2: "), "{error}");
    assert!(!error.contains('\n'), "{error}");
    assert!(hint.contains("TOML"), "{hint}");
}

#[test]
fn an_impossible_value_is_refused() {
    let camera = |key: &str, value: &str| {
        let mut profile = Profile::from_toml(&whole()).unwrap();
        profile.set(&format!("camera.{key}"), value).unwrap_err().to_string()
    };
    let gel = |key: &str, value: &str| {
        let mut profile = Profile::from_toml(&whole()).unwrap();
        profile.set(&format!("gel.{key}"), value).unwrap_err().to_string()
    };
    assert_eq!(
        camera("focal_length_px", "[-400, 400]"),
        "camera.focal_length_px = [-400.0, 400.0] is impossible: it must be two lengths above 0 px"
    );
    assert!(camera("principal_point_px", "[nan, 1]").contains("camera.principal_point_px = [NaN, 1.0]"));
    assert!(camera("distortion.k1", "inf").contains("camera.distortion.k1 = inf"));
    assert!(camera("rotation_rad", "[0, nan, 0]").contains("camera.rotation_rad"));
    assert!(camera("rotation_rad", "[3, 0, 0]").contains("sees the gel from underneath"));
    assert!(camera("translation_mm", "[0, 0, -25]").contains("camera.translation_mm"));
    assert!(gel("size_mm", "[0, 30]").contains("gel.size_mm"));
    assert!(gel("thickness_mm", "0").contains("gel.thickness_mm = 0.0"));
    for ratio in ["-0.1", "0.5", "nan"] {
        assert!(gel("poissons_ratio", ratio).contains("it must be 0 to below 0.5"), "{ratio}");
    }
    assert!(gel("youngs_modulus_mpa", "-0.6").contains("gel.youngs_modulus_mpa = -0.6"));
}

#[test]
fn an_impossible_parameter_of_an_algorithm_is_refused() {
    for (text, key) in [
        ("[image]\nregion_of_interest = [0, 0, 0, 10]", "image.region_of_interest"),
        ("[depth]\ndensity = { slope_mm = nan, intercept_mm = 0 }", "depth.density.slope_mm"),
        ("[flow]\nnoise_levels = -1", "flow.noise_levels"),
        ("[references]\nmin_matched = 2", "references.min_matched"),
        ("[density]\nsigma_px = 0", "density.sigma_px"),
    ] {
        let (error, hint) = refusal(text);
        assert!(error.starts_with(&format!("line 2: {key}")), "{error}");
        assert!(!hint.is_empty());
    }
}

#[test]
fn a_gain_of_perspective_needs_a_camera() {
    let mut profile = Profile::from_toml(&whole()).unwrap();
    profile.set("depth.density", "{ gain = 0.8 }").unwrap();
    assert_eq!(profile.depth.density, Some(DepthLaw::Perspective(PerspectiveGain { gain: 0.8 })));
    assert_eq!(Profile::from_toml(&profile.to_toml()).unwrap(), profile);
    let (error, hint) = refusal("[depth]\ndensity = { gain = 0.8 }");
    assert!(
        error.starts_with("line 2: depth.density.gain = 0.8 is impossible: it must be used with a [camera]"),
        "{error}"
    );
    assert!(hint.contains("slope_mm"), "{hint}");
}

#[test]
fn a_depth_law_that_is_none_is_named_with_its_line() {
    let (error, hint) = refusal("name = 'a'\n[depth]\ndensity = { slope_mm = 1.0 }");
    assert_eq!(error, "line 3: depth.density: missing intercept_mm beside slope_mm");
    assert!(hint.contains("all keys"), "{hint}");
    let (error, hint) = refusal("[depth]\ndensity = { slop_mm = 1.0, intercept_mm = 0.0 }");
    assert_eq!(
        (error.as_str(), hint.as_str()),
        ("line 2: unknown key depth.density.slop_mm", "did you mean depth.density.slope_mm?")
    );
}

#[test]
fn a_number_beyond_what_a_table_holds_is_refused() {
    let mut profile = Profile::default();
    profile.references.rest_frames = u64::MAX;
    let error = profile.set("flow.colour", "false").unwrap_err().to_string();
    assert_eq!(error, "references.rest_frames: u64 value was too large");
}

#[test]
fn a_value_is_set_by_its_path() {
    let mut profile = Profile::default();
    profile.set("flow.finest_level", "1").unwrap();
    profile.set("name", "left index").unwrap();
    profile.set("references.policy", "stack").unwrap();
    profile.set("image.region_of_interest", "[1, 2, 64, 48]").unwrap();
    assert_eq!(profile.flow.finest_level, Some(1));
    assert_eq!((profile.name.as_str(), profile.references.policy), ("left index", Policy::Stack));
    assert_eq!(profile.image.unwrap().region_of_interest, [1, 2, 64, 48]);
    let untouched = Profile { flow: profile.flow, ..Profile::default() };
    assert_eq!(untouched.flow.affine, FlowParams::default().affine, "the rest keeps its bits");
}

#[test]
fn values_that_belong_together_are_set_together() {
    let mut profile = Profile::default();
    assert!(profile.set("depth.density.slope_mm", "15").is_err());
    profile.set_all([("depth.density.slope_mm", "15"), ("depth.density.intercept_mm", "0.5")]).unwrap();
    assert_eq!(profile.depth.density, Some(DepthLine { slope_mm: 15.0, intercept_mm: 0.5 }.into()));
}

#[test]
fn an_unknown_path_is_refused_and_changes_nothing() {
    let mut profile = Profile::default();
    for (path, value, expected) in [
        ("flow.finest_levl", "1", "unknown key flow.finest_levl"),
        ("flw.finest_level", "1", "unknown key flw"),
        ("name.first", "1", "name.first: name is a value, not a table"),
        (
            "flow.finest_level",
            "coarse",
            "flow.finest_level: invalid type: string \"coarse\", expected a whole number, 0 or more",
        ),
        ("", "1", "unknown key "),
    ] {
        assert_eq!(profile.set(path, value).unwrap_err().to_string(), expected);
    }
    let hint = profile.set("flow.finest_levl", "1").unwrap_err().hint();
    assert_eq!(hint.as_deref(), Some("did you mean flow.finest_level?"));
    assert_eq!(profile, Profile::default());
}

#[test]
fn a_region_outside_the_frame_is_refused() {
    let profile = Profile::from_toml(&whole()).unwrap();
    let error = profile.region((320, 240)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "image.region_of_interest = [15, 15, 610, 450] reaches outside the frames of 320x240 px"
    );
    assert!(error.hint().unwrap().contains("[0, 0, 320, 240]"));
}

#[test]
fn an_error_names_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sensor.toml");
    let missing = Profile::load(&path).unwrap_err();
    assert!(missing.to_string().contains("sensor.toml: no such file"), "{missing}");
    assert!(missing.hint().is_some());
    fs::write(&path, "[gel]\nthickness_m = 1").unwrap();
    let unknown = Profile::load(&path).unwrap_err().to_string();
    assert!(unknown.ends_with("sensor.toml, line 2: unknown key gel.thickness_m"), "{unknown}");
    fs::write(&path, [0xff, 0xfe]).unwrap();
    assert!(Profile::load(&path).unwrap_err().to_string().contains("UTF-8"));
}

#[test]
fn a_setting_without_effect_is_named_with_what_would_use_it() {
    let everything = Fields { displacement: true, traction: true, ..Fields::default() };
    let uncalibrated = Profile::default();
    let with = |assignments: &[(&str, &str)]| {
        let mut profile = Profile::default();
        profile.set_all(assignments.iter().copied()).unwrap();
        profile
    };
    let stack = with(&[("references.policy", "stack")]);
    let single = with(&[("references.policy", "single")]);
    let medium = with(&[("flow.preset", "medium")]);
    let grey = with(&[("flow.colour", "false")]);
    for (profile, key, hint) in [
        (&uncalibrated, "flow.finest_level", "flow.preset=medium"),
        (&uncalibrated, "references.push_error", "references.policy=stack"),
        (&uncalibrated, "capture.gain", "into the profile"),
        (&uncalibrated, "elastic.mode", "[camera]"),
        (&uncalibrated, "gel.thickness_mm", "[camera]"),
        (&stack, "references.rest_frames", "references.policy=anchored"),
        (&stack, "flow.finest_level", "flow.preset=medium"),
        (&single, "references.min_matched", "references.policy=anchored"),
        (&single, "flow.affine.search_steps", "flow.affine.steps"),
        (&single, "flow.search.refine.passes", "references.policy=anchored"),
        (&medium, "flow.affine.iterations", "flow.preset=affine"),
        (&grey, "flow.affine.colour_row_step", "flow.colour=true"),
    ] {
        let error = profile.expect_effect([key], everything).unwrap_err();
        assert!(error.to_string().starts_with(&format!("{key} has no effect: ")), "{error}");
        let found = error.hint().unwrap();
        assert!(found.contains(hint), "{key}: {found}");
    }
    for (profile, key) in [
        (&medium, "flow.finest_level"),
        (&stack, "references.min_matched"),
        (&stack, "flow.affine.steps"),
        (&stack, "references.push_error"),
        (&single, "flow.search.iterations"),
        (&uncalibrated, "references.rest_frames"),
        (&uncalibrated, "flow.noise_levels"),
        (&uncalibrated, "density.sigma_px"),
        (&uncalibrated, "depth.density"),
        (&uncalibrated, "image.region_of_interest"),
    ] {
        profile.expect_effect([key], everything).unwrap();
    }
    let error = uncalibrated.expect_effect(["density.filter.radius_px"], Fields::NONE).unwrap_err();
    assert!(error.hint().unwrap().contains("--fields"), "{error}");
}

#[test]
fn the_record_of_a_run_gives_its_profile() {
    let profile = Profile::from_toml(&whole()).unwrap();
    let table: toml::Table = profile.to_toml().parse().unwrap();
    let mut record = toml::Table::new();
    record.insert("version".into(), "0.1.0".into());
    record.insert("source".into(), "press: 2 images".into());
    record.insert("fields".into(), vec!["flow"].into());
    record.insert("profile".into(), table.into());
    let text = record.to_string();
    assert!(Profile::is_run_record(&text) && !Profile::is_run_record(&whole()));
    assert_eq!(Profile::from_toml(&text).unwrap(), profile);
}

#[test]
fn a_fault_in_the_record_of_a_run_is_named_with_its_line() {
    let (error, hint) = refusal("version = '0.1.0'\n[profile.flow]\nfinest_levl = 1");
    assert_eq!(error, "line 3: unknown key profile.flow.finest_levl");
    assert_eq!(hint, "did you mean profile.flow.finest_level?");
    let (error, hint) = refusal("[profile]\nname = 'a'");
    assert!(error.contains("unknown key profile"), "without a version it is no record: {error}, {hint}");
}

#[test]
fn lengths_in_another_unit_are_refused_with_the_unit() {
    let text = |distance: &str, size: &str, thickness: &str| {
        format!(
            "name = 'a'\n[camera]\nfocal_length_px = [400.0, 400.0]\nprincipal_point_px = [239.5, 239.5]\n\
             translation_mm = [0.0, 0.0, {distance}]\n[gel]\nsize_mm = [{size}, {size}]\nthickness_mm = {thickness}\n\
             poissons_ratio = 0.48\n"
        )
    };
    assert!(Profile::from_toml(&text("25.0", "30.0", "10.0")).is_ok());
    for (distance, size, thickness, key) in [
        ("0.025", "30.0", "10.0", "camera.translation_mm"),
        ("25000.0", "30.0", "10.0", "camera.translation_mm"),
        ("25.0", "0.03", "0.01", "gel.size_mm"),
        ("25.0", "0.03", "10.0", "gel.size_mm"),
        ("25.0", "30000.0", "10000.0", "gel.size_mm"),
        ("25.0", "30.0", "0.01", "gel.thickness_mm"),
    ] {
        let error = Profile::from_toml(&text(distance, size, thickness)).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
        assert!(error.hint().unwrap().contains("in mm"), "{:?}", error.hint());
    }
}
