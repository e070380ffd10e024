//! Reads a file from its start to its end, or to where it is cut off, and stores the position of every message.
//!
//! The index is not used, so a file that was not closed, is cut off or is damaged yields all its complete messages. The
//! data of messages are skipped, so a scan reads only a small part of a large file.

use std::io::{self, Read, Seek, SeekFrom};

use super::record::{Get, MAGIC, PREFIX_LEN, kind};
use super::writer::MESSAGE_PREFIX_LEN;

/// The longest record that is read whole, bytes; longer ones are skipped.
const LONGEST_RECORD: u64 = 1 << 24;
/// Bytes of a chunk before the name of its compression.
const CHUNK_FIXED_LEN: u64 = 28;
/// The longest name of a compression, bytes.
const LONGEST_NAME: u64 = 64;

/// The contents of a file.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Contents {
    /// The program that wrote it.
    pub(crate) library: String,
    /// Number and name of every schema.
    pub(crate) schemas: Vec<(u16, String)>,
    pub(crate) channels: Vec<Channel>,
    /// Every complete chunk, in the order of the file.
    pub(crate) chunks: Vec<Chunk>,
    pub(crate) attachments: Vec<Attachment>,
    pub(crate) metadata: Vec<(String, Vec<(String, String)>)>,
    /// The file has its end: it was closed.
    pub(crate) is_closed: bool,
    /// The first fault, other than a missing end.
    pub(crate) fault: Option<String>,
    /// The compression of its chunks, if there is one: such chunks are not read.
    pub(crate) compression: Option<String>,
}

/// The messages of one topic.
#[derive(Debug, PartialEq)]
pub(crate) struct Channel {
    id: u16,
    pub(crate) schema: u16,
    pub(crate) topic: String,
    pub(crate) messages: Vec<Place>,
}

/// Where the records of a chunk are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chunk {
    pub(crate) offset: u64,
    pub(crate) len: u64,
    /// CRC-32 of the records; 0: not known.
    pub(crate) crc32: u32,
}

/// The position of a message's data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// The number that the writer gave it in its channel.
    pub(crate) number: u32,
    pub(crate) time_ns: u64,
    pub(crate) offset: u64,
    pub(crate) len: u64,
}

/// An attachment: a file within the file.
#[derive(Debug, PartialEq)]
pub(crate) struct Attachment {
    pub(crate) name: String,
    pub(crate) data: Vec<u8>,
}

/// Reads a file; `None` if it does not begin as an MCAP file does.
///
/// # Errors
///
/// Errors of the reader, except an early end of the file.
pub(crate) fn scan(from: impl Read + Seek) -> io::Result<Option<Contents>> {
    let mut from = io::BufReader::new(from);
    let end = from.seek(SeekFrom::End(0))?;
    from.seek(SeekFrom::Start(0))?;
    let mut scan = Scan { from, at: 0, end, contents: Contents::default() };
    let mut magic = [0; MAGIC.len()];
    if !scan.fill(&mut magic)? || magic != MAGIC || !scan.step(end)? || scan.contents.library.is_empty() {
        return Ok(None);
    }
    while !scan.contents.is_closed && scan.step(end)? {}
    Ok(Some(scan.contents))
}

struct Scan<R> {
    from: io::BufReader<R>,
    at: u64,
    /// Length of the file, bytes.
    end: u64,
    contents: Contents,
}

impl<R: Read + Seek> Scan<R> {
    /// Reads as many bytes as `into` has; false if there are fewer.
    fn fill(&mut self, into: &mut [u8]) -> io::Result<bool> {
        if self.end.saturating_sub(self.at) < into.len() as u64 {
            return Ok(false);
        }
        self.from.read_exact(into)?;
        self.at += into.len() as u64;
        Ok(true)
    }

    fn go_to(&mut self, place: u64) -> io::Result<()> {
        self.from.seek_relative(place.cast_signed() - self.at.cast_signed())?;
        self.at = place;
        Ok(())
    }

    fn fault(&mut self, what: &str) {
        let at = self.at;
        self.contents.fault.get_or_insert_with(|| format!("{what} near byte {at}"));
    }

    /// Reads one record that ends before `limit`. Returns false if no complete record does.
    fn step(&mut self, limit: u64) -> io::Result<bool> {
        let mut prefix = [0; PREFIX_LEN as usize];
        if limit.saturating_sub(self.at) < PREFIX_LEN || !self.fill(&mut prefix)? {
            return Ok(false);
        }
        let [kind, len @ ..] = prefix;
        let (len, start) = (u64::from_le_bytes(len), self.at);
        let room = limit - start;
        // A chunk that is cut off contains messages, too.
        if kind == kind::CHUNK {
            return self.chunk(start.saturating_add(len).min(limit), len <= room);
        }
        if len > room {
            return Ok(false);
        }
        match kind {
            kind::MESSAGE => self.message(start, len)?,
            kind::HEADER | kind::SCHEMA | kind::CHANNEL | kind::ATTACHMENT | kind::METADATA
                if len <= LONGEST_RECORD =>
            {
                let mut content = vec![0; len as usize];
                if !self.fill(&mut content)? {
                    return Ok(false);
                }
                if self.contents.add(kind, &content).is_none() {
                    self.fault("a damaged record");
                }
            }
            kind::FOOTER => return self.footer(start + len),
            // Kind 0 is not used: no record begins here. Unknown kinds are skipped, because the format may get new
            // ones.
            0 => {
                self.fault("no record");
                return Ok(false);
            }
            _ => {}
        }
        self.go_to(start + len)?;
        Ok(true)
    }

