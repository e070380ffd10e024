//! The folder of a run, written and read back.

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

use crate::synthetic::{Press, TRACTION_SIZE};
use fingervision_sink::{Field, Precision, RunFolder, RunOptions, Sink, SinkError};
use fingervision_touch::Flag;
use half::f16;

const PRESS: Press = Press { width: 24, height: 16, frames: 8 };

fn options(overwrite: bool) -> RunOptions {
    let size = (PRESS.width, PRESS.height);
    let precision = Precision::Float32;
    RunOptions { size, traction_size: Some(TRACTION_SIZE), precision, fields: Field::ALL.to_vec(), overwrite }
}

fn shape(path: &Path) -> Vec<u64> {
    npyz::NpyFile::new(File::open(path).unwrap()).unwrap().shape().to_vec()
}

fn values(path: &Path) -> Vec<f32> {
    npyz::NpyFile::new(File::open(path).unwrap()).unwrap().into_vec().unwrap()
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/run");
    let mut run = RunFolder::create(&path, &options(false), "version = 1\n").unwrap();
    for frame in 0..3 {
        run.write(&PRESS.reading(frame), &PRESS.frame(frame)).unwrap();
        assert_eq!(shape(&path.join("flow.npy")), [frame as u64 + 1, 16, 24, 2], "readable while it grows");
    }
    let summary = run.finish().unwrap();
    assert_eq!(summary.frames, 3);

    let reading = PRESS.reading(2);
    let flow = values(&path.join("flow.npy"));
    let expected = reading.flow.u.values().iter().zip(reading.flow.v.values()).flat_map(|(&u, &v)| [u, v]);
    assert_eq!(flow[2 * 24 * 16 * 2..], expected.collect::<Vec<_>>());
    let depth = values(&path.join("depth.npy"));
    assert_eq!(depth[2 * 24 * 16..], *reading.depth.unwrap().values());
    for name in ["density.npy", "deviation.npy", "valid.npy"] {
        assert_eq!(shape(&path.join(name)), [3, 16, 24], "{name}");
    }
    let files = Field::ALL.iter().map(|field| format!("{}.npy", field.name()));
    let files = files.chain(["valid.npy".into(), "readings.csv".into()]);
    let bytes: u64 = files.map(|name| fs::metadata(path.join(name)).unwrap().len()).sum();
    assert_eq!(summary.bytes, bytes);
    assert_eq!(fs::read_to_string(path.join("run.toml")).unwrap(), "version = 1\n");
}

#[test]
fn half_precision_takes_half_the_bytes_and_is_close() {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions { precision: Precision::Float16, ..options(false) };
    let mut run = RunFolder::create(folder.path(), &options, "").unwrap();
    let before = fs::metadata(folder.path().join("readings.csv")).unwrap().len();
    let reading = PRESS.reading(4);
    run.write(&reading, &PRESS.frame(4)).unwrap();
    let table = fs::metadata(folder.path().join("readings.csv")).unwrap().len();
    let (headers, pixels) = (10 * 128, 24 * 16);
    let bytes = run.finish().unwrap().bytes;
    assert!(before < table && bytes == table + headers + options.bytes_per_frame());
    assert_eq!(options.bytes_per_frame(), pixels * (2 * 9 + 3) + 15 * 3 * 2);

    let file = npyz::NpyFile::new(File::open(folder.path().join("flow.npy")).unwrap()).unwrap();
    assert_eq!(file.dtype().descr(), "'<f2'");
    assert_eq!(file.shape(), [1, 16, 24, 2]);
    let bytes = fs::read(folder.path().join("flow.npy")).unwrap();
    let found = bytes[128..].chunks_exact(2).map(|pair| f16::from_le_bytes([pair[0], pair[1]]).to_f32());
    let expected = reading.flow.u.values().iter().zip(reading.flow.v.values()).flat_map(|(&u, &v)| [u, v]);
    for (found, expected) in found.zip(expected) {
        assert!((found - expected).abs() <= expected.abs() / 2048.0 + 1e-7, "{found} for {expected}");
    }
}

