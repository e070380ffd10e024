//! A parser under test.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use crate::form::Form;
use crate::mutator::mutation;
use crate::random::Random;
use crate::settings::Settings;
use crate::watchdog::Watchdog;

/// How many failures are collected before a run ends.
const MOST_FAILURES: usize = 10;

/// A parser and the settings of its test.
#[derive(Debug, Clone)]
pub struct Parser {
    /// The name in failure reports; it also seeds the mutations.
    pub name: &'static str,
    /// How its files are mutated.
    pub form: Form,
    /// Valid files, at least one.
    pub files: Vec<Vec<u8>>,
    /// How many inputs it gets in an ordinary test run.
    pub inputs: u64,
    /// The most memory that one input may hold at a time on the parser's own thread, bytes.
    pub most_bytes: u64,
}

/// The results of a run.
#[derive(Debug, Default)]
struct Tally {
    /// Inputs that were parsed without an error.
    accepted: u64,
    /// The most memory that an input held, bytes, and the input's number.
    largest: (u64, u64),
    /// The longest time that an input took, and the input's number.
    slowest: (Duration, u64),
    failures: Vec<String>,
}

impl Parser {
    /// Parses every file and then its mutations; `parse` returns whether there was no error.
    ///
    /// # Panics
    ///
    /// If a file is refused, or if an input panics or holds too much memory. The message names parser, seed and input.
    pub fn run(&self, mut parse: impl FnMut(&[u8]) -> bool) {
        for (number, file) in self.files.iter().enumerate() {
            assert!(parse(file), "{}: valid file {number} is refused", self.name);
        }
        let Settings { seed, first, inputs } = Settings::from_environment(self.inputs);
        let watchdog = Watchdog::new(self.name, seed);
        let (mut tally, begin) = (Tally::default(), Instant::now());
        for input in first..first.saturating_add(inputs) {
            let bytes = mutation(&mut Random::new(self.name, seed, input), self.form, &self.files);
            watchdog.start(input);
            if let Err(why) = tally.add(input, self.most_bytes, || parse(&bytes)) {
                tally.failures.push(format!("{}: seed {seed}, input {input}: {why}", self.name));
            }
            if tally.failures.len() == MOST_FAILURES {
                break;
            }
        }
        self.report(&tally, inputs, begin.elapsed());
        assert!(tally.failures.is_empty(), "{}", tally.failures.join("\n"));
    }

    #[allow(clippy::print_stdout, reason = "the record of a long run; the test harness hides it otherwise")]
    fn report(&self, tally: &Tally, inputs: u64, took: Duration) {
        let Tally { accepted, largest: (bytes, large), slowest: (slow, late), .. } = tally;
        let mib = *bytes as f64 / f64::from(1 << 20);
        println!(
            "{}: {inputs} inputs in {:.1} s, {accepted} accepted; at most {mib:.1} MiB (input {large}), {slow:.1?} (input {late})",
            self.name,
            took.as_secs_f64()
        );
    }
}

impl Tally {
    fn add(&mut self, input: u64, most_bytes: u64, parse: impl FnOnce() -> bool) -> Result<(), String> {
        let begin = Instant::now();
        let mut outcome = Ok(false);
        let memory = allocation_counter::measure(|| outcome = catch_unwind(AssertUnwindSafe(parse)));
        self.slowest = self.slowest.max((begin.elapsed(), input));
        self.largest = self.largest.max((memory.bytes_max, input));
        self.accepted += u64::from(outcome.map_err(|panic| message(panic.as_ref()))?);
        if memory.bytes_max > most_bytes {
            return Err(format!("holds {} bytes, {most_bytes} are allowed", memory.bytes_max));
        }
        Ok(())
    }
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("panics: {}", text.unwrap_or("without a message"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parser() -> Parser {
        Parser { name: "numbers", form: Form::Text, files: vec![b"12".to_vec()], inputs: 200, most_bytes: 1 << 20 }
    }

    fn failure(parse: impl FnMut(&[u8]) -> bool) -> String {
        message(catch_unwind(AssertUnwindSafe(|| parser().run(parse))).unwrap_err().as_ref())
    }

    #[test]
    fn a_parser_that_refuses_what_is_damaged_passes() {
        parser().run(|bytes| std::str::from_utf8(bytes).is_ok_and(|text| text.parse::<f64>().is_ok()));
    }

    #[test]
    fn a_panic_is_reported_with_seed_and_input() {
        let report = failure(|bytes| {
            assert!(bytes == b"12", "not twelve");
            true
        });
        assert!(report.contains("numbers: seed 1, input ") && report.contains("panics: not twelve"), "{report}");
    }

    #[test]
    fn memory_without_bound_is_reported() {
        let report = failure(|bytes| bytes == b"12" || std::hint::black_box(vec![1_u8; 1 << 21]).is_empty());
        assert!(report.contains("bytes, 1048576 are allowed"), "{report}");
    }

    #[test]
    fn a_valid_file_that_is_refused_fails() {
        assert_eq!(failure(|_| false), "panics: numbers: valid file 0 is refused");
    }
}
