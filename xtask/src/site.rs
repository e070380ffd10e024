//! `cargo xtask site`: builds the documentation as a site with `MkDocs`, in the target folder.
//!
//! `docs/site/` has its settings and the program that collects its pages. The build fails if a link or an anchor leads
//! nowhere, if a page is missing in the navigation, or if a page loads anything from another server.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::environment::Interpreter;

const MKDOCS: [&str; 2] = ["mkdocs>=1.6,<2", "mkdocs-material>=9.6,<10"];
/// Elements that load something when a page opens, and the attribute that says what.
const LOADING: [(&str, &str); 7] = [
    ("<script", "src="),
    ("<img", "src="),
    ("<iframe", "src="),
    ("<source", "src="),
    ("<video", "src="),
    ("<link", "href="),
    ("<object", "data="),
];

/// Options of the site.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Fail instead of skipping the site where Python or packages are missing.
    #[arg(long)]
    required: bool,
}

pub(crate) fn run(args: &Args, out: &mut impl Write) -> Result<()> {
    let folder = crate::target_folder().join("site");
    let python = Interpreter::find().and_then(|python| python.environment(&folder.join("tools"), &MKDOCS, &[]));
    let Some(python) = crate::unless_missing("site", python, args.required, out)? else { return Ok(()) };
    let pages = folder.join("pages");
    let mut mkdocs = Command::new(python);
    mkdocs.args(["-m", "mkdocs", "build", "--strict", "--site-dir"]).arg(&pages);
    // Without these Python writes beside the sources, and Material for MkDocs advertises its successor.
    mkdocs.envs([("PYTHONDONTWRITEBYTECODE", "1"), ("NO_MKDOCS_2_WARNING", "1")]);
    let status = mkdocs.current_dir(crate::workspace().join("docs/site")).status().context("MkDocs cannot be run")?;
    ensure!(status.success(), "the site has faults");
    let files = files_in(&pages)?;
    for file in &files {
        expect_local(file)?;
    }
    let count = files.iter().filter(|file| has_extension(file, "html")).count();
    writeln!(out, "site: {count} pages, {}", pages.join("index.html").display())?;
    Ok(())
}

/// All files in a folder and in those inside it.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(files_in(&path)?);
        } else {
            files.push(path);
        }
    }
    Ok(files)
}

/// Fails if a page or a style sheet loads something from another server.
fn expect_local(file: &Path) -> Result<()> {
    let is_page = has_extension(file, "html");
    if !is_page && !has_extension(file, "css") {
        return Ok(());
    }
    let text = fs::read_to_string(file)?;
    let foreign = if is_page { loaded_by_page(&text) } else { loaded_by_style(&text) };
    ensure!(foreign.is_none(), "{} loads {} from another server", file.display(), foreign.unwrap_or_default());
    Ok(())
}

fn loaded_by_page(text: &str) -> Option<&str> {
    LOADING.iter().find_map(|(element, attribute)| {
        let mut elements = text.split(element).skip(1).filter_map(|rest| rest.split('>').next());
        elements.find_map(|inside| {
            let address = inside.split(attribute).nth(1)?.trim_start_matches(['"', '\'']);
            is_foreign(address).then(|| address.split(['"', '\'', ' ']).next().unwrap_or(address))
        })
    })
}

fn loaded_by_style(text: &str) -> Option<&str> {
    let mut addresses = text.split("url(").skip(1).map(|rest| rest.trim_start_matches(['"', '\'']));
    addresses
        .find(|address| is_foreign(address))
        .map(|address| address.split([')', '"', '\'']).next().unwrap_or(address))
}

fn is_foreign(address: &str) -> bool {
    ["http:", "https:", "//"].iter().any(|scheme| address.starts_with(scheme))
}

fn has_extension(file: &Path, wanted: &str) -> bool {
    file.extension().is_some_and(|extension| extension == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_page_loads_from_another_server_is_found() {
        let local = r#"<a href="https://a.org">a</a><script src="b.js"></script><link rel="icon" href="../c.png">"#;
        assert_eq!(loaded_by_page(local), None);
        let page = |element: &str| loaded_by_page(&format!("{local}{element}")).map(str::to_owned);
        assert_eq!(
            page(r#"<link rel="stylesheet" href="https://f.org/i.css">"#).as_deref(),
            Some("https://f.org/i.css")
        );
        assert_eq!(page(r"<img alt=x src=//f.org/p.png >").as_deref(), Some("//f.org/p.png"));
        assert_eq!(page(r"<script async src='http://f.org/s.js'>").as_deref(), Some("http://f.org/s.js"));
    }

    #[test]
    fn what_a_style_loads_from_another_server_is_found() {
        assert_eq!(loaded_by_style("a { b: url(c.png) } /* https://d.org */"), None);
        assert_eq!(loaded_by_style("@import url('https://d.org/e.css');"), Some("https://d.org/e.css"));
    }
}
