//! What a command refuses before it starts: settings without effect, existing files, folders in use.

use std::fs::{self, File};

use serde_json::Value;

use crate::workbench::Workbench;

#[test]
fn a_setting_that_changes_nothing_is_refused_before_any_work() {
    let bench = Workbench::new();
    bench.press(2);
    for (assignment, why, hint) in [
        ("flow.finest_level=1", "flow.preset = \"affine\" always ends at full size", "flow.preset=medium"),
        ("references.push_error=8", "references.policy = \"anchored\" does not use it", "references.policy=stack"),
        ("elastic.mode=live", "there is no elastic depth: the profile has no [camera]", "describe [camera]"),
    ] {
        let key = assignment.split('=').next().unwrap();
        let ended = bench.run(&format!("track press --out run --set {assignment}"));
        ended.expect_failure(&format!("{key} has no effect: {why}"), hint);
    }
    let ended = bench.run("track press --out run --fields flow --set density.sigma_px=3");
    ended.expect_failure("density.sigma_px has no effect", "--fields");
    assert!(!bench.path("run").exists(), "nothing is begun");
    bench.run("track press --out run --set flow.preset=medium --set flow.finest_level=1").expect_done();
}

#[test]
fn a_profile_file_may_hold_settings_without_effect_and_they_are_noted() {
    let bench = Workbench::new();
    bench.press(2);
    bench.write("sensor.toml", "[references]\ncoarse_grid = [50, 40]\nmax_references = 64\n");
    let ended = bench.run("track press --out run --profile sensor.toml").expect_done();
    assert!(ended.errors.contains("note: references.coarse_grid has no effect: references.policy"), "{}", ended.errors);
    assert!(!ended.errors.contains("max_references"), "a default is not worth a note: {}", ended.errors);
}

#[test]
fn the_example_of_the_help_changes_the_flow() {
    let bench = Workbench::new();
    bench.press(3);
    let help = bench.run("track --help").expect_done().out;
    let example = help.split('`').find(|text| text.starts_with("flow.") && text.contains('=')).unwrap().to_string();
    let flow = |set: &str| {
        bench.run(&format!("track press --out run --overwrite {set}")).expect_done();
        bench.array::<f32>("flow.npy").1
    };
    assert!(flow("") != flow(&format!("--set {example}")), "{example} changes nothing");
}

#[test]
fn a_rate_that_the_source_does_not_take_is_refused() {
    let bench = Workbench::new();
    let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../source/testdata/colour.avi");
    bench.run(&format!("track {clip} --out run --fps 60")).expect_failure("has its own time stamps", "leave --fps out");
    bench.run("track sim:letter?fps=60 --out run --fps 50").expect_failure("already contains a rate", "once");
    bench
        .run("track sim:letter?fps=abc --out run")
        .expect_failure("abc is not a number of frames per second", "--fps 60");
    bench.run("track sim:letter?speed=2 --out run").expect_failure("the option speed=2 is not supported", "fps=RATE");
}

#[test]
fn a_pattern_is_replaced_only_when_asked() {
    let bench = Workbench::new();
    bench.write("a.svg", "mine");
    let command = "pattern --size-mm 3,3 --out a.svg";
    bench.run(command).expect_failure("a.svg exists already", "--overwrite");
    assert_eq!(fs::read_to_string(bench.path("a.svg")).unwrap(), "mine");
    bench.run(&format!("{command} --overwrite")).expect_done();
    assert!(fs::read_to_string(bench.path("a.svg")).unwrap().contains("<svg"));
}

#[test]
fn a_report_is_replaced_only_when_asked() {
    let bench = Workbench::new();
    bench.folder("report");
    bench.write("report/mine.txt", "mine");
    bench
        .run("reproduce --quick --out report")
        .expect_failure("contains files that are not a report", "an empty folder");
    bench.folder("earlier");
    bench.write("earlier/report.html", "an earlier one");
    let ended = bench.run("evaluate --benchmark --quick --out earlier");
    ended.expect_failure("contains a previous report", "--overwrite");
}

