//! `calibrate gel` with presses of known depth and force.

use std::fs;

use serde_json::Value;

use crate::workbench::Workbench;

/// The sensor, its gel not yet known: Poisson's ratio, thickness and Young's modulus are wrong.
const PROFILE: &str = "# of the left hand\nname = \"left\"\n\n[camera]\nfocal_length_px = [300.0, 300.0]\n\
    principal_point_px = [119.5, 119.5]\ntranslation_mm = [0.0, 0.0, 25.0]\n\n[gel]\nsize_mm = [20.0, 20.0]\n\
    thickness_mm = 7.2 # as poured\npoissons_ratio = 0.4\n";
/// A press on a gel of ν 0.45, 8 mm and 0.6 `MPa`. It is not in the middle, where ν and thickness are correlated by 0.97 and one
/// press does not determine both.
const PRESS: &str = "name = 'disc'\n[gel]\nsize_mm = [20.0, 20.0]\nthickness_mm = 8.0\npoissons_ratio = 0.45\n\
    [indenter]\nshape = 'circle'\nradius_mm = 2.5\n\
    [motion]\ncentre_mm = [2.0, 1.0]\nframes = 5\nkeyframes = [{ at = 4, depth_mm = 0.8 }]\n[mesh]\nresolution = 'draft'\n\
    [camera]\nfocal_length_px = [300.0, 300.0]\n[pattern]\ncell_mm = 0.35\n[render]\nwidth = 240\nheight = 240\n";

fn bench() -> Workbench {
    let bench = Workbench::new();
    bench.write("sensor.toml", PROFILE);
    bench
}

#[test]
fn a_simulated_press_tells_the_gel() {
    let bench = bench();
    bench.write("press.toml", PRESS);
    let ended = bench.run("calibrate gel sim:press.toml --profile sensor.toml --json").expect_done();
    let result: Value = serde_json::from_str(&ended.out).unwrap();
    let written = |key: &str| result["written"][key].as_f64().unwrap();
    assert!((written("poissons_ratio") - 0.45).abs() < 0.03, "{result}");
    assert!((written("thickness_mm") / 8.0 - 1.0).abs() < 0.1, "{result}");
    assert!((written("youngs_modulus_mpa") / 0.6 - 1.0).abs() < 0.12, "{result}");
    let part = |key: &str| result[key].as_f64().unwrap();
    assert!(part("unexplained") < 0.5 * part("unexplained_before"), "{result}");
    assert!(result["presses"][0]["frames"].as_array().unwrap().len() >= 2, "{result}");
    let text = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    assert!(text.starts_with(&PROFILE[..PROFILE.find("thickness_mm").unwrap()]), "{text}");
    assert!(text.contains("# as poured") && text.contains("youngs_modulus_mpa = "), "{text}");
    for picture in ["sensor-gel.png", "sensor-gel-force.png"] {
        assert!(image::open(bench.path(picture)).unwrap().width() > 500, "{picture}");
    }
}

#[test]
fn a_simulated_press_seen_by_another_camera_than_the_profiles_is_refused() {
    let bench = bench();
    bench.write("press.toml", PRESS);
    bench
        .write("tilted.toml", &PROFILE.replace("translation_mm", "rotation_rad = [0.06, -0.04, 0.02]\ntranslation_mm"));
    bench.write("far.toml", &PROFILE.replace("25.0]", "35.0]").replace("[300.0, 300.0]", "[420.0, 420.0]"));
    for profile in ["tilted.toml", "far.toml"] {
        let ended = bench.run(&format!("calibrate gel sim:press.toml --profile {profile}"));
        ended.expect_failure(
            "the profile's [camera] differs from that of this press",
            "profile.toml that simulate writes",
        );
    }
    bench.run("simulate press.toml --out press").expect_done();
    let ended = bench.run("calibrate gel press --profile tilted.toml");
    ended.expect_failure("the profile's [camera] differs from that of this press", "profile.toml that simulate writes");
}

#[test]
fn what_cannot_be_fitted_is_named_and_the_profile_stays_as_it_was() {
    let bench = bench();
    bench.press(4);
    bench.folder("empty");
    let table = |name: &str, text: &str| {
        let folder = bench.folder(name);
        for frame in 0..4 {
            let image = format!("{frame:04}.png");
            fs::copy(bench.path(&format!("press/{image}")), folder.join(image)).unwrap();
        }
        bench.write(&format!("{name}/depth.csv"), text);
    };
    table("small", "frame,depth_mm\n0,0\n1,0.4\n2,0.7\n3,1.0\n");
    table("shallow", "frame,depth_mm\n0,0\n1,0.01\n2,0.02\n3,0.03\n");
    table("late", "frame,depth_mm\n0,0.5\n1,0.6\n2,0.7\n3,1.0\n");
    table("weak", "frame,depth_mm,force_z_n\n0,0,0\n1,0.4,none\n2,0.7,1\n3,1.0,1\n");
    let refused = |arguments: &str, error: &str, hint: &str| {
        bench.run(&format!("calibrate gel {arguments}")).expect_failure(error, hint);
    };
    let sensor = "--profile sensor.toml";
    refused(&format!("press {sensor}"), "press: there are no depths", "depth.csv");
    refused(&format!("nowhere {sensor}"), "nowhere: there is no such folder", "give folders");
    refused(&format!("small {sensor}"), "images are 128x96 px, but the profile's camera", "use the profile");
    refused(&format!("shallow {sensor}"), "no frame is 0.29 to 0.86 mm deep", "record the press in smaller steps");
    refused(&format!("late {sensor}"), "already pressed at the start: 0.5 mm", "begin the recording");
    refused(&format!("weak {sensor}"), "line 3: force_z_n = none is not a force", "first line names the columns");
    bench.write(
        "blind.toml",
        "name = \"blind\"\n[gel]\nsize_mm = [30.0, 30.0]\nthickness_mm = 9.0\npoissons_ratio = 0.4\n",
    );
    refused("small --profile blind.toml", "the profile has no [camera]", "calibrate the camera first");
    bench.write("unknown.toml", "name = \"unknown\"\n");
    refused("small --profile unknown.toml", "the profile has no [gel]", "give the values that you know");
    let near = PROFILE.replace("[119.5, 119.5]", "[63.5, 47.5]");
    bench.write("near.toml", &near);
    refused("small --profile near.toml --fit youngs-modulus", "none of 1 presses has forces", "force_z_n");
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), PROFILE);
    assert!(!bench.path("sensor-gel.png").exists());
}

#[test]
fn forces_in_another_unit_are_refused_and_nothing_is_written() {
    let bench = bench();
    bench.write("press.toml", PRESS);
    bench.run("simulate press.toml --out press").expect_done();
    let force = fs::read_to_string(bench.path("press/truth/force.csv")).unwrap();
    let column = force.lines().next().unwrap().split(',').position(|name| name == "force_z_n").unwrap();
    let rows = force.lines().skip(1).enumerate().map(|(frame, row)| {
        let newtons: f64 = row.split(',').nth(column).unwrap().parse().unwrap();
        format!("{frame},{},{}\n", 0.2 * frame as f64, 1000.0 * newtons)
    });
    let table: String = std::iter::once("frame,depth_mm,force_z_n\n".into()).chain(rows).collect();
    bench.write("press/depth.csv", &table);
    let ended = bench.run("calibrate gel press --profile sensor.toml");
    ended.expect_failure("the presses give an impossible gel: gel.youngs_modulus_mpa = ", "forces (N");
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), PROFILE);
}
