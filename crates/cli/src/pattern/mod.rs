//! `fingervision pattern`: a pattern to print, and how accurately a camera will track it.

mod choice;
mod print;
mod score;
mod table;

use std::io::Write;
use std::path::PathBuf;

use crate::failure::Failure;
use crate::output::OutputArgs;
use crate::profile_args::ProfileArgs;

use choice::PatternArgs;
pub(crate) use score::simulated_camera;

/// Write a pattern at true scale, or predict how accurately a camera will track it
///
/// With --out a page is written with the pattern, crop marks, a scale bar of 10 mm and a caption with everything needed
/// to make the same pattern again. Print it at 100 % and check the bar. With --score a table over cell sizes shows the
/// noise of the flow with the profile's camera, by the Cramér–Rao bound, so that a size can be chosen before anything
/// is printed.
#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("task").required(true).multiple(true)))]
pub(crate) struct Args {
    /// The file to write; its extension selects the format: .pdf, .svg or .png
    #[arg(long, value_name = "FILE", group = "task")]
    out: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print a table of sizes with the resulting noise of the flow
    #[arg(long, group = "task")]
    score: bool,
    #[command(flatten)]
    pattern: PatternArgs,
    /// Put the pattern in the middle of a sheet of this size; without it the page is just large enough
    ///
    /// The sheet is used in landscape if the pattern is too wide for portrait.
    #[arg(long, value_name = "PAPER", value_enum, requires = "out")]
    page: Option<print::PageName>,
    /// Resolution of a PNG, px per inch; without it the one nearest to 1200 at which every cell is a whole number of px
    #[arg(long, value_name = "DPI", value_parser = dpi, requires = "out")]
    dpi: Option<f64>,
    #[command(flatten)]
    sight: score::SightArgs,
    #[command(flatten)]
    profile: ProfileArgs,
    #[command(flatten)]
    output: OutputArgs,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    if !args.score && !args.profile.is_absent() {
        let message = "--profile and --set have no effect: the page does not depend on the camera";
        return Err(Failure::new(message, "leave them out, or pass --score"));
    }
    if let Some(file) = &args.out {
        let written = print::write(args, file)?;
        // Only one of two results can be the JSON.
        if args.score && args.output.is_json() {
            args.output.note(&written.to_string());
        } else {
            args.output.result(out, &written, &written.to_string())?;
        }
    }
    if args.score {
        let table = score::table(args)?;
        args.output.result(out, &table, &table.to_string())?;
    }
    Ok(())
}

fn dpi(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(dpi) if (50.0..=20_000.0).contains(&dpi) => Ok(dpi),
        _ => Err("a resolution is a number from 50 to 20000 px per inch".into()),
    }
}

/// Two values separated by a comma.
fn pair<T: std::str::FromStr + Copy>(text: &str, example: &str) -> Result<[T; 2], String> {
    let values = text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    values.ok_or_else(|| format!("expected two values separated by a comma, as in {example}"))
}
