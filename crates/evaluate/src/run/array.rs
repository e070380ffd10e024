//! Reads a `.npy` file of frames, one frame after another: memory does not grow with the recording.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use half::f16;

use super::RunError;
use super::npy_header::{HeaderError, NpyHeader};

/// The type of a value in an array.
pub(crate) trait Value: Copy + Default {
    /// The types that such an array can have, for messages.
    const EXPECTED: &'static str;
    /// How to convert any array to such an array with `numpy`.
    const HINT: &'static str;

    /// How the value is stored under a type code of the format; none if the code is not supported.
    fn stored_as(code: &str) -> Option<Stored<Self>>;
}

/// A storage format of values: the number of bytes and their conversion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stored<T> {
    len: usize,
    decode: fn(&[u8]) -> T,
}

impl Value for f32 {
    const EXPECTED: &'static str = "little-endian float16, float32 or float64";
    const HINT: &'static str = "numpy.save(file, array.astype('<f4'))";

    fn stored_as(code: &str) -> Option<Stored<Self>> {
        fn bytes<const N: usize>(value: &[u8]) -> [u8; N] {
            value.try_into().expect("as many bytes as the type has")
        }
        match code {
            "<f2" => Some(Stored { len: 2, decode: |value| f16::from_le_bytes(bytes(value)).to_f32() }),
            "<f4" => Some(Stored { len: 4, decode: |value| f32::from_le_bytes(bytes(value)) }),
            "<f8" => Some(Stored { len: 8, decode: |value| f64::from_le_bytes(bytes(value)) as f32 }),
            _ => None,
        }
    }
}

impl Value for u8 {
    const EXPECTED: &'static str = "uint8 or bool";
    const HINT: &'static str = "numpy.save(file, array.astype('u1'))";

    fn stored_as(code: &str) -> Option<Stored<Self>> {
        matches!(code, "|u1" | "|b1").then_some(Stored { len: 1, decode: |value| u8::from(value[0] != 0) })
    }
}

/// An array `[frame][row][column]`, or with the channels as fourth dimension, and the frame last read.
#[derive(Debug)]
pub(super) struct FrameArray<T> {
    path: PathBuf,
    file: BufReader<File>,
    stored: Stored<T>,
    frames: u64,
    size: (usize, usize),
    bytes: Vec<u8>,
    values: Vec<T>,
}

impl<T: Value> FrameArray<T> {
    /// Opens a file if it exists and checks that its length agrees with its header.
    ///
    /// Bytes after the last complete frame are allowed: a run that was interrupted can leave some.
    pub(super) fn open(path: &Path, channels: usize) -> Result<Option<Self>, RunError> {
        let file = match File::open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(RunError::reading(path))?,
        };
        let file_len = file.metadata().map_err(RunError::reading(path))?.len();
        let mut file = BufReader::new(file);
        let header = NpyHeader::read(&mut file).map_err(|error| match error {
            HeaderError::Read(error) => RunError::reading(path)(error),
            error => fault(path, format!("this is not an array: {error}"), "write it with numpy.save"),
        })?;
        let stored = stored(path, &header)?;
        let (frames, size) = shape(path, &header, channels)?;

        let frame_len = [size.0, size.1, channels, stored.len].into_iter().try_fold(1, usize::checked_mul);
        let whole = frame_len.map_or(0, |frame_len| (file_len - header.len) / frame_len.max(1) as u64);
        if whole < frames {
            let reason = format!("the header states {frames} frames, but the file ends after {whole}");
            return Err(fault(path, reason, "the file was cut short: copy or write it again"));
        }
        let frame_len = frame_len.unwrap_or_default();
        let (bytes, values) = (vec![0; frame_len], vec![T::default(); frame_len / stored.len]);
        Ok(Some(Self { path: path.to_owned(), file, stored, frames, size, bytes, values }))
    }

    /// Reads the next frame.
    pub(super) fn advance(&mut self) -> Result<(), RunError> {
        self.file.read_exact(&mut self.bytes).map_err(RunError::reading(&self.path))?;
        for (value, bytes) in self.values.iter_mut().zip(self.bytes.chunks_exact(self.stored.len)) {
            *value = (self.stored.decode)(bytes);
        }
        Ok(())
    }

    /// The frame last read, row by row, channels innermost.
    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn frames(&self) -> u64 {
        self.frames
    }

    /// Columns and rows, px.
    pub(super) fn size(&self) -> (usize, usize) {
        self.size
    }
}

fn stored<T: Value>(path: &Path, header: &NpyHeader) -> Result<Stored<T>, RunError> {
    let code = &header.code;
    let stored = T::stored_as(code)
        .ok_or_else(|| fault(path, format!("its values are of type {code}, expected {}", T::EXPECTED), T::HINT))?;
    if header.is_fortran {
        let hint = "numpy.save(file, numpy.ascontiguousarray(array))";
        return Err(fault(path, "it is in Fortran order, expected C order".into(), hint));
    }
    Ok(stored)
}

/// Frames, and columns and rows.
fn shape(path: &Path, header: &NpyHeader, channels: usize) -> Result<(u64, (usize, usize)), RunError> {
    let (shape, channels) = (&header.shape[..], channels as u64);
    let (&[frames, height, width], rest) = shape.split_first_chunk().unwrap_or((&[0; 3], &[]));
    let is_expected = shape.len() >= 3 && if channels == 1 { rest.is_empty() } else { rest == [channels] };
    let sides = usize::try_from(width).ok().zip(usize::try_from(height).ok());
    match sides {
        Some((width, height)) if is_expected && frames > 0 && width > 0 && height > 0 => Ok((frames, (width, height))),
        _ => {
            let last = if channels == 1 { String::new() } else { format!(", {channels}") };
            let reason = format!("its shape is {shape:?}, expected [frames, rows, columns{last}], none of them 0");
            Err(fault(path, reason, "a single frame also has a first dimension, of length 1"))
        }
    }
}

fn fault(path: &Path, reason: String, hint: &str) -> RunError {
    RunError::Array { file: path.to_owned(), reason, hint: hint.into() }
}
