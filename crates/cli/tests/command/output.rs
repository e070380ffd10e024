//! The commands that need no recording, JSON for programs, and a run that is interrupted.

use std::fs;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::workbench::{Ended, Workbench};

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).unwrap()
}

#[test]
fn the_demo_is_tracked_close_to_its_truth() {
    let bench = Workbench::with_empty_cache();
    let ended = bench.run("demo --headless").expect_done();
    assert!(ended.out.contains("preview  fingervision-demo/run/preview.png"), "{}", ended.out);
    assert!(ended.out.contains("flow error 0.0"), "{}", ended.out);
    let result = json(&bench.run("demo --headless --json").expect_done());
    assert_eq!(result["frames"], 21, "{result}");
    assert_eq!(result["simulation"]["press"], "cache", "the first demo kept its press");
    let errors = &result["truth"]["mean"]["flow_px"]["everywhere"];
    assert!(errors["mean"].as_f64().unwrap() < 0.02 && errors["true_peak"].as_f64().unwrap() > 2.0, "{errors}");
    let pixels = &result["truth"]["mean"]["pixels"]["everywhere"];
    let [compared, rest] = [&pixels["compared"], &pixels["not_valid"]].map(|count| count.as_f64().unwrap());
    assert!(compared > 0.9 * (compared + rest), "{pixels}");
    let depth = &result["truth"]["mean"]["depth_mm"];
    let error_mm = |part: &str| depth[part]["mean"].as_f64().unwrap();
    assert!(error_mm("everywhere") < 0.015 && error_mm("inside") < 0.05, "{depth}");
    let [told_n, true_n] = [&result["deepest"], &result["simulation"]].map(|of| of["force_z_n"].as_f64().unwrap());
    assert!((told_n / true_n - 1.0).abs() < 0.05, "{told_n} N, {true_n} N in truth");
    for name in ["flow.npy", "depth.npy", "valid.npy", "readings.csv", "run.toml", "evaluation/evaluation.png"] {
        assert!(bench.path("fingervision-demo/run").join(name).exists(), "{name}");
    }
}

#[test]
fn the_demo_replaces_only_its_own_folder() {
    let bench = Workbench::new();
    bench.run("simulate board --frames 2 --truth-only --out mine/simulation").expect_done();
    let refused = bench.run("demo --out mine");
    refused.expect_failure("mine/simulation contains a previous simulation", "choose a new folder");
}

#[test]
fn the_bench_times_whole_presses_and_finds_them_close_to_their_truth() {
    let bench = Workbench::new();
    let report = json(&bench.run("bench --frames 3 --json").expect_done());
    let times = ["p10", "p50", "p90", "p99", "max"].map(|name| report["frame_ms"][name].as_f64().unwrap());
    assert!(times[0] > 0.0 && times.is_sorted(), "{report}");
    assert_eq!(report["frame_ms"]["median"], report["frame_ms"]["p50"]);
    assert_eq!((&report["frames"], &report["size"]), (&Value::from(30), &serde_json::json!([610, 450])));
    assert!(report["frames_per_second"].as_f64().unwrap() > 0.0, "{report}");
    for (name, most_px) in [("mean", 0.05), ("final", 0.1)] {
        let error_px = report["epe_px"][name].as_f64().unwrap();
        assert!(error_px > 0.0 && error_px < most_px, "{name} {error_px} px, expected at most {most_px} px");
    }
    let elastic = &report["elastic_ms"];
    assert!(
        elastic["flow"].as_f64().unwrap() > 0.0 && elastic["live"].is_f64() && elastic["exact"].is_f64(),
        "{elastic}"
    );
}

