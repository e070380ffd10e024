//! Patterns from the command line: files, messages and errors.

use std::fs;

use image::GenericImageView;
use serde_json::Value;

use crate::workbench::{Ended, Workbench};

fn refused(arguments: &str, what: &str, hint: &str) {
    let bench = Workbench::new();
    bench.run(&format!("pattern {arguments}")).expect_failure(what, hint);
    assert_eq!(fs::read_dir(bench.path("")).unwrap().count(), 0, "{arguments}: nothing is begun");
}

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).unwrap()
}

#[test]
fn every_kind_is_written_in_every_format() {
    let bench = Workbench::new();
    for kind in ["colour", "dots --dots 5,4", "speckle --speckle-diameter-mm 0.5"] {
        for (ending, start) in [("pdf", "%PDF-".as_bytes()), ("svg", b"<?xml "), ("png", b"\x89PNG")] {
            let ended =
                bench.run(&format!("pattern --overwrite --out a.{ending} --size-mm 6,5 --kind {kind}")).expect_done();
            assert!(ended.out.contains("6 x 5 mm on a page of 50 x "), "{}", ended.out);
            assert!(fs::read(bench.path(&format!("a.{ending}"))).unwrap().starts_with(start), "{kind} as {ending}");
        }
    }
}

#[test]
fn a_sheet_of_paper_holds_the_pattern_in_its_middle_or_says_how_much_fits() {
    let bench = Workbench::new();
    let ended = bench.run("pattern --out a.pdf --size-mm 30,30 --page a4").expect_done();
    assert!(ended.out.contains("30 x 30 mm on a page of 210 x 297 mm"), "{}", ended.out);
    let ended = bench.run("pattern --out b.svg --size-mm 230,90 --cell-mm 1 --page letter").expect_done();
    assert!(ended.out.contains("230 x 90 mm on a page of 279.4 x 215.9 mm"), "{}", ended.out);
    refused(
        "--out a.pdf --size-mm 300,30 --cell-mm 1 --page a4",
        "a pattern of 300x30 mm does not fit on A4",
        "--size-mm of up to 186x",
    );
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let bench = Workbench::new();
    for ending in ["pdf", "svg", "png"] {
        let bytes = ["a", "b", "c --seed 2"].map(|name| {
            let (name, rest) = name.split_once(' ').unwrap_or((name, ""));
            bench.run(&format!("pattern --size-mm 3,3 --out {name}.{ending} {rest}")).expect_done();
            fs::read(bench.path(&format!("{name}.{ending}"))).unwrap()
        });
        assert!(bytes[0] == bytes[1] && bytes[0] != bytes[2], "{ending}");
    }
}

#[test]
fn a_png_gives_every_cell_whole_px_unless_told_otherwise() {
    let bench = Workbench::new();
    let ended = bench.run("pattern --size-mm 3,3 --out a.png --json").expect_done();
    assert_eq!(ended.errors, "");
    let written = json(&ended);
    assert_eq!(written["px_per_m"], 50_000);
    assert_eq!(written["pattern_mm"], serde_json::json!([3.0, 3.0]));
    let width = f64::from(image::open(bench.path("a.png")).unwrap().dimensions().0);
    assert!((width - 50.0 * written["page_mm"][0].as_f64().unwrap()).abs() <= 1.0, "{width} px");
    let ended = bench.run("pattern --size-mm 3,3 --out a.png --overwrite --dpi 1200").expect_done();
    assert!(ended.errors.contains("pixels on its edges have a mixed colour; --dpi 1270"), "{ended:?}");
}

#[test]
fn a_size_that_is_no_whole_number_of_cells_is_rounded_with_a_word() {
    let ended = Workbench::new().run("pattern --size-mm 3,5.3 --cell-mm 0.4 --out a.pdf").expect_done();
    assert!(ended.errors.contains("note: the pattern is 3.2000x5.2000 mm: 3x5.3 mm is not a whole"), "{ended:?}");
}

