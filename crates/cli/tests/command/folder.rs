//! `track` of a folder of recordings.

use std::fs;
#[cfg(unix)]
use std::process::{Command, Stdio};
#[cfg(unix)]
use std::{thread, time::Duration};

use serde_json::Value;

use crate::workbench::{Ended, Workbench};

/// A folder `presses`: images in a folder, in the subfolder of a press, and a recording; beside them files that are none.
fn presses() -> Workbench {
    let bench = Workbench::new();
    bench.press(5);
    bench.run("record press presses.mcap --frames-only").expect_done();
    bench.folder("presses/b");
    fs::rename(bench.path("press"), bench.path("presses/a")).unwrap();
    bench.press(3);
    fs::rename(bench.path("press"), bench.path("presses/b/frames")).unwrap();
    fs::rename(bench.path("presses.mcap"), bench.path("presses/c.mcap")).unwrap();
    // `simulate` writes a preview beside its images. The files after it are not recordings.
    fs::copy(bench.path("presses/a/0000.png"), bench.path("presses/b/preview.png")).unwrap();
    fs::copy(bench.path("presses/a/0000.png"), bench.path("presses/setup.png")).unwrap();
    bench.write("presses/notes.txt", "the second one is short");
    bench.run("track presses/a --out presses/old --fields flow").expect_done();
    bench.folder("presses/empty");
    bench
}

#[test]
fn each_recording_of_a_folder_is_tracked_as_if_it_were_alone() {
    let bench = presses();
    let ended = bench.run("track presses --out runs --fields flow --threads 2").expect_done();
    assert!(ended.out.contains("presses/b/frames: 3 frames"), "{}", ended.out);
    assert!(ended.out.contains("3 recordings, 13 frames in "), "{}", ended.out);
    let mut runs: Vec<_> = fs::read_dir(bench.path("runs")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    runs.sort();
    assert_eq!(runs, ["a", "b", "c"]);
    for (recording, name) in [("a", "a"), ("b/frames", "b"), ("c.mcap", "c")] {
        let alone = format!("track presses/{recording} --out run --overwrite --fields flow --threads 1");
        bench.run(&alone).expect_done();
        for file in ["flow.npy", "valid.npy"] {
            let of = |run: &str| fs::read(bench.path(&format!("{run}/{file}"))).unwrap();
            assert!(of("run") == of(&format!("runs/{name}")), "{recording}: {file} differs");
        }
    }
    let results = |ended: &Ended| serde_json::from_str::<Value>(&ended.out).unwrap();
    let ended = bench.run("track presses --out runs --overwrite --fields flow --json --threads 1").expect_done();
    let results = results(&ended);
    assert_eq!((&results["frames"], &results["recordings"][1]["frames"]), (&13.into(), &3.into()));
    assert_eq!(results["recordings"][2]["recording"], "presses/c.mcap");
}

#[test]
fn a_bad_recording_does_not_keep_the_others_from_being_tracked() {
    let bench = presses();
    bench.write("presses/d.mp4", "");
    let whole = fs::read(bench.path("presses/a/0002.png")).unwrap();
    fs::write(bench.path("presses/a/0002.png"), &whole[..whole.len() / 2]).unwrap();
    let ended = bench.run("track presses --out runs --fields flow");
    let what = "2 of 4 recordings were not tracked to the end: presses/a/0002.png: frame 2: ";
    let ended = ended.expect_failure(what, "--json gives a hint for each");
    assert!(ended.errors.contains("; presses/d.mp4: "), "{}", ended.errors);
    assert!(ended.out.contains("presses/a: 2 frames: "), "{}", ended.out);
    let frames = |run: &str| bench.array_at::<f32>(&format!("runs/{run}/flow.npy")).0[0];
    assert_eq!(["a", "b", "c"].map(frames), [2, 3, 5]);
}

#[test]
fn what_cannot_hold_for_several_recordings_is_refused_before_the_first() {
    let bench = presses();
    let overlay = bench.run("track presses --out runs --overlay runs.avi");
    overlay.expect_failure("--overlay is for one recording, but presses contains 3", "track one of them");
    bench.run("track presses --out presses").expect_failure("among the recordings in presses", "--out");
    fs::create_dir_all(bench.path("runs/c")).unwrap();
    bench.write("runs/c/important.txt", "");
    bench.run("track presses --out runs").expect_failure("runs/c", "");
    assert!(!bench.path("runs/a").exists(), "nothing is tracked before a run is refused");
    bench.run("track presses/empty --out others").expect_failure("presses/empty", "");
}

#[test]
fn every_sensor_of_a_recording_is_tracked() {
    let bench = Workbench::new();
    let scene = "[motion]\nframes = 3\nkeyframes = [{ at = 2, depth_mm = 0.4 }]\n[render]\nwidth = 160\nheight = 160";
    bench.write("scene.toml", scene);
    bench.folder("recordings");
    bench.run("record sim:scene.toml?draft sim:scene.toml?draft recordings/two.mcap --frames-only").expect_done();
    bench.run("track recordings --out runs --fields flow").expect_done();
    let runs = fs::read_dir(bench.path("runs")).unwrap().count();
    assert_eq!(runs, 2, "a run for each sensor");
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_all_recordings_in_order() {
    let bench = Workbench::new();
    for name in ["a", "b", "c"] {
        bench.press(60);
        bench.folder("presses");
        fs::rename(bench.path("press"), bench.path(&format!("presses/{name}"))).unwrap();
    }
    let mut command = bench.command("track presses --out runs --fields flow --threads 1 --json");
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !bench.path("runs/a/readings.csv").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    let id = command.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let ended = Ended::from(command.wait_with_output().unwrap());
    assert_eq!(ended.code, Some(130), "{ended:?}");
    let results: Value = serde_json::from_str(&ended.out).unwrap();
    let recordings = results["recordings"].as_array().unwrap();
    assert_eq!(recordings.len(), 3);
    assert!(recordings[0]["error"].as_str().unwrap().contains("interrupted after"), "{}", recordings[0]);
    assert_eq!(recordings[2]["error"], "interrupted before its first frame");
}
