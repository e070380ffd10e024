//! `calibrate depth` with presses of known depth.

use std::fmt::Write as _;
use std::fs;

use serde_json::Value;

use crate::workbench::{Ended, Workbench, picture, press_motion, save};

const FRAMES: u32 = 6;
const PROFILE: &str = "# of the left hand\nname = \"left\" # index\n\n[camera]\nfocal_length_px = [100.0, 100.0]\n\
    principal_point_px = [63.5, 47.5]\ndistortion = { k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0 }\n\
    rotation_rad = [0.0, 0.0, 0.0]\ntranslation_mm = [0.0, 0.0, 20.0]\n\n[flow]\nnoise_levels = 2.0\n";

/// A bench with a profile.
fn bench() -> Workbench {
    let bench = Workbench::new();
    bench.write("sensor.toml", PROFILE);
    bench
}

/// A press whose bump grows with its depth up to `scale` mm, its depths written with `table`.
fn press(bench: &Workbench, name: &str, scale: f64, table: impl Fn(u32) -> String) {
    let folder = bench.folder(name);
    for frame in 0..FRAMES {
        let part = f64::from(frame) / f64::from(FRAMES - 1);
        // Each recording has its own noise.
        let noise_seed = u64::from(frame) + 100 * name.bytes().map(u64::from).sum::<u64>();
        save(&picture(&press_motion().at(part * scale), 1, noise_seed).into(), &folder, frame);
    }
    let rows: String = (0..FRAMES).fold("frame,depth_mm\n".into(), |mut text, frame| {
        let _ = writeln!(text, "{}", table(frame));
        text
    });
    bench.write(&format!("{name}/depth.csv"), &rows);
}

/// A press up to this depth, mm, at the bump's full size.
fn good(bench: &Workbench, name: &str, depth_mm: f64) {
    press(bench, name, 1.0, |frame| format!("{frame},{}", depth_mm * f64::from(frame) / f64::from(FRAMES - 1)));
}

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).unwrap()
}

#[test]
fn presses_become_a_law_in_the_profile_and_nothing_else_changes() {
    let bench = bench();
    good(&bench, "shallow", 1.0);
    good(&bench, "again", 1.0);
    let ended = bench.run("calibrate depth shallow again --profile sensor.toml").expect_done();
    for text in
        ["shallow", "all together", "least error", "sensor-depth.png", "depth.density is now a line through the origin"]
    {
        assert!(ended.out.contains(text), "no {text} in {}", ended.out);
    }
    assert!(!ended.out.contains("warning"), "{}", ended.out);
    let text = fs::read_to_string(bench.path("sensor.toml")).unwrap();
    let (before, added) = text.split_at(PROFILE.len());
    assert_eq!(before, PROFILE);
    assert!(added.starts_with("\n[depth]\ndensity = { ") && added.contains("intercept_mm = 0.0"), "{added}");
    assert!(image::open(bench.path("sensor-depth.png")).unwrap().width() > 500);
    let ended = bench.run("track shallow --out run --profile sensor.toml").expect_done();
    assert!(!ended.errors.contains("no depth"), "{ended:?}");
    let deepest: f64 = bench.column("max_depth_mm")[5].parse().unwrap();
    assert!((deepest - 1.0).abs() < 0.25, "{deepest} mm instead of 1 mm");
}

#[test]
fn the_law_that_is_written_can_be_chosen() {
    let bench = bench();
    good(&bench, "press", 1.0);
    let ended = bench.run("calibrate depth press --profile sensor.toml --method perspective").expect_done();
    assert!(!ended.out.contains("not used for the fit"), "there is only one press: {}", ended.out);
    for (options, key) in [("line", "intercept_mm"), ("perspective", "gain"), ("origin --maximum robust", "slope_mm")] {
        let command = format!("calibrate depth press --profile sensor.toml --picture p.png --json --method {options}");
        let result = json(&bench.run(&command).expect_done());
        assert!(result["written"]["law"][key].is_f64(), "{result}");
        assert!(result["presses"][0]["line"]["correlation"].as_f64().unwrap() > 0.95, "{result}");
        assert_eq!(result["presses"][0]["points"].as_array().unwrap().len(), FRAMES as usize);
        assert_eq!(result["presses"][0]["place"], "centre");
        let text = fs::read_to_string(bench.path("sensor.toml")).unwrap();
        assert!(text.contains(key) && text.matches("density =").count() == 1, "{text}");
    }
}

