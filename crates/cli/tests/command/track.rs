//! The files that `track` writes for recordings without faults.

use std::fs;

use fingervision_gel::Motion;
use image::{DynamicImage, ImageBuffer, Luma, Rgb, Rgba};

use crate::workbench::{AMPLITUDE_PX, SIZE, Workbench, picture, press_image, press_motion, save};

#[test]
fn a_folder_of_images_becomes_a_folder_of_fields() {
    let bench = Workbench::new();
    bench.press(5);
    let ended = bench.run("track press --out run").expect_done();
    bench.expect_run_of(5);
    assert!(ended.out.contains("5 frames of 128x96 px"), "{}", ended.out);
    assert!(ended.out.contains("run/preview.png"), "{}", ended.out);

    let (shape, flow) = bench.array::<f32>("flow.npy");
    assert_eq!(shape, [5, 96, 128, 2]);
    let (_, valid) = bench.array::<u8>("valid.npy");
    let (width, height) = SIZE;
    let truth = press_motion().flow(width, height);
    let last = 4 * width * height;
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, (&u, &v)) in truth.u.values().iter().zip(truth.v.values()).enumerate() {
        if valid[last + k] == 1 {
            sum += (flow[2 * (last + k)] - u).hypot(flow[2 * (last + k) + 1] - v);
            count += 1.0;
        }
    }
    assert!(count > 0.8 * (width * height) as f32, "{count} valid pixels");
    let error = sum / count;
    assert!(error < 0.1, "a press of {AMPLITUDE_PX} px is off by {error} px on average");
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    let bench = Workbench::new();
    bench.press(4);
    let arrays = || {
        bench.run("track press --out run --overwrite --fields flow,density,deviation").expect_done();
        ["flow", "density", "deviation", "valid"].map(|name| fs::read(bench.path(&format!("run/{name}.npy"))).unwrap())
    };
    assert!(arrays() == arrays(), "two runs over the same frames differ");
}

#[test]
fn only_the_fields_asked_for_are_written() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run("track press --out run --fields deviation,flow").expect_done();
    for (name, is_there) in [("flow", true), ("deviation", true), ("valid", true), ("density", false), ("depth", false)]
    {
        assert_eq!(bench.path(&format!("run/{name}.npy")).exists(), is_there, "{name}.npy");
    }
    let (shape, _) = bench.array::<f32>("deviation.npy");
    assert_eq!(shape, [2, 96, 128]);
}

#[test]
fn depth_comes_from_the_profiles_line() {
    let bench = Workbench::new();
    bench.press(3);
    bench.write("sensor.toml", "[depth]\ndensity = { slope_mm = 2.0, intercept_mm = 0.5 }");
    let ended = bench.run("track press --out run --profile sensor.toml").expect_done();
    assert!(!ended.errors.contains("depth"), "{}", ended.errors);
    let (density, depth) = (bench.array::<f32>("density.npy").1, bench.array::<f32>("depth.npy").1);
    for (feature, depth) in density.iter().zip(&depth) {
        assert!((2.0 * feature + 0.5 - depth).abs() < 1e-5, "feature {feature} gives {depth} mm");
    }
    assert!(bench.column("max_depth_mm").iter().all(|cell| !cell.is_empty()));
}

#[test]
fn without_a_line_the_absence_of_depth_is_said_once() {
    let bench = Workbench::new();
    bench.press(3);
    let ended = bench.run("track press --out run").expect_done();
    assert_eq!(ended.errors.matches("note: no depth").count(), 1, "{}", ended.errors);
    assert!(!bench.path("run/depth.npy").exists());
    let ended = bench.run("track press --out run --overwrite --fields flow,density").expect_done();
    assert_eq!(ended.errors, "", "depth was not asked for");
    let ended = bench.run("track press --out run --overwrite --quiet").expect_done();
    assert_eq!((ended.out.as_str(), ended.errors.as_str()), ("", ""));
}

#[test]
fn depth_asked_for_but_not_calibrated_is_an_error() {
    let bench = Workbench::new();
    bench.press(2);
    let ended = bench.run("track press --out run --fields flow,depth");
    ended.expect_failure(
        "the profile (--profile) has no [camera], no [gel] and no depth.density",
        "leave depth out of --fields",
    );
    assert!(!bench.path("run").exists());
}

#[test]
fn elastic_depth_names_the_missing_values() {
    let bench = Workbench::new();
    bench.press(2);
    let ended = bench.run("track press --out run --set depth.method=elastic");
    ended.expect_failure("depth.method = \"elastic\" needs [camera]", "set depth.method=density");
    bench.run("track press --out run --set depth.method=elastic --fields flow").expect_done();
}