#[test]
fn what_elasticity_tells_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = RunFolder::create(folder.path(), &options(false), "").unwrap();
    let reading = PRESS.reading(4);
    run.write(&reading, &PRESS.frame(4)).unwrap();
    let path = |name: &str| folder.path().join(name);
    assert_eq!(shape(&path("displacement.npy")), [1, 16, 24, 3]);
    let [x, y, z] = reading.displacement.as_ref().unwrap();
    let expected: Vec<f32> = (0..24 * 16).flat_map(|at| [x, y, z].map(|plane| plane.values()[at])).collect();
    assert_eq!(values(&path("displacement.npy")), expected);
    assert_eq!(shape(&path("traction.npy")), [1, 3, 5, 3], "a grid of its own");
    assert_eq!(values(&path("traction.npy")), reading.traction.as_ref().unwrap().traction_mpa.concat());
    let mask = |name: &str| npyz::NpyFile::new(File::open(path(name)).unwrap()).unwrap().into_vec::<u8>().unwrap();
    assert_eq!(mask("contact.npy"), reading.contact.as_ref().unwrap().values());
    assert!(mask("depth_valid.npy").iter().enumerate().all(|(at, &valid)| valid == u8::from(at % 24 > 0)));
    assert_eq!(shape(&path("depth_deviation.npy")), [1, 16, 24]);

    let mut other = reading.clone();
    other.traction.as_mut().unwrap().columns = 6;
    let error = run.write(&other, &PRESS.frame(4)).unwrap_err();
    assert_eq!(error.to_string(), "traction has 6x3 px, expected 5x3 px");
    other.traction = None;
    assert_eq!(run.write(&other, &PRESS.frame(4)).unwrap_err().to_string(), "frame 4 has no traction");
    assert_eq!(run.finish().unwrap().frames, 1);
}

#[test]
fn an_absent_value_is_an_empty_cell() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = RunFolder::create(folder.path(), &options(false), "").unwrap();
    let mut reading = PRESS.reading(0);
    reading.numbers.flags.raise(Flag::Lost);
    reading.numbers.flags.raise(Flag::DensityGap);
    (reading.numbers.max_depth_mm, reading.numbers.force_n, reading.numbers.torque_nmm) =
        (None, Some([0.5, -0.25, 2.0]), Some(-1.5));
    run.write(&reading, &PRESS.frame(0)).unwrap();
    (reading.numbers.contact_area_mm2, reading.numbers.force_n, reading.numbers.torque_nmm) = (None, None, None);
    run.write(&reading, &PRESS.frame(0)).unwrap();
    let table = fs::read_to_string(folder.path().join("readings.csv")).unwrap();
    let expected = "sequence,capture_time_s,reference_id,reference_count,photometric_error,max_depth_mm,\
                    contact_area_mm2,force_x_n,force_y_n,force_z_n,latency_ms,flags,\
                    torque_z_nmm\n\
                    0,1234.5,0,1,2.5,,0,0.5,-0.25,2,7.250,lost+density-gap,-1.5\n\
                    0,1234.5,0,1,2.5,,,,,,7.250,lost+density-gap,\n";
    assert_eq!(table, expected);
}

#[test]
fn only_the_fields_asked_for_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions { fields: vec![Field::Depth], ..options(false) };
    let mut run = RunFolder::create(folder.path(), &options, "").unwrap();
    let mut reading = PRESS.reading(0);
    run.write(&reading, &PRESS.frame(0)).unwrap();
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["depth.npy", "readings.csv", "run.toml", "valid.npy"]);

    reading.depth = None;
    let error = run.write(&reading, &PRESS.frame(0)).unwrap_err();
    assert_eq!(error.to_string(), "frame 0 has no depth");
}

