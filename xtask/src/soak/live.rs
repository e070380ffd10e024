//! The running `fingervision live`.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

/// The longest time until the page is served: the press is solved first.
const START: Duration = Duration::from_mins(2);
/// The longest time until the recording is closed.
const END: Duration = Duration::from_mins(1);
const POLL: Duration = Duration::from_millis(100);
/// How the note with the page's address begins.
const PAGE: &str = "the page: http://";

/// A running command; it is killed if it is dropped.
#[derive(Debug)]
pub(super) struct Live {
    child: Child,
    host: String,
    /// Its notes, as they come.
    notes: Receiver<String>,
}

/// What the command reports at its end.
#[derive(Debug, Deserialize)]
struct Summary {
    sensors: Vec<Ended>,
}

/// The counts of a sensor at the end.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Ended {
    pub(super) sensor: String,
    pub(super) frames: u64,
    pub(super) readings: u64,
    /// Readings per second, from the first to the last; `None` with fewer than two.
    pub(super) frames_per_second: Option<f64>,
    pub(super) dropped_by_camera: u64,
    pub(super) dropped_before_tracking: u64,
    pub(super) damaged: u64,
}

/// A line on standard error: a note, or an error.
#[derive(Debug, Deserialize)]
struct Line {
    note: Option<String>,
    error: Option<String>,
}

impl Live {
    /// Starts the command, and waits for its page.
    pub(super) fn start(
        command: &Path,
        sources: &[String],
        (profile, recording): (Option<&Path>, Option<&Path>),
    ) -> Result<Self> {
        let mut live = Command::new(command);
        live.arg("live").args(sources).args(["--json", "--port", "0"]);
        for (option, file) in [("--profile", profile), ("--record", recording)] {
            if let Some(file) = file {
                live.arg(option).arg(file);
            }
        }
        live.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = live.spawn().with_context(|| format!("{} cannot be run", command.display()))?;
        let errors = child.stderr.take().context("no standard error")?;
        let (to, notes) = channel();
        thread::spawn(move || {
            for line in BufReader::new(errors).lines().map_while(Result::ok) {
                // Nobody reads the notes of a command that is killed.
                let _ = to.send(text(&line));
            }
        });
        let mut live = Self { child, host: String::new(), notes };
        live.host = live.wait_for_page()?;
        Ok(live)
    }

    fn wait_for_page(&mut self) -> Result<String> {
        let end = Instant::now() + START;
        let mut said = Vec::new();
        while let Ok(note) = self.notes.recv_timeout(end.saturating_duration_since(Instant::now())) {
            if let Some(host) = note.strip_prefix(PAGE) {
                return Ok(host.trim_end_matches('/').to_owned());
            }
            said.push(note);
        }
        bail!("fingervision live has served no page in {} s: {}", START.as_secs(), said.join("; "))
    }

    /// As in `127.0.0.1:8090`.
    pub(super) fn host(&self) -> &str {
        &self.host
    }

    pub(super) fn process(&self) -> u32 {
        self.child.id()
    }

    /// An error if the command has ended.
    pub(super) fn check_runs(&mut self) -> Result<()> {
        if let Some(status) = self.child.try_wait()? {
            let said: Vec<String> = self.notes.iter().collect();
            bail!("fingervision live has ended too early, {status}: {}", said.join("; "));
        }
        Ok(())
    }

    /// Ends the command as Ctrl-C does.
    pub(super) fn stop(mut self) -> Result<Vec<Ended>> {
        self.check_runs()?;
        crate::expect_success(Command::new("kill").args(["-INT", &self.process().to_string()]))?;
        let end = Instant::now() + END;
        let status = loop {
            if let Some(status) = self.child.try_wait()? {
                break status;
            }
            ensure!(Instant::now() < end, "fingervision live has not ended {} s after Ctrl-C", END.as_secs());
            thread::sleep(POLL);
        };
        let mut report = String::new();
        self.child.stdout.take().context("no standard output")?.read_to_string(&mut report)?;
        let said: Vec<String> = self.notes.iter().collect();
        ensure!(status.success(), "fingervision live: {status}: {}", said.join("; "));
        ended(&report)
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // An error means that it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The text of a line of JSON; other lines are kept as they are.
fn text(line: &str) -> String {
    let parsed = serde_json::from_str::<Line>(line).ok();
    parsed.and_then(|line| line.note.or(line.error)).unwrap_or_else(|| line.to_owned())
}

fn ended(report: &str) -> Result<Vec<Ended>> {
    let summary: Summary = serde_json::from_str(report)
        .with_context(|| format!("fingervision live printed another report than expected: {}", report.trim()))?;
    Ok(summary.sensors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_and_errors_are_read_from_lines_of_json() {
        assert_eq!(text("{\"note\":\"the page: http://127.0.0.1:1/\"}"), "the page: http://127.0.0.1:1/");
        assert_eq!(text("{\"error\":\"port taken\",\"hint\":\"choose another\"}"), "port taken");
        assert_eq!(text("thread panicked"), "thread panicked");
    }

    #[test]
    fn counts_are_read_from_the_report() {
        let report = r#"{"sensors": [{"sensor": "left", "source": "sim:letter", "frames": 9, "readings": 7,
            "frames_per_second": 10.0, "dropped_by_camera": 1, "dropped_before_tracking": 2, "damaged": 3}]}"#;
        let sensor = "left".to_owned();
        let expected = Ended {
            sensor,
            frames: 9,
            readings: 7,
            frames_per_second: Some(10.0),
            dropped_by_camera: 1,
            dropped_before_tracking: 2,
            damaged: 3,
        };
        assert_eq!(ended(report).unwrap(), [expected]);
        let error = ended("left: 7 readings\n").unwrap_err().to_string();
        assert_eq!(error, "fingervision live printed another report than expected: left: 7 readings");
    }
}