#[test]
fn every_pixel_format_gives_the_same_flow() {
    let bench = Workbench::new();
    let convert = |name: &str, format: fn(DynamicImage) -> DynamicImage| {
        let folder = bench.folder("images");
        for frame in 0..2 {
            save(&format(press_image(frame, 2).into()), &folder, frame);
        }
        bench.run("track images --out run --overwrite --fields flow").expect_done();
        let flow = bench.array::<f32>("flow.npy").1;
        assert_eq!(flow.len(), 2 * 2 * 128 * 96, "{name}");
        flow
    };
    let rgb = convert("8-bit colour", |image| image);
    let with_alpha: fn(DynamicImage) -> DynamicImage = |image| {
        ImageBuffer::<Rgba<u8>, _>::from_fn(128, 96, |x, y| {
            let Rgb([r, g, b]) = image.to_rgb8()[(x, y)];
            Rgba([r, g, b, (x + y) as u8])
        })
        .into()
    };
    assert!(convert("RGBA", with_alpha) == rgb, "transparency changes the flow");
    let deep = convert("16-bit colour", |image| image.to_rgb16().into());
    assert!(largest_difference(&deep, &rgb) < 1e-3, "16 bits change the flow");
    let grey = convert("8-bit grey", |image| image.to_luma8().into());
    let deep_grey = convert("16-bit grey", |image| {
        let values = image.to_luma8().into_raw().into_iter().map(|value| 257 * u16::from(value)).collect();
        ImageBuffer::<Luma<u16>, _>::from_raw(128, 96, values).unwrap().into()
    });
    assert!(largest_difference(&deep_grey, &grey) < 1e-3, "16 bits of grey change the flow");
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_video_is_tracked_at_its_own_times() {
    let bench = Workbench::new();
    let clips = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata");
    for (clip, times) in [("uneven.mp4", "uneven.times"), ("colour.avi", "colour.times")] {
        bench.run(&format!("track {clips}/{clip} --out run --overwrite")).expect_done();
        let expected = fs::read_to_string(format!("{clips}/{times}")).unwrap();
        let found = bench.column("capture_time_s");
        for (found, expected) in found.iter().zip(expected.split_whitespace()) {
            let (found, expected): (f64, f64) = (found.parse().unwrap(), expected.parse().unwrap());
            assert!((found - expected).abs() < 1e-5, "{clip}: {found} s, expected {expected} s");
        }
        bench.expect_run_of(expected.split_whitespace().count() as u64);
    }
}

#[test]
fn the_rate_of_a_folder_sets_its_times() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run --fps 50").expect_done();
    assert_eq!(bench.column("capture_time_s"), ["0", "0.02", "0.04"]);
}

#[test]
fn images_that_are_missing_are_flagged_and_counted() {
    let bench = Workbench::new();
    let folder = bench.press(6);
    fs::remove_file(folder.join("0002.png")).unwrap();
    fs::remove_file(folder.join("0003.png")).unwrap();
    let ended = bench.run("track press --out run").expect_done();
    assert!(ended.out.contains("dropped in 1 of 4 frames: 2 missing before them"), "{}", ended.out);
    assert_eq!(bench.column("sequence"), ["0", "1", "4", "5"]);
    assert_eq!(bench.column("flags"), ["", "", "dropped", ""]);
    assert_eq!(bench.column("capture_time_s")[2], (4.0_f64 / 30.0).to_string());
}

#[test]
fn a_jump_in_the_times_of_a_video_is_flagged() {
    let bench = Workbench::new();
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata/uneven.mp4");
    bench.run(&format!("track {clip} --out run")).expect_done();
    assert_eq!(bench.column("sequence"), ["0", "1", "3", "4", "5", "7", "8", "9", "11"]);
    let dropped: Vec<bool> = bench.column("flags").iter().map(|flags| flags.contains("dropped")).collect();
    assert_eq!(dropped, [false, false, true, false, false, true, false, false, true]);
}

#[test]
fn a_uniform_image_is_flagged() {
    let bench = Workbench::new();
    let folder = bench.folder("grey");
    for frame in 0..3 {
        save(&ImageBuffer::from_pixel(128, 96, Luma([120_u8])).into(), &folder, frame);
    }
    let ended = bench.run("track grey --out run").expect_done();
    assert!(ended.out.contains("no-texture in 3 of 3 frames"), "{}", ended.out);
    assert!(bench.column("flags").iter().all(|flags| flags.contains("no-texture")));
    assert!(bench.array::<u8>("valid.npy").1.iter().all(|&valid| valid == 0), "nothing is measured");
    bench.expect_run_of(3);
}

#[test]
fn a_frame_with_another_pattern_is_flagged_and_tracking_recovers() {
    let bench = Workbench::new();
    let folder = bench.folder("press");
    for frame in 0..10 {
        let image = if frame == 4 || frame == 5 { picture(&Motion::STILL, 77, 4) } else { press_image(frame, 10) };
        save(&image.into(), &folder, frame);
    }
    bench.run("track press --out run").expect_done();
    let flags = bench.column("flags");
    for (frame, flags) in flags.iter().enumerate() {
        assert_eq!(flags.contains("lost"), frame == 4 || frame == 5, "frame {frame}: {flags}");
    }
    let (_, valid) = bench.array::<u8>("valid.npy");
    let part = |frame: usize| {
        let values = &valid[frame * 128 * 96..][..128 * 96];
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / (128.0 * 96.0)
    };
    assert!(part(4) < 0.2 && part(5) < 0.2, "{} and {} of a foreign image are valid", part(4), part(5));
    assert!(part(9) > 0.8, "{} of the last frame is valid", part(9));
}
