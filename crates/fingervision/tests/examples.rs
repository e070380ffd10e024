//! Runs the examples, as built by `cargo test`, and checks their output.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

use fingervision::{Image, Pixels, write_pixels};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Where cargo puts an example: in the folder beside that of this test.
fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let example =
        test.ancestors().nth(2).unwrap().join("examples").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    assert!(example.is_file(), "{}: `cargo build -p fingervision --examples` makes it", example.display());
    example
}

fn run(name: &str, arguments: &[&OsStr]) -> Output {
    Command::new(program(name)).args(arguments).output().unwrap()
}

/// What an example prints that ends well.
fn printed(name: &str, arguments: &[&OsStr]) -> String {
    let output = run(name, arguments);
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A recording of a random pattern of cells of 3 px that moves right by 1 px a frame.
fn write_recording(folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    for shot in 0..3 {
        let image = Image::from_fn(120, 90, |x, y| {
            let (column, row) = (((x + 9 - shot) / 3) as u32, (y / 3) as u32);
            let mixed = column.wrapping_mul(73_856_093) ^ row.wrapping_mul(19_349_663);
            (mixed.wrapping_mul(2_654_435_761) >> 24) as u8
        });
        write_pixels(&Pixels::Grey8(image), &folder.join(format!("{shot}.png"))).unwrap();
    }
}

#[test]
fn own_frames_are_followed() {
    let text = printed("own_frames", &[]);
    assert!(text.contains("frame 9: the middle moved by (+9.0"), "{text}");
}

#[test]
fn flow_alone_finds_the_shift_and_draws_it() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("flow.png");
    let text = printed("flow_alone", &[picture.as_os_str()]);
    assert!(text.contains("the shift of 4 px is off by 0.00"), "{text}");
    assert!(picture.is_file());
}

#[test]
fn a_folder_becomes_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let [frames, profile, out] = ["frames", "sensor.toml", "run"].map(|name| folder.path().join(name));
    write_recording(&frames);
    std::fs::write(&profile, "name = 'mine'").unwrap();
    let text = printed("track_folder", &[frames.as_os_str(), profile.as_os_str(), out.as_os_str()]);
    assert!(text.contains("3 frames, "), "{text}");
    for file in ["run.toml", "flow.npy", "valid.npy", "density.npy", "readings.csv", "preview.png"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let again = run("track_folder", &[frames.as_os_str(), profile.as_os_str(), out.as_os_str()]);
    assert!(!again.status.success(), "a run is not replaced unasked");
}

#[cfg(feature = "simulate")]
#[test]
fn a_simulated_press_is_compared_with_its_truth() {
    let text = printed("simulate_and_evaluate", &[]);
    let overlaps: Vec<f64> =
        text.lines().skip(1).map(|line| line.split_whitespace().nth(4).unwrap().parse().unwrap()).collect();
    assert_eq!(overlaps.len(), 11, "{text}");
    assert!(overlaps.iter().all(|&overlap| overlap > 60.0), "{text}");
}

#[cfg(feature = "simulate")]
#[test]
fn a_depth_law_is_fitted_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sensor.toml");
    let text = printed("calibrate", &[file.as_os_str()]);
    assert!(text.contains("depth is off by 0.0"), "{text}");
    let profile = fingervision::Profile::load(&file).unwrap();
    assert!(matches!(profile.depth.density, Some(fingervision::DepthLaw::Perspective(_))), "{:?}", profile.depth);
}
