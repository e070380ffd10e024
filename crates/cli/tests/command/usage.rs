//! Help texts, and errors for wrong usage.

use std::fs;
use std::process::Stdio;

use crate::workbench::Workbench;

#[test]
fn wrong_usage_exits_with_2() {
    let bench = Workbench::new();
    for arguments in [
        "",
        "trak press",
        "track",
        "track press",
        "track press --out run --fps 0",
        "track press --out run --fields flow,forces",
        "track press --out run --set flow.finest_level",
        "track press --out run --frames 3..3",
        "track press --out run --frames 5",
        "track press --out run --threads 0",
        "track press --out run --threads 1025",
        "profile",
        "profile new",
        "profile new --out a.toml --image-size 640",
        "profile new --out a.toml --distance-mm -3",
        "profile new --out a.toml --poissons-ratio 0.5",
        "profile new --out a.toml --focal-length-px 400",
        "profile show a.toml --toml --json",
        "completions",
        "completions tcsh",
        "bench --frames 0",
        "simulate",
        "simulate circle",
        "simulate circle --list",
        "simulate circle --random 3 --out a",
        "simulate --random 0 --out a",
        "simulate circle --out a --set gel.thickness_mm",
        "evaluate run",
        "pattern",
        "pattern --out a.png --dpi 0",
        "pattern --out a.pdf --size-mm 30",
        "pattern --out a.pdf --size-mm 30,-1",
        "pattern --out a.pdf --levels 0,256",
        "pattern --out a.pdf --kind stripes",
        "pattern --score --mm-per-px 0",
        "evaluate --benchmark run truth",
        "evaluate run truth --quick",
        "evaluate run truth --set elastic.network=false",
        "evaluate run truth --mesh fine",
        "calibrate --step-mm 0",
        "calibrate --distance-mm 25",
        "calibrate --folder sensor camera board --step-mm 0.5 --profile a.toml",
        "calibrate gel press",
        "calibrate gel --profile a.toml",
        "calibrate gel press --profile a.toml --fit stiffness",
        "calibrate camera board --step-mm 0.5",
        "calibrate camera board --step-mm 0.5 --corners a.csv --profile a.toml",
        "calibrate camera board --profile a.toml",
        "calibrate camera board --profile a.toml --step-mm -0.5",
        "live --no-page --port 8090",
        "calibrate camera board --profile a.toml --step-mm 0.5 --direction z",
        "calibrate camera board --profile a.toml --step-mm 0.5 --prior distance_mm=25",
    ] {
        let ended = bench.run(arguments);
        assert_eq!(ended.code, Some(2), "{arguments}: {ended:?}");
        assert_eq!(ended.out, "", "{arguments}");
        assert!(!ended.errors.is_empty(), "{arguments}");
    }
}

/// After a change of the help, look at it and run the tests with `UPDATE_HELP=1`.
#[test]
fn the_help_is_as_recorded() {
    let bench = Workbench::new();
    for name in [
        "fingervision",
        "live",
        "record",
        "track",
        "evaluate",
        "export",
        "demo",
        "pattern",
        "reproduce",
        "calibrate",
        "calibrate-camera",
        "calibrate-depth",
        "calibrate-gel",
        "simulate",
        "bench",
        "doctor",
        "profile",
        "profile-new",
        "profile-show",
        "profile-check",
        "profile-fingerprint",
        "completions",
        "man",
    ] {
        let command = name.replace('-', " ");
        let arguments = if name == "fingervision" { "--help".into() } else { format!("{command} --help") };
        let help = bench.run(&arguments).expect_done().out;
        let path = format!("{}/tests/help/{name}.txt", env!("CARGO_MANIFEST_DIR"));
        if std::env::var_os("UPDATE_HELP").is_some() {
            fs::write(&path, &help).unwrap();
        }
        let recorded = fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(help, recorded, "{path}");
    }
}

#[test]
fn a_reader_that_leaves_is_no_failure() {
    let bench = Workbench::new();
    let mut child = bench.command("doctor").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), [].as_slice()));
}

#[test]
fn an_output_that_is_full_is_a_failure() {
    let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") else {
        println!("skipped: this machine has no /dev/full");
        return;
    };
    let output = Workbench::new().command("doctor").stdout(full).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.starts_with("error: cannot write the output: No space left"), "{errors}");
}

#[test]
fn a_negative_number_is_refused_with_what_is_expected() {
    let bench = Workbench::new();
    for (arguments, expected) in [
        ("track press --out run --fps -5", "invalid value '-5' for '--fps <RATE>': a rate is a number above 0"),
        ("track press --out run --threads -1", "invalid value '-1' for '--threads <N>': expected a number of threads"),
        (
            "profile new --out a.toml --thickness-mm -10",
            "invalid value '-10' for '--thickness-mm <MM>': expected a number",
        ),
        ("calibrate --view-mm -3", "invalid value '-3' for '--view-mm <MM>': expected a length in mm"),
        ("simulate circle --out a --frames -3", "invalid value '-3' for '--frames <N>': expected a whole number"),
        ("simulate circle --out a --seed -3", "invalid value '-3' for '--seed <SEED>': expected a whole number"),
        ("pattern --out a.pdf --seed -1", "invalid value '-1' for '--seed <N>': expected a whole number"),
    ] {
        let ended = bench.run(arguments);
        assert_eq!(ended.code, Some(2), "{ended:?}");
        assert!(ended.errors.contains(expected), "{arguments}: {}", ended.errors);
    }
}
