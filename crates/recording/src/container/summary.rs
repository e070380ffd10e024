//! The index behind the messages, with which other programs find messages without reading the whole file.

use super::record::{MAGIC, Put, kind};

/// The parts of the written records that the index needs.
#[derive(Debug, Default)]
pub(crate) struct Summary {
    /// Number of schemas; they are numbered from 1.
    pub(crate) schemas: u16,
    pub(crate) schema_records: Vec<u8>,
    pub(crate) channel_records: Vec<u8>,
    /// Number of messages of every channel in the written chunks.
    pub(crate) message_counts: Vec<u64>,
    pub(crate) chunks: Vec<ChunkEntry>,
    pub(crate) attachments: Vec<AttachmentEntry>,
    /// Position, length and name of every metadata record.
    pub(crate) metadata: Vec<(u64, u64, String)>,
}

/// The position of a chunk.
#[derive(Debug)]
pub(crate) struct ChunkEntry {
    offset: u64,
    pub(crate) length: u64,
    times_ns: [u64; 2],
    records_len: u64,
    /// The position of each channel's index.
    pub(crate) index_offsets: Vec<(u16, u64)>,
    pub(crate) index_length: u64,
}

impl ChunkEntry {
    pub(crate) fn new(offset: u64, times_ns: [u64; 2], records_len: u64) -> Self {
        Self { offset, length: 0, times_ns, records_len, index_offsets: Vec::new(), index_length: 0 }
    }
}

/// The position of an attachment.
#[derive(Debug)]
pub(crate) struct AttachmentEntry {
    pub(crate) offset: u64,
    pub(crate) length: u64,
    pub(crate) time_ns: u64,
    pub(crate) data_len: u64,
    pub(crate) name: String,
    pub(crate) media_type: String,
}

impl Summary {
    /// The index, its table of contents, the footer and the last bytes, for a file that has `start` bytes before them.
    pub(crate) fn bytes(&self, start: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut groups = Vec::new();
        let kinds = [
            kind::SCHEMA,
            kind::CHANNEL,
            kind::STATISTICS,
            kind::CHUNK_INDEX,
            kind::ATTACHMENT_INDEX,
            kind::METADATA_INDEX,
        ];
        for kind in kinds {
            let at = bytes.len();
            self.put_group(kind, &mut bytes);
            if bytes.len() > at {
                groups.push((kind, start + at as u64, (bytes.len() - at) as u64));
            }
        }
        let offsets = start + bytes.len() as u64;
        for (group, at, len) in groups {
            bytes.put_record(kind::SUMMARY_OFFSET, |content| {
                content.push(group);
                content.put_u64(at);
                content.put_u64(len);
            });
        }
        put_footer(&mut bytes, start, offsets);
        bytes.extend_from_slice(&MAGIC);
        bytes
    }

    /// Appends all records of a kind.
    fn put_group(&self, kind: u8, bytes: &mut Vec<u8>) {
        match kind {
            kind::SCHEMA => bytes.extend_from_slice(&self.schema_records),
            kind::CHANNEL => bytes.extend_from_slice(&self.channel_records),
            kind::STATISTICS => self.put_statistics(bytes),
            kind::CHUNK_INDEX => self.chunks.iter().for_each(|chunk| put_chunk(bytes, chunk)),
            kind::ATTACHMENT_INDEX => self.attachments.iter().for_each(|entry| put_attachment(bytes, entry)),
            _ => self.metadata.iter().for_each(|entry| put_metadata(bytes, entry)),
        }
    }

    fn put_statistics(&self, bytes: &mut Vec<u8>) {
        let start_ns = self.chunks.iter().map(|chunk| chunk.times_ns[0]).min().unwrap_or(0);
        let end_ns = self.chunks.iter().map(|chunk| chunk.times_ns[1]).max().unwrap_or(0);
        bytes.put_record(kind::STATISTICS, |content| {
            content.put_u64(self.message_counts.iter().sum());
            content.put_u16(self.schemas);
            content.put_u32(self.message_counts.len() as u32);
            content.put_u32(self.attachments.len() as u32);
            content.put_u32(self.metadata.len() as u32);
            content.put_u32(self.chunks.len() as u32);
            content.put_u64(start_ns);
            content.put_u64(end_ns);
            content.put_u32(10 * self.message_counts.len() as u32);
            for (id, count) in self.message_counts.iter().enumerate() {
                content.put_u16(id as u16);
                content.put_u64(*count);
            }
        });
    }
}

fn put_chunk(bytes: &mut Vec<u8>, chunk: &ChunkEntry) {
    bytes.put_record(kind::CHUNK_INDEX, |content| {
        content.put_u64(chunk.times_ns[0]);
        content.put_u64(chunk.times_ns[1]);
        content.put_u64(chunk.offset);
        content.put_u64(chunk.length);
        content.put_u32(10 * chunk.index_offsets.len() as u32);
        for (channel, offset) in &chunk.index_offsets {
            content.put_u16(*channel);
            content.put_u64(*offset);
        }
        content.put_u64(chunk.index_length);
        content.put_text("");
        content.put_u64(chunk.records_len);
        content.put_u64(chunk.records_len);
    });
}

fn put_attachment(bytes: &mut Vec<u8>, entry: &AttachmentEntry) {
    bytes.put_record(kind::ATTACHMENT_INDEX, |content| {
        content.put_u64(entry.offset);
        content.put_u64(entry.length);
        content.put_u64(entry.time_ns);
        content.put_u64(entry.time_ns);
        content.put_u64(entry.data_len);
        content.put_text(&entry.name);
        content.put_text(&entry.media_type);
    });
}

fn put_metadata(bytes: &mut Vec<u8>, (offset, length, name): &(u64, u64, String)) {
    bytes.put_record(kind::METADATA_INDEX, |content| {
        content.put_u64(*offset);
        content.put_u64(*length);
        content.put_text(name);
    });
}

/// The footer's checksum covers everything from the start of the index to itself.
fn put_footer(bytes: &mut Vec<u8>, start: u64, offsets: u64) {
    bytes.push(kind::FOOTER);
    bytes.put_u64(20);
    bytes.put_u64(start);
    bytes.put_u64(offsets);
    let crc = crc32fast::hash(bytes);
    bytes.put_u32(crc);
}
