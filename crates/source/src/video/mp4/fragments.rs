//! Movie fragments: samples that are written while the recording runs, each with a piece of the index before it.

use super::boxes::{Bytes, boxes, find, find_path};
use super::samples::MediaSample;
use crate::video::fault::Fault;

/// Values of a sample that its run does not contain.
#[derive(Default, Clone, Copy)]
struct Defaults {
    duration: u32,
    len: u32,
}

/// Appends the samples in the fragment at byte `at` of the file for a track.
pub(super) fn add_fragment(
    samples: &mut Vec<MediaSample>,
    movie: &[u8],
    track_id: u32,
    at: u64,
    fragment: &[u8],
    file_len: u64,
) -> Result<(), Fault> {
    let defaults = track_defaults(movie, track_id).unwrap_or_default();
    for (kind, content) in boxes(fragment) {
        if &kind == b"traf" {
            let added = add_track_fragment(samples, defaults, track_id, at, content, file_len);
            added.ok_or(Fault::Damaged("a movie fragment is damaged"))?;
        }
    }
    Ok(())
}

/// The track's defaults for all fragments.
fn track_defaults(movie: &[u8], track_id: u32) -> Option<Defaults> {
    let of_track = |content: &[u8]| {
        let mut content = Bytes(content);
        content.version_and_flags()?;
        let id = content.u32()?;
        content.u32()?;
        let defaults = Defaults { duration: content.u32()?, len: content.u32()? };
        (id == track_id).then_some(defaults)
    };
    boxes(find_path(movie, &[*b"mvex"])?).filter(|(kind, _)| kind == b"trex").find_map(|(_, content)| of_track(content))
}

fn add_track_fragment(
    samples: &mut Vec<MediaSample>,
    mut defaults: Defaults,
    track_id: u32,
    at: u64,
    content: &[u8],
    file_len: u64,
) -> Option<()> {
    let mut header = Bytes(find(content, *b"tfhd")?);
    let (_, flags) = header.version_and_flags()?;
    if header.u32()? != track_id {
        return Some(());
    }
    let base = if flags & 0x01 > 0 { header.u64()? } else { at };
    if flags & 0x02 > 0 {
        header.u32()?;
    }
    if flags & 0x08 > 0 {
        defaults.duration = header.u32()?;
    }
    if flags & 0x10 > 0 {
        defaults.len = header.u32()?;
    }
    let mut cursor = Cursor { offset: base, time: samples.last().map_or(0, |sample| sample.decoding_end) };
    if let Some(start) = find(content, *b"tfdt") {
        let mut start = Bytes(start);
        let (version, _) = start.version_and_flags()?;
        cursor.time = i64::try_from(start.u32_or_u64(version)?).ok()?;
    }
    for (_, run) in boxes(content).filter(|(kind, _)| kind == b"trun") {
        add_run(samples, defaults, base, &mut cursor, run, file_len)?;
    }
    Some(())
}

/// The place of the next sample in the file and in time.
struct Cursor {
    offset: u64,
    time: i64,
}

fn add_run(
    samples: &mut Vec<MediaSample>,
    defaults: Defaults,
    base: u64,
    cursor: &mut Cursor,
    run: &[u8],
    file_len: u64,
) -> Option<()> {
    let mut run = Bytes(run);
    let (_, flags) = run.version_and_flags()?;
    let has = |flag: u32| flags & flag > 0;
    let count = run.u32()?;
    // If every sample uses its defaults, no entry confirms the count, so the file must.
    (samples.len() as u64 + u64::from(count) <= file_len).then_some(())?;
    if has(0x01) {
        cursor.offset = base.checked_add_signed(i64::from(run.i32()?))?;
    }
    if has(0x04) {
        run.u32()?;
    }
    for _ in 0..count {
        let duration = if has(0x100) { run.u32()? } else { defaults.duration };
        let len = if has(0x200) { run.u32()? } else { defaults.len };
        if has(0x400) {
            run.u32()?;
        }
        let delay = if has(0x800) { run.i32()? } else { 0 };
        let decoding_end = cursor.time.checked_add(i64::from(duration))?;
        let time = cursor.time.checked_add(i64::from(delay))?;
        samples.push(MediaSample { offset: cursor.offset, len, time, decoding_end });
        *cursor = Cursor { offset: cursor.offset.checked_add(u64::from(len))?, time: decoding_end };
    }
    Some(())
}
