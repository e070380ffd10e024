//! Checks that no source file has more than 400 lines.

use anyhow::{Context, Result, bail};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Lines that a source file may have.
const MOST_LINES: usize = 400;

/// Longer files, from the workspace's folder, and why they are.
const EXCEPTIONS: [(&str, &str); 0] = [];

/// Folders that hold no sources of ours.
const LEFT_OUT: [&str; 3] = ["target", "node_modules", ".git"];

pub(crate) fn run(out: &mut impl Write) -> Result<()> {
    let root = crate::workspace();
    let mut files = Vec::new();
    collect(&root, &mut files)?;
    let mut long = Vec::new();
    for file in &files {
        let lines = fs::read_to_string(file).with_context(|| file.display().to_string())?.lines().count();
        let name = file.strip_prefix(&root).unwrap_or(file);
        if lines > MOST_LINES && EXCEPTIONS.iter().all(|(exception, _)| Path::new(exception) != name) {
            long.push(format!("{} has {lines} lines", name.display()));
        }
    }
    if !long.is_empty() {
        bail!("more than {MOST_LINES} lines: {}", long.join(", "));
    }
    writeln!(out, "lengths: {} files of at most {MOST_LINES} lines", files.len())?;
    Ok(())
}

/// All Rust files below a folder.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let is_left_out = LEFT_OUT.iter().any(|name| path.file_name().is_some_and(|file| file == *name));
        if path.is_dir() && !is_left_out {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
