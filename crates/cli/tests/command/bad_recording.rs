//! Recordings that are damaged, cut off or none, and a disk that becomes full while one is written.

use std::fs;
use std::process::Command;

use crate::workbench::{Ended, Workbench};

/// A bench with a recording of so many frames.
fn recorded(frames: u32) -> Workbench {
    let bench = Workbench::new();
    bench.press(frames);
    bench.run("record press press.mcap --frames-only").expect_done();
    bench
}

/// Where the stored pictures of frames begin.
fn pictures(file: &[u8]) -> Vec<usize> {
    file.windows(4).enumerate().filter(|(_, letters)| *letters == b"RIFF").map(|(at, _)| at).collect()
}

#[test]
fn a_damaged_frame_is_named_and_can_be_skipped() {
    let bench = recorded(6);
    let mut file = fs::read(bench.path("press.mcap")).unwrap();
    let pictures = pictures(&file);
    assert_eq!(pictures.len(), 6);
    file[pictures[3] + 1000] ^= 1;
    fs::write(bench.path("press.mcap"), file).unwrap();
    bench.run("track press.mcap --out run").expect_failure("frame 3", "--skip-bad-frames");
    bench.run("track press.mcap --out skipped --skip-bad-frames").expect_done();
    let table = fs::read_to_string(bench.path("skipped/readings.csv")).unwrap();
    let numbers: Vec<&str> = table.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(numbers, ["0", "1", "2", "4", "5"]);
    bench.run("export press.mcap --out x.npz").expect_failure("frame 3", "");
    // Live goes on after it and says so.
    let ended = bench.run("live press.mcap --no-page").expect_done();
    assert!(ended.errors.contains("frame 3"), "{ended:?}");
}

#[test]
fn a_recording_that_is_cut_off_is_used_up_to_there() {
    let bench = recorded(6);
    let file = fs::read(bench.path("press.mcap")).unwrap();
    let pictures = pictures(&file);
    fs::write(bench.path("cut.mcap"), &file[..pictures[4] + 1000]).unwrap();
    let ended = bench.run("track cut.mcap --out run").expect_done();
    assert!(ended.errors.contains("cut.mcap was not closed"), "{ended:?}");
    assert_eq!(bench.column("sequence").len(), 4);
    let ended = bench.run("export cut.mcap --out cut.npz").expect_done();
    assert!(ended.out.contains("cut.npz: 4 frames"), "{ended:?}");
    assert!(bench.run("live cut.mcap --no-page").expect_done().errors.contains("was not closed"));
    // Too little is left for a reference and a frame.
    fs::write(bench.path("short.mcap"), &file[..pictures[1]]).unwrap();
    bench.run("track short.mcap --out none").expect_failure("short.mcap: one frame", "");
}

#[test]
fn what_is_no_recording_is_refused() {
    let bench = Workbench::new();
    for (name, bytes) in
        [("empty.mcap", b"".as_slice()), ("text.mcap", b"force,depth\n1,2\n"), ("magic.mcap", b"\x89MCAP0\r\n")]
    {
        fs::write(bench.path(name), bytes).unwrap();
        for command in ["track NAME --out run", "live NAME --no-page", "export NAME --out x.npz"] {
            bench.run(&command.replace("NAME", name)).expect_failure(name, "");
        }
    }
}

/// A limit on the length of files stands for the disk.
#[cfg(unix)]
#[test]
fn a_disk_that_becomes_full_ends_the_recording_and_keeps_what_was_written() {
    let bench = Workbench::new();
    bench.press(40);
    let program = bench.command("record press full.mcap --frames-only");
    let mut limited = Command::new("sh");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 600; exec \"$@\"", "sh"]).arg(program.get_program());
    limited.args(program.get_args()).current_dir(bench.path("."));
    let ended = Ended::from(limited.output().unwrap());
    ended.expect_failure("full.mcap: cannot be written", "what was recorded so far can be read");
    let ended = bench.run("track full.mcap --out run").expect_done();
    assert!(ended.errors.contains("full.mcap was not closed"), "{ended:?}");
    let frames = bench.column("sequence").len();
    assert!((3..40).contains(&frames), "{frames} frames");
}
