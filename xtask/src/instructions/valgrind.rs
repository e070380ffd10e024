//! Counts the instructions of all stages under valgrind.
//!
//! The program counts itself: it runs again as `cargo xtask instructions --count RUN`. A run calls a function of a known
//! name before and after each frame, where valgrind begins a new part of its output: start and preparation of a
//! tracker are not in the parts of the frames.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::thread;

use anyhow::{Context, Result, ensure};

use super::stage::{MARK, Run, Stage};

/// Bytes of a line of a cache.
pub(super) const LINE_BYTES: u64 = 64;
/// The caches that are simulated: 32 KiB for data and instructions, then 512 KiB.
const CACHES: [&str; 4] = ["--cache-sim=yes", "--I1=32768,8,64", "--D1=32768,8,64", "--LL=524288,8,64"];

/// What one run, or one frame, takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Counts {
    pub(super) instructions: u64,
    /// Lines that are fetched into the first cache, or are written where they are not in it.
    pub(super) first_misses: u64,
    /// The same of the second cache.
    pub(super) second_misses: u64,
}

/// The version of valgrind.
pub(super) fn version() -> Result<String> {
    let output = crate::expect_success(Command::new("valgrind").arg("--version"))?;
    Ok(String::from_utf8_lossy(&output).trim().to_owned())
}

/// Counts of a frame of each stage; of stages that only add to another one, what they add.
///
/// The instructions are always those without simulated caches: the C library chooses how it fills memory by the caches that it
/// finds.
pub(super) fn count_all(film: &Path, with_caches: bool) -> Result<Vec<(Stage, Counts)>> {
    let plain = count_once(film, false)?;
    if !with_caches {
        return Ok(plain);
    }
    let cached = count_once(film, true)?;
    let both = |((stage, plain), (_, cached)): ((Stage, Counts), (_, Counts))| {
        (stage, Counts { instructions: plain.instructions, ..cached })
    };
    Ok(plain.into_iter().zip(cached).map(both).collect())
}

fn count_once(film: &Path, with_caches: bool) -> Result<Vec<(Stage, Counts)>> {
    let (next, done) = (Mutex::new(Run::ALL.iter()), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(&run) = next.lock().ok().and_then(|mut next| next.next()) {
                    let counts = count(run, film, with_caches).with_context(|| format!("run {}", run.name()));
                    done.lock().map(|mut done| done.push(counts)).ok();
                }
            });
        }
    });
    let runs = done.into_inner().unwrap_or_default().into_iter().collect::<Result<Vec<_>>>()?;
    let whole: Vec<(Stage, Counts)> = runs.into_iter().flatten().collect();
    let of = |stage: Stage| {
        let found = whole.iter().find(|(counted, _)| *counted == stage).map(|(_, counts)| *counts);
        found.with_context(|| format!("stage {stage} was not counted"))
    };
    let added =
        |stage: Stage| Ok((stage, stage.base().map_or_else(|| of(stage), |base| Ok(of(stage)?.minus(of(base)?)))?));
    Stage::ALL.into_iter().map(added).collect()
}

/// Counts of a frame of each stage of a run.
fn count(run: Run, film: &Path, with_caches: bool) -> Result<Vec<(Stage, Counts)>> {
    let own = env::current_exe().context("the program does not know its own path")?;
    let parts = film.with_extension(run.name());
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--tool=callgrind", "--combine-dumps=yes", &format!("--dump-before=*{MARK}*")]);
    valgrind.arg(format!("--callgrind-out-file={}", parts.display()));
    if with_caches {
        valgrind.args(CACHES);
    }
    valgrind.arg(own).args(["instructions", "--count", &run.name(), "--film"]).arg(film);
    let output = valgrind.env("RAYON_NUM_THREADS", "1").output()?;
    ensure!(output.status.success(), "valgrind: {}", String::from_utf8_lossy(&output.stderr).trim());
    let text = fs::read_to_string(&parts).with_context(|| format!("{} cannot be read", parts.display()))?;
    fs::remove_file(&parts)?;
    of_stages(run, &Counts::read_all(&text))
}

