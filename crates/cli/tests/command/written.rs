//! The files of a run other than its arrays, and the size of a run.

use std::fs;

use crate::workbench::{Ended, Workbench, press_image};

#[test]
fn the_overlay_is_a_video_that_can_be_tracked_again() {
    let bench = Workbench::new();
    bench.press(4);
    let ended = bench.run("track press --out run --overlay run/overlay.avi --fps 60").expect_done();
    assert!(ended.out.contains("overlay  run/overlay.avi"), "{}", ended.out);
    let ended = bench.run("track run/overlay.avi --out again --fields flow").expect_done();
    assert!(ended.out.starts_with("4 frames of "), "{}", ended.out);
    let table = fs::read_to_string(bench.path("again/readings.csv")).unwrap();
    let second = table.lines().nth(2).unwrap();
    assert!(second.starts_with("1,0.01666"), "frames are 1/60 s apart: {second}");

    bench
        .run("track press --out other --overlay run/overlay.avi")
        .expect_failure("run/overlay.avi exists already", "--overwrite");
    assert!(!bench.path("other").exists(), "nothing is begun");
    bench.run("track press --out run --overlay run/overlay.avi --overwrite").expect_done();
}

#[test]
fn the_recording_is_never_replaced_by_its_own_run() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run --overlay run/overlay.avi").expect_done();
    let video = fs::read(bench.path("run/overlay.avi")).unwrap();
    fs::write(bench.path("press.avi"), &video).unwrap();
    let command = "track press.avi --out other --overlay ./press.avi --overwrite";
    bench.run(command).expect_failure("./press.avi is the recording itself", "another name");
    let command = "track run/overlay.avi --out run --overwrite";
    bench.run(command).expect_failure("run/overlay.avi is in run, which --overwrite clears", "another folder");
    for name in ["press.avi", "run/overlay.avi"] {
        assert_eq!(fs::read(bench.path(name)).unwrap(), video, "{name}");
    }
}

#[test]
fn an_overlay_without_a_folder_is_refused_before_the_previous_run_is_replaced() {
    let bench = Workbench::new();
    bench.press(3);
    bench.run("track press --out run").expect_done();
    let command = "track press --out run --overlay nowhere/a.avi --overwrite";
    bench.run(command).expect_failure("nowhere/a.avi: there is no folder nowhere", "make the folder first");
    bench.expect_run_of(3);
}

#[test]
fn an_overlay_of_another_kind_is_refused_with_the_command_that_makes_it() {
    let bench = Workbench::new();
    bench.press(2);
    let ended = bench.run("track press --out run --overlay a.mkv");
    assert_eq!(ended.code, Some(2), "{ended:?}");
    assert!(ended.errors.contains("ffmpeg -i a.avi -c:v libx264 -pix_fmt yuv420p a.mp4"), "{}", ended.errors);
}

#[test]
fn float16_takes_half_of_the_disk() {
    let bench = Workbench::new();
    bench.press(3);
    let len = |dtype: &str| {
        bench.run(&format!("track press --out run --overwrite --dtype {dtype}")).expect_done();
        let file = fs::read(bench.path("run/flow.npy")).unwrap();
        let header = String::from_utf8_lossy(&file[..128]).into_owned();
        assert!(header.contains(if dtype == "float16" { "<f2" } else { "<f4" }), "{header}");
        file.len() - 128
    };
    assert_eq!(len("float32"), 2 * len("float16"));
    assert_eq!(fs::metadata(bench.path("run/valid.npy")).unwrap().len(), 128 + 3 * 128 * 96);
}

#[test]
fn a_folder_of_images_with_and_without_loss_is_remarked_on() {
    let bench = Workbench::new();
    let folder = bench.press(4);
    let ended = bench.run("track press --out run").expect_done();
    assert!(!ended.errors.contains("JPEG"), "{}", ended.errors);
    press_image(1, 4).save(folder.join("0001.jpg")).unwrap();
    fs::remove_file(folder.join("0001.png")).unwrap();
    let ended = bench.run("track press --out run --overwrite").expect_done();
    assert!(ended.errors.contains("note: 1 of 4 images are JPEG, the first is 0001.jpg"), "{}", ended.errors);
}

#[test]
#[cfg(unix)]
fn a_file_that_may_not_grow_further_is_an_error_that_names_it() {
    use std::process::Command;

    let bench = Workbench::new();
    bench.press(4);
    // Blocks of 512 bytes: less than the flow of a frame.
    let track = bench.command("track press --out run");
    let mut limited = Command::new("sh");
    limited.args(["-c", "ulimit -f 64; exec \"$@\"", "limited"]).arg(track.get_program()).args(track.get_args());
    limited.current_dir(bench.path(""));
    limited.envs(track.get_envs().filter_map(|(name, value)| Some((name, value?))));
    Ended::from(limited.output().unwrap()).expect_failure("run/flow.npy: File too large", "disk");
}
