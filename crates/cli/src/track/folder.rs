//! Tracks every recording of a folder, several at the same time.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use fingervision_recording::{Recording, RecordingSensor};
use fingervision_sink::RunFolder;
use fingervision_source::recordings_in;
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::{Args, track};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::part::Part;
use crate::place::SENSOR;
use crate::summary::Summary;
use crate::threads;

/// A recording of the folder.
#[derive(Debug, PartialEq)]
struct Item {
    /// The name of its run.
    name: String,
    /// Where its frames are, as a user would name it.
    location: PathBuf,
}

/// The recordings of a folder.
pub(super) struct RecordingFolder {
    items: Vec<Item>,
}

/// A recording that was tracked, or why it was not, or not to its end.
#[derive(Debug, Serialize)]
struct Outcome {
    recording: String,
    #[serde(flatten)]
    summary: Option<Summary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<String>,
}

/// The result of all of them.
#[derive(Debug, Serialize)]
struct Results {
    folder: PathBuf,
    /// From the first opening to the last closing, s.
    seconds: f64,
    frames: u64,
    recordings: Vec<Outcome>,
}

impl RecordingFolder {
    /// The recordings of a folder; none if the place is a recording itself, or has none.
    ///
    /// # Errors
    ///
    /// [`Failure`] if a folder cannot be read.
    pub(super) fn of(source: &Path) -> Result<Option<Self>, Failure> {
        if !source.is_dir() {
            return Ok(None);
        }
        let found = recordings_in(source)?;
        let names = names(source, &found);
        let mut items: Vec<Item> = found.iter().zip(&names).flat_map(|(path, name)| items_of(path, name)).collect();
        tell_apart(&mut items);
        Ok((!items.is_empty()).then_some(Self { items }))
    }

    /// Tracks each into a folder of its own, as many at the same time as there are threads.
    ///
    /// # Errors
    ///
    /// What is refused before the first frame, and after the last the recordings that could not be tracked to their end.
    pub(super) fn track(&self, args: &Args, part: Part, out: &mut impl Write) -> Result<(), Failure> {
        self.refuse(args)?;
        let begin = Instant::now();
        let bar = args.output.steps("tracking recordings", self.items.len() as u64);
        let outcomes = self.in_parallel(|item| {
            bar.set_message(item.name.clone());
            let outcome = item.track(args, part);
            bar.inc(1);
            args.output.note_without_terminal(&outcome.to_string());
            outcome
        })?;
        bar.finish_and_clear();
        let results = Results {
            folder: args.out.clone(),
            seconds: begin.elapsed().as_secs_f64(),
            frames: outcomes.iter().filter_map(|outcome| outcome.summary.as_ref()).map(|run| run.tally.frames).sum(),
            recordings: outcomes,
        };
        args.output.result(out, &results, &results.to_string())?;
        results.failure().map_or(Ok(()), Err)
    }

    /// Refuses what holds for one recording only, and folders of runs that are taken, before anything is tracked.
    fn refuse(&self, args: &Args) -> Result<(), Failure> {
        // A mistake in the profile is found once, not for every recording.
        args.profile.load()?;
        let (source, count) = (args.source.display(), self.items.len());
        if let Some(item) = self.items.iter().find(|item| args.fps.is_some() && !item.location.is_dir()) {
            args.expect_no_rate(true, &format!("{} has", item.location.display()))?;
        }
        if args.overlay.is_some() {
            let message = format!("--overlay is for one recording, but {source} contains {count}");
            return Err(Failure::new(message, "leave it out, or track one of them"));
        }
        if fs::canonicalize(&args.out).is_ok_and(|out| fs::canonicalize(&args.source).is_ok_and(|source| source == out))
        {
            let message = format!("the runs would be written among the recordings in {source}");
            return Err(Failure::new(message, "choose another folder with --out"));
        }
        for item in &self.items {
            RunFolder::check(&args.out.join(&item.name), args.overwrite)?;
        }
        Ok(())
    }

    /// Does the work for each recording, on as many threads as may be used. After an interrupt no more are begun.
    fn in_parallel(&self, work: impl Fn(&Item) -> Outcome + Sync) -> Result<Vec<Outcome>, Failure> {
        let threads = threads::count().get();
        let workers = threads.min(self.items.len());
        let share = |worker: usize| threads / workers + usize::from(worker < threads % workers);
        let pools = (0..workers).map(|worker| pool(share(worker))).collect::<Result<Vec<_>, _>>()?;
        let (next, outcomes) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let interrupt = Interrupt::listen();
        let take = || {
            while let Some((index, item)) = self.item(next.fetch_add(1, Ordering::Relaxed)) {
                let outcome = if interrupt.is_asked() { item.interrupted() } else { work(item) };
                outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((index, outcome));
            }
        };
        thread::scope(|scope| {
            for pool in &pools {
                scope.spawn(|| pool.install(take));
            }
        });
        let mut outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
        outcomes.sort_by_key(|(index, _)| *index);
        Ok(outcomes.into_iter().map(|(_, outcome)| outcome).collect())
    }

    fn item(&self, index: usize) -> Option<(usize, &Item)> {
        self.items.get(index).map(|item| (index, item))
    }
}

/// The threads for one recording.
fn pool(threads: usize) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| threads::not_started(threads, &error))
}

