//! Videos that are cut off or have flipped bytes, at every position: an error or frames, never a panic or a silent
//! loss.

use fingervision_image::Frame;
use fingervision_source::{Options, SourceError, open};
use std::fs;
use std::path::{Path, PathBuf};

const CLIPS: [&str; 7] =
    ["b_frames.mp4", "phone.mp4", "uneven.mp4", "trimmed.mp4", "fragments.mov", "colour.avi", "jpeg.mov"];

fn clip(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata").join(name)
}

/// The numbers of the frames that come, and the error that ends them.
fn read(path: &Path) -> (Vec<u64>, Option<SourceError>) {
    let mut sequences = Vec::new();
    let mut source = match open(path, &Options::default()) {
        Ok(source) => source,
        Err(error) => return (sequences, Some(error)),
    };
    loop {
        match source.next_frame() {
            Ok(Some(frame)) => sequences.push(frame.sequence),
            Ok(None) => return (sequences, None),
            Err(error) => {
                assert_eq!(source.next_frame().unwrap(), None, "a source is at its end after an error");
                return (sequences, Some(error));
            }
        }
    }
}

/// Reads every clip after each of many changes; `change` tells the next from a running number, until it has no more.
fn for_every_change(
    change: impl Fn(&[u8], usize) -> Option<Vec<u8>>,
    check: impl Fn(&str, usize, Vec<u64>, Option<SourceError>),
) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip");
    for name in CLIPS {
        let whole = fs::read(clip(name)).unwrap();
        for (number, bytes) in (0..).map_while(|number| Some((number, change(&whole, number)?))) {
            fs::write(&path, bytes).unwrap();
            let (sequences, error) = read(&path);
            check(name, number, sequences, error);
        }
    }
}

#[test]
fn a_video_that_is_cut_off_yields_its_whole_frames_and_then_an_error() {
    let cut = |whole: &[u8], number: usize| (37 * number < whole.len()).then(|| whole[..37 * number].to_vec());
    for_every_change(cut, |name, number, sequences, error| {
        let place = format!("{name} cut to {} bytes: {} frames", 37 * number, sequences.len());
        assert!(sequences.is_sorted(), "{place}: {sequences:?}");
        // Behind the frames a file holds an index or nothing of interest.
        assert!(error.is_some() || sequences.len() >= 9, "{place} and no error");
        if let Some(error @ SourceError::Frame { sequence, .. }) = &error {
            assert!(!sequences.contains(sequence), "{place}, and yet {error}");
        }
    });
}

#[test]
fn a_cut_names_the_file_and_the_first_frame_that_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.avi");
    let whole = fs::read(clip("colour.avi")).unwrap();
    fs::write(&path, &whole[..whole.len() * 3 / 4]).unwrap();
    let (sequences, error) = read(&path);
    let error = error.unwrap().to_string();
    let wanted = format!("clip.avi: frame {}: the file is cut off within it", sequences.len());
    assert!(sequences.len() > 3 && error.ends_with(&wanted), "{error}");
}

#[test]
fn an_mp4_without_its_index_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.mp4");
    let whole = fs::read(clip("b_frames.mp4")).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let (sequences, error) = read(&path);
    let error = error.unwrap();
    assert!(sequences.is_empty() && error.to_string().contains("no index (moov box)"), "{error}");
    assert!(error.hint().is_some());
}

#[test]
fn a_flipped_byte_anywhere_never_panics() {
    let flip = |whole: &[u8], number: usize| {
        let mut bytes = whole.to_vec();
        // The stride has no factor in common with tables of 4, 8 and 12 bytes; the masks hit high and low bits.
        *bytes.get_mut(7 * number)? ^= [0x01, 0x80, 0xff][number % 3];
        Some(bytes)
    };
    for_every_change(flip, |name, number, sequences, _| {
        assert!(sequences.is_sorted_by(|a, b| a < b), "{name}, change {number}: {sequences:?}");
    });
}

/// All frames that can be read, and why the others cannot.
fn read_on(path: &Path) -> (Vec<Frame>, Vec<SourceError>) {
    let (mut frames, mut errors) = (Vec::new(), Vec::new());
    let mut source = open(path, &Options::default()).unwrap();
    loop {
        match source.next_frame() {
            Ok(Some(frame)) => frames.push(frame),
            Ok(None) => return (frames, errors),
            Err(error) => {
                errors.push(error);
                if !source.resume() {
                    return (frames, errors);
                }
            }
        }
    }
}

#[test]
fn a_damaged_video_goes_on_at_its_next_key_frame() {
    // Its samples lie one after another from byte 48; those numbered 0 and 8 are key frames.
    const PREDICTED: usize = 48 + 852;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.mp4");
    let mut bytes = fs::read(clip("b_frames.mp4")).unwrap();
    bytes[PREDICTED] = 0xff;
    fs::write(&path, bytes).unwrap();
    let (whole, _) = read_on(&clip("b_frames.mp4"));
    let (frames, errors) = read_on(&path);
    assert_eq!(frames.iter().map(|frame| frame.sequence).collect::<Vec<_>>(), [0, 8, 9, 10, 11]);
    assert!(errors.len() == 1 && matches!(errors[0], SourceError::Frame { .. }), "{errors:?}");
    assert!(frames[1..] == whole[8..], "frames behind the key frame are as in the whole video");
}

#[test]
fn a_video_damaged_anywhere_is_read_to_its_end_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip");
    for name in CLIPS {
        let whole = fs::read(clip(name)).unwrap();
        for start in (0..whole.len()).step_by(97) {
            let mut bytes = whole.clone();
            let end = (start + 5).min(bytes.len());
            bytes[start..end].fill(0xff);
            fs::write(&path, bytes).unwrap();
            if open(&path, &Options::default()).is_ok() {
                let (frames, _) = read_on(&path);
                assert!(frames.is_sorted_by(|a, b| a.sequence < b.sequence), "{name}, damaged from byte {start}");
            }
        }
    }
}

#[test]
fn a_video_that_is_cut_off_ends_although_it_is_read_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.avi");
    let whole = fs::read(clip("colour.avi")).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let (frames, errors) = read_on(&path);
    assert!(!frames.is_empty() && !errors.is_empty(), "{} frames, {errors:?}", frames.len());
}

/// The decoder would repeat the last reference picture four billion times.
#[test]
fn a_slice_with_too_many_reference_pictures_is_refused() {
    let (frames, errors) = read_on(&clip("references.mp4"));
    let refused = errors.iter().filter(|error| error.to_string().contains("reference pictures, 32 are allowed"));
    assert_eq!((frames.len(), refused.count()), (1, 1), "{errors:?}");
}
