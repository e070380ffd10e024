//! Opens the source that the user names.

use crate::folder::FolderSource;
#[cfg(feature = "video")]
use crate::video;
use crate::{Options, Source, SourceError, regular};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Number of bytes by which a file is recognised.
const SIGNATURE_LEN: u64 = 64;

/// Opens a folder of images or a video file, by content and not by name.
///
/// The first frame is read at once, so that a source that opens has a size.
///
/// # Errors
///
/// [`SourceError::NotFound`] and [`SourceError::Io`] if nothing can be read there, [`SourceError::NotRead`] if it is
/// something else than a folder or a known video, [`SourceError::TooFewFrames`] if there are fewer than two frames,
/// [`SourceError::Container`] if a video's index is damaged, [`SourceError::Rate`] if the options make no sense, and
/// the errors of [`Source::next_frame`] for the first frame.
pub fn open(location: impl AsRef<Path>, options: &Options) -> Result<Box<dyn Source>, SourceError> {
    let path = location.as_ref();
    options.validate()?;
    if let Some(what) = promised(path) {
        return Err(SourceError::not_read_yet(path, what));
    }
    let metadata = fs::metadata(path).map_err(|error| SourceError::io(path, error))?;
    if metadata.is_dir() {
        return Ok(Box::new(FolderSource::open(path, options.frames_per_second)?));
    }
    open_file(path)
}

/// Locations that are not files.
fn promised(path: &Path) -> Option<&'static str> {
    let name = path.to_string_lossy();
    match name.as_ref() {
        name if name.starts_with("/dev/video") => Some("a camera"),
        _ => None,
    }
}

fn open_file(path: &Path) -> Result<Box<dyn Source>, SourceError> {
    regular::check(path)?;
    let io = |error| SourceError::io(path, error);
    let mut signature = Vec::new();
    File::open(path).and_then(|file| file.take(SIGNATURE_LEN).read_to_end(&mut signature)).map_err(io)?;
    match content(&signature) {
        #[cfg(feature = "video")]
        Content::Mp4 => video::open_mp4(path),
        #[cfg(feature = "video")]
        Content::Avi => video::open_avi(path),
        #[cfg(not(feature = "video"))]
        Content::Mp4 | Content::Avi => Err(SourceError::video_left_out(path)),
        Content::Image => Err(SourceError::single_image(path)),
        Content::Recording => Err(SourceError::not_read_yet(path, "a recording")),
        Content::Video(what) => Err(SourceError::unread_video(path, what.into())),
        Content::Unknown if signature.is_empty() => Err(SourceError::not_read_yet(path, "an empty file")),
        Content::Unknown => Err(SourceError::not_read_yet(path, "this kind of file")),
    }
}

/// The content of a file, by its first bytes.
#[derive(Debug, PartialEq)]
enum Content {
    Mp4,
    Avi,
    Image,
    Recording,
    /// A video format that is not read; its name.
    Video(&'static str),
    Unknown,
}

fn content(signature: &[u8]) -> Content {
    let at = |offset: usize, text: &[u8]| signature.get(offset..).is_some_and(|rest| rest.starts_with(text));
    // A QuickTime file may start without `ftyp`.
    let mp4 = [b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"];
    match () {
        () if mp4.iter().any(|kind| at(4, *kind)) => Content::Mp4,
        () if at(0, b"RIFF") && at(8, b"AVI ") => Content::Avi,
        () if at(0, b"\x89MCAP0\r\n") => Content::Recording,
        () if at(0, b"\x1a\x45\xdf\xa3") => Content::Video("Matroska or WebM video"),
        () if at(0, b"OggS") => Content::Video("Ogg video"),
        () if at(0, b"FLV") => Content::Video("Flash video"),
        () if at(0, b"\0\0\0\x01") || at(0, b"\0\0\x01") => Content::Video("a video stream without a container"),
        () if image::guess_format(signature).is_ok() => Content::Image,
        () => Content::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(not(feature = "video"))]
    #[test]
    fn a_video_names_the_feature_that_reads_it() {
        let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/phone.mp4");
        let error = open(clip, &Options::default()).map(|_| ()).unwrap_err();
        assert!(error.to_string().ends_with("phone.mp4: a video is not supported"), "{error}");
        assert!(error.hint().unwrap().contains("feature `video`"));
    }

    #[test]
    fn content_is_recognised_by_the_first_bytes() {
        assert_eq!(content(b"\0\0\0\x20ftypisom"), Content::Mp4);
        assert_eq!(content(b"RIFF\x10\0\0\0AVI LIST"), Content::Avi);
        assert_eq!(content(b"\x89PNG\r\n\x1a\n"), Content::Image);
        assert_eq!(content(b"\x89MCAP0\r\n"), Content::Recording);
        assert_eq!(content(b"hello"), Content::Unknown);
        assert_eq!(content(b""), Content::Unknown);
    }
}
