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
    let bench = Workbench::new();
    let ended = bench.run("demo").expect_done();
    assert!(ended.out.contains("preview  fingervision-demo/preview.png"), "{}", ended.out);
    assert!(ended.out.contains("flow is off by 0.0"), "{}", ended.out);
    assert_eq!(ended.errors, "");
    let result = json(&bench.run("demo --headless --json").expect_done());
    assert_eq!(result["frames"], 25, "{result}");
    let (mean, deepest) = (&result["truth"]["mean_error_px"], &result["truth"]["deepest"]);
    assert!(mean.as_f64().unwrap() < 0.03, "{mean} px");
    assert!(deepest["mean_px"].as_f64().unwrap() < 0.05 && deepest["valid"].as_f64().unwrap() > 0.9, "{deepest}");
    for name in ["flow.npy", "density.npy", "valid.npy", "readings.csv", "run.toml", "preview.png"] {
        assert!(bench.path("fingervision-demo").join(name).exists(), "{name}");
    }
}

#[test]
fn the_demo_replaces_only_its_own_folder() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run("track press --out run").expect_done();
    bench.run("demo --out run").expect_failure("run holds a previous run", "choose a new folder");
}

#[test]
fn the_bench_reports_ordered_percentiles() {
    let ended = Workbench::new().run("bench --frames 4 --json").expect_done();
    let speed = json(&ended);
    let times = ["p50_ms", "p90_ms", "p99_ms", "max_ms"].map(|name| speed[name].as_f64().unwrap());
    assert!(times[0] > 0.0 && times.is_sorted(), "{speed}");
    assert_eq!(speed["frames"], 4);
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
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let ended = Ended::from(child.wait_with_output().unwrap());
    ended.expect_failure("of 3000 frames", "what was written can be read");
    bench.expect_run_of(bench.column("sequence").len() as u64);
}
