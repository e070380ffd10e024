//! Damaged recordings and folders: one clear error line with a hint, and files that were written remain readable.

use std::fs;
use std::path::Path;
use std::process::Command;

use image::{ImageBuffer, Rgb, RgbImage};

use crate::workbench::{Workbench, press_image, save};

#[test]
fn an_empty_folder_is_named() {
    let bench = Workbench::new();
    bench.folder("press");
    bench.run("track press --out run").expect_failure("press: no frame", "PNG, JPEG, TIFF or BMP");
    assert!(!bench.path("run").exists(), "nothing is begun");
}

#[test]
fn one_image_is_too_few() {
    let bench = Workbench::new();
    bench.press(1);
    bench.run("track press --out run").expect_failure("press: one frame", "record the gel at rest first");
    bench.run("track press/0000.png --out run").expect_failure("a single image is not supported", "give the folder");
}

#[test]
fn a_source_that_is_not_there_is_named() {
    let bench = Workbench::new();
    bench.run("track nowhere --out run").expect_failure("nowhere: no such file or folder", "are read");
}

#[test]
fn a_size_that_changes_midway_ends_the_run_with_the_frames_before_it() {
    let bench = Workbench::new();
    let folder = bench.press(4);
    save(&RgbImage::new(96, 96).into(), &folder, 3);
    let ended = bench.run("track press --out run");
    let ended = ended.expect_failure("0003.png: frame 3: 96x96 px 8-bit colour, expected 128x96 px", "one size");
    assert!(ended.out.contains("3 frames"), "{}", ended.out);
    bench.expect_run_of(3);
}

#[test]
fn a_truncated_image_ends_the_run_with_the_frames_before_it() {
    let bench = Workbench::new();
    let folder = bench.press(4);
    let whole = fs::read(folder.join("0002.png")).unwrap();
    fs::write(folder.join("0002.png"), &whole[..whole.len() / 2]).unwrap();
    bench.run("track press --out run").expect_failure("0002.png: frame 2: ", "skip it with --skip-bad-frames");
    bench.expect_run_of(2);
}

#[test]
fn a_truncated_first_image_begins_no_run() {
    let bench = Workbench::new();
    let folder = bench.press(2);
    fs::write(folder.join("0000.png"), &fs::read(folder.join("0000.png")).unwrap()[..100]).unwrap();
    bench.run("track press --out run").expect_failure("0000.png: frame 0: ", "the first frame must be readable");
    let ended = bench.run("track press --out run --skip-bad-frames");
    assert!(ended.errors.contains("note: skipped: press/0000.png: frame 0: "), "{ended:?}");
    ended.expect_failure("the first frame cannot be read, and it is the reference", "use --reference-frame 1");
    assert!(!bench.path("run").exists());
}

#[test]
fn a_truncated_video_ends_the_run_with_the_frames_before_it() {
    let clips = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata");
    let bench = Workbench::new();
    for (name, hint) in
        [("colour.avi", "frames before it are complete"), ("fragments.mov", "frames before it are complete")]
    {
        let whole = fs::read(format!("{clips}/{name}")).unwrap();
        fs::write(bench.path(name), &whole[..whole.len() * 2 / 3]).unwrap();
        bench.run(&format!("track {name} --out run --overwrite")).expect_failure(name, hint);
        let frames = bench.column("sequence").len() as u64;
        assert!((2..12).contains(&frames), "{name}: {frames} frames");
        bench.expect_run_of(frames);
    }
    let whole = fs::read(format!("{clips}/b_frames.mp4")).unwrap();
    fs::write(bench.path("unclosed.mp4"), &whole[..whole.len() / 2]).unwrap();
    bench.run("track unclosed.mp4 --out run2").expect_failure("unclosed.mp4: ", "record again");
}

#[test]
fn a_video_of_another_kind_is_named_with_the_way_out() {
    let clips = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata");
    let bench = Workbench::new();
    bench.run(&format!("track {clips}/vp9.webm --out run")).expect_failure("WebM video is not supported", "ffmpeg -i");
}

#[test]
fn a_number_that_is_none_is_named_with_its_pixel() {
    let bench = Workbench::new();
    let folder = bench.folder("float");
    for frame in 0..3 {
        let image = press_image(frame, 3);
        let mut image =
            ImageBuffer::from_fn(128, 96, |x, y| Rgb(image[(x, y)].0.map(|value| f32::from(value) / 255.0)));
        if frame == 2 {
            image.put_pixel(17, 5, Rgb([0.5, f32::NAN, 0.5]));
        }
        image.save(folder.join(format!("{frame}.tif"))).unwrap();
    }
    let ended = bench.run("track float --out run");
    ended.expect_failure("2.tif: frame 2: pixel (17, 5) is NaN", "scale the images to 0 to 1");
    bench.expect_run_of(2);
}

