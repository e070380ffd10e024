//! The writer against the reader: whole files, files cut off anywhere, damaged files, a full disk.

use std::io::{self, Cursor, Write};

use super::scan::{Contents, scan};
use super::writer::{Stamp, Writer};

/// A file with three channels, whose messages are numbers of different lengths. A chunk is written every `every` messages.
fn write(to: impl Write, messages: u64, every: u64) -> io::Result<()> {
    let mut writer = Writer::new(to, "test")?;
    let schema = writer.schema("Number", b"described")?;
    for topic in ["/a", "/b", "/c"] {
        writer.channel(schema, topic)?;
    }
    writer.attachment("profile.toml", "application/toml", 5, b"name = \"x\"")?;
    writer.metadata("sensor", &[("name", "left"), ("unit", "mm")])?;
    for number in 0..messages {
        let stamp = Stamp { channel: (number % 3) as u16, time_ns: 1000 + number };
        writer.message(stamp, |data| (0..=number % 40).for_each(|_| data.extend_from_slice(&number.to_le_bytes())))?;
        if number % every == every - 1 {
            writer.flush()?;
        }
    }
    writer.finish().map(drop)
}

fn file(messages: u64, every: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(&mut bytes, messages, every).unwrap();
    bytes
}

fn contents(bytes: &[u8]) -> Option<Contents> {
    scan(Cursor::new(bytes)).unwrap()
}

/// The numbers in the file, in order of their times; every one is checked against its bytes.
fn numbers(bytes: &[u8], contents: &Contents) -> Vec<u64> {
    let places = contents.channels.iter().flat_map(|channel| &channel.messages);
    let mut numbers: Vec<u64> = places
        .map(|place| {
            let number = place.time_ns - 1000;
            let data = &bytes[place.offset as usize..][..place.len as usize];
            assert_eq!(data.len() as u64, 8 * (number % 40 + 1));
            assert!(data.chunks(8).all(|chunk| chunk == number.to_le_bytes()), "number {number}");
            number
        })
        .collect();
    numbers.sort_unstable();
    numbers
}

#[test]
fn a_file_contains_what_was_written() {
    let bytes = file(100, 7);
    let contents = contents(&bytes).unwrap();
    assert!(contents.is_closed && contents.fault.is_none(), "{:?}", contents.fault);
    assert_eq!(contents.library, "test");
    assert_eq!(contents.schemas, [(1, "Number".to_owned())]);
    assert_eq!(contents.attachments[0].data, b"name = \"x\"");
    assert_eq!(contents.metadata[0].1[1], ("unit".to_owned(), "mm".to_owned()));
    assert_eq!(numbers(&bytes, &contents), (0..100).collect::<Vec<_>>());
}

#[test]
fn a_file_cut_off_anywhere_gives_all_complete_messages() {
    let bytes = file(100, 7);
    let whole = contents(&bytes).unwrap();
    let mut opened = 0;
    for len in 0..bytes.len() {
        let cut = &bytes[..len];
        let Some(contents) = contents(cut) else {
            assert_eq!(opened, 0, "{len} bytes are refused, fewer are not");
            continue;
        };
        opened += 1;
        assert!(!contents.is_closed && contents.fault.is_none(), "{len}: {:?}", contents.fault);
        let places = whole.channels.iter().flat_map(|channel| &channel.messages);
        let complete = places.filter(|place| place.offset + place.len <= len as u64).count();
        assert_eq!(numbers(cut, &contents).len(), complete, "{len} bytes");
    }
    assert!(opened > bytes.len() - 64, "only {opened} of {} open", bytes.len());
}

#[test]
fn messages_of_a_killed_program_are_in_the_file_chunk_by_chunk() {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, "test").unwrap();
    let schema = writer.schema("Number", b"").unwrap();
    writer.channel(schema, "/a").unwrap();
    for number in 0..5_u64 {
        let stamp = Stamp { channel: 0, time_ns: 1000 + number };
        writer.message(stamp, |data| data.extend(std::iter::repeat_n(1, 600_000))).unwrap();
        writer.flush_due().unwrap();
    }
    drop(writer);
    // Two messages make a chunk of a megabyte; the fifth was still in memory.
    assert_eq!(contents(&bytes).unwrap().channels[0].messages.len(), 4);
}

/// A disk that has this much space.
struct SmallDisk {
    bytes: Vec<u8>,
    space: usize,
}

impl Write for &mut SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let len = bytes.len().min(self.space - self.bytes.len());
        if len == 0 {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.bytes.extend_from_slice(&bytes[..len]);
        Ok(len)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn what_fits_on_a_full_disk_can_be_read() {
    let len = file(100, 7).len();
    for space in (200..len).step_by(97) {
        let mut disk = SmallDisk { bytes: Vec::new(), space };
        let error = write(&mut disk, 100, 7).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{space}");
        let contents = contents(&disk.bytes).unwrap();
        let numbers = numbers(&disk.bytes, &contents);
        assert_eq!(numbers, (0..numbers.len() as u64).collect::<Vec<_>>(), "{space}");
    }
}

#[test]
fn nothing_is_written_after_an_error() {
    let mut disk = SmallDisk { bytes: Vec::new(), space: 300 };
    let mut writer = Writer::new(&mut disk, "test").unwrap();
    let schema = writer.schema("Number", b"").unwrap();
    writer.channel(schema, "/a").unwrap();
    let stamp = Stamp { channel: 0, time_ns: 1 };
    writer.message(stamp, |data| data.resize(400, 0)).unwrap();
    assert!(writer.flush().is_err());
    assert!(writer.message(stamp, |_| ()).is_err() && writer.flush().is_err() && writer.finish().is_err());
}

#[test]
fn a_damaged_length_does_not_hide_the_next_chunk() {
    let mut bytes = file(21, 7);
    let first = contents(&bytes).unwrap().channels[0].messages[0];
    // The length of the first message's record.
    let at = first.offset as usize - 30;
    bytes[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    let contents = contents(&bytes).unwrap();
    assert!(contents.is_closed);
    assert_eq!(numbers(&bytes, &contents), (7..21).collect::<Vec<_>>());
}
