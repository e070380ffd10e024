//! `export` to MP4, in programs that have it and in others.

use crate::workbench::Workbench;

#[cfg(not(feature = "mp4"))]
#[test]
fn a_program_without_mp4_says_so() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("record press press.mcap --frames-only").expect_done();
    bench.run("export press.mcap --out press.mp4").expect_failure("built without MP4", "--features mp4");
    assert!(!bench.path("press.mp4").exists());
}

#[test]
fn a_video_whose_name_ends_otherwise_is_refused() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("record press press.mcap --frames-only").expect_done();
    bench.run("export press.mcap --out press.bin --format avi").expect_failure("ends in .avi or .mp4", "--format");
    bench.run("export press.mcap --out press.mp4 --format avi").expect_failure("ends in .avi or .mp4", "--format");
}

/// More frames than a fragment has.
#[cfg(feature = "mp4")]
#[test]
fn both_videos_show_the_same_at_the_same_times() {
    use fingervision_image::Frame;
    use fingervision_source::Options;

    let bench = Workbench::new();
    bench.press(35);
    bench.run("record press press.mcap --frames-only").expect_done();
    let [avi, mp4]: [Vec<Frame>; 2] = ["avi", "mp4"].map(|ending| {
        bench.run(&format!("export press.mcap --out press.{ending}")).expect_done();
        let path = bench.path(&format!("press.{ending}"));
        let mut source = fingervision_source::open(path, &Options::default()).unwrap();
        std::iter::from_fn(|| source.next_frame().unwrap()).collect()
    });
    assert_eq!((avi.len(), mp4.len()), (35, 35));
    for (old, new) in avi.iter().zip(&mp4) {
        let (number, (width, height)) = (new.sequence, new.pixels.size());
        assert_eq!(old.pixels.size(), (width, height));
        assert!((new.capture_time_s - number as f64 / 30.0).abs() < 1e-4, "frame {number} at {} s", new.capture_time_s);
        let grey = |frame: &Frame, x, y| frame.pixels.levels(x, y).iter().sum::<f32>() / 3.0;
        let places = || (0..height).step_by(3).flat_map(|y| (0..width).step_by(3).map(move |x| (x, y)));
        let differences = places().map(|(x, y)| (grey(old, x, y) - grey(new, x, y)).abs());
        let mean = differences.sum::<f32>() / places().count() as f32;
        assert!(mean < 4.0, "frame {number}: the mean difference is {mean} levels");
    }
    // A run that was killed leaves whole fragments.
    let file = std::fs::read(bench.path("press.mp4")).unwrap();
    let last = file.windows(4).rposition(|letters| letters == b"moof").unwrap() - 4;
    std::fs::write(bench.path("cut.mp4"), &file[..last]).unwrap();
    let mut source = fingervision_source::open(bench.path("cut.mp4"), &Options::default()).unwrap();
    assert_eq!(std::iter::from_fn(|| source.next_frame().unwrap()).count(), 30);
}
