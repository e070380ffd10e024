//! Writes a file from its start to its end and only appends.
//!
//! Messages are collected in memory as a chunk. The chunk is written whole, with its index, as soon as it is large or
//! old enough. So a killed program loses at most one chunk, and only the last record of a file can be incomplete.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use super::record::{MAGIC, PREFIX_LEN, Put, kind};
use super::summary::{AttachmentEntry, ChunkEntry, Summary};

/// A chunk is written once it has this length, bytes.
const CHUNK_LEN: usize = 1 << 20;
/// A chunk is written once its first message is this old.
const LONGEST_WAIT: Duration = Duration::from_millis(400);

/// The channel and the time of a message.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stamp {
    pub(crate) channel: u16,
    /// Time of the message, ns since 1970.
    pub(crate) time_ns: u64,
}

/// A file that is being written.
#[derive(Debug)]
pub(crate) struct Writer<W> {
    to: W,
    /// Bytes written.
    end: u64,
    crc: crc32fast::Hasher,
    summary: Summary,
    channels: Vec<ChannelState>,
    chunk: Chunk,
    /// A write has failed: records behind it could not be found.
    is_broken: bool,
    scratch: Vec<u8>,
}

#[derive(Debug, Default)]
struct ChannelState {
    /// Number of the next message.
    sequence: u32,
    /// Times and positions of the messages in the chunk.
    in_chunk: Vec<(u64, u64)>,
}

#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    begun: Option<Instant>,
    times_ns: Option<[u64; 2]>,
}

impl<W: Write> Writer<W> {
    /// Begins a file with the name of the program that writes it.
    pub(crate) fn new(to: W, library: &str) -> io::Result<Self> {
        let (crc, summary) = (crc32fast::Hasher::new(), Summary::default());
        let (channels, chunk, scratch) = (Vec::new(), Chunk::default(), Vec::new());
        let mut writer = Self { to, end: 0, crc, summary, channels, chunk, is_broken: false, scratch };
        let mut head = MAGIC.to_vec();
        head.put_record(kind::HEADER, |content| {
            content.put_text("");
            content.put_text(library);
        });
        writer.append(&head)?;
        Ok(writer)
    }

    /// Bytes that were written, without those of the chunk that is being filled.
    pub(crate) fn written_bytes(&self) -> u64 {
        self.end
    }

    /// Adds a schema; returns its number.
    pub(crate) fn schema(&mut self, name: &str, data: &[u8]) -> io::Result<u16> {
        let id = self.summary.schemas + 1;
        let mut record = Vec::new();
        record.put_record(kind::SCHEMA, |content| {
            content.put_u16(id);
            content.put_text(name);
            content.put_text("protobuf");
            content.put_u32(data.len() as u32);
            content.extend_from_slice(data);
        });
        self.append(&record)?;
        self.summary.schemas = id;
        self.summary.schema_records.extend_from_slice(&record);
        Ok(id)
    }

    /// Adds a channel for messages of a schema; returns its number.
    pub(crate) fn channel(&mut self, schema: u16, topic: &str) -> io::Result<u16> {
        let id = self.channels.len() as u16;
        let mut record = Vec::new();
        record.put_record(kind::CHANNEL, |content| {
            content.put_u16(id);
            content.put_u16(schema);
            content.put_text(topic);
            content.put_text("protobuf");
            content.put_map(&[]);
        });
        self.append(&record)?;
        self.channels.push(ChannelState::default());
        self.summary.message_counts.push(0);
        self.summary.channel_records.extend_from_slice(&record);
        Ok(id)
    }

    /// Adds an attachment: a file within the file.
    pub(crate) fn attachment(&mut self, name: &str, media_type: &str, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let mut record = Vec::new();
        record.put_record(kind::ATTACHMENT, |content| {
            let start = content.len();
            content.put_u64(time_ns);
            content.put_u64(time_ns);
            content.put_text(name);
            content.put_text(media_type);
            content.put_u64(data.len() as u64);
            content.extend_from_slice(data);
            let crc = crc32fast::hash(&content[start..]);
            content.put_u32(crc);
        });
        let (offset, length, data_len) = (self.end, record.len() as u64, data.len() as u64);
        let (name, media_type) = (name.to_owned(), media_type.to_owned());
        self.append(&record)?;
        self.summary.attachments.push(AttachmentEntry { offset, length, time_ns, data_len, name, media_type });
        Ok(())
    }

