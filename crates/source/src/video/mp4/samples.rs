//! The sample table: six compact lists that together give the position of every sample in the file and in time.

use super::boxes::{Bytes, find};
use crate::video::fault::Fault;

/// One sample of the track, in decoding order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MediaSample {
    /// Where it starts in the file, bytes.
    pub(super) offset: u64,
    /// Its length, bytes.
    pub(super) len: u32,
    /// Its display time, ticks of the media.
    pub(super) time: i64,
    /// The decoding time of its successor, ticks of the media.
    pub(super) decoding_end: i64,
}

/// Reads the table; in a fragmented file it is empty.
pub(super) fn sample_table(table: &[u8], file_len: u64) -> Result<Vec<MediaSample>, Fault> {
    let lens = find(table, *b"stsz").and_then(|list| lengths(list, file_len));
    let lens = lens.ok_or(Fault::Damaged("the list of sample sizes is damaged"))?;
    let offsets = offsets(table, &lens).ok_or(Fault::Damaged("the list of sample places is damaged"))?;
    let times = times(table, lens.len()).ok_or(Fault::Damaged("the list of sample times is damaged"))?;
    let place = |((len, offset), (time, decoding_end))| MediaSample { offset, len, time, decoding_end };
    Ok(lens.into_iter().zip(offsets).zip(times).map(place).collect())
}

fn lengths(list: &[u8], file_len: u64) -> Option<Vec<u32>> {
    let mut list = Bytes(list);
    list.version_and_flags()?;
    let common = list.u32()?;
    if common > 0 {
        let count = list.u32()?;
        // No entry confirms this count, so the file must: samples have at least one byte.
        return (u64::from(count) <= file_len).then(|| vec![common; count as usize]);
    }
    (0..list.table_len(4)?).map(|_| list.u32()).collect()
}

/// Samples are stored in chunks; `stsc` gives their number, in runs of equal chunks, `stco` or `co64` the place.
fn offsets(table: &[u8], lens: &[u32]) -> Option<Vec<u64>> {
    let mut runs = Bytes(find(table, *b"stsc")?);
    runs.version_and_flags()?;
    let run_count = runs.table_len(12)?;
    let mut runs = (0..run_count).map_while(|_| Some((runs.u32()?, runs.u32()?, runs.u32()?))).peekable();
    let mut lens = lens.iter();
    let mut offsets = Vec::with_capacity(lens.len());
    let mut samples_per_chunk = 0;
    for (number, chunk) in (1..).zip(chunk_offsets(table)?) {
        while let Some((_, count, description)) = runs.next_if(|&(first, ..)| first <= number) {
            // A second description would be a change of codec.
            (description == 1).then_some(())?;
            samples_per_chunk = count as usize;
        }
        let mut at = chunk;
        for &len in lens.by_ref().take(samples_per_chunk) {
            offsets.push(at);
            at = at.checked_add(u64::from(len))?;
        }
    }
    (lens.len() == 0).then_some(offsets)
}

fn chunk_offsets(table: &[u8]) -> Option<Vec<u64>> {
    let (list, version) = find(table, *b"stco").map(|list| (list, 0)).or(find(table, *b"co64").map(|list| (list, 1)))?;
    let mut list = Bytes(list);
    list.version_and_flags()?;
    let count = list.table_len(if version == 1 { 8 } else { 4 })?;
    (0..count).map(|_| list.u32_or_u64(version)).collect()
}

/// For each sample its display time and the decoding time of its successor.
fn times(table: &[u8], count: usize) -> Option<Vec<(i64, i64)>> {
    let durations = runs(find(table, *b"stts")?, count)?;
    let delays = match find(table, *b"ctts") {
        Some(list) => runs(list, count)?,
        None => vec![0; count],
    };
    let mut now = 0_i64;
    let time = |(duration, delay): (u32, u32)| {
        // Version 0 calls the delay unsigned, but files hold negative ones.
        let shown = now + i64::from(delay.cast_signed());
        now += i64::from(duration);
        (shown, now)
    };
    Some(durations.into_iter().zip(delays).map(time).collect())
}

/// Expands runs of equal values to one value per sample.
fn runs(list: &[u8], count: usize) -> Option<Vec<u32>> {
    let mut list = Bytes(list);
    list.version_and_flags()?;
    let mut values = Vec::with_capacity(count);
    for _ in 0..list.table_len(8)? {
        let (run, value) = (list.u32()? as usize, list.u32()?);
        values.resize(values.len().saturating_add(run).min(count), value);
    }
    (values.len() == count).then_some(values)
}
