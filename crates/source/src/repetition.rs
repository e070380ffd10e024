//! Finds a recording that is the same as another one.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::folder::images_in;

/// Why two locations have the same recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repetition {
    /// Both lead to the same folder or file.
    SamePlace,
    /// All images, or the videos, are the same to the last byte. Noise makes this impossible for two recordings.
    Copy,
}

/// Compares two folders of images, in natural order, or two videos; none if they differ, or if one cannot be read.
///
/// Recordings usually differ in their first image, so that hardly more than that is read.
#[must_use]
pub fn repetition(a: &Path, b: &Path) -> Option<Repetition> {
    let [place, other] = [a, b].map(|path| fs::canonicalize(path).ok());
    if place? == other? {
        return Some(Repetition::SamePlace);
    }
    let is_copy = match (a.is_dir(), b.is_dir()) {
        (true, true) => {
            let (a, b) = (images_in(a).ok()?, images_in(b).ok()?);
            let are_same = |(a, b): (&PathBuf, &PathBuf)| have_same_bytes(a, b).unwrap_or(false);
            !a.is_empty() && a.len() == b.len() && a.iter().zip(&b).all(are_same)
        }
        (false, false) => have_same_bytes(a, b).unwrap_or(false),
        _ => false,
    };
    is_copy.then_some(Repetition::Copy)
}

/// Whether two regular files have the same content; empty ones have none.
fn have_same_bytes(a: &Path, b: &Path) -> io::Result<bool> {
    let [about, other] = [fs::metadata(a)?, fs::metadata(b)?];
    if !about.is_file() || !other.is_file() || about.len() == 0 || about.len() != other.len() {
        return Ok(false);
    }
    let (mut a, mut b) = (BufReader::new(File::open(a)?), BufReader::new(File::open(b)?));
    loop {
        let (left, right) = (a.fill_buf()?, b.fill_buf()?);
        let len = left.len().min(right.len());
        if len == 0 {
            return Ok(left.len() == right.len());
        }
        if left[..len] != right[..len] {
            return Ok(false);
        }
        a.consume(len);
        b.consume(len);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of files that are named like images.
    fn recording(parent: &Path, name: &str, images: &[(&str, &[u8])]) -> PathBuf {
        let folder = parent.join(name);
        fs::create_dir(&folder).unwrap();
        for (image, bytes) in images {
            fs::write(folder.join(image), bytes).unwrap();
        }
        folder
    }

    #[test]
    fn paths_to_one_folder_are_the_same_place() {
        let parent = tempfile::tempdir().unwrap();
        let press = recording(parent.path(), "press", &[("0.png", b"a")]);
        assert_eq!(repetition(&press, &press.join("../press/")), Some(Repetition::SamePlace));
        #[cfg(unix)]
        {
            let link = parent.path().join("link");
            std::os::unix::fs::symlink(&press, &link).unwrap();
            assert_eq!(repetition(&press, &link), Some(Repetition::SamePlace));
        }
    }

    #[test]
    fn the_same_images_under_other_names_are_a_copy() {
        let parent = tempfile::tempdir().unwrap();
        let make = |name, images| recording(parent.path(), name, images);
        let press = make("press", &[("9.png", b"first"), ("10.png", b"last"), ("depth.csv", b"depth_mm")]);
        let copy = make("copy", &[("000.png", b"first"), ("001.png", b"last"), ("notes.txt", b"mine")]);
        assert_eq!(repetition(&press, &copy), Some(Repetition::Copy));
        let long = vec![7; 100_000];
        let (mut other, video) = (long.clone(), parent.path().join("a.avi"));
        other[99_999] = 8;
        for (name, bytes, expected) in [("b.avi", &long, Some(Repetition::Copy)), ("c.avi", &other, None)] {
            fs::write(&video, &long).unwrap();
            fs::write(parent.path().join(name), bytes).unwrap();
            assert_eq!(repetition(&video, &parent.path().join(name)), expected, "{name}");
        }
    }

    #[test]
    fn whatever_differs_is_no_repetition() {
        let parent = tempfile::tempdir().unwrap();
        let make = |name, images| recording(parent.path(), name, images);
        let press = make("press", &[("0.png", b"first"), ("1.png", b"last")]);
        for other in [
            make("last", &[("0.png", b"first"), ("1.png", b"lost")]),
            make("longer", &[("0.png", b"first"), ("1.png", b"last"), ("2.png", b"more")]),
            make("empty", &[]),
            parent.path().join("nowhere"),
            press.join("0.png"),
        ] {
            assert_eq!(repetition(&press, &other), None, "{}", other.display());
        }
        assert_eq!(repetition(&parent.path().join("empty"), &make("void", &[])), None);
    }
}
