//! The command: as a program, and as a function that returns its result.

use std::ffi::OsString;
use std::io::Write;

use pyo3::prelude::*;

use crate::error::OrRaise;

/// Runs the program with these arguments, the first of which is its name, and ends the process.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, arguments: Vec<OsString>) {
    py.detach(|| {
        let code = fingervision_cli::run(&arguments);
        // No destructor runs behind this line.
        let _ = std::io::stdout().lock().flush();
        // An ExitCode tells its number to the end of a process only.
        code.exit_process()
    });
}

/// The result of a command as its JSON text, and its notes.
#[pyfunction]
pub(crate) fn call(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<(String, Vec<String>)> {
    let mut out = Vec::new();
    let notes = py.detach(|| fingervision_cli::call(&arguments, &mut out)).or_raise()?;
    Ok((String::from_utf8_lossy(&out).into_owned(), notes))
}
