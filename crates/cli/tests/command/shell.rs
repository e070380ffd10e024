//! Completions and the manual.

use std::fs;
use std::process::{Command, Stdio};

use crate::workbench::Workbench;

/// Whether this machine has a program.
fn has(program: &str) -> bool {
    Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

#[test]
fn every_shell_gets_completions() {
    let bench = Workbench::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = bench.run(&format!("completions {shell}")).expect_done().out;
        for word in ["calibrate", "overwrite", "skip-bad-frames"] {
            assert!(text.contains(word), "the completions for {shell} do not contain {word}");
        }
        if !["bash", "zsh", "fish"].contains(&shell) {
            continue;
        }
        if has(shell) {
            bench.write("completions", &text);
            let checked = Command::new(shell).arg("-n").arg(bench.path("completions")).output().unwrap();
            assert!(checked.status.success() && checked.stderr.is_empty(), "{shell}: {checked:?}");
        } else {
            println!("not checked: this machine has no {shell}");
        }
    }
}

#[test]
fn bash_completes_commands_and_options() {
    if !has("bash") {
        println!("skipped: this machine has no bash");
        return;
    }
    let bench = Workbench::new();
    bench.write("completions", &bench.run("completions bash").expect_done().out);
    let complete = |words: &str| {
        let count = words.split(' ').count();
        let script = format!(
            "source completions; COMP_WORDS=({words}); COMP_CWORD={}; \
             _fingervision fingervision \"${{COMP_WORDS[{0}]}}\" \"${{COMP_WORDS[{}]}}\"; echo \"${{COMPREPLY[@]}}\"",
            count - 1,
            count - 2
        );
        let output = Command::new("bash").args(["-c", &script]).current_dir(bench.path("")).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(complete("fingervision tra").trim(), "track");
    assert_eq!(complete("fingervision track --skip").trim(), "--skip-bad-frames");
}

#[test]
fn the_manual_has_a_page_for_every_command() {
    let bench = Workbench::new();
    bench.run("man --out man1").expect_done();
    for name in ["fingervision", "fingervision-track", "fingervision-calibrate-camera", "fingervision-profile-new"] {
        let page = fs::read_to_string(bench.path(&format!("man1/{name}.1"))).unwrap();
        assert!(
            page.contains(".TH") && page.contains(".SH SYNOPSIS") && page.contains(".SH DESCRIPTION"),
            "{name}: {page}"
        );
        if has("groff") {
            let path = bench.path(&format!("man1/{name}.1"));
            let drawn = Command::new("groff").args(["-man", "-Tutf8", "-Kutf8", "-ww"]).arg(path).output().unwrap();
            assert!(drawn.status.success() && drawn.stderr.is_empty(), "{name}: {drawn:?}");
        } else {
            println!("not drawn: this machine has no groff");
        }
    }
    assert_eq!(bench.run("man").expect_done().out, fs::read_to_string(bench.path("man1/fingervision.1")).unwrap());
    bench.write("taken", "");
    bench.run("man --out taken/man1").expect_failure("taken/man1: the pages cannot be written", "--out");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_earlier_page() {
    let bench = Workbench::new();
    bench.run("man --out man1").expect_done();
    bench.write("man1/fingervision-track.1", "the earlier page");
    std::os::unix::fs::symlink("/dev/full", bench.path("man1/fingervision-track.1.new")).unwrap();
    bench.run("man --out man1").expect_failure("cannot write man1/fingervision-track.1: No space", "free some space");
    assert_eq!(fs::read_to_string(bench.path("man1/fingervision-track.1")).unwrap(), "the earlier page");
    bench.run("man --out man1").expect_done();
    assert!(fs::read_to_string(bench.path("man1/fingervision-track.1")).unwrap().contains(".TH"));
}
