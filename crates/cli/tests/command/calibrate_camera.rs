//! `calibrate camera`: fits to a sliding board, and recordings that are refused.

use std::fmt::Write;
use std::fs;

use image::{DynamicImage, GrayImage};
use serde_json::Value;

use crate::workbench::{Workbench, save};

/// A board in small images. The keyframe gives its motion: a slide in steps of 0.5 mm, or larger steps and a rotation.
fn scene(keyframe: &str) -> String {
    format!(
        "[camera]\nfocal_length_px = [133.0, 133.0]\nrotation_rad = [0.06, -0.04, 0.02]\n\
         distortion = {{ k1 = -0.08, k2 = 0.02, p1 = 0.001, p2 = -0.0005 }}\n[gel]\nsize_mm = [60.0, 60.0]\n\
         [motion]\nkind = 'rigid'\nframes = 8\nkeyframes = [{{ at = 7, {keyframe} }}]\n\
         [pattern]\ncell_mm = 0.5\n[render]\nwidth = 160\nheight = 120\n"
    )
}

const ALONG_X: &str = "shear_mm = [3.5, 0.0]";

/// A bench with this board simulated into `board`.
fn board(keyframe: &str) -> Workbench {
    let bench = Workbench::new();
    simulate(&bench, "board", keyframe);
    bench
}

fn simulate(bench: &Workbench, name: &str, keyframe: &str) {
    bench.write(&format!("{name}.toml"), &scene(keyframe));
    bench.run(&format!("simulate {name}.toml --out {name}")).expect_done();
}

fn frame(number: usize) -> String {
    format!("board/frames/{number:06}.png")
}

/// The places of the board in its images, in another order.
fn reorder(bench: &Workbench, order: &[usize]) {
    let images: Vec<Vec<u8>> = order.iter().map(|&number| fs::read(bench.path(&frame(number))).unwrap()).collect();
    fs::remove_dir_all(bench.path("board/frames")).unwrap();
    bench.folder("board/frames");
    for (number, image) in images.into_iter().enumerate() {
        fs::write(bench.path(&frame(number)), image).unwrap();
    }
}

/// Checks that the board is refused and no profile is written.
fn refused(bench: &Workbench, options: &str, what: &str, hint: &str) {
    let ended = bench.run(&format!("calibrate camera board/frames --step-mm 0.5 --profile sensor.toml {options}"));
    ended.expect_failure(what, hint);
    assert!(!bench.path("sensor.toml").exists(), "{what}: a profile was written");
}

#[test]
fn a_board_gives_the_camera_and_the_profile_keeps_the_rest() {
    let bench = board(ALONG_X);
    bench.write("sensor.toml", "name = 'left' # index\n\n[flow] # as ever\nnoise_levels = 3.0\n");
    let arguments = "calibrate camera board/frames --step-mm 0.5 --profile sensor.toml --prior distance_mm=25±0.5";
    let result: Value = serde_json::from_str(&bench.run(&format!("{arguments} --json")).expect_done().out).unwrap();
    let number = |name: &str| result[name].as_f64().unwrap();
    assert!(number("after_over_before") < 0.1 && (number("test_over_after") - 1.0).abs() < 0.1, "{result}");
    let focal = result["camera"]["focal_length_px"][0].as_f64().unwrap();
    assert!((focal / 133.0 - 1.0).abs() < 0.02, "{focal} px instead of 133");
    assert_eq!(result["estimates"].as_array().unwrap().len(), 13);
    assert_eq!(image::image_dimensions(bench.path("sensor-camera.png")).unwrap().0, 1600);

    let profile = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    let start = "name = 'left' # index\n\n[flow] # as ever\nnoise_levels = 3.0\n\n[camera]\nfocal_length_px = [13";
    assert!(profile.starts_with(start), "{profile}");
    bench.run("track board/frames --profile sensor.toml --out run").expect_done();
    // The camera that is there now is no obstacle, and the same recording gives the same file.
    bench.run(arguments).expect_done();
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), profile);
}

