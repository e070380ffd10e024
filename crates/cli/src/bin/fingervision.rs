//! The `fingervision` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    fingervision_cli::run(&std::env::args_os().collect::<Vec<_>>()).into()
}
