//! The boxes of the file: a length, four letters, and content that may again be boxes. All numbers are big-endian.

/// Ticks of all times.
pub(super) const TICKS_PER_SECOND: u32 = 90_000;
/// The only track.
const TRACK: u32 = 1;
/// 1.0 in 16.16 fixed point.
const ONE: u32 = 0x1_0000;
/// No rotation and no scaling.
const UNCHANGED: [u32; 9] = [ONE, 0, 0, 0, ONE, 0, 0, 0, 0x4000_0000];
/// Flags of a picture: it needs no other one, or it does and is no place to begin.
const IS_KEY: u32 = 0x0200_0000;
const IS_NO_KEY: u32 = 0x0101_0000;
/// What a run of samples states: where its data begin; duration, length and flags of each.
const RUN_FLAGS: u32 = 0x1 | 0x100 | 0x200 | 0x400;
/// Places count from the start of the fragment.
const FROM_FRAGMENT: u32 = 0x2_0000;
/// Colours of ITU-R BT.709: primaries, transfer and matrix.
const BT_709: [u16; 3] = [1; 3];

/// The description of the track.
pub(super) struct Track<'a> {
    /// Columns and rows, px.
    pub(super) size: (usize, usize),
    /// The sequence's parameters, a NAL unit.
    pub(super) sequence: &'a [u8],
    /// The pictures' parameters, a NAL unit.
    pub(super) picture: &'a [u8],
}

/// A picture of a fragment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Bytes.
    pub(super) len: u32,
    pub(super) ticks: u32,
    pub(super) is_key: bool,
}

/// Pictures that are written together.
#[derive(Debug, Default)]
pub(super) struct Fragment {
    /// From 1.
    pub(super) number: u32,
    pub(super) start_ticks: u64,
    pub(super) samples: Vec<Sample>,
    pub(super) data: Vec<u8>,
}

impl Track<'_> {
    /// The file up to the first fragment.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let brands = boxed(*b"ftyp", &[b"isom", &0x200_u32.to_be_bytes(), b"isom", b"iso6", b"avc1", b"mp41"]);
        let extends = full(*b"trex", 0, &words(&[TRACK, 1, 0, 0, 0]));
        let movie = boxed(*b"moov", &[&movie_header(), &self.track(), &boxed(*b"mvex", &[&extends])]);
        [brands, movie].concat()
    }

    fn track(&self) -> Vec<u8> {
        let handler = full(*b"hdlr", 0, &[&words(&[0]), b"vide".as_slice(), &[0; 12], b"video\0"].concat());
        let media_header = full(*b"mdhd", 0, &[words(&[0, 0, TICKS_PER_SECOND, 0]), vec![0x55, 0xc4, 0, 0]].concat());
        let reference = full(*b"dref", 0, &[words(&[1]), full(*b"url ", 1, &[])].concat());
        let information =
            boxed(*b"minf", &[&full(*b"vmhd", 1, &[0; 8]), &boxed(*b"dinf", &[&reference]), &self.sample_table()]);
        boxed(*b"trak", &[&self.track_header(), &boxed(*b"mdia", &[&media_header, &handler, &information])])
    }

    fn track_header(&self) -> Vec<u8> {
        let (width, height) = self.size;
        // Enabled, in the movie, and in its preview.
        let begin = words(&[0, 0, TRACK, 0, 0, 0, 0, 0, 0]);
        let sides = words(&[ONE * width as u32, ONE * height as u32]);
        full(*b"tkhd", 7, &[begin, words(&UNCHANGED), sides].concat())
    }

    /// No samples: they are in the fragments.
    fn sample_table(&self) -> Vec<u8> {
        let empty = |kind| full(kind, 0, &words(&[0]));
        let descriptions = full(*b"stsd", 0, &[words(&[1]), self.sample_entry()].concat());
        let lengths = full(*b"stsz", 0, &words(&[0, 0]));
        boxed(*b"stbl", &[&descriptions, &empty(*b"stts"), &empty(*b"stsc"), &lengths, &empty(*b"stco")])
    }

    fn sample_entry(&self) -> Vec<u8> {
        let (width, height) = self.size;
        let sides = [width as u16, height as u16].map(u16::to_be_bytes).concat();
        // 72 px an inch, one picture a sample, no name, 24 bits.
        let resolution = words(&[72 * ONE, 72 * ONE, 0]);
        let depth = [0, 24, 0xff, 0xff];
        let colour = [b"nclx".to_vec(), BT_709.map(u16::to_be_bytes).concat(), vec![0]].concat();
        boxed(
            *b"avc1",
            &[
                &[0, 0, 0, 0, 0, 0, 0, 1],
                &[0; 16],
                &sides,
                &resolution,
                &[0, 1],
                &[0; 32],
                &depth,
                &self.configuration(),
                &boxed(*b"colr", &[&colour]),
            ],
        )
    }

    /// Profile and level, four bytes for the length of a unit, and one set of parameters of each kind.
    fn configuration(&self) -> Vec<u8> {
        let Self { sequence, picture, .. } = self;
        let len = |unit: &[u8]| (unit.len() as u16).to_be_bytes();
        let profile = sequence.get(1..4).unwrap_or_default();
        boxed(*b"avcC", &[&[1], profile, &[0xff, 0xe1], &len(sequence), sequence, &[1], &len(picture), picture])
    }
}

impl Fragment {
    /// Says for how long the last picture is shown.
    pub(super) fn end_last(&mut self, ticks: u32) {
        if let Some(last) = self.samples.last_mut() {
            last.ticks = ticks;
        }
    }

    /// Everything before the data.
    pub(super) fn header(&self) -> Vec<u8> {
        let len = self.movie_fragment(0).len() as u32;
        let data = [(self.data.len() as u32 + 8).to_be_bytes(), *b"mdat"].concat();
        [self.movie_fragment(len + 8), data].concat()
    }

    fn movie_fragment(&self, data_at: u32) -> Vec<u8> {
        let flags = |is_key| if is_key { IS_KEY } else { IS_NO_KEY };
        let samples = self.samples.iter().flat_map(|sample| [sample.ticks, sample.len, flags(sample.is_key)]);
        let run: Vec<u32> = [self.samples.len() as u32, data_at].into_iter().chain(samples).collect();
        // Version 1: the time has 64 bits.
        let start = [words(&[0x0100_0000]), self.start_ticks.to_be_bytes().to_vec()].concat();
        let track = boxed(
            *b"traf",
            &[
                &full(*b"tfhd", FROM_FRAGMENT, &words(&[TRACK])),
                &boxed(*b"tfdt", &[&start]),
                &full(*b"trun", RUN_FLAGS, &words(&run)),
            ],
        );
        boxed(*b"moof", &[&full(*b"mfhd", 0, &words(&[self.number])), &track])
    }
}

fn movie_header() -> Vec<u8> {
    let begin = words(&[0, 0, TICKS_PER_SECOND, 0, ONE, 0x0100_0000, 0, 0]);
    full(*b"mvhd", 0, &[begin, words(&UNCHANGED), words(&[0, 0, 0, 0, 0, 0, TRACK + 1])].concat())
}

fn boxed(kind: [u8; 4], parts: &[&[u8]]) -> Vec<u8> {
    let content = parts.concat();
    [&(content.len() as u32 + 8).to_be_bytes(), kind.as_slice(), &content].concat()
}

/// A box of version 0 with flags.
fn full(kind: [u8; 4], flags: u32, content: &[u8]) -> Vec<u8> {
    boxed(kind, &[&flags.to_be_bytes(), content])
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}
