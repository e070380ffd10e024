//! A part of a recording, tracked.

use std::fs;

use serde_json::Value;

use crate::workbench::Workbench;

/// The bytes of some frames of an array of the run, behind its header.
fn frames_of(bench: &Workbench, name: &str, frames: std::ops::Range<usize>) -> Vec<u8> {
    let bytes = fs::read(bench.path(&format!("run/{name}.npy"))).unwrap();
    let count = bench.column("sequence").len();
    let channels = if name == "flow" { 2 } else { 1 };
    let frame_len = 128 * 96 * 4 * channels;
    let start = bytes.len() - count * frame_len;
    bytes[start + frames.start * frame_len..start + frames.end * frame_len].to_vec()
}

#[test]
fn a_part_is_what_the_whole_recording_gives_there() {
    let bench = Workbench::new();
    bench.press(8);
    bench.run("track press --out run").expect_done();
    let expected = ["flow", "density"].map(|name| frames_of(&bench, name, 3..6));
    let ended = bench.run("track press --out run --overwrite --frames 3..6").expect_done();
    assert!(ended.out.starts_with("3 frames"), "{}", ended.out);
    bench.expect_run_of(3);
    assert_eq!(bench.column("sequence"), ["3", "4", "5"]);
    assert_eq!(bench.column("capture_time_s")[0], "0.1");
    assert!(bench.column("flags").iter().all(|flags| !flags.contains("dropped")));
    assert!(["flow", "density"].map(|name| frames_of(&bench, name, 0..3)) == expected);
    let record: toml::Table = fs::read_to_string(bench.path("run/run.toml")).unwrap().parse().unwrap();
    assert_eq!(record["part"]["first"].as_integer(), Some(3));
    assert_eq!(record["part"]["end"].as_integer(), Some(6));
}

#[test]
fn a_reference_frame_is_where_displacement_is_zero() {
    let bench = Workbench::new();
    bench.press(6);
    bench
        .run("track press --out run --reference-frame 2 --frames ..5")
        .expect_failure("frame 2 comes after", "before the");
    bench.run("track press --out run --reference-frame 2").expect_done();
    assert_eq!(bench.column("sequence"), ["2", "3", "4", "5"]);
    let (_, flow) = bench.array::<f32>("flow.npy");
    let largest =
        |frame: usize| flow[frame * 2 * 128 * 96..][..2 * 128 * 96].iter().fold(0.0_f32, |a, b| a.max(b.abs()));
    assert!(largest(0) < 0.05 && largest(3) > 1.0, "{} px, {} px", largest(0), largest(3));
}

#[test]
fn frames_behind_the_part_are_not_read() {
    let bench = Workbench::new();
    bench.press(5);
    bench.write("press/0003.png", "not an image");
    bench.run("track press --out run --frames 1..3").expect_done();
    assert_eq!(bench.column("sequence"), ["1", "2"]);
}

#[test]
fn a_part_that_the_recording_does_not_have_is_refused() {
    let bench = Workbench::new();
    bench.press(4);
    let ended = bench.run("track press --out run --frames 7..9");
    ended.expect_failure("no frame in --frames 7..9: its last one is frame 3", "name frames that it contains");
    assert!(!bench.path("run").exists(), "nothing is begun");
    let ended = bench.run("track press --out other --reference-frame 7");
    ended.expect_failure("the recording has no frame 7 to begin with: its last one is frame 3", "--reference-frame");
    assert!(!bench.path("other").exists(), "nothing is begun");
    let ended = bench.run("track sim:circle?draft --out run --frames 100..");
    ended.expect_failure("no frame in --frames 100..: its last one is frame", "name frames that it contains");
}

#[test]
fn a_part_that_falls_into_a_gap_leaves_nothing_behind() {
    let bench = Workbench::new();
    let folder = bench.press(8);
    (3..6).for_each(|frame| fs::remove_file(folder.join(format!("{frame:04}.png"))).unwrap());
    let ended = bench.run("track press --out run --overlay film.avi --frames 4..6");
    let ended = ended.expect_failure("the recording has no frame in --frames 4..6", "name frames that it contains");
    assert_eq!(ended.out, "");
    assert!(!bench.path("run").exists() && !bench.path("film.avi").exists());
}

#[test]
fn a_part_is_evaluated_against_its_own_frames() {
    let bench = Workbench::new();
    bench.write("scene.toml", "[motion]\nkind = 'rigid'\nframes = 6\n[render]\nwidth = 96\nheight = 96");
    bench.run("simulate scene.toml --out truth").expect_done();
    bench.run("track truth/frames --out run --profile truth/profile.toml --fields flow").expect_done();
    let whole: Value = serde_json::from_str(&bench.run("evaluate run truth --json").expect_done().out).unwrap();
    bench
        .run("track truth/frames --out run --profile truth/profile.toml --fields flow --frames 3..5 --overwrite")
        .expect_done();
    let part: Value = serde_json::from_str(&bench.run("evaluate run truth --json").expect_done().out).unwrap();
    assert_eq!(part["frames"], 2);
    for row in 0..2 {
        let (part, whole) = (&part["per_frame"][row], &whole["per_frame"][row + 3]);
        assert_eq!(part["true_flow_px"], whole["true_flow_px"]);
        assert_eq!(part["errors"]["flow_px"], whole["errors"]["flow_px"]);
    }
}

#[test]
fn a_run_that_is_relative_to_another_frame_than_its_truth_is_remarked_on() {
    let bench = Workbench::new();
    bench.write("scene.toml", "[motion]\nkind = 'rigid'\nframes = 6\n[render]\nwidth = 96\nheight = 96");
    bench.run("simulate scene.toml --out truth").expect_done();
    bench.run("track truth/frames --out run --fields flow --reference-frame 2").expect_done();
    let ended = bench.run("evaluate run truth").expect_done();
    assert!(ended.out.contains("the run is relative to frame 2, the truth to frame 0"), "{}", ended.out);
    bench.run("track truth/frames --out run --fields flow --frames 2.. --overwrite").expect_done();
    let ended = bench.run("evaluate run truth").expect_done();
    assert!(!ended.out.contains("relative to frame"), "{}", ended.out);
}
