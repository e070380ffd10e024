//! The output of a command, as text or JSON.

use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::failure::{Failure, Wording};

/// Interval at which a bar is redrawn while nothing happens.
const TICK: Duration = Duration::from_millis(200);

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct OutputArgs {
    /// Print only errors
    #[arg(long, short)]
    quiet: bool,
    /// Print the result as JSON; errors and notes too, one object per line on standard error
    #[arg(long)]
    json: bool,
    /// The recording that notes are about, if several are tracked at the same time; then no bar is shown for a single one.
    #[arg(skip)]
    recording: Option<&'static str>,
}

impl OutputArgs {
    /// Whether a program reads the result.
    pub(crate) fn is_json(self) -> bool {
        self.json
    }

    /// The same for one of several recordings that are tracked at the same time.
    pub(crate) fn of_recording(self, name: &str) -> Self {
        // As long as the program runs: a few bytes for each recording.
        Self { recording: Some(String::leak(name.to_owned())), ..self }
    }

    fn wording(self) -> Wording {
        if self.json { Wording::Json } else { Wording::Text }
    }

    /// Prints a note for the user on standard error.
    pub(crate) fn note(self, text: &str) {
        if !self.quiet {
            let text = self.recording.map_or_else(|| text.to_owned(), |recording| format!("{recording}: {text}"));
            // If standard error cannot be written, nobody can be informed.
            let _ = self.wording().note(&text, &mut io::stderr());
        }
    }

    /// Prints a note on work that takes long, where no bar shows it.
    pub(crate) fn note_without_terminal(self, text: &str) {
        if !io::stderr().is_terminal() {
            self.note(text);
        }
    }

    /// Prints the result: as JSON if requested, otherwise as text unless quiet.
    pub(crate) fn result(self, out: &mut impl Write, value: &impl Serialize, text: &str) -> Result<(), Failure> {
        if self.json {
            // The text is complete before it is written: a part of a JSON object is useless.
            let json = serde_json::to_string_pretty(value).map_err(io::Error::from)?;
            writeln!(out, "{json}")?;
        } else if !self.quiet {
            writeln!(out, "{}", text.trim_end())?;
        }
        Ok(())
    }

    /// A bar on standard error over this many steps, with the name of the last one beside it.
    pub(crate) fn steps(self, doing: &'static str, count: u64) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        ticking(ProgressBar::new(count), doing, "{spinner} {prefix} {pos}/{len}, {elapsed} {wide_msg}")
    }

    /// A line on standard error that is updated while something runs. Nothing is shown without a terminal.
    pub(crate) fn line(self) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        ticking(ProgressBar::new_spinner(), "", "{spinner} {wide_msg}")
    }

    /// A bar on standard error over `count` frames, labelled with the work being done; a counter if their number is not
    /// known. Nothing is shown without a terminal.
    pub(crate) fn progress(self, doing: &'static str, count: Option<u64>) -> ProgressBar {
        if self.quiet || self.recording.is_some() {
            return ProgressBar::hidden();
        }
        let (bar, template) = match count {
            Some(count) => (ProgressBar::new(count), "{spinner} {prefix} {pos}/{len} frames, {elapsed} {wide_bar}"),
            None => (ProgressBar::new_spinner(), "{spinner} {prefix} {pos} frames, {elapsed}"),
        };
        ticking(bar, doing, template)
    }
}

/// Refuses a file that exists already: without `--overwrite` nothing is replaced. A device accepts anything.
pub(crate) fn refuse_existing(file: &Path) -> Result<(), Failure> {
    if !file.is_file() {
        return Ok(());
    }
    Err(Failure::new(format!("{} exists already", file.display()), "choose a new name or pass --overwrite"))
}

/// A bar that fits any width of terminal, and whose time is updated while a step takes long.
fn ticking(bar: ProgressBar, doing: &'static str, template: &str) -> ProgressBar {
    let bar = bar.with_prefix(doing);
    let bar = match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    };
    bar.enable_steady_tick(TICK);
    bar
}