impl Item {
    fn track(&self, args: &Args, part: Part) -> Outcome {
        let output = args.output.of_recording(&self.name);
        let (summary, failure) = match track(args, &self.location, part, args.out.join(&self.name), output) {
            Ok((summary, failure)) => (Some(summary), failure),
            Err(failure) => (None, Some(failure)),
        };
        let (error, hint) = match failure {
            Some(Failure::Stated { message, hint }) => (Some(message), hint),
            Some(Failure::BrokenPipe) | None => (None, None),
        };
        Outcome { recording: self.location.display().to_string(), summary, error, hint }
    }

    fn interrupted(&self) -> Outcome {
        let recording = self.location.display().to_string();
        let (error, hint) = ("interrupted before its first frame".into(), "run the command again".into());
        Outcome { recording, summary: None, error: Some(error), hint: Some(hint) }
    }
}

impl Results {
    /// The recordings that were not tracked to their end; none if there are none.
    fn failure(&self) -> Option<Failure> {
        let failed: Vec<&Outcome> = self.recordings.iter().filter(|outcome| outcome.error.is_some()).collect();
        let first = failed.first()?;
        let errors: Vec<String> = failed.iter().filter_map(|outcome| outcome.named_error()).collect();
        let (errors, count, all) = (errors.join("; "), failed.len(), self.recordings.len());
        let is_common = failed.iter().all(|outcome| outcome.hint == first.hint);
        let hint = if is_common { first.hint.clone() } else { Some("--json gives a hint for each".into()) };
        let message = format!("{count} of {all} recordings were not tracked to the end: {errors}");
        Some(Failure::Stated { message, hint })
    }
}

impl Outcome {
    /// The error, which names the recording.
    fn named_error(&self) -> Option<String> {
        let error = self.error.as_ref()?;
        Some(if error.contains(&self.recording) { error.clone() } else { format!("{}: {error}", self.recording) })
    }
}

/// A line for each recording, then the sum.
impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for outcome in &self.recordings {
            writeln!(f, "{outcome}")?;
        }
        let (count, frames, seconds) = (self.recordings.len(), self.frames, self.seconds);
        let rate = frames as f64 / seconds.max(f64::MIN_POSITIVE);
        let plural = if count == 1 { "" } else { "s" };
        writeln!(f, "{count} recording{plural}, {frames} frames in {seconds:.1} s: {rate:.1} frames per second")?;
        writeln!(f, "folder   {}", self.folder.display())
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(summary) = &self.summary else { return f.write_str(&self.named_error().unwrap_or_default()) };
        write!(f, "{}: {}", self.recording, summary.in_one_line())?;
        self.error.as_ref().map_or(Ok(()), |error| write!(f, ": {error}"))
    }
}

/// A recording as one item, or as one for each of its sensors if it has several.
fn items_of(path: &Path, name: &str) -> Vec<Item> {
    // Damage is reported when the recording is tracked.
    let recording = if Recording::is_at(path) { Recording::open(path).ok() } else { None };
    let of_sensor = |sensor: &RecordingSensor| Item {
        name: format!("{name}-{}", sensor.name.replace(['/', '\\'], "_")),
        location: format!("{}{SENSOR}{}", path.display(), sensor.name).into(),
    };
    match recording {
        Some(recording) if recording.sensors().len() > 1 => recording.sensors().iter().map(of_sensor).collect(),
        _ => vec![Item { name: name.into(), location: path.into() }],
    }
}

/// Names of runs: the names of the files without their endings and of the folders; with their endings where two would be the same.
fn names(folder: &Path, recordings: &[PathBuf]) -> Vec<String> {
    let text = |name: &OsStr| name.to_string_lossy().into_owned();
    let entry = |path: &PathBuf| {
        let below = path.strip_prefix(folder).unwrap_or(path);
        folder.join(below.iter().next().unwrap_or_default())
    };
    let entries: Vec<PathBuf> = recordings.iter().map(entry).collect();
    let short = |entry: &PathBuf| {
        let name = if entry.is_dir() { entry.file_name() } else { entry.file_stem() };
        text(name.unwrap_or_default())
    };
    let shorts: Vec<String> = entries.iter().map(short).collect();
    let is_taken = |short: &String| shorts.iter().filter(|other| *other == short).count() > 1;
    let name = |(entry, short): (&PathBuf, &String)| {
        if is_taken(short) { text(entry.file_name().unwrap_or_default()) } else { short.clone() }
    };
    entries.iter().zip(&shorts).map(name).collect()
}

/// Numbers runs whose names are the same but for upper and lower case, which are one folder on some systems.
fn tell_apart(items: &mut [Item]) {
    let mut taken = HashSet::new();
    for item in items {
        let (name, mut number) = (item.name.clone(), 1);
        while !taken.insert(item.name.to_lowercase()) {
            number += 1;
            item.name = format!("{name}-{number}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_named_after_recordings() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a/frames", "b"] {
            fs::create_dir_all(at(name)).unwrap();
        }
        let recordings = [at("a/frames"), at("b"), at("b.avi"), at("c.avi"), at("d.avi"), at("d.mp4")];
        assert_eq!(names(folder.path(), &recordings), ["a", "b", "b.avi", "c", "d.avi", "d.mp4"]);
    }
    #[test]
    fn runs_of_the_same_name_are_numbered() {
        let item = |name: &str| Item { name: name.into(), location: name.into() };
        let mut items = ["x-left", "X-left", "y", "x-left", "x-left-2"].map(item);
        tell_apart(&mut items);
        assert_eq!(items.map(|item| item.name), ["x-left", "X-left-2", "y", "x-left-3", "x-left-2-2"]);
    }
}