#[test]
fn a_previous_run_is_replaced_only_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    RunFolder::create(folder.path(), &options(false), "old").unwrap();
    let error = RunFolder::create(folder.path(), &options(false), "new").unwrap_err();
    assert!(matches!(error, SinkError::Previous { .. }), "{error}");
    assert_eq!(error.hint(), Some("choose a new folder or pass --overwrite"));

    let only_depth = RunOptions { fields: vec![Field::Depth], ..options(true) };
    RunFolder::create(folder.path(), &only_depth, "new").unwrap();
    assert_eq!(fs::read_to_string(folder.path().join("run.toml")).unwrap(), "new");
    assert!(!folder.path().join("flow.npy").exists(), "no field of the old run is left");
}

#[test]
fn a_folder_that_is_no_run_is_never_touched() {
    let folder = tempfile::tempdir().unwrap();
    let thesis = folder.path().join("thesis.tex");
    fs::write(&thesis, "chapter one").unwrap();
    let error = RunFolder::create(folder.path(), &options(true), "").unwrap_err();
    assert!(matches!(error, SinkError::FolderNotEmpty { .. }), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_file_in_the_folders_place_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    fs::write(&path, "").unwrap();
    let error = RunFolder::create(&path, &options(false), "").unwrap_err();
    assert!(error.to_string().contains(path.to_str().unwrap()), "{error}");
    assert!(error.hint().is_some(), "{error}");
}

#[test]
fn a_reading_of_another_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = RunFolder::create(folder.path(), &options(false), "").unwrap();
    let larger = Press { width: 25, ..PRESS };
    let error = run.write(&larger.reading(0), &larger.frame(0)).unwrap_err();
    assert_eq!(error.to_string(), "flow has 25x16 px, expected 24x16 px");
    assert_eq!(run.finish().unwrap().frames, 0);
}

#[test]
fn writing_a_reading_allocates_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = RunFolder::create(folder.path(), &options(false), "").unwrap();
    let (reading, frame) = (PRESS.reading(4), PRESS.frame(4));
    run.write(&reading, &frame).unwrap();
    let allocations = allocation_counter::measure(|| run.write(&reading, &frame).unwrap());
    assert_eq!(allocations.count_total, 0, "{allocations:?}");
}

/// A file system of 64 KiB, unmounted when dropped.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    /// `None` without the rights to mount it.
    fn mount(path: &'a Path) -> Option<Self> {
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(path).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(Self(path))
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).output();
    }
}

#[test]
fn a_full_disk_costs_no_frame_that_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let Some(disk) = SmallDisk::mount(folder.path()) else {
        println!("skipped: this machine does not let the test mount a small disk");
        return;
    };
    let mut run = RunFolder::create(disk.0, &options(false), "version = 1\n").unwrap();
    let written = (0..100).map(|frame| run.write(&PRESS.reading(frame), &PRESS.frame(frame)));
    let written: Vec<_> = written.take_while(Result::is_ok).collect();
    let error = run.write(&PRESS.reading(0), &PRESS.frame(0)).unwrap_err();
    assert!(error.to_string().contains("No space left"), "{error}");
    assert!(error.to_string().contains(".npy"), "{error}");
    assert!(error.hint().unwrap().contains("space"));

    let frames = written.len();
    assert!((1..100).contains(&frames), "{frames} frames");
    for name in ["flow.npy", "density.npy", "depth.npy", "deviation.npy", "valid.npy"] {
        assert_eq!(shape(&disk.0.join(name))[0], frames as u64, "{name}");
    }
    let depth = values(&disk.0.join("depth.npy"));
    assert_eq!(depth[(frames - 1) * 24 * 16..], *PRESS.reading(frames - 1).depth.unwrap().values());
    let table = fs::read_to_string(disk.0.join("readings.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + frames);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_takes_nothing_is_reported_with_the_file() {
    let error = fingervision_sink::Table::create(Path::new("/dev/full")).unwrap_err();
    assert!(error.to_string().starts_with("cannot write /dev/full: No space left"), "{error}");
}