    /// Reads the bytes behind the last record; false if the end of the file is missing.
    fn footer(&mut self, end: u64) -> io::Result<bool> {
        self.go_to(end)?;
        let mut magic = [0; MAGIC.len()];
        self.contents.is_closed = self.fill(&mut magic)? && magic == MAGIC;
        Ok(self.contents.is_closed)
    }

    fn message(&mut self, start: u64, len: u64) -> io::Result<()> {
        let mut fixed = [0; (MESSAGE_PREFIX_LEN - PREFIX_LEN) as usize];
        if len < fixed.len() as u64 || !self.fill(&mut fixed)? {
            self.fault("a damaged message");
            return Ok(());
        }
        let mut fixed = Get(&fixed);
        let (Some(id), Some(number), Some(time_ns)) = (fixed.u16(), fixed.u32(), fixed.u64()) else { return Ok(()) };
        let offset = start + MESSAGE_PREFIX_LEN - PREFIX_LEN;
        let place = Place { number, time_ns, offset, len: start + len - offset };
        match self.contents.channels.iter_mut().find(|channel| channel.id == id) {
            Some(channel) => channel.messages.push(place),
            None => self.fault("a message without a channel"),
        }
        Ok(())
    }

    /// Reads the records of a chunk that ends at `end`; false if that is the end of the file.
    fn chunk(&mut self, end: u64, is_whole: bool) -> io::Result<bool> {
        let mut fixed = [0; CHUNK_FIXED_LEN as usize];
        let mut name_len = [0; 4];
        if end.saturating_sub(self.at) < CHUNK_FIXED_LEN + 4 || !self.fill(&mut fixed)? || !self.fill(&mut name_len)? {
            return Ok(false);
        }
        let name_len = u64::from(u32::from_le_bytes(name_len));
        let mut name = vec![0; name_len.min(LONGEST_NAME) as usize];
        let mut records_len = [0; 8];
        if name_len > LONGEST_NAME {
            self.fault("a damaged chunk");
        } else if !self.fill(&mut name)? || !self.fill(&mut records_len)? {
            return Ok(false);
        } else if !name.is_empty() {
            self.contents.compression = Some(String::from_utf8_lossy(&name).into_owned());
        } else {
            let (offset, len) = (self.at, u64::from_le_bytes(records_len));
            if is_whole && len <= end - offset {
                let [.., a, b, c, d] = fixed;
                self.contents.chunks.push(Chunk { offset, len, crc32: u32::from_le_bytes([a, b, c, d]) });
            }
            let records_end = offset.saturating_add(len).min(end);
            while self.step(records_end)? {}
        }
        if !is_whole {
            return Ok(false);
        }
        // The next record begins behind the chunk, whatever faults the chunk has.
        self.go_to(end)?;
        Ok(true)
    }
}

impl Contents {
    /// Stores the content of a small record; `None` if it is damaged. Schemas and channels occur again in the index.
    fn add(&mut self, kind: u8, content: &[u8]) -> Option<()> {
        let mut from = Get(content);
        match kind {
            kind::HEADER => {
                let _profile = from.text()?;
                let library = from.text()?;
                self.library = if library.is_empty() { "?".into() } else { library.into() };
            }
            kind::SCHEMA => {
                let (id, name) = (from.u16()?, from.text()?);
                if !self.schemas.iter().any(|(known, _)| *known == id) {
                    self.schemas.push((id, name.into()));
                }
            }
            kind::CHANNEL => {
                let (id, schema, topic) = (from.u16()?, from.u16()?, from.text()?);
                if !self.channels.iter().any(|channel| channel.id == id) {
                    self.channels.push(Channel { id, schema, topic: topic.into(), messages: Vec::new() });
                }
            }
            kind::ATTACHMENT => {
                let _times = from.bytes(16)?;
                let (name, _media_type) = (from.text()?, from.text()?);
                let len = usize::try_from(from.u64()?).ok()?;
                let data = from.bytes(len)?;
                let crc = from.u32()?;
                let is_sound = crc == 0 || crc == crc32fast::hash(content.get(..content.len() - 4)?);
                is_sound.then(|| self.attachments.push(Attachment { name: name.into(), data: data.to_vec() }))?;
            }
            _ => {
                let name = from.text()?.to_owned();
                let pairs = from.map()?.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
                self.metadata.push((name, pairs));
            }
        }
        Some(())
    }
}
