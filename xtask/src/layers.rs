//! `cargo xtask layers`: arrows between crates only point up the table.
//!
//! What a crate may stand on is listed in full: that `touch` may use `flow` and `flow` may use `image` does not let
//! anybody use both.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::collections::HashSet;
use std::io::Write;
use std::process::Command;

/// What a crate of the workspace may name in its dependencies, with the prefix `fingervision-` left off.
const LAYERS: [(&str, &[&str]); 14] = [
    ("image", &[]),
    ("settings", &[]),
    ("optics", &[]),
    ("elastic", &[]),
    ("flow", &["image"]),
    ("gel", &["image", "optics", "elastic", "settings"]),
    ("touch", &["image", "flow", "optics", "elastic", "settings"]),
    ("source", &["image", "gel"]),
    // A simulated press is written like a run: the same arrays, tables and pictures.
    ("sink", &["touch", "image", "flow", "gel"]),
    ("calibrate", &["touch", "sink", "elastic", "flow", "optics", "settings", "image"]),
    ("evaluate", &["touch", "gel", "calibrate", "image", "flow", "optics", "settings", "sink"]),
    ("live", &["touch", "source", "sink"]),
    ("cli", &["image", "optics", "elastic", "flow", "gel", "touch", "calibrate", "source", "sink", "evaluate", "live"]),
    ("xtask", &["evaluate", "gel", "image"]),
];

/// Tests of any crate may use simulated frames.
const FOR_TESTS: &str = "gel";

/// Heavy dependencies and the only crates that may name them outside tests.
const HEAVY: [(&str, &[&str]); 25] = [
    ("axum", &["live"]),
    ("base64", &["evaluate"]),
    ("clap", &["cli", "xtask"]),
    ("faer", &["elastic"]),
    ("image", &["source", "sink", "evaluate"]),
    ("indicatif", &["cli"]),
    ("mcap", &["source", "sink"]),
    ("minijinja", &["evaluate"]),
    ("miniz_oxide", &["gel"]),
    ("nalgebra", &["optics", "elastic", "calibrate", "evaluate"]),
    ("pdf-writer", &["gel"]),
    ("png", &["gel"]),
    ("rayon", &["elastic", "calibrate", "evaluate"]),
    ("re_mp4", &["source"]),
    ("realfft", &["elastic"]),
    ("rust_h264", &["source"]),
    ("rustfft", &["elastic"]),
    ("serde_json", &["sink", "evaluate", "live", "cli", "xtask"]),
    ("svg", &["gel"]),
    ("tiff", &["source"]),
    ("tiny-skia", &["sink"]),
    ("tokio", &["live"]),
    ("ttf-parser", &["gel", "sink"]),
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
    let faults = faults(&metadata.packages);
    for fault in &faults {
        writeln!(out, "{fault}")?;
    }
    if !faults.is_empty() {
        bail!("{} dependencies are not allowed", faults.len());
    }
    writeln!(out, "layers: {} crates stand on what lies below them", metadata.packages.len())?;
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
            faults.push(format!("{name} has no place in the layers"));
            continue;
        };
        for dependency in &package.dependencies {
            let is_for_tests = dependency.kind.as_deref() == Some("dev");
            let (is_allowed, kind) = if ours.contains(dependency.name.as_str()) {
                let below = short_name(&dependency.name);
                (allowed.contains(&below) || is_for_tests && below == FOR_TESTS, "lies not below it")
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
        assert_eq!(faults(&workspace(&[("fingervision-touch", None)])), ["flow uses touch, which lies not below it"]);
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
    fn a_crate_without_a_layer_is_found() {
        assert_eq!(faults(&[package("fingervision-odds", &[])]), ["odds has no place in the layers"]);
    }
}
