//! `cargo xtask performance`: measures the tables of `docs/performance.md` on this machine, and writes them there.
//!
//! The times are those of the `fingervision` command, which is built first. Other programs on the machine make them
//! longer, so each table has the load average at its start beside it. A table that cannot be measured leaves the others
//! as they are.

mod document;
mod program;
mod roofline;
mod tables;

use std::fs;
use std::io::Write;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use clap::ValueEnum;

use crate::instructions::{instruction_set_of_processor, processor};
pub(crate) use document::table;
use program::Program;
use tables::Name;

const PAGE: &str = "docs/performance.md";

/// Options of the measurement.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Only this table; may be repeated.
    #[arg(long, value_name = "TABLE")]
    only: Vec<Name>,
    /// Print the tables, and leave the page as it is.
    #[arg(long)]
    print: bool,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let program = Program::build()?;
    let start = Instant::now();
    let path = crate::workspace().join(PAGE);
    let asked: &[Name] = if args.only.is_empty() { Name::value_variants() } else { &args.only };
    let mut failed = Vec::new();
    for &name in asked {
        let word = name.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        let machine = machine();
        let table = match name.make(&program) {
            Ok(table) => format!("{}\n\n{machine}", table.trim()),
            Err(error) => {
                writeln!(out, "{word}: {error:#}\n")?;
                failed.push(word);
                continue;
            }
        };
        writeln!(out, "{word}\n\n{table}\n")?;
        if !args.print {
            let page = fs::read_to_string(&path).with_context(|| format!("{PAGE} cannot be read"))?;
            let page = document::replace(&page, &word, &table).with_context(|| PAGE.to_owned())?;
            fs::write(&path, page).with_context(|| format!("{PAGE} cannot be written"))?;
        }
    }
    fs::remove_dir_all(&program.folder)?;
    writeln!(out, "performance: {} tables in {:.0} s", asked.len() - failed.len(), start.elapsed().as_secs_f64())?;
    if !failed.is_empty() {
        bail!("not measured: {}", failed.join(", "));
    }
    Ok(())
}

/// The machine and its load, for a line below a table.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split_whitespace().next().map_or("unknown".to_owned(), str::to_owned);
    format!("*{}, {cores} cores, {}; load average {load}.*", processor(), instruction_set_of_processor())
}