    /// Adds metadata: named texts.
    pub(crate) fn metadata(&mut self, name: &str, pairs: &[(&str, &str)]) -> io::Result<()> {
        let mut record = Vec::new();
        record.put_record(kind::METADATA, |content| {
            content.put_text(name);
            content.put_map(pairs);
        });
        let place = (self.end, record.len() as u64, name.to_owned());
        self.append(&record)?;
        self.summary.metadata.push(place);
        Ok(())
    }

    /// Adds a message; `fill` appends its bytes. It is written with its chunk.
    pub(crate) fn message(&mut self, stamp: Stamp, fill: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        self.expect_whole()?;
        let Stamp { channel, time_ns } = stamp;
        let Some(state) = self.channels.get_mut(usize::from(channel)) else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "no such channel"));
        };
        let chunk = &mut self.chunk;
        state.in_chunk.push((time_ns, chunk.records.len() as u64));
        let sequence = state.sequence;
        chunk.records.put_record(kind::MESSAGE, |content| {
            content.put_u16(channel);
            content.put_u32(sequence);
            content.put_u64(time_ns);
            content.put_u64(time_ns);
            fill(content);
        });
        state.sequence = sequence.wrapping_add(1);
        let [first, last] = chunk.times_ns.unwrap_or([time_ns; 2]);
        chunk.times_ns = Some([first.min(time_ns), last.max(time_ns)]);
        chunk.begun.get_or_insert_with(Instant::now);
        Ok(())
    }

    /// Writes the chunk if it is large or old. To be called after messages that belong together, and also while no
    /// message arrives.
    pub(crate) fn flush_due(&mut self) -> io::Result<()> {
        let is_old = self.chunk.begun.is_some_and(|begun| begun.elapsed() >= LONGEST_WAIT);
        if is_old || self.chunk.records.len() >= CHUNK_LEN { self.flush() } else { self.expect_whole() }
    }

    /// Writes the chunk.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.expect_whole()?;
        let chunk = &mut self.chunk;
        let Some([start_ns, end_ns]) = chunk.times_ns.take() else { return Ok(()) };
        chunk.begun = None;
        let mut bytes = std::mem::take(&mut self.scratch);
        let mut entry = ChunkEntry::new(self.end, [start_ns, end_ns], chunk.records.len() as u64);
        bytes.clear();
        bytes.put_record(kind::CHUNK, |content| {
            content.put_u64(start_ns);
            content.put_u64(end_ns);
            content.put_u64(chunk.records.len() as u64);
            content.put_u32(crc32fast::hash(&chunk.records));
            content.put_text("");
            content.put_u64(chunk.records.len() as u64);
            content.extend_from_slice(&chunk.records);
        });
        entry.length = bytes.len() as u64;
        chunk.records.clear();
        for (id, channel) in self.channels.iter_mut().enumerate().filter(|(_, channel)| !channel.in_chunk.is_empty()) {
            entry.index_offsets.push((id as u16, self.end + bytes.len() as u64));
            self.summary.message_counts[id] += channel.in_chunk.len() as u64;
            bytes.put_record(kind::MESSAGE_INDEX, |content| {
                content.put_u16(id as u16);
                content.put_u32(16 * channel.in_chunk.len() as u32);
                for (time_ns, offset) in channel.in_chunk.drain(..) {
                    content.put_u64(time_ns);
                    content.put_u64(offset);
                }
            });
        }
        entry.index_length = bytes.len() as u64 - entry.length;
        let done = self.append(&bytes);
        self.scratch = bytes;
        self.summary.chunks.push(entry);
        done
    }

    /// Writes the last chunk and the index; returns the output.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        let mut record = Vec::new();
        let crc = self.crc.clone().finalize();
        record.put_record(kind::DATA_END, |content| content.put_u32(crc));
        self.append(&record)?;
        let summary = self.summary.bytes(self.end);
        self.append(&summary)?;
        self.to.flush()?;
        Ok(self.to)
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.expect_whole()?;
        let done = self.to.write_all(bytes).and_then(|()| self.to.flush());
        self.is_broken = done.is_err();
        done?;
        self.crc.update(bytes);
        self.end += bytes.len() as u64;
        Ok(())
    }

    fn expect_whole(&self) -> io::Result<()> {
        if self.is_broken {
            return Err(io::Error::other("the file ended with an earlier error"));
        }
        Ok(())
    }
}

/// Bytes of a message's record before its data.
pub(crate) const MESSAGE_PREFIX_LEN: u64 = PREFIX_LEN + 22;