#[test]
fn a_camera_that_contradicts_its_priors_is_remarked() {
    let bench = board(ALONG_X);
    let priors = "--prior distance_mm=25±0.5 --prior focal_length_px=133±1";
    let camera = |step: &str| {
        let ended =
            bench.run(&format!("calibrate camera board/frames --step-mm {step} --profile sensor.toml {priors}"));
        ended.expect_done().errors
    };
    let said = camera("0.5");
    assert!(!said.contains("differs from its prior"), "{said}");
    // The step is 0.5 mm.
    let said = camera("0.6");
    assert!(said.contains("distance_mm = ") && said.contains("differs from its prior, 25 ± 0.5, by "), "{said}");
    assert!(said.contains("check the priors and --step-mm"), "{said}");
}

#[test]
fn the_report_names_what_a_slide_does_not_determine() {
    let bench = board(ALONG_X);
    let arguments = "calibrate camera board/frames --step-mm 0.5 --profile new.toml --start published";
    let ended = bench.run(&format!("{arguments} --prior distance_mm=50±5")).expect_done();
    for expected in [
        "8 images of 160x120 px, 0.5 mm a step along 0°",
        "before, plain camera",
        "4.57e-3 before, 2.23e-3 after, 2.16e-3 in the test",
        "not determined  the position of the origin on the board",
        "not determined  focal length against distance",
        "--prior distance_mm=25±0.5",
        "50 ± 5, which determines it",
        "picture   new-camera.png\nprofile   new.toml",
    ] {
        assert!(ended.out.contains(expected), "no \"{expected}\" in {}", ended.out);
    }
    assert!(ended.errors.contains("is uncertain by 10 %: measure the distance"), "{}", ended.errors);
    assert!(!ended.out.contains("NaN"), "{}", ended.out);
}

#[test]
fn a_camera_that_the_slides_do_not_determine_is_not_written() {
    let bench = board(ALONG_X);
    let hint = "nothing was written: measure the distance";
    refused(&bench, "", "the slides do not determine the camera: focal_length_px = ", hint);
    refused(&bench, "--prior distance_mm=25±10", "at most 20 % are allowed", hint);
    assert!(!bench.path("sensor-camera.png").exists(), "a picture of residuals was written");
    let ended =
        bench.run("calibrate camera board/frames --step-mm 0.5 --profile sensor.toml --prior distance_mm=25±0.5");
    assert!(!ended.expect_done().errors.contains("uncertain"));
}

#[test]
fn two_slides_are_fitted_together() {
    let bench = board(ALONG_X);
    simulate(&bench, "across", "shear_mm = [0.0, 3.5]");
    let arguments = "calibrate camera board/frames across/frames --step-mm 0.5 --profile sensor.toml --radial printed";
    let ended = bench.run(&format!("{arguments} --prior focal_length_px=133+-1 --json")).expect_done();
    let result: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(result["slides"][1]["direction_deg"], 90.0);
    assert!(result["after_over_before"].as_f64().unwrap() < 0.1, "{result}");
    assert!(fs::read_to_string(bench.path("sensor.toml")).unwrap().contains("radial = \"printed\""));
    let swapped = bench.run(&format!("{arguments} --direction y,x"));
    swapped.expect_failure("board/frames: the board moves towards", "--direction");
    let twice = arguments.replace("across/frames", "board/../board/frames");
    bench.run(&twice).expect_failure("board/../board/frames is the same recording as board/frames", "every slide once");
    let options = "--direction x,y,x";
    bench.run(&format!("{arguments} {options}")).expect_failure("2 slides, 1 steps and 3 directions", "one for each");
}

#[test]
fn a_recording_in_the_wrong_order_is_named() {
    let bench = board(ALONG_X);
    reorder(&bench, &[7, 6, 5, 4, 3, 2, 1, 0]);
    refused(&bench, "", "the board moves towards -179°", "reverse the order of the images");
    reorder(&bench, &[7, 6, 4, 5, 3, 2, 1, 0]);
    refused(&bench, "", "images are out of order: from image 3 to 4 the board moves back", "number the images");
    let bench = board(ALONG_X);
    reorder(&bench, &[0, 1, 2, 4, 5, 6, 7]);
    refused(&bench, "", "1 image is missing between image 3 and 4", "put the missing image back");
    reorder(&bench, &[0, 1, 2, 2, 3, 4, 5]);
    refused(&bench, "", "images 3 and 4 show the board at the same place", "leave one of the two out");
    reorder(&bench, &[0, 1, 2, 4, 5]);
    refused(&bench, "", "the board is shown in 5 images: at least 6", "21 images");
}

