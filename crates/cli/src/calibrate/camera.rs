//! `fingervision calibrate camera`: how the camera sees the gel, from a board that slides in known steps.

use std::io::Write;
use std::path::PathBuf;

use crate::failure::Failure;

/// Find how the camera sees the gel, from a patterned board that slides in known steps
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The images of the board, in order: a folder, a video or sim:board
    board: PathBuf,
}

pub(crate) fn run(args: &Args, _out: &mut impl Write) -> Result<(), Failure> {
    let message = format!("{}: a board cannot be evaluated yet", args.board.display());
    Err(Failure::new(message, "write the [camera] table of the profile by hand"))
}
