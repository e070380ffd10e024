//! A folder of images, one frame per file.

use crate::compression::mixed;
use crate::jpeg::has_coarse_colour;
use crate::natural::natural_order;
use crate::numbering;
use crate::picture::{PictureFault, decode};
use crate::{FrameFormat, Source, SourceError, regular};
use fingervision_image::Frame;
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};

/// Files with these extensions are frames; all others are ignored.
const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "bmp"];
/// Extensions of images that are not read.
const OTHER_EXTENSIONS: [&str; 12] =
    ["webp", "gif", "pgm", "ppm", "pnm", "jp2", "heic", "heif", "avif", "jxl", "exr", "tga"];

/// Reads the images of a folder in natural order, one at a time.
pub(crate) struct FolderSource {
    folder: PathBuf,
    files: Vec<PathBuf>,
    /// The sequence number of each file.
    sequences: Vec<u64>,
    frames_per_second: f64,
    format: FrameFormat,
    has_full_colour: bool,
    /// What was read when the folder was opened: images that cannot be read, then the first that can.
    begin: VecDeque<Result<Frame, SourceError>>,
    /// The next file to read.
    next: usize,
    /// Whether an error has ended the source.
    is_failed: bool,
}

impl FolderSource {
    pub(crate) fn open(folder: &Path, frames_per_second: f64) -> Result<Self, SourceError> {
        let files = images_in(folder)?;
        if files.len() < 2 {
            let count = files.len() as u64;
            let too_few = SourceError::TooFewFrames { path: folder.to_owned(), count };
            return Err(other_images(folder)?.unwrap_or(too_few));
        }
        let sequences = sequences(&files);
        let (begin, format) = begin(folder, &files, &sequences, frames_per_second)?;
        let next = begin.len();
        let folder = folder.to_owned();
        let has_full_colour = !has_coarse_colour(&bytes_of(&files[next - 1])?);
        let is_failed = false;
        Ok(Self { folder, files, sequences, frames_per_second, format, has_full_colour, begin, next, is_failed })
    }

    fn read_next(&mut self) -> Result<Frame, SourceError> {
        let (path, sequence) = (&self.files[self.next], self.sequences[self.next]);
        self.next += 1;
        let frame = read(path, sequence, self.frames_per_second)?;
        let found = FrameFormat::from(&frame.pixels);
        if found == self.format {
            Ok(frame)
        } else {
            Err(SourceError::FormatChanged { path: path.clone(), sequence, found, expected: self.format })
        }
    }
}

impl Source for FolderSource {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.is_failed {
            return Ok(None);
        }
        let frame = match self.begin.pop_front() {
            Some(frame) => frame,
            None if self.next >= self.files.len() => return Ok(None),
            None => self.read_next(),
        };
        self.is_failed = frame.is_err();
        frame.map(Some)
    }

    fn resume(&mut self) -> bool {
        std::mem::take(&mut self.is_failed)
    }

    fn frame_count(&self) -> Option<u64> {
        Some(self.files.len() as u64)
    }

    fn last_sequence(&self) -> Option<u64> {
        self.sequences.last().copied()
    }

    fn size(&self) -> (usize, usize) {
        (self.format.width, self.format.height)
    }

    fn has_full_colour(&self) -> bool {
        self.has_full_colour
    }

    fn description(&self) -> String {
        let (folder, count, rate) = (self.folder.display(), self.files.len(), self.frames_per_second);
        format!("{folder}: {count} images, {}, nominally {rate} frames per second", self.format)
    }

    fn remarks(&self) -> Vec<String> {
        let coarse = "the images store colour at a lower resolution than brightness (JPEG 4:2:0 or 4:2:2), so they are matched in grey";
        mixed(&self.files).into_iter().chain((!self.has_full_colour).then(|| coarse.into())).collect()
    }
}

/// The images up to the first that can be read, whose format the others must have.
fn begin(
    folder: &Path,
    files: &[PathBuf],
    sequences: &[u64],
    frames_per_second: f64,
) -> Result<(VecDeque<Result<Frame, SourceError>>, FrameFormat), SourceError> {
    let mut begin = VecDeque::new();
    for (file, &sequence) in files.iter().zip(sequences) {
        let frame = read(file, sequence, frames_per_second);
        let format = frame.as_ref().ok().map(|frame| FrameFormat::from(&frame.pixels));
        begin.push_back(frame);
        if let Some(format) = format {
            return Ok((begin, format));
        }
    }
    // No image can be read: the first error is that of the folder.
    match begin.pop_front() {
        Some(Err(error)) => Err(error),
        _ => Err(SourceError::TooFewFrames { path: folder.to_owned(), count: 0 }),
    }
}

/// The image files of a folder in natural order; hidden files and folders are ignored.
pub(crate) fn images_in(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let mut images = entries_of(folder)?;
    images.retain(|(name, path)| is_image_name(name) && !path.is_dir());
    let paths = images.into_iter().map(|(_, path)| path);
    paths.map(|path| regular::check(&path).map(|()| path)).collect()
}

/// The names and paths of all files and folders in a folder that are not hidden, in natural order.
pub(crate) fn entries_of(folder: &Path) -> Result<Vec<(String, PathBuf)>, SourceError> {
    let io = |error| SourceError::io(folder, error);
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.starts_with('.') {
            entries.push((name, path));
        }
    }
    entries.sort_by(|(a, _), (b, _)| natural_order(a, b));
    Ok(entries)
}

/// The files' sequence numbers: those in their names if these count, otherwise their places in the folder.
fn sequences(files: &[PathBuf]) -> Vec<u64> {
    let stems: Option<Vec<&str>> = files.iter().map(|file| file.file_stem()?.to_str()).collect();
    stems.and_then(numbering::by_names).unwrap_or_else(|| (0..files.len() as u64).collect())
}

fn is_image_name(name: &str) -> bool {
    has_ending(name, &EXTENSIONS)
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let extension = name.rsplit_once('.').map(|(_, extension)| extension.to_ascii_lowercase());
    extension.is_some_and(|extension| endings.contains(&extension.as_str()))
}

/// The error if the folder has two images or more of a format that is not read.
fn other_images(folder: &Path) -> Result<Option<SourceError>, SourceError> {
    let entries = entries_of(folder)?;
    let counted = OTHER_EXTENSIONS.iter().map(|&ending| {
        let count = entries.iter().filter(|(name, path)| has_ending(name, &[ending]) && !path.is_dir()).count();
        (count, ending)
    });
    let most = counted.max_by_key(|(count, _)| *count).filter(|(count, _)| *count >= 2);
    Ok(most.map(|(count, ending)| SourceError::other_images(folder, count, ending)))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, SourceError> {
    regular::check(path)?;
    fs::read(path).map_err(|error| SourceError::io(path, error))
}

fn read(path: &Path, sequence: u64, frames_per_second: f64) -> Result<Frame, SourceError> {
    let bytes = bytes_of(path)?;
    let path = path.to_owned();
    match decode(&bytes) {
        Ok(pixels) => Ok(Frame { sequence, capture_time_s: sequence as f64 / frames_per_second, pixels }),
        Err(PictureFault::Damaged(reason)) => Err(SourceError::Frame { path, sequence, reason }),
        Err(PictureFault::Range { x, y, value }) => Err(SourceError::PixelRange { path, sequence, x, y, value }),
    }
}
