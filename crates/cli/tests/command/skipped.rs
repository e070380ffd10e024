//! Frames that cannot be read are skipped.

use std::fs;

use image::RgbImage;
use serde_json::Value;

use crate::workbench::{Workbench, save};

#[test]
fn bad_images_are_named_counted_and_flagged() {
    let bench = Workbench::new();
    let folder = bench.press(8);
    let whole = fs::read(folder.join("0002.png")).unwrap();
    fs::write(folder.join("0002.png"), &whole[..whole.len() / 2]).unwrap();
    save(&RgbImage::new(96, 96).into(), &folder, 4);
    bench.write("press/0005.png", "not an image");
    let ended = bench.run("track press --out run --skip-bad-frames --fields flow --json").expect_done();
    for name in ["0002.png: frame 2: ", "0004.png: frame 4: 96x96 px", "0005.png: frame 5: "] {
        assert!(ended.errors.contains(&format!("skipped: press/{name}")), "{}", ended.errors);
    }
    assert_eq!(bench.column("sequence"), ["0", "1", "3", "6", "7"]);
    let is_flagged: Vec<bool> = bench.column("flags").iter().map(|flags| flags.contains("dropped")).collect();
    assert_eq!(is_flagged, [false, false, true, true, false]);
    bench.expect_run_of(5);
    let summary: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!((&summary["frames"], &summary["skipped_frames"]), (&5.into(), &3.into()));
    assert_eq!(summary["bad_frames"].as_array().unwrap().len(), 3);
    let ended = bench.run("track press --out run --overwrite --skip-bad-frames --fields flow").expect_done();
    assert!(ended.out.contains("skipped  3 frames"), "{}", ended.out);
}

#[test]
fn bad_frames_at_the_end_are_counted_too() {
    let bench = Workbench::new();
    bench.press(4);
    bench.write("press/0003.png", "not an image");
    let ended = bench.run("track press --out run --skip-bad-frames").expect_done();
    assert!(ended.out.contains("skipped  1 frame that"), "{}", ended.out);
    bench.expect_run_of(3);
}

#[test]
fn a_reference_that_cannot_be_read_is_an_error() {
    let bench = Workbench::new();
    bench.press(4);
    bench.write("press/0001.png", "not an image");
    bench
        .run("track press --out run --skip-bad-frames --reference-frame 1")
        .expect_failure("the reference frame 1 cannot be read", "--reference-frame");
}

#[test]
fn a_bad_first_image_is_skipped_if_another_one_is_the_reference() {
    let bench = Workbench::new();
    bench.press(5);
    bench.write("press/0000.png", "not an image");
    let tracked = "track press --out run --skip-bad-frames";
    let ended = bench.run(&format!("{tracked} --reference-frame 1 --fields flow --json")).expect_done();
    assert!(ended.errors.contains("skipped: press/0000.png: frame 0: "), "{}", ended.errors);
    assert_eq!(bench.column("sequence"), ["1", "2", "3", "4"]);
    let summary: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(summary["skipped_frames"], 1);
    // The same as without the bad image.
    let flow = bench.array::<f32>("flow.npy");
    fs::remove_file(bench.path("press/0000.png")).unwrap();
    bench.run("track press --out run --overwrite --fields flow").expect_done();
    assert_eq!(bench.array::<f32>("flow.npy"), flow);

    bench.write("press/0000.png", "not an image");
    let first = "the first frame cannot be read, and it is the reference";
    bench.run(&format!("{tracked} --overwrite")).expect_failure(first, "use --reference-frame 1");
    bench.run("track press --out other").expect_failure("press/0000.png: frame 0: ", "");
}

#[test]
fn a_damaged_picture_of_a_motion_jpeg_video_is_left_out_alone() {
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata/colour.avi");
    let bench = Workbench::new();
    let mut bytes = fs::read(clip).unwrap();
    let starts: Vec<usize> = (0..bytes.len() - 3).filter(|&at| bytes[at..].starts_with(&[0xff, 0xd8, 0xff])).collect();
    bytes[starts[4]..starts[4] + 2].fill(0);
    fs::write(bench.path("clip.avi"), &bytes).unwrap();
    bench.run("track clip.avi --out run").expect_failure("clip.avi: frame 4: ", "");
    let ended = bench.run("track clip.avi --out run --overwrite --skip-bad-frames").expect_done();
    assert!(ended.errors.contains("skipped: clip.avi: frame 4: "), "{}", ended.errors);
    let expected: Vec<String> = (0..starts.len()).filter(|&frame| frame != 4).map(|frame| frame.to_string()).collect();
    assert_eq!(bench.column("sequence"), expected);
}