#[test]
fn what_cannot_be_is_refused() {
    refused("--out a.jpg", "a.jpg: a pattern cannot be written in this format", ".pdf, .svg or .png");
    refused("--out a", "a: a pattern cannot be written", ".pdf, .svg or .png");
    refused("--out a.pdf --cell-mm 0", "cell_mm = 0 is impossible", "0.001 to 1000 mm");
    refused("--out a.pdf --cell-mm -0.1", "cell_mm = -0.1 is impossible", "0.001 to 1000 mm");
    refused("--out a.pdf --cell-mm nan", "cell_mm = NaN is impossible", "0.001 to 1000 mm");
    refused("--out a.pdf --cell-mm 20", "30 mm with cells of 20 mm has 2 across", "a larger pattern");
    refused("--out a.pdf --cell-mm 0.001", "has 30000 across: 3 to 4096 are possible", "a smaller pattern");
    refused("--out a.pdf --levels 100,120", "span of the pattern's levels is 20", "differ more");
    refused("--out a.pdf --levels 200,100", "levels = [200, 100] is impossible", "in this order");
    refused("--out a.pdf --kind dots --dot-diameter-mm 2", "dots of 2 mm overlap", "below 2.0000 mm");
    refused("--out a.pdf --kind dots --cell-mm 1", "--cell-mm is for --kind colour, not for dots", "--kind colour");
    refused("--out a.pdf --kind speckle --coverage 1", "coverage = 1 is impossible", "0.05 to 0.9");
    refused("--out a.svg --dpi 600", "--dpi is only for PNG: a.svg has no px", "name the file .png");
    refused("--out a.png --dpi 20000 --size-mm 500,500 --cell-mm 1", "px per m, is too large", "PDF or SVG");
    refused("--score --blur-px -1", "blur_px = -1 is impossible", "0 to 100 px");
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    refused("--out none/a.pdf", "cannot write none/a.pdf: No such file or directory", "make the folder first");
    let bench = Workbench::new();
    bench.folder("a.pdf");
    bench.run("pattern --out a.pdf").expect_failure("cannot write a.pdf: Is a directory", "name a file");
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_half_page() {
    let bench = Workbench::new();
    if !std::path::Path::new("/dev/full").exists() {
        println!("skipped: this machine has no /dev/full");
        return;
    }
    std::os::unix::fs::symlink("/dev/full", bench.path("a.pdf.new")).unwrap();
    bench.run("pattern --out a.pdf").expect_failure("cannot write a.pdf: No space left", "free some space");
    assert!(!bench.path("a.pdf").exists());
}

/// The cells' sides and the flow's deviation to the right of a score.
fn deviations(score: &Value) -> Vec<(f64, f64)> {
    let row = |row: &Value| (row["part_mm"].as_f64().unwrap(), row["flow_deviation_px"][0].as_f64().unwrap());
    score["rows"].as_array().unwrap().iter().map(row).collect()
}

#[test]
fn a_score_names_the_size_with_the_least_noise() {
    let bench = Workbench::new();
    bench.write(
        "sensor.toml",
        "[image]\nregion_of_interest = [0, 0, 320, 240]\n[camera]\nfocal_length_px = [400, 400]\n\
         principal_point_px = [159.5, 119.5]\ntranslation_mm = [0, 0, 50]",
    );
    let score = json(&bench.run("pattern --score --json --profile sensor.toml --cell-mm 0.35").expect_done());
    assert_eq!((score["image_px"][0].as_u64(), score["mm_per_px"].as_f64()), (Some(320), Some(0.125)));
    let deviations = deviations(&score);
    assert!(deviations.iter().any(|(side, _)| (side - 0.35).abs() < 1e-12), "the size that was asked for is there");
    let best = deviations.iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let named = score["best_part_mm"].as_f64().unwrap();
    assert!((named / best.0 - 1.0).abs() < 0.5, "{named} mm, least at {best:?}");
    // Cells of two to four px.
    assert!((0.25..=0.5).contains(&named), "{named} mm");
    let text = bench.run("pattern --score --profile sensor.toml").expect_done().out;
    assert!(text.contains(&format!("least noise with a cell of {named:.4} mm")), "{text}");
}

#[test]
fn a_score_without_a_camera_says_which_it_takes() {
    let bench = Workbench::new();
    let ended = bench.run("pattern --score --kind dots --image-px 240,240 --size-mm 15,15 --dots 7,7").expect_done();
    assert!(ended.errors.contains("note: no camera in the profile"), "{ended:?}");
    let ended = bench.run("pattern --score --json --image-px 240,240 --mm-per-px 0.1").expect_done();
    assert_eq!(ended.errors, "");
    assert_eq!(json(&ended)["mm_per_px"].as_f64().map(|scale| (1e9 * scale).round()), Some(1e8));
}

#[test]
fn a_camera_that_sees_no_gel_is_refused() {
    refused(
        "--score --set gel.size_mm=[1,1] --set gel.thickness_mm=1 --set gel.poissons_ratio=0.4",
        "the camera does not see the gel",
        "check the camera's",
    );
}
