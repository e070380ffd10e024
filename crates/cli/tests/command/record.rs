//! `fingervision record`, and what reads its files.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use crate::workbench::Workbench;

/// The columns of a table without that of the latency, which differs from run to run.
fn rows(bench: &Workbench, name: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(bench.path(name)).unwrap();
    let row = |line: &str| -> Vec<String> { line.split(',').map(Into::into).collect() };
    let mut rows: Vec<Vec<String>> = text.lines().map(row).collect();
    let latency = rows[0].iter().position(|name| name == "latency_ms").unwrap();
    for row in &mut rows {
        row.remove(latency);
    }
    rows
}

#[test]
fn a_recording_is_tracked_as_its_source() {
    let bench = Workbench::new();
    bench.press(6);
    fs::write(bench.path("sensor.toml"), "name = \"left\"\n[flow]\nnoise_levels = 1.5\n").unwrap();
    let ended = bench.run("record press press.mcap --profile sensor.toml").expect_done();
    assert!(ended.out.contains("press.mcap: 6 frames, 6 readings"), "{}", ended.out);
    bench.run("track press --out direct --profile sensor.toml --fields flow,density").expect_done();
    // The profile is in the file.
    bench.run("track press.mcap --out recorded --fields flow,density").expect_done();
    for name in ["flow.npy", "density.npy", "valid.npy"] {
        let [direct, recorded] = ["direct", "recorded"].map(|run| fs::read(bench.path(run).join(name)).unwrap());
        assert!(direct == recorded, "{name} differs");
    }
    assert_eq!(rows(&bench, "direct/readings.csv"), rows(&bench, "recorded/readings.csv"));
    let record = fs::read_to_string(bench.path("recorded/run.toml")).unwrap();
    assert!(record.contains("press.mcap") && record.contains("noise_levels = 1.5"), "{record}");
}

#[test]
fn a_recording_of_a_video_is_tracked_as_the_video() {
    let bench = Workbench::new();
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata/colour.avi"), bench.path("press.avi")).unwrap();
    bench.run("record press.avi press.mcap").expect_done();
    for (source, run) in [("press.avi", "direct"), ("press.mcap", "recorded")] {
        bench.run(&format!("track {source} --out {run} --fields flow")).expect_done();
    }
    // Its colour has half the resolution: the flow is computed from grey.
    assert_eq!(rows(&bench, "direct/readings.csv"), rows(&bench, "recorded/readings.csv"));
    let [direct, recorded] = ["direct", "recorded"].map(|run| fs::read(bench.path(run).join("flow.npy")).unwrap());
    assert!(direct == recorded, "the flow differs");
}

#[test]
fn a_part_is_recorded_by_the_files_own_time() {
    let bench = Workbench::new();
    bench.press(9);
    // 30 frames per second: frames 0 to 4 are before 0.15 s.
    let ended = bench.run("record press part.mcap --seconds 0.15 --frames-only --json").expect_done();
    let result: serde_json::Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!((&result["frames"], &result["readings"]), (&5.into(), &0.into()), "{result}");
    let sensor = &result["sensors"][0];
    assert_eq!((&sensor["readings"], sensor["frames_per_second"].is_null()), (&0.into(), true), "{result}");
    bench.run("track part.mcap --out run").expect_done();
    assert_eq!(bench.column("sequence").len(), 5);
}

#[test]
fn one_of_several_sensors_is_tracked_by_its_name() {
    let bench = Workbench::new();
    bench.press(4);
    bench.run("record press press two.mcap").expect_done();
    bench.run("track two.mcap --out run").expect_failure("it has 2 sensors: press, press 2", "?sensor=press");
    bench.run("track two.mcap?sensor=press --out run").expect_done();
    bench.run("track two.mcap?sensor=left --out run2").expect_failure("there is no sensor left", "?sensor=press");
}

#[test]
fn files_that_cannot_be_recordings_are_refused() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("record press press.avi").expect_failure("recordings are MCAP files", "name it press.mcap");
    bench.run("record press absent/press.mcap").expect_failure("there is no folder absent", "make the folder first");
    bench.run("record press press.mcap").expect_done();
    bench.run("record press press.mcap").expect_failure("press.mcap exists already", "--overwrite");
    bench.run("record press press.mcap --overwrite").expect_done();
}

#[test]
fn a_killed_recording_can_be_tracked() {
    let bench = Workbench::new();
    bench.press(40);
    let mut child =
        bench.command("record press killed.mcap").stderr(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
    let path = bench.path("killed.mcap");
    // Until the first chunk with frames is in the file.
    while fs::metadata(&path).map_or(0, |metadata| metadata.len()) < 40_000 && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    child.wait().unwrap();
    assert_eq!(out, "", "the recording had not ended");
    let ended = bench.run("track killed.mcap --out run").expect_done();
    assert!(ended.errors.contains("killed.mcap was not closed"), "{}", ended.errors);
    assert!(bench.column("sequence").len() > 1);
}

#[test]
fn a_recording_is_exported_as_its_run() {
    let bench = Workbench::new();
    bench.press(5);
    bench.run("record press press.mcap").expect_done();
    bench.run("track press.mcap --out run").expect_done();
    bench.run("export run --out run.csv").expect_done();
    assert_eq!(fs::read(bench.path("run.csv")).unwrap(), fs::read(bench.path("run/readings.csv")).unwrap());
    bench.run("export run --out run.npz").expect_done();
    let ended = bench.run("export press.mcap --out press.npz").expect_done();
    assert!(ended.out.contains("press.npz: 5 frames"), "{}", ended.out);
    let len = |name: &str| fs::metadata(bench.path(name)).unwrap().len();
    // They differ in the record only, which names the folder of neither.
    assert!(len("run.npz").abs_diff(len("press.npz")) < 200, "{} and {}", len("run.npz"), len("press.npz"));
    bench.run("export press.mcap --out press.zarr").expect_done();
    assert!(bench.path("press.zarr/flow/4.0.0.0").is_file() && bench.path("press.zarr/photometric_error/0").is_file());
    bench.run("export press.mcap --out press.avi").expect_done();
    assert!(fs::read(bench.path("press.avi")).unwrap().starts_with(b"RIFF"));
    let left: Vec<_> = fs::read_dir(bench.path(".")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(!left.iter().any(|name| name.to_string_lossy().starts_with(".export")), "{left:?}");
}

#[test]
fn exports_that_are_not_possible_are_refused() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run").expect_done();
    bench.run("export run --out run.avi").expect_failure("has no camera images", "--overlay");
    bench.run("export run --out run.mp4").expect_failure("has no camera images", "--overlay");
    bench.run("export press --out x.npz").expect_failure("press is not a run", "`fingervision track`");
    bench.run("export run --out x.xyz").expect_failure("x.xyz names no format", ".npz, .csv, .zarr, .avi or .mp4");
    bench.run("export run --out x.csv").expect_done();
    bench.run("export run --out x.csv").expect_failure("x.csv exists already", "--overwrite");
    bench.run("export run --out x.csv --overwrite").expect_done();
    bench
        .run("export run --out run --format zarr --overwrite")
        .expect_failure("run exists already", "choose a new name");
}