#[test]
fn a_score_names_the_size_that_was_asked_for() {
    let bench = Workbench::new();
    let ended = bench.run("pattern --score --cell-mm 0.1 --image-px 64,64").expect_done();
    assert!(ended.out.contains("requested: 0.1000 mm, "), "{}", ended.out);
    bench.run("pattern --score --set flow.validity.noise_floor=3").expect_failure("has no effect", "flow.noise_levels");
    bench.run("pattern --out a.svg --set flow.noise_levels=3").expect_failure("have no effect", "--score");
}

#[test]
fn overwriting_removes_what_the_run_before_left_and_nothing_else() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run").expect_done();
    bench.folder("run/evaluation");
    bench.write("run/evaluation/evaluation.png", "of the run before");
    bench.run("track press --out run --overwrite").expect_done();
    assert!(!bench.path("run/evaluation").exists(), "the picture belonged to the run before");
    bench.folder("run/evaluation");
    bench.write("run/evaluation/notes.txt", "mine");
    bench.run("track press --out run --overwrite").expect_done();
    assert_eq!(fs::read_to_string(bench.path("run/evaluation/notes.txt")).unwrap(), "mine");
}

#[cfg(unix)]
#[test]
fn a_folder_that_another_command_writes_is_refused() {
    let bench = Workbench::new();
    bench.press(2);
    bench.run("track press --out run").expect_done();
    let folder = File::open(bench.path("run")).unwrap();
    folder.try_lock().unwrap();
    let command = "track press --out run --overwrite";
    bench.run(command).expect_failure("run is being written by another command", "wait until");
    assert!(bench.path("run/flow.npy").exists(), "nothing of the other is touched");
    drop(folder);
    bench.run(command).expect_done();
}

#[cfg(unix)]
#[test]
fn a_pipe_among_the_images_is_refused_and_not_waited_for() {
    let bench = Workbench::new();
    let folder = bench.press(3);
    assert!(std::process::Command::new("mkfifo").arg(folder.join("0003.png")).status().unwrap().success());
    bench
        .run("track press --out run")
        .expect_failure("0003.png: a pipe, socket or device is not supported", "regular files");
}

#[test]
fn errors_are_json_where_results_are() {
    let bench = Workbench::new();
    let error = |arguments: &str, code: i32| -> Value {
        let ended = bench.run(arguments);
        assert_eq!((ended.code, ended.out.as_str()), (Some(code), ""), "{ended:?}");
        let error: Value = serde_json::from_str(ended.errors.lines().last().unwrap()).unwrap();
        assert_eq!(error["exit_code"], code, "{error}");
        error
    };
    let failed = error("track nowhere --out run --json", 1);
    assert_eq!(failed["error"], "nowhere: no such file or folder");
    assert!(failed["hint"].as_str().unwrap().contains("are read"), "{failed}");
    let misused = error("track press --json", 2);
    assert!(misused["error"].as_str().unwrap().contains("required arguments"), "{misused}");
}

#[cfg(unix)]
#[test]
fn a_name_that_json_cannot_hold_is_refused_before_the_work() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    let bench = Workbench::new();
    bench.press(2);
    let output = |more: &[&str]| {
        let mut command = bench.command("track press --out");
        command.arg(OsStr::from_bytes(b"run\xff")).args(more).output().unwrap()
    };
    let refused = output(&["--json"]);
    assert_eq!((refused.status.code(), refused.stdout.as_slice()), (Some(1), [].as_slice()));
    let errors = String::from_utf8(refused.stderr).unwrap();
    assert!(errors.contains("is not UTF-8 text, which --json needs"), "{errors}");
    assert_eq!(fs::read_dir(bench.path(".")).unwrap().count(), 1, "nothing but the press is there");
    assert_eq!(output(&[]).status.code(), Some(0));
}