#[test]
fn a_slide_that_differs_from_the_given_one_is_refused() {
    let bench = board(ALONG_X);
    refused(&bench, "--direction y", "moves towards 1° in the image, not towards 90°", "--direction x, y or degrees");
    let known = "--prior distance_mm=25±0.5 --prior focal_length_px=133±2";
    bench.run(&format!("calibrate camera board/frames --step-mm 0.5 --profile sensor.toml {known}")).expect_done();
    let profile = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    let wrong = bench.run("calibrate camera board/frames --step-mm 1 --profile sensor.toml");
    wrong.expect_failure("the board moves 0.49", "check --step-mm");
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), profile);
    fs::remove_file(bench.path("sensor.toml")).unwrap();
    refused(
        &bench,
        "--prior distance_mm=50±1 --prior focal_length_px=133±2",
        "not 0.5 mm",
        "belongs to another camera",
    );
}

#[test]
fn a_profile_of_another_image_size_is_named() {
    let bench = board(ALONG_X);
    let calibrate = |profile: &str| {
        bench.write("sensor.toml", profile);
        bench.run("calibrate camera board/frames --step-mm 0.5 --profile sensor.toml")
    };
    let region = "[image]\nregion_of_interest = [15, 15, 610, 450]";
    calibrate(region).expect_failure("[15, 15, 610, 450] reaches outside the frames of 160x120", "[0, 0, 160, 120]");
    let camera =
        "[camera]\nfocal_length_px = [400, 400]\nprincipal_point_px = [319.5, 239.5]\ntranslation_mm = [0, 0, 25]";
    let ended = calibrate(camera);
    ended.expect_failure("[319.5, 239.5] lies outside the images' region of 160x120", "another image size");
    assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), camera);
}

#[test]
fn a_board_that_rests_turns_or_is_blank_is_named() {
    let bench = board(ALONG_X);
    reorder(&bench, &[0; 8]);
    refused(&bench, "", "the board does not move", "slide the board by the same step");
    for number in 0..8 {
        save(
            &DynamicImage::from(GrayImage::from_pixel(160, 120, image::Luma([90]))),
            &bench.path("board/frames"),
            number,
        );
        fs::remove_file(bench.path(&frame(number as usize))).unwrap();
    }
    refused(&bench, "", "0 % of image 1 has texture", "dense random pattern");
    let bench = board("shear_mm = [3.5, 0.0], twist_rad = 0.15");
    refused(&bench, "", "the fit did not converge: no camera explains the flow", "no profile was written");
}

#[test]
fn corners_of_a_checkerboard_give_a_camera_without_a_slide() {
    let bench = Workbench::new();
    // A pinhole of 400 px, 25 mm away, and a board tilted about x.
    let mut table = String::from("image,x_mm,y_mm,u_px,v_px\n");
    for (image, tilt) in [0.0_f64, 0.3, -0.4, 0.5].into_iter().enumerate() {
        for corner in 0..48 {
            let (x, y) = (f64::from(corner % 8) * 2.0 - 7.0, f64::from(corner / 8) * 2.0 - 5.0);
            let distance = 25.0 + tilt.sin() * y;
            let (u, v) = (400.0 * x / distance + 240.0, 400.0 * tilt.cos() * y / distance + 200.0);
            writeln!(table, "{image},{x},{y},{u},{v}").unwrap();
        }
    }
    bench.write("corners.csv", &table);
    let ended = bench.run("calibrate camera --corners corners.csv --profile sensor.toml").expect_done();
    assert!(ended.out.contains("corners   192 in 4 images"), "{}", ended.out);
    let profile = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    assert!(profile.contains("focal_length_px = [400.0") || profile.contains("focal_length_px = [399.99"), "{profile}");

    bench.write("short.csv", &table.lines().take(97).collect::<Vec<_>>().join("\n"));
    let refused = |file: &str, what: &str, hint: &str| {
        let ended = bench.run(&format!("calibrate camera --corners {file} --profile none.toml"));
        ended.expect_failure(what, hint);
        assert!(!bench.path("none.toml").exists());
    };
    refused("short.csv", "short.csv: the corners come from 2 images", "5 or more poses");
    bench.write("torn.csv", &table[..table.len() - 30]);
    refused("torn.csv", "is not five numbers", "a row for each corner");
    refused("nowhere.csv", "nowhere.csv: No such file", "name a file with the corners");
}
