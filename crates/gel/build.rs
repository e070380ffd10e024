//! Computes a digest of the sources that determine how a press is solved: a press that another version has solved is
//! never taken from the cache.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// The solver, the shapes that it presses, and how a scene is put to it; from this package's folder.
const SOURCES: [&str; 3] = ["../elastic/src", "src/indenter", "src/scene/solve.rs"];

fn main() -> io::Result<()> {
    let mut hasher = DefaultHasher::new();
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
        let mut files = Vec::new();
        collect(Path::new(source), &mut files)?;
        files.sort();
        for file in files {
            file.to_string_lossy().hash(&mut hasher);
            fs::read(&file)?.hash(&mut hasher);
        }
    }
    // Other instructions and another optimisation may round differently.
    for variable in ["TARGET", "PROFILE", "OPT_LEVEL", "CARGO_ENCODED_RUSTFLAGS"] {
        env::var_os(variable).hash(&mut hasher);
    }
    println!("cargo::rustc-env=FINGERVISION_SOLVER={:016x}", hasher.finish());
    Ok(())
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    if path.is_dir() {
        return fs::read_dir(path)?.try_for_each(|entry| collect(&entry?.path(), files));
    }
    if path.exists() {
        files.push(path.to_owned());
    }
    Ok(())
}
