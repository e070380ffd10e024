//! `cargo xtask layers`: a crate depends only on the crates that are listed for it.
//!
//! Each list is complete: a dependency of a dependency is allowed only if it is listed as well.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::collections::HashSet;
use std::io::Write;
use std::process::Command;

/// The dependencies that a crate of the workspace may have, without the prefix `fingervision-`.
const LAYERS: [(&str, &[&str]); 24] = [
    // Stands apart: only tests use it.
    ("fuzz", &[]),
    ("image", &[]),
    ("settings", &[]),
    ("optics", &[]),
    ("fourier", &[]),
    ("elastic", &["fourier"]),
    ("flow", &["image"]),
    ("gel", &["image", "optics", "elastic", "settings"]),
    ("touch", &["image", "flow", "optics", "elastic", "settings"]),
    ("source", &["image"]),
    // The profile's table says how a camera captures.
    ("camera", &["image", "source", "touch"]),
    ("pipeline", &["image", "source", "camera", "touch"]),
    ("recording", &["image", "optics", "source", "touch", "pipeline"]),
    ("foxglove", &["image", "source", "touch", "pipeline", "recording"]),
    ("page", &["image", "optics", "source", "touch", "pipeline"]),
    ("plot", &["image", "flow"]),
    ("sink", &["touch", "image", "flow", "plot", "settings"]),
    // A simulated press is read like a recording and written like a run: the same arrays, tables and pictures.
    ("simulation", &["gel", "touch", "image", "flow", "plot", "source", "sink"]),
    // The crate that a program names: names alone, from the others.
    (
        "fingervision",
        &["image", "flow", "optics", "elastic", "settings", "gel", "touch", "source", "plot", "sink", "simulation"],
    ),
    ("calibrate", &["touch", "plot", "elastic", "flow", "optics", "settings", "image"]),
    ("evaluate", &["touch", "gel", "calibrate", "image", "flow", "optics", "settings", "plot", "sink", "simulation"]),
    (
        "cli",
        &[
            "image",
            "optics",
            "elastic",
            "flow",
            "gel",
            "touch",
            "calibrate",
            "source",
            "camera",
            "pipeline",
            "page",
            "foxglove",
            "recording",
            "sink",
            "simulation",
            "evaluate",
        ],
    ),
    // The package for Python: arrays in, arrays out, and the command.
    ("python", &["image", "flow", "gel", "touch", "source", "camera", "recording", "sink", "simulation", "cli"]),
    ("xtask", &["evaluate", "gel", "flow", "image", "pipeline", "recording", "simulation", "source", "touch"]),
];

/// Additional dependencies that are allowed in tests and examples: of any crate, simulated frames and mutated files; of
/// the library, the fits; of recordings, a camera that fails on demand.
const FOR_TESTS: [(Option<&str>, &str); 4] =
    [(None, "gel"), (None, "fuzz"), (Some("fingervision"), "calibrate"), (Some("recording"), "camera")];

/// Heavy dependencies and the only crates that may name them outside tests.
const HEAVY: [(&str, &[&str]); 31] = [
    ("axum", &["page"]),
    ("base64", &["evaluate"]),
    ("chrono", &["cli"]),
    ("clap", &["cli", "xtask"]),
    ("image", &["source", "plot", "sink", "evaluate"]),
    ("image-webp", &["recording"]),
    ("indicatif", &["cli"]),
    ("jpeg-encoder", &["page", "cli", "xtask"]),
    ("minijinja", &["evaluate"]),
    ("miniz_oxide", &["gel", "sink"]),
    ("moq-v4l", &["camera"]),
    ("nalgebra", &["calibrate", "evaluate"]),
    ("numpy", &["python"]),
    ("pdf-writer", &["gel"]),
    ("png", &["gel"]),
    ("prost", &["recording"]),
    ("prost-types", &["recording"]),
    ("pyo3", &["python"]),
    ("rayon", &["flow", "elastic", "evaluate", "cli"]),
    ("realfft", &["fourier"]),
    ("rust_h264", &["source"]),
    ("rustfft", &["fourier"]),
    ("serde_json", &["cli", "page", "xtask"]),
    ("svg", &["gel"]),
    ("tiff", &["source"]),
    ("tokio", &["page"]),
    ("tiny-skia", &["plot"]),
    ("ttf-parser", &["gel", "plot"]),
    ("zip", &["evaluate", "sink"]),
    ("zune-core", &["source"]),
    ("zune-jpeg", &["source"]),
];

#[derive(Debug, Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Debug, Deserialize)]
struct Package {
    name: String,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Deserialize)]
struct Dependency {
    name: String,
    /// Absent for a normal dependency, else `dev` or `build`.
    kind: Option<String>,
}

pub(crate) fn run(out: &mut impl Write) -> Result<()> {
    let arguments = ["metadata", "--format-version=1", "--no-deps", "--locked"];
    let metadata = Command::new(env!("CARGO")).args(arguments).current_dir(crate::workspace()).output()?;
    ensure!(metadata.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&metadata.stderr).trim());
    let metadata: Metadata = serde_json::from_slice(&metadata.stdout).context("output of cargo metadata")?;
    let mut faults = faults(&metadata.packages);
    faults.extend(outdated(&metadata.packages));
    for fault in &faults {
        writeln!(out, "{fault}")?;
    }
    if !faults.is_empty() {
        bail!("{} faults in the layers", faults.len());
    }
    writeln!(out, "layers: {} crates depend only on the crates listed for them", metadata.packages.len())?;
    Ok(())
}

fn short_name(package: &str) -> &str {
    package.strip_prefix("fingervision-").unwrap_or(package)
}

