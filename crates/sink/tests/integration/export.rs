//! A run folder in other forms.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use crate::synthetic::{Press, TRACTION_SIZE};
use fingervision_sink::{Field, Precision, RunArrays, RunFolder, RunOptions, Sink, SinkError, write_npz, write_zarr};

const PRESS: Press = Press { width: 24, height: 16, frames: 8 };

fn run(folder: &Path) -> RunArrays {
    let size = (PRESS.width, PRESS.height);
    let (precision, fields) = (Precision::Float32, Field::ALL.to_vec());
    let options = RunOptions { size, traction_size: Some(TRACTION_SIZE), precision, fields, overwrite: false };
    let mut run = RunFolder::create(folder, &options, "version = 1\n").unwrap();
    for frame in 0..4 {
        run.write(&PRESS.reading(frame), &PRESS.frame(frame)).unwrap();
    }
    run.finish().unwrap();
    RunArrays::open(folder).unwrap()
}

/// The bytes behind the header.
fn values(npy: &[u8]) -> &[u8] {
    &npy[10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]))..]
}

#[test]
fn one_file_has_every_array_and_every_column() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("run"), folder.path().join("run.npz"));
    write_npz(&run(&from), &to).unwrap();
    let mut zip = zip::ZipArchive::new(File::open(&to).unwrap()).unwrap();
    let mut entry = |name: &str| {
        let mut bytes = Vec::new();
        zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
        bytes
    };
    for field in Field::ALL {
        let (exported, original) = (entry(field.file_name()), fs::read(from.join(field.file_name())).unwrap());
        let shape = |bytes: &[u8]| npyz::NpyFile::new(bytes).unwrap().shape().to_vec();
        assert_eq!(shape(&exported), shape(&original), "{field:?}");
        assert!(values(&exported) == values(&original), "{field:?}");
    }
    let times: Vec<f64> = npyz::NpyFile::new(entry("capture_time_s.npy").as_slice()).unwrap().into_vec().unwrap();
    assert_eq!(times, (0..4).map(|frame| PRESS.reading(frame).capture_time_s).collect::<Vec<_>>());
    let header = String::from_utf8_lossy(&entry("flags.npy")).into_owned();
    assert!(header.contains("'<U1'") && header.contains("(4,)"), "{header}");
    assert_eq!(entry("run.toml"), b"version = 1\n");
}

#[test]
fn a_zarr_group_has_a_chunk_for_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("run"), folder.path().join("run.zarr"));
    let run = run(&from);
    write_zarr(&run, &to).unwrap();
    let described = fs::read_to_string(to.join("flow/.zarray")).unwrap();
    assert!(
        described.contains("\"shape\": [4, 16, 24, 2], \"chunks\": [1, 16, 24, 2], \"dtype\": \"<f4\""),
        "{described}"
    );
    let original = fs::read(from.join("flow.npy")).unwrap();
    for (frame, expected) in values(&original).chunks(16 * 24 * 2 * 4).enumerate() {
        let chunk = fs::read(to.join(format!("flow/{frame}.0.0.0"))).unwrap();
        assert!(miniz_oxide::inflate::decompress_to_vec_zlib(&chunk).unwrap() == expected, "frame {frame}");
    }
    let attributes = fs::read_to_string(to.join("depth/.zattrs")).unwrap();
    assert_eq!(attributes, "{\"_ARRAY_DIMENSIONS\": [\"frame\", \"row\", \"column\"], \"units\": \"mm\"}");
    assert_eq!(fs::read_to_string(to.join(".zattrs")).unwrap(), "{\"run.toml\": \"version = 1\\n\"}");
    assert!(matches!(write_zarr(&run, &to), Err(SinkError::Write { .. })), "nothing is replaced");
}

#[test]
fn other_folders_are_no_runs() {
    let folder = tempfile::tempdir().unwrap();
    let error = RunArrays::open(folder.path()).unwrap_err();
    assert!(matches!(&error, SinkError::NotARun { reason, .. } if reason == "it has no readings.csv"), "{error}");
    drop(run(&folder.path().join("run")));
    fs::write(folder.path().join("run/depth.npy"), b"\x93NUMPY\x01\0\x03\0abc and more").unwrap();
    let error = RunArrays::open(&folder.path().join("run")).unwrap_err();
    assert!(error.to_string().contains("depth.npy is not a run"), "{error}");
}