#[test]
fn a_file_that_is_no_image_is_named() {
    let bench = Workbench::new();
    bench.press(4);
    bench.write("press/0001.png", "not an image at all");
    bench.run("track press --out run").expect_failure("0001.png: frame 1: ", "frames before it are complete");
    bench.expect_run_of(1);
    bench.write("notes.txt", "not a recording");
    bench.run("track notes.txt --out run2").expect_failure("notes.txt: this kind of file is not supported", "are read");
    bench.write("empty.mp4", "");
    bench.run("track empty.mp4 --out run2").expect_failure("empty.mp4: an empty file is not supported", "are read");
}

#[test]
fn frames_too_small_for_flow_are_refused() {
    let bench = Workbench::new();
    let folder = bench.folder("tiny");
    for frame in 0..2 {
        save(&RgbImage::new(20, 20).into(), &folder, frame);
    }
    bench.run("track tiny --out run").expect_failure("20x20 px is too small", "larger size");
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let bench = Workbench::new();
    bench.press(2);
    bench.write("taken", "a file");
    bench.run("track press --out taken/run").expect_failure("taken/run", "choose another");
    bench.run("track press --out press").expect_failure("press contains files that are not a run", "choose a new");
}

#[test]
fn a_previous_run_is_replaced_only_when_asked() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run").expect_done();
    bench.run("track press --out run").expect_failure("run contains a previous run", "--overwrite");
    fs::remove_file(bench.path("press/0002.png")).unwrap();
    bench.run("track press --out run --overwrite").expect_done();
    bench.expect_run_of(2);
}

/// A small disk, unmounted at the end.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    /// The disk; none where the machine does not let a test mount one.
    fn mount(path: &'a Path, size: &str) -> Option<Self> {
        let size = format!("size={size}");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(path).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(Self(path))
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).output();
    }
}

#[test]
fn a_full_disk_ends_the_run_with_the_frames_before_it() {
    let bench = Workbench::new();
    bench.press(6);
    let path = bench.folder("run");
    let Some(_disk) = SmallDisk::mount(&path, "512k") else {
        println!("skipped: this machine does not let the test mount a small disk");
        return;
    };
    let ended = bench.run("track press --out run");
    let said =
        "note: the run takes 958.5 kB for 6 frames, 159.7 kB each, but only 524.3 kB are free: it will end early";
    assert!(ended.errors.contains(said), "{}", ended.errors);
    let ended = ended.expect_failure("No space left", "what was written so far can be read");
    let frames = bench.array::<f32>("flow.npy").0[0];
    assert!((1..6).contains(&frames), "{frames} frames fit");
    assert_eq!(bench.column("sequence").len() as u64, frames);
    assert!(ended.out.contains(&format!("{frames} frames")), "{}", ended.out);
    assert!(!path.join("preview.png").exists(), "a picture that does not fit is not begun");
}

#[test]
fn an_export_to_a_full_disk_leaves_no_file() {
    let bench = Workbench::new();
    bench.press(6);
    bench.run("track press --out run").expect_done();
    let path = bench.folder("disk");
    let Some(_disk) = SmallDisk::mount(&path, "512k") else {
        println!("skipped: this machine does not let the test mount a small disk");
        return;
    };
    let ended = bench.run("export run --out disk/run.npz").expect_failure("No space left", "free some space");
    assert_eq!(ended.errors.lines().count(), 2, "the error and its hint: {ended:?}");
    assert!(!path.join("run.npz").exists());
}

#[test]
fn a_disk_that_takes_no_frame_promises_nothing() {
    let bench = Workbench::new();
    bench.press(3);
    for command in ["track press --out run", "simulate board --frames 2 --out run"] {
        let path = bench.folder("run");
        let Some(_disk) = SmallDisk::mount(&path, "64k") else {
            println!("skipped: this machine does not let the test mount a small disk");
            return;
        };
        let ended = bench.run(command).expect_failure("No space left", "free some space");
        assert!(!ended.out.contains("NaN") && !ended.out.contains("preview"), "{command}: {}", ended.out);
        assert!(!path.join("preview.png").exists(), "{command}");
    }
}