/// Every dependency that is not allowed, in words.
fn faults(packages: &[Package]) -> Vec<String> {
    let ours: HashSet<&str> = packages.iter().map(|package| package.name.as_str()).collect();
    let mut faults = Vec::new();
    for package in packages {
        let name = short_name(&package.name);
        let Some((_, allowed)) = LAYERS.iter().find(|(layer, _)| *layer == name) else {
            faults.push(format!("{name} is not in the list of layers"));
            continue;
        };
        for dependency in &package.dependencies {
            let is_for_tests = dependency.kind.as_deref() == Some("dev");
            let (is_allowed, kind) = if ours.contains(dependency.name.as_str()) {
                let below = short_name(&dependency.name);
                (allowed.contains(&below) || is_for_tests && may_test_with(name, below), "is not listed for it")
            } else {
                (is_for_tests || may_carry(name, &dependency.name), "belongs to another crate")
            };
            if !is_allowed {
                faults.push(format!("{name} uses {}, which {kind}", short_name(&dependency.name)));
            }
        }
    }
    faults
}

/// Outdated entries of the tables, in words: crates that do not exist, and heavy dependencies that are no longer used.
fn outdated(packages: &[Package]) -> Vec<String> {
    let find = |layer: &str| packages.iter().find(|package| short_name(&package.name) == layer);
    let gone =
        LAYERS.iter().filter(|(layer, _)| find(layer).is_none()).map(|(layer, _)| format!("{layer} is not a crate"));
    let uses = |owner: &str, heavy: &str| {
        let normal = |dependency: &&Dependency| dependency.name == heavy && dependency.kind.is_none();
        find(owner).is_some_and(|package| package.dependencies.iter().any(|dependency| normal(&dependency)))
    };
    let pairs = HEAVY.iter().flat_map(|(heavy, owners)| owners.iter().map(move |owner| (*heavy, *owner)));
    let unused = pairs.filter(|(heavy, owner)| !uses(owner, heavy));
    gone.chain(unused.map(|(heavy, owner)| format!("{owner} may use {heavy}, but does not"))).collect()
}

/// Whether a crate's tests and examples may use a crate of the workspace that does not lie below it.
fn may_test_with(name: &str, below: &str) -> bool {
    FOR_TESTS.iter().any(|(only, allowed)| *allowed == below && only.is_none_or(|only| only == name))
}

/// Whether a crate may use a dependency from outside the workspace.
fn may_carry(package: &str, dependency: &str) -> bool {
    let owners = HEAVY.iter().find(|(heavy, _)| *heavy == dependency);
    owners.is_none_or(|(_, owners)| owners.contains(&package))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, dependencies: &[(&str, Option<&str>)]) -> Package {
        let dependency =
            |(name, kind): &(&str, Option<&str>)| Dependency { name: (*name).into(), kind: kind.map(Into::into) };
        Package { name: name.into(), dependencies: dependencies.iter().map(dependency).collect() }
    }

    fn workspace(flow: &[(&str, Option<&str>)]) -> Vec<Package> {
        let below = ["image", "gel", "touch"].map(|name| package(&format!("fingervision-{name}"), &[]));
        [package("fingervision-flow", flow)].into_iter().chain(below).collect()
    }

    #[test]
    fn what_lies_below_is_allowed() {
        let packages = workspace(&[("fingervision-image", None), ("fingervision-gel", Some("dev")), ("serde", None)]);
        assert!(faults(&packages).is_empty(), "{:?}", faults(&packages));
    }

    #[test]
    fn an_arrow_downwards_is_found() {
        assert_eq!(
            faults(&workspace(&[("fingervision-touch", None)])),
            ["flow uses touch, which is not listed for it"]
        );
        assert_eq!(faults(&workspace(&[("fingervision-touch", Some("dev"))])).len(), 1);
        assert_eq!(faults(&workspace(&[("fingervision-gel", None)])).len(), 1);
        assert_eq!(faults(&workspace(&[("fingervision-gel", Some("build"))])).len(), 1);
    }

    #[test]
    fn heavy_dependencies_stay_where_they_belong() {
        assert_eq!(faults(&workspace(&[("clap", None)])), ["flow uses clap, which belongs to another crate"]);
        assert!(faults(&workspace(&[("clap", Some("dev"))])).is_empty());
        // Ours and the one from outside share a name, but not a package.
        assert_eq!(faults(&workspace(&[("image", None)])).len(), 1);
    }

    #[test]
    fn the_examples_of_the_library_may_calibrate() {
        let with = |name: &str, kind| {
            let calibrate = package("fingervision-calibrate", &[]);
            faults(&[package(name, &[("fingervision-calibrate", kind)]), calibrate]).len()
        };
        assert_eq!(with("fingervision", Some("dev")), 0);
        assert_eq!(with("fingervision", None), 1);
        assert_eq!(with("fingervision-flow", Some("dev")), 1);
    }

    #[test]
    fn what_is_gone_is_found_in_the_tables() {
        let without_gel =
            [package("fingervision-flow", &[("rayon", None)]), package("fingervision-source", &[("tiff", None)])];
        let found = outdated(&without_gel);
        assert!(found.contains(&"gel is not a crate".into()), "{found:?}");
        assert!(found.contains(&"source may use rust_h264, but does not".into()), "{found:?}");
        assert!(!found.iter().any(|fault| fault.starts_with("flow") || fault.contains("tiff")), "{found:?}");
    }

    #[test]
    fn a_crate_without_a_layer_is_found() {
        assert_eq!(faults(&[package("fingervision-odds", &[])]), ["odds is not in the list of layers"]);
    }
}
