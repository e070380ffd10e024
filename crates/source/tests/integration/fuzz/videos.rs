//! Video files, read to their end; reading continues after every error.

use std::fs;
use std::path::{Path, PathBuf};

use fingervision_fuzz::{Form, Parser};
use fingervision_source::{Options, open};

/// The most memory that one file may take, bytes: the largest pictures of H.264 and their reference pictures.
const MOST_BYTES: u64 = 3 << 29;

fn clip(name: &str) -> Vec<u8> {
    fs::read(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata").join(name)).unwrap()
}

/// Reads all frames that can be read; whether there was no error.
fn read(path: &Path) -> bool {
    let Ok(mut source) = open(path, &Options::default()) else { return false };
    let (mut is_whole, mut last) = (true, None);
    loop {
        match source.next_frame() {
            Ok(Some(frame)) => {
                assert!(last < Some(frame.sequence), "frame {} after {last:?}", frame.sequence);
                last = Some(frame.sequence);
            }
            Ok(None) => return is_whole,
            Err(_) => {
                is_whole = false;
                if !source.resume() {
                    return false;
                }
            }
        }
    }
}

fn run(name: &'static str, inputs: u64, files: Vec<Vec<u8>>, whole: impl Fn(&[u8]) -> Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip");
    Parser { name, form: Form::Binary, files, inputs, most_bytes: MOST_BYTES }.run(|bytes| {
        fs::write(&path, whole(bytes)).unwrap();
        read(&path)
    });
}

#[test]
fn a_mutated_mp4_is_read_or_refused() {
    let names = ["b_frames.mp4", "phone.mp4", "uneven.mp4", "trimmed.mp4", "fragments.mov", "jpeg.mov", "jpeg.mp4"];
    run("mp4", 1500, names.map(clip).to_vec(), <[u8]>::to_vec);
}

#[test]
fn a_mutated_avi_is_read_or_refused() {
    run("avi", 1500, vec![clip("colour.avi")], <[u8]>::to_vec);
}

/// Mutates only the compressed pictures, and leaves the file around them whole.
#[test]
fn a_mutated_h264_stream_is_read_or_refused() {
    for (name, file) in
        [("h264 with b-frames", "b_frames.mp4"), ("h264 baseline", "phone.mp4"), ("h264 trimmed", "trimmed.mp4")]
    {
        let whole = clip(file);
        let media = content(&whole, *b"mdat");
        run(name, 700, vec![whole[media.clone()].to_vec()], |bytes| replaced(&whole, media.clone(), bytes));
    }
}

/// Mutates only the parameter sets of the stream.
#[test]
fn mutated_h264_parameters_are_read_or_refused() {
    let whole = clip("b_frames.mp4");
    let config = content(&whole, *b"avcC");
    run("h264 parameters", 1500, vec![whole[config.clone()].to_vec()], |bytes| replaced(&whole, config.clone(), bytes));
}

/// The content of the first box of a kind, wherever it lies.
fn content(file: &[u8], kind: [u8; 4]) -> std::ops::Range<usize> {
    let at = file.windows(4).position(|window| window == kind).unwrap();
    let len = u32::from_be_bytes(file[at - 4..at].try_into().unwrap()) as usize;
    at + 4..at - 4 + len
}

/// The file with other bytes in a range, cut or filled up with zeros to its length.
fn replaced(file: &[u8], range: std::ops::Range<usize>, bytes: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    let len = bytes.len().min(range.len());
    file[range.clone()].fill(0);
    file[range][..len].copy_from_slice(&bytes[..len]);
    file
}