/// Each counted frame is the part between two marks: every other part after the first.
fn of_stages(run: Run, parts: &[Counts]) -> Result<Vec<(Stage, Counts)>> {
    let stages = run.stages();
    let frames: usize = stages.iter().map(|(_, frames)| frames.len()).sum();
    ensure!(parts.len() == 2 * frames + 1, "valgrind counted {} parts for {frames} frames", parts.len());
    let mut counted = parts.iter().skip(1).step_by(2);
    let mean = |(stage, frames): &(Stage, &[usize])| {
        let sum = counted.by_ref().take(frames.len()).fold(Counts::default(), |sum, &part| sum.plus(part));
        (*stage, sum.divided_by(frames.len() as u64))
    };
    Ok(stages.iter().map(mean).collect())
}

impl Counts {
    /// Reads the line `events` and the lines `totals` of all parts of callgrind's output.
    fn read_all(text: &str) -> Vec<Self> {
        let mut events = Vec::new();
        let mut parts = Vec::new();
        for line in text.lines() {
            if let Some(names) = line.strip_prefix("events: ") {
                events = names.split_whitespace().collect();
            } else if let Some(values) = line.strip_prefix("totals: ") {
                let counts: Vec<u64> = values.split_whitespace().map_while(|value| value.parse().ok()).collect();
                // Events at the end that are 0 are left out.
                let of = |name: &str| {
                    events
                        .iter()
                        .position(|event| *event == name)
                        .and_then(|place| counts.get(place))
                        .copied()
                        .unwrap_or(0)
                };
                parts.push(Self {
                    instructions: of("Ir"),
                    first_misses: of("D1mr") + of("D1mw"),
                    second_misses: of("DLmr") + of("DLmw"),
                });
            }
        }
        parts
    }

    fn plus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            first_misses: self.first_misses + other.first_misses,
            second_misses: self.second_misses + other.second_misses,
        }
    }

    fn minus(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.saturating_sub(other.instructions),
            first_misses: self.first_misses.saturating_sub(other.first_misses),
            second_misses: self.second_misses.saturating_sub(other.second_misses),
        }
    }

    fn divided_by(self, parts: u64) -> Self {
        let Self { instructions, first_misses, second_misses } = self;
        let part = |count: u64| count / parts;
        Self { instructions: part(instructions), first_misses: part(first_misses), second_misses: part(second_misses) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read_by_the_names_of_events() {
        let text = "part: 1\nevents: Ir Dr Dw I1mr D1mr D1mw ILmr DLmr DLmw\nfn=(1)\n0 7\n\
                    totals: 900 300 200 9 40 20 8 4 2\npart: 2\ntotals: 5 1\n";
        let first = Counts { instructions: 900, first_misses: 60, second_misses: 6 };
        assert_eq!(Counts::read_all(text), [first, Counts { instructions: 5, ..Counts::default() }]);
        assert_eq!(Counts::read_all("no part"), []);
    }

    #[test]
    fn only_parts_between_marks_are_counted() {
        let part = |instructions| Counts { instructions, ..Counts::default() };
        // The start, then two frames at rest and four pressed ones, each followed by what is not counted.
        let tracker = [10, 700, 20, 700, 100, 700, 200, 700, 300, 700, 400, 700];
        let parts: Vec<Counts> =
            [9000].into_iter().chain(tracker).chain(tracker.map(|count| 2 * count)).map(part).collect();
        let counted = of_stages(Run::Elastic, &parts).unwrap();
        let exact = [(Stage::RestExact, part(15)), (Stage::Exact, part(250))];
        assert_eq!(counted, [exact, [(Stage::RestLive, part(30)), (Stage::Live, part(500))]].concat());
        assert!(of_stages(Run::Elastic, &parts[..24]).is_err());
    }
}