#[test]
fn presses_that_share_no_line_are_warned_of_with_the_factor() {
    let bench = bench();
    good(&bench, "flat", 1.0);
    good(&bench, "steep", 4.0);
    let ended = bench.run("calibrate depth flat steep --profile sensor.toml").expect_done();
    let factor = "warning      one line does not fit all presses: their slopes differ by a factor of 4.0, from ";
    assert!(ended.out.contains(factor), "{}", ended.out);
    assert!(ended.out.contains(" for all presses together, but "), "{}", ended.out);
}

#[test]
fn a_simulated_press_is_solved_and_its_folder_says_the_same() {
    let bench = bench();
    bench.write(
        "press.toml",
        "name = 'sphere'\n[indenter]\nshape = 'sphere'\nradius_mm = 8.0\n\
         [motion]\nframes = 4\nkeyframes = [{ at = 3, depth_mm = 1.5 }]\n[mesh]\ncells = [12, 12, 3]\n\
         [camera]\nfocal_length_px = [100.0, 100.0]\n[pattern]\ncell_mm = 0.8\n[render]\nwidth = 120\nheight = 110\n",
    );
    let fit = |press: &str| {
        let command = format!("calibrate depth {press} --profile sensor.toml --json");
        json(&bench.run(&command).expect_done())["presses"][0]["points"].clone()
    };
    let solved = fit("sim:press.toml");
    assert_eq!(solved[3]["depth_mm"], 1.5, "{solved}");
    bench.run("simulate press.toml --out folder").expect_done();
    assert_eq!(fit("folder"), solved);
}

#[test]
fn a_press_that_is_none_is_named_and_the_profile_stays_as_it_was() {
    let bench = bench();
    let depth = |frame: u32| 0.2 * f64::from(frame);
    press(&bench, "constant", 1.0, |frame| format!("{frame},0.5"));
    press(&bench, "late", 1.0, |frame| format!("{frame},{}", 0.5 + depth(frame)));
    press(&bench, "few", 1.0, |frame| if frame < 5 { format!("{frame},{}", depth(frame)) } else { String::new() });
    press(&bench, "words", 1.0, |frame| format!("{frame},deep"));
    press(&bench, "still", 0.0, |frame| format!("{frame},{}", depth(FRAMES - frame) - 1.2 + depth(2 * frame)));
    good(&bench, "nothing", 1.0);
    fs::remove_file(bench.path("nothing/depth.csv")).unwrap();
    good(&bench, "bare", 1.0);
    for frame in 0..FRAMES {
        fs::remove_file(bench.path(&format!("bare/{frame:04}.png"))).unwrap();
    }
    let refused = |press: &str, what: &str, hint: &str| {
        bench.run(&format!("calibrate depth {press} --profile sensor.toml")).expect_failure(what, hint);
        assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), PROFILE, "{press}");
        assert!(!bench.path("sensor-depth.png").exists(), "{press}");
    };
    refused("nothing", "nothing: there are no depths: neither depth.csv nor truth/force.csv", "a row for every image");
    refused("constant", "constant: the depth is the same in every frame: 0.5 mm", "with the depth of every image");
    refused(
        "late",
        "late: the gel is already pressed at the start: 0.5 mm in the first frame",
        "before the indenter touches",
    );
    refused("few", "few: 6 images, but 5 depths", "write a row with the depth of every image");
    refused("words", "words/depth.csv, line 2: depth_mm = deep is not a length", "the first line names the columns");
    refused("bare", "bare", "");
    refused("neither", "neither: there is no such folder and no such scene", "simulate --list");
    refused("sim:leter", "no scene leter", "did you mean letter?");
}

#[test]
fn a_recording_that_begins_pressed_is_recognised_from_its_images() {
    let bench = bench();
    let folder = bench.folder("released");
    for frame in 0..FRAMES {
        let part = 1.0 - f64::from(frame) / f64::from(FRAMES - 1);
        save(&picture(&press_motion().at(part), 1, u64::from(frame)).into(), &folder, frame);
    }
    bench.write("released/depth.csv", "depth_mm\n0\n0.2\n0.4\n0.6\n0.8\n1\n");
    bench
        .run("calibrate depth released --profile sensor.toml")
        .expect_failure("released: the gel is already pressed at the start", "before the indenter touches");
}

