//! How much a command says, and in which form.

use std::io::{self, Write};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::failure::Failure;

#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct OutputArgs {
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl OutputArgs {
    /// Whether a program reads the result.
    pub(crate) fn is_json(self) -> bool {
        self.json
    }

    /// Says something to the person at the keyboard, on standard error.
    pub(crate) fn note(self, text: &str) {
        if !self.quiet {
            // Without standard error there is nobody left to tell.
            let _ = writeln!(io::stderr(), "note: {text}");
        }
    }

    /// Hands over the result: as JSON where asked for, else as text unless quiet.
    pub(crate) fn result(self, out: &mut impl Write, value: &impl Serialize, text: &str) -> Result<(), Failure> {
        if self.json {
            serde_json::to_writer_pretty(&mut *out, value).map_err(io::Error::from)?;
            writeln!(out)?;
        } else if !self.quiet {
            writeln!(out, "{}", text.trim_end())?;
        }
        Ok(())
    }

    /// A bar on standard error over so many steps, the name of the last one beside it.
    pub(crate) fn steps(self, doing: &'static str, count: u64) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(count).with_prefix(doing);
        match ProgressStyle::with_template("{prefix} {bar:40} {pos}/{len} {elapsed} {msg}") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    /// A bar on standard error over `count` frames, after what is done with them; a counter where their number is not
    /// known. It shows nothing where nobody looks.
    pub(crate) fn progress(self, doing: &'static str, count: Option<u64>) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let (bar, template) = match count {
            Some(count) => (ProgressBar::new(count), "{prefix} {bar:40} {pos}/{len} frames, {eta} left"),
            None => (ProgressBar::new_spinner(), "{spinner} {prefix} {pos} frames in {elapsed}"),
        };
        let bar = bar.with_prefix(doing);
        match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }
}