#[test]
fn the_bench_writes_its_press_once_with_a_truth_to_compare_runs_with() {
    let bench = Workbench::new();
    let write = "bench --write-frames press --set image.region_of_interest=[0,0,244,180]";
    bench.run(write).expect_done();
    let mut names: Vec<_> =
        fs::read_dir(bench.path("press/frames")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!((names.len(), names[0].to_str(), names[30].to_str()), (31, Some("000000.png"), Some("000030.png")));
    assert_eq!(image::image_dimensions(bench.path("press/frames/000030.png")).unwrap(), (244, 180));

    let (shape, flow) = bench.array_at::<f32>("press/truth/flow.npy");
    assert_eq!(shape, [31, 180, 244, 2]);
    let largest = |frame: &[f32]| frame.chunks(2).map(|uv| uv[0].hypot(uv[1])).fold(0.0, f32::max);
    let [start, middle, end] = [0, 15, 30].map(|frame| largest(&flow[frame * 180 * 244 * 2..][..180 * 244 * 2]));
    // 25 px on 450 rows.
    assert!(start == 0.0 && (middle - 5.0).abs() < 0.01 && (end - 10.0).abs() < 0.01, "{start}, {middle}, {end} px");

    bench.folder("run");
    fs::copy(bench.path("press/truth/flow.npy"), bench.path("run/flow.npy")).unwrap();
    let report = json(&bench.run("evaluate run press --json").expect_done());
    assert_eq!(report["pooled"]["flow_px"]["everywhere"]["largest"].as_f64(), Some(0.0));
    assert_eq!(report["frames"], 31);

    bench.run(write).expect_failure("press/frames exists already", "choose a new folder");
}

#[test]
fn the_bench_tracks_simulated_cameras_at_their_rate() {
    let bench = Workbench::new();
    let load = "bench --sensors 2 --rate 10 --seconds 2 --size 160x120 --json";
    let report = json(&bench.run(load).expect_done());
    assert_eq!(report["sensors"], 2);
    let count = |key: &str| report[key].as_u64().unwrap();
    assert_eq!((count("readings") + count("dropped_frames"), count("damaged_frames")), (40, 0), "{report}");
    assert!(count("touched_readings") > 0 && count("lost_readings") == 0, "{report}");
    let latency = ["p50", "p95", "p99", "max"].map(|name| report["latency_ms"][name].as_f64().unwrap());
    assert!(latency[0] > 0.0 && latency.is_sorted(), "{report}");
    for stage in ["decode", "flow", "elastic"] {
        assert!(report["stages_ms"][stage]["p50"].as_f64().unwrap() > 0.0, "{stage}: {report}");
    }
    assert!(report["sensor_memory_mib"].is_number() || !cfg!(target_os = "linux"), "{report}");
    let found = json(&bench.run("bench --find --sensors 1 --rate 2 --seconds 1 --size 160x120 --json").expect_done());
    assert!(found["readings"].as_u64().is_some() && found["sensor_memory_mib"].is_null(), "of several trials: {found}");
    for (usage, error) in [("--sensors 2 --frames 30", "cannot be used with"), ("--rate 30", "--sensors <N>|--find")] {
        let ended = bench.run(&format!("bench {usage}"));
        assert_eq!(ended.code, Some(2), "{ended:?}");
        assert!(ended.errors.contains(error), "{ended:?}");
    }
    bench.run("bench --sensors 1 --recording absent").expect_failure("absent", "");
    bench.run("bench --sensors 1 --recording camera:left").expect_failure("is a camera", "record it first");
}

#[test]
fn the_doctor_finds_this_machine_healthy() {
    let bench = Workbench::new();
    let ended = bench.run("doctor").expect_done();
    assert!(ended.out.contains("self-test  passed"), "{}", ended.out);
    let diagnosis = json(&bench.run("doctor --json").expect_done());
    assert!(diagnosis["self_test_error_px"].as_f64().unwrap() < 0.05, "{diagnosis}");
}

#[test]
fn a_command_with_nothing_to_keep_ends_at_once() {
    let bench = Workbench::new();
    for (arguments, place) in
        [("evaluate --benchmark --out bench", "bench/report.html"), ("reproduce --out report", "report/report.html")]
    {
        let mut child = bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        while !bench.path(place).exists() {
            assert!(child.try_wait().unwrap().is_none(), "{arguments} ended before it was interrupted");
            std::thread::yield_now();
        }
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let ended = Ended::from(child.wait_with_output().unwrap());
        // What is said where nothing waits for the step at hand.
        ended.expect_failure_with(130, "interrupted before the result was written", "run the command again");
    }
}

#[test]
fn a_program_can_read_what_a_run_came_to() {
    let bench = Workbench::new();
    bench.press(3);
    let result = json(&bench.run("track press --out run --json").expect_done());
    assert_eq!((&result["frames"], &result["has_depth"]), (&Value::from(3), &Value::from(false)));
    assert_eq!(result["preview"], "run/preview.png");
    assert_eq!(result["flagged"], serde_json::json!({}));
}

#[test]
fn an_interrupted_run_keeps_what_was_written() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        expect_interrupted(signal, code);
    }
}

fn expect_interrupted(signal: &str, code: i32) {
    let bench = Workbench::new();
    let folder = bench.press(2);
    for copy in 2..3000 {
        fs::hard_link(folder.join("0001.png"), folder.join(format!("{copy:04}.png"))).unwrap();
    }
    let mut command = bench.command("track press --out run");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let table = bench.path("run/readings.csv");
    while !fs::read_to_string(&table).is_ok_and(|table| table.lines().count() > 2) {
        assert!(child.try_wait().unwrap().is_none(), "the run ended before it was interrupted");
        std::thread::yield_now();
    }
    Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    let ended = Ended::from(child.wait_with_output().unwrap());
    ended.expect_failure_with(code, "of 3000 frames", "the frames written so far can be used");
    bench.expect_run_of(bench.column("sequence").len() as u64);
}