#[test]
fn a_press_on_compressible_gel_is_not_taken_for_a_release() {
    let bench = bench();
    bench.write(
        "press.toml",
        "name = 'centre'\n[gel]\npoissons_ratio = 0.35\n[indenter]\nshape = 'rectangle'\nsize_mm = [3.0, 3.0]\n\
         [motion]\nframes = 5\nkeyframes = [{ at = 4, depth_mm = 2.0 }]\n[mesh]\nresolution = 'draft'\n\
         [camera]\nfocal_length_px = [300.0, 300.0]\n[pattern]\ncell_mm = 0.3\n[render]\nwidth = 240\nheight = 240\n",
    );
    bench.run("simulate press.toml --out press").expect_done();
    bench.run("track press/frames --out run").expect_done();
    assert_eq!(bench.column("flags"), vec![""; 5]);
    bench.run("calibrate depth press --profile press/profile.toml").expect_done();
}

#[test]
fn depths_that_no_press_has_are_refused() {
    let bench = bench();
    let refused = |name: &str, depth_mm: &dyn Fn(u32) -> f64, what: &str, hint: &str| {
        press(&bench, name, 1.0, |frame| format!("{frame},{}", depth_mm(frame)));
        bench.run(&format!("calibrate depth {name} --profile sensor.toml")).expect_failure(what, hint);
        assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), PROFILE, "{name}");
    };
    let part = |frame: u32| f64::from(frame) / f64::from(FRAMES - 1);
    refused("micrometres", &|frame| 1000.0 * part(frame), "above 20 mm, the distance to the camera", "if it is in µm");
    refused("metres", &|frame| 0.001 * part(frame), "its largest depth is 0.001 mm", "if it is in m");
    refused("upwards", &|frame| -part(frame), "upwards: frame 1 has a negative depth, -0.2 mm", "reverse the signs");
    let shuffled = [0.0, 0.8, 0.9, 0.2, 1.0, 0.4];
    refused("shuffled", &|frame| shuffled[frame as usize], "does not follow the depth", "number the images");
    // Micrometres that are few enough for a press.
    refused("few", &|frame| 0.06 * part(frame), "the depth law is impossible", "[camera] is this sensor's");
}

#[test]
fn a_press_given_twice_is_refused() {
    let bench = bench();
    good(&bench, "press", 1.0);
    good(&bench, "copy", 2.0);
    for frame in 0..FRAMES {
        let image = |name: &str| bench.path(&format!("{name}/{frame:04}.png"));
        fs::copy(image("press"), image("copy")).unwrap();
    }
    let refused = |presses: &str, what: &str| {
        let command = format!("calibrate depth {presses} --profile sensor.toml");
        bench.run(&command).expect_failure(what, "give every press once");
        assert_eq!(fs::read_to_string(bench.path("sensor.toml")).unwrap(), PROFILE, "{presses}");
    };
    refused("press press", "error: press is given twice");
    refused("press press/", "error: press/ is the same recording as press");
    refused("press ./copy/../press", "error: ./copy/../press is the same recording as press");
    refused("press copy", "error: copy is a copy of press");
    refused("circle sim:circle --draft", "error: sim:circle is the same scene as circle");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(bench.path("press"), bench.path("link")).unwrap();
        refused("link press", "error: press is the same recording as link");
    }
    bench.run("calibrate gel press press --profile sensor.toml").expect_failure("press is given twice", "every press");
}

#[test]
fn depths_between_semicolons_are_refused_with_what_to_write() {
    let bench = bench();
    good(&bench, "press", 1.0);
    bench.write("press/depth.csv", "frame;depth_mm\r\n0;0,0\r\n1;0,25\r\n");
    bench.run("calibrate depth press --profile sensor.toml").expect_failure(
        "press/depth.csv, line 1: its cells are separated by semicolons, not by commas",
        "with commas between the cells and decimal points, as in 1,0.25",
    );
}

#[test]
fn a_profile_of_another_image_is_refused() {
    let bench = bench();
    good(&bench, "press", 1.0);
    let other = PROFILE.replace("[63.5, 47.5]", "[319.5, 239.5]");
    bench.write("other.toml", &other);
    bench
        .run("calibrate depth press --profile other.toml")
        .expect_failure("press: its images are 128x96 px, but the profile's camera", "the profile of the camera that");
    bench.write("region.toml", "[image]\nregion_of_interest = [15, 15, 610, 450]\n");
    bench
        .run("calibrate depth press --profile region.toml")
        .expect_failure("press: image.region_of_interest = [15, 15, 610, 450] reaches outside", "[0, 0, 128, 96]");
    bench.write("bare.toml", "name = 'bare'\n");
    bench
        .run("calibrate depth press --profile bare.toml --method perspective")
        .expect_failure("the profile has no [camera]", "--method line or origin");
    bench.run("calibrate depth press --profile none.toml").expect_failure("none.toml: no such file", "start one");
}
