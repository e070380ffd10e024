//! The headers before the frames, of a fixed length so that they can be rewritten, and a part's index.

/// Reserved index entries: seeking works in as many parts.
pub(super) const MOST_PARTS: usize = 256;
/// From the file's start to the list of frames, bytes: `RIFF` with its name, then `hdrl` with all in it.
pub(super) const HEADER_LEN: usize = 12 + 8 + HDRL_LEN;
const HDRL_LEN: usize = 4 + (8 + 56) + (8 + STRL_LEN) + (8 + 4 + 8 + EXTENDED_LEN);
const STRL_LEN: usize = 4 + (8 + 56) + (8 + 40) + (8 + SUPER_INDEX_LEN);
const SUPER_INDEX_LEN: usize = 24 + 16 * MOST_PARTS;
const EXTENDED_LEN: usize = 248;
/// `AVIF_HASINDEX`.
const HAS_INDEX: u32 = 0x10;
/// Frame rate before the actual one is known.
const USUAL_PERIOD_US: u32 = 33_333;

/// Where a part's index lies.
#[derive(Debug)]
pub(super) struct IndexPart {
    /// Of the chunk, from the file's start, bytes.
    pub(super) at: u64,
    /// With letters and length, bytes.
    pub(super) len: u32,
    pub(super) frames: u32,
}

/// The numbers in the header.
#[derive(Debug)]
pub(super) struct Header {
    width: u32,
    height: u32,
    pub(super) has_index: bool,
    pub(super) parts: Vec<IndexPart>,
    /// All frames, and those of the first part.
    frames: u32,
    first_frames: u32,
    longest: u32,
    period_us: u32,
}

impl Header {
    /// The header of a video without frames of this size, px.
    pub(super) fn new((width, height): (usize, usize)) -> Self {
        let (width, height, parts) = (width as u32, height as u32, Vec::new());
        let (frames, first_frames, longest, period_us) = (0, 0, 0, USUAL_PERIOD_US);
        Self { width, height, has_index: false, parts, frames, first_frames, longest, period_us }
    }

    /// Counts a frame of `len` bytes. An invalid period keeps the previous one.
    pub(super) fn count(&mut self, len: usize, period_s: f64, is_in_first_part: bool) {
        self.frames += 1;
        self.first_frames += u32::from(is_in_first_part);
        self.longest = self.longest.max(len as u32);
        let period_us = (1e6 * period_s).round();
        if (1.0..=1e9).contains(&period_us) {
            self.period_us = period_us as u32;
        }
    }

    /// From behind the first part's length to the list of frames.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let extended = chunk(*b"dmlh", &words(&[self.frames], EXTENDED_LEN));
        let hdrl = [
            chunk(*b"avih", &self.main()),
            list(*b"strl", &[chunk(*b"strh", &self.stream()), chunk(*b"strf", &self.format()), self.super_index()]),
            list(*b"odml", &[extended]),
        ];
        let bytes = [b"AVI ".to_vec(), list(*b"hdrl", &hdrl)].concat();
        assert_eq!(bytes.len() + 8, HEADER_LEN, "the header's length is fixed");
        bytes
    }

    fn main(&self) -> Vec<u8> {
        let rate = u64::from(self.longest) * 1_000_000 / u64::from(self.period_us);
        let flags = if self.has_index { HAS_INDEX } else { 0 };
        let bytes_per_second = u32::try_from(rate).unwrap_or(u32::MAX);
        let Self { period_us, first_frames, longest, width, height, .. } = *self;
        words(&[period_us, bytes_per_second, 0, flags, first_frames, 0, 1, longest, width, height], 56)
    }

    fn stream(&self) -> Vec<u8> {
        let (video, codec) = (u32::from_le_bytes(*b"vids"), u32::from_le_bytes(*b"MJPG"));
        let best_quality = u32::MAX;
        let mut stream =
            words(&[video, codec, 0, 0, 0, self.period_us, 1_000_000, 0, self.frames, self.longest, best_quality], 56);
        // Where it is shown: right and bottom in 16 bits.
        stream[52..54].copy_from_slice(&(self.width as u16).to_le_bytes());
        stream[54..56].copy_from_slice(&(self.height as u16).to_le_bytes());
        stream
    }

    fn format(&self) -> Vec<u8> {
        let planes_and_bits = 1 | 24 << 16;
        let codec = u32::from_le_bytes(*b"MJPG");
        words(&[40, self.width, self.height, planes_and_bits, codec, 3 * self.width * self.height], 40)
    }

    /// Where the parts' indexes lie.
    fn super_index(&self) -> Vec<u8> {
        let mut index = words(&[4, self.parts.len() as u32, u32::from_le_bytes(*b"00dc")], 24);
        for part in &self.parts {
            index.extend(part.at.to_le_bytes());
            index.extend(part.len.to_le_bytes());
            index.extend(part.frames.to_le_bytes());
        }
        index.resize(SUPER_INDEX_LEN, 0);
        chunk(*b"indx", &index)
    }
}

/// The index of a part: place and length of every frame, counted from `base`.
pub(super) fn part_index(base: u64, frames: &[(u32, u32)]) -> Vec<u8> {
    // Two words an entry, and of the kind that lists chunks.
    let mut index = words(&[2 | 1 << 24, frames.len() as u32, u32::from_le_bytes(*b"00dc")], 12);
    index.extend(base.to_le_bytes());
    index.extend([0; 4]);
    for (place, len) in frames {
        index.extend(place.to_le_bytes());
        index.extend(len.to_le_bytes());
    }
    index
}

/// A chunk: letters, length, content, and padding to an even length.
pub(super) fn chunk(kind: [u8; 4], content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(content.len() + 9);
    bytes.extend(kind);
    bytes.extend((content.len() as u32).to_le_bytes());
    bytes.extend(content);
    bytes.resize(bytes.len().next_multiple_of(2), 0);
    bytes
}

fn list(kind: [u8; 4], chunks: &[Vec<u8>]) -> Vec<u8> {
    chunk(*b"LIST", &[&kind[..], &chunks.concat()].concat())
}

/// Words in little endian, and zeros up to a length, bytes.
fn words(words: &[u32], len: usize) -> Vec<u8> {
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.resize(len, 0);
    bytes
}
