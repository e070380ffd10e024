//! The edit list: which part of the media is shown, and when it starts.

use super::boxes::{Bytes, find_path};
use crate::video::fault::Fault;

/// Rate 1.0 in 16.16 fixed point.
const NORMAL_SPEED: u32 = 0x1_0000;

/// The one edit of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edit {
    /// Time before the film during which nothing is shown, ticks of the movie.
    delay: u64,
    /// Start of the film in the media, ticks of the media; `None` without an edit list: the start of the media.
    start: Option<u32>,
    /// Duration of the film, ticks of the movie; 0 for everything.
    duration: u64,
}

impl Edit {
    /// Reads the edit list of a track.
    pub(super) fn read(track: &[u8]) -> Result<Self, Fault> {
        let mut edit = Self { delay: 0, start: None, duration: 0 };
        let Some(list) = find_path(track, &[*b"edts", *b"elst"]) else { return Ok(edit) };
        let entries = entries(list).ok_or(Fault::Damaged("the edit list is damaged"))?;
        for entry in entries {
            match entry.start {
                None if edit.start.is_none() => edit.delay = edit.delay.saturating_add(entry.duration),
                Some(_) if edit.start.is_none() && entry.rate == NORMAL_SPEED => {
                    (edit.start, edit.duration) = (entry.start, entry.duration);
                }
                _ => return Err(Fault::NotRead("an edit list with several edits or another speed".into())),
            }
        }
        Ok(edit)
    }

    /// Display time of a sample at `time` ticks of the media, s, or `None` if it is not part of the film.
    pub(super) fn film_time_s(&self, time: i64, timescale: u32, movie_timescale: u32) -> Option<f64> {
        let start = i64::from(self.start.unwrap_or(0));
        let (ticks, movie_ticks) = (f64::from(timescale), f64::from(movie_timescale));
        let since_start_s = (time - start) as f64 / ticks;
        // The duration is rounded to ticks of the movie, so the film may seem to end a tick early.
        let is_after_end = self.duration > 0 && since_start_s >= (self.duration + 1) as f64 / movie_ticks;
        let is_shown = self.start.is_none() || (time >= start && !is_after_end);
        is_shown.then_some(self.delay as f64 / movie_ticks + since_start_s)
    }
}

struct Entry {
    /// Ticks of the movie.
    duration: u64,
    /// Ticks of the media; `None` shows nothing.
    start: Option<u32>,
    rate: u32,
}

fn entries(list: &[u8]) -> Option<Vec<Entry>> {
    let mut list = Bytes(list);
    let (version, _) = list.version_and_flags()?;
    let count = list.table_len(if version == 1 { 20 } else { 12 })?;
    let mut entries = Vec::with_capacity(count);
    for _ in 0..count {
        let duration = list.u32_or_u64(version)?;
        let start = list.u32_or_u64(version)?;
        let is_empty = if version == 1 { start == u64::MAX } else { start == u64::from(u32::MAX) };
        let start = if is_empty { None } else { Some(u32::try_from(start).ok()?) };
        entries.push(Entry { duration, start, rate: list.u32()? });
    }
    Some(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_before_and_after_the_edit_are_not_shown() {
        let edit = Edit { delay: 500, start: Some(100), duration: 1000 };
        let shown = |time| edit.film_time_s(time, 100, 1000);
        assert_eq!(shown(99), None);
        assert_eq!(shown(100), Some(0.5));
        assert_eq!(shown(199), Some(1.49));
        assert_eq!(shown(201), None);
    }

    #[test]
    fn without_an_edit_list_the_media_is_the_film() {
        let edit = Edit::read(&[]).unwrap();
        assert_eq!(edit.film_time_s(-50, 100, 1000), Some(-0.5));
    }
}
