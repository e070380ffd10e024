//! `cargo xtask accuracy`: the accuracy tables.

use crate::workspace;
use anyhow::{Context, Result};
use clap::ValueEnum;
use fingervision_evaluate::recordings::{FOLDER_VARIABLE, Punyo, Recordings, measure_independent, measure_pairs};
use fingervision_evaluate::{PressOptions, Table, elasticity, motion, pairs, resolution, sequences};
use fingervision_gel::{PressCache, Resolution};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Patterns a simulated pair.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Only these tables.
    #[arg(long)]
    only: Option<Tables>,
    /// Presses on a mesh of this resolution. Finer ones take much longer.
    #[arg(long, default_value = "fine")]
    mesh: Mesh,
    /// Only presses of this ready-made scene; may be repeated.
    #[arg(long, value_name = "SCENE")]
    scene: Vec<String>,
    /// Also write the tables to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Tables {
    /// Simulated pairs.
    Pairs,
    /// Recorded pairs and the recorded press.
    Real,
    /// Presses of another finite-element program and renderer.
    Independent,
    /// Simulated sequences.
    Sequences,
    /// The star: which periods are resolved.
    Resolution,
    /// Presses at several speeds, and the rim of their contact: takes hours, so only on request.
    Motion,
    /// Depth and force of presses, stuck and sliding: takes hours on the fine mesh, so only on request.
    Elasticity,
}

/// The cells of the mesh: 0.75, 0.45 or 0.3 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Mesh {
    Draft,
    Medium,
    Fine,
}

impl From<Mesh> for Resolution {
    fn from(mesh: Mesh) -> Self {
        match mesh {
            Mesh::Draft => Self::Draft,
            Mesh::Medium => Self::Medium,
            Mesh::Fine => Self::Fine,
        }
    }
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let start = Instant::now();
    let is_asked = |tables| args.only.is_none_or(|only| only == tables);
    let mut tables = Vec::new();
    let mut show = |table: Table, out: &mut dyn Write| {
        writeln!(out, "{table}")?;
        tables.push(table);
        anyhow::Ok(())
    };
    if is_asked(Tables::Pairs) {
        let measured = pairs::measure(args.seeds)?;
        show(measured.accuracy, out)?;
        show(measured.calibration, out)?;
    }
    if is_asked(Tables::Real) || is_asked(Tables::Independent) {
        if let Some(recordings) = Recordings::find(&workspace()) {
            if is_asked(Tables::Real) {
                show(measure_pairs(&recordings)?, out)?;
                show(Punyo::open(&recordings)?.measure()?, out)?;
            }
            if is_asked(Tables::Independent) {
                show(measure_independent(&recordings)?, out)?;
            }
        } else {
            writeln!(out, "Recordings: skipped, no folder ../shared/data; {FOLDER_VARIABLE} may name another\n")?;
        }
    }
    if is_asked(Tables::Sequences) {
        show(sequences::measure(&sequences::POLICIES)?, out)?;
    }
    if is_asked(Tables::Resolution) {
        show(resolution::measure()?, out)?;
    }
    if args.only == Some(Tables::Motion) {
        let options = PressOptions { mesh: args.mesh.into(), scenes: args.scene.clone() };
        let measured = motion::measure(&options, &PressCache::standard(), &mut |press| eprintln!("{press}"))?;
        for table in [measured.motion, measured.rim, measured.deviation, measured.disturbed] {
            show(table, out)?;
        }
    }
    if args.only == Some(Tables::Elasticity) {
        let options = PressOptions { mesh: args.mesh.into(), scenes: args.scene.clone() };
        let measured = elasticity::measure(&options, &PressCache::standard(), &|press| eprintln!("{press}"))?;
        show(measured.presses, out)?;
        show(measured.over_all, out)?;
    }
    let short = tables.iter().flat_map(Table::short).count();
    let asked = tables.iter().flat_map(|table| &table.rows).filter(|row| row.asked.is_some()).count();
    writeln!(out, "{asked} figures asked, {short} short, measured in {:.0} s", start.elapsed().as_secs_f64())?;
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(&tables)?;
        fs::write(file, text).with_context(|| format!("{} cannot be written", file.display()))?;
    }
    Ok(())
}
