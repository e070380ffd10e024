//! Reads single messages of a file, a chunk at a time, and compares its check sum.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::Arc;

use fingervision_source::{CameraLayout, EncodedFrame};
use prost::Message;

use crate::coding;
use crate::container::scan::{Chunk, Contents, Place};
use crate::lossless::{self, Storage};
use crate::message::{CompressedImage, Frame};

/// Longer chunks, which other programs may write, are not read as a whole, and their sums not compared, bytes.
const LONGEST_CHUNK: u64 = 1 << 28;

/// Reads the messages of a recording.
#[derive(Debug)]
pub(crate) struct MessageReader {
    file: File,
    contents: Arc<Contents>,
    /// The chunk in `bytes`.
    chunk: Option<Chunk>,
    /// Its check sum is right, or not known.
    is_sound: bool,
    bytes: Vec<u8>,
    image: CompressedImage,
}

impl MessageReader {
    pub(crate) fn new(file: File, contents: Arc<Contents>) -> Self {
        let (bytes, image) = (Vec::new(), CompressedImage::default());
        Self { file, contents, chunk: None, is_sound: true, bytes, image }
    }

    /// The data of a message. A place is always inside the file, so its length is bounded by the file's.
    pub(crate) fn read(&mut self, place: Place) -> io::Result<&[u8]> {
        let Some(chunk) = self.chunk_of(place) else {
            self.chunk = None;
            self.load(place.offset, place.len)?;
            self.is_sound = true;
            return Ok(&self.bytes);
        };
        if self.chunk != Some(chunk) {
            self.chunk = None;
            self.load(chunk.offset, chunk.len)?;
            self.is_sound = chunk.crc32 == 0 || chunk.crc32 == crc32fast::hash(&self.bytes);
            self.chunk = Some(chunk);
        }
        let begin = (place.offset - chunk.offset) as usize;
        Ok(&self.bytes[begin..begin + place.len as usize])
    }

    /// The data of a message that has no check sum of its own; none if that of its chunk is wrong.
    pub(crate) fn read_sound(&mut self, place: Place) -> io::Result<Option<&[u8]>> {
        self.read(place)?;
        if self.is_sound { self.read(place).map(Some) } else { Ok(None) }
    }

    /// The complete chunk that contains a message.
    fn chunk_of(&self, place: Place) -> Option<Chunk> {
        let chunks = &self.contents.chunks;
        let chunk = chunks[..chunks.partition_point(|chunk| chunk.offset <= place.offset)].last()?;
        let is_inside = place.offset + place.len <= chunk.offset + chunk.len && chunk.len <= LONGEST_CHUNK;
        is_inside.then_some(*chunk)
    }

    fn load(&mut self, offset: u64, len: u64) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(offset))?;
        self.bytes.resize(len as usize, 0);
        self.file.read_exact(&mut self.bytes)
    }

    /// Reads a frame as it came; `images` are the places of the sensor's image messages.
    ///
    /// # Errors
    ///
    /// What is wrong with it.
    pub(crate) fn frame(&mut self, place: Place, images: &[Place], into: &mut EncodedFrame) -> Result<(), String> {
        let bytes = self.read(place).map_err(|error| error.to_string())?;
        let message = Frame::decode(bytes).map_err(|_| "its message is damaged")?;
        let coding =
            coding::of(&message.coding).ok_or_else(|| format!("the coding {} is not known", message.coding))?;
        let (width, height) = (message.width as usize, message.height as usize);
        into.layout = CameraLayout { coding, width, height, row_bytes: message.row_bytes as usize };
        (into.sequence, into.capture_time_s) = (message.sequence, message.capture_time_s);
        let storage = Storage::of(&message.storage).ok_or_else(|| format!("stored as {}", message.storage))?;
        let len = usize::try_from(message.length).map_err(|_| "its length is impossible")?;
        match storage {
            Storage::Raw => into.bytes = message.data,
            Storage::WebP => lossless::decode(into.layout, len, &message.data, &mut into.bytes)?,
            Storage::Image => {
                let found = images.binary_search_by_key(&message.image, |place| place.number);
                let place = found.ok().and_then(|index| images.get(index)).ok_or("its image is missing")?;
                self.image(*place, &mut into.bytes)?;
            }
        }
        if into.bytes.len() != len || crc32fast::hash(&into.bytes) != message.crc32 {
            return Err("its bytes are damaged".into());
        }
        Ok(())
    }

    fn image(&mut self, place: Place, into: &mut Vec<u8>) -> Result<(), String> {
        let mut image = std::mem::take(&mut self.image);
        image.clear();
        let bytes = self.read(place).map_err(|error| error.to_string())?;
        let merged = image.merge(bytes);
        std::mem::swap(into, &mut image.data);
        self.image = image;
        merged.map_err(|_| "its image is damaged".into())
    }
}
