//! `cargo xtask circles`: modules of the same folder must not import each other in a circle.
//!
//! A module is a file with all that lies in its folder. For every folder the imports between its modules are followed,
//! by `use` and by paths that begin with `crate` or `super`; names that a module re-exports lead to where they are.
//! Paths in attributes count, for example in attributes of serde. Tests are left out, and so are items that a module
//! imports from its parent itself.

use anyhow::{Context, Result, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path as FilePath, PathBuf};

/// A module or an item in one, from the crate's root.
type Path = Vec<String>;

pub(crate) fn run(out: &mut impl Write) -> Result<()> {
    let crates = crate::workspace().join("crates");
    let mut folders: Vec<PathBuf> =
        fs::read_dir(&crates)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    folders.push(crate::workspace().join("python"));
    folders.sort();
    let mut faults = Vec::new();
    for folder in folders {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut sources = BTreeMap::new();
        collect(&folder.join("src"), &Path::new(), &mut sources)?;
        for (parent, circle) in Modules::of(&sources).circles() {
            faults.push(format!(
                "{}: {}",
                [name.as_str(), &parent].join("::").trim_end_matches(':'),
                circle.join(", ")
            ));
        }
    }
    if !faults.is_empty() {
        bail!("files that import each other in a circle: {}", faults.join("; "));
    }
    writeln!(out, "circles: none")?;
    Ok(())
}

/// Reads all modules below a folder, without their tests.
fn collect(folder: &FilePath, parent: &Path, sources: &mut BTreeMap<Path, String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let file = entry?.path();
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let module = [parent.clone(), vec![name.clone()]].concat();
        if name.starts_with("tests") {
            continue;
        }
        if file.is_dir() {
            collect(&file, &module, sources)?;
        } else if file.extension().is_some_and(|extension| extension == "rs") {
            let is_of_folder = ["lib", "main", "mod"].contains(&name.as_str());
            let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
            sources.insert(if is_of_folder { parent.clone() } else { module }, text);
        }
    }
    Ok(())
}

/// The modules of a crate, what each imports and what each re-exports.
#[derive(Debug, Default)]
struct Modules {
    imports: BTreeMap<Path, Vec<Path>>,
    names: BTreeMap<Path, Path>,
}

impl Modules {
    fn of(sources: &BTreeMap<Path, String>) -> Self {
        let mut modules = Self::default();
        for (module, text) in sources {
            let code = without_tests(text);
            let mut imports = Vec::new();
            for tree in uses(&code) {
                for path in leaves(&tree) {
                    let Some(full) = absolute(&path, module, sources) else { continue };
                    if let Some(name) = path.last().filter(|name| *name != "self" && *name != "*") {
                        modules.names.insert([module.clone(), vec![name.clone()]].concat(), full.clone());
                    }
                    imports.push(full);
                }
            }
            imports.extend(paths(&code).iter().filter_map(|path| absolute(path, module, sources)));
            modules.imports.insert(module.clone(), imports);
        }
        modules
    }

    /// The module in which something lies, through re-exports.
    fn home(&self, path: &Path) -> Path {
        let mut path = path.clone();
        // A name that leads back to itself ends here.
        for _ in 0..8 {
            let known = (1..=path.len()).rev().find(|&len| self.imports.contains_key(&path[..len]));
            let from = known.map_or(1, |len| len + 1);
            let Some(name) = (from..=path.len()).rev().find(|&len| self.names.contains_key(&path[..len])) else {
                break;
            };
            path = [self.names[&path[..name]].clone(), path[name..].to_vec()].concat();
        }
        let len = (0..=path.len()).rev().find(|&len| self.imports.contains_key(&path[..len])).unwrap_or(0);
        path[..len].to_vec()
    }

    /// Every circle: the module in which it is, and its members.
    fn circles(&self) -> Vec<(String, Vec<String>)> {
        let mut edges: BTreeMap<Path, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        for (from, imports) in &self.imports {
            for to in imports.iter().map(|import| self.home(import)) {
                let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
                if let (Some(a), Some(b)) = (from.get(shared), to.get(shared)) {
                    let beside = edges.entry(from[..shared].to_vec()).or_default();
                    beside.entry(a.clone()).or_default().insert(b.clone());
                }
            }
        }
        edges.iter().flat_map(|(parent, edges)| in_circles(edges).into_iter().map(|c| (parent.join("::"), c))).collect()
    }
}

/// The groups whose members all lead to each other.
fn in_circles(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reached = |from: &String| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(at) = next.pop() {
            next.extend(edges.get(at).into_iter().flatten().filter(|&to| reached.insert(to.clone())));
        }
        reached
    };
    let reached: BTreeMap<&String, BTreeSet<String>> = edges.keys().map(|from| (from, reached(from))).collect();
    let mut groups = BTreeSet::new();
    for (from, there) in &reached {
        let back = |to: &&String| reached.get(*to).is_some_and(|back| back.contains(*from));
        if there.contains(*from) {
            groups.insert(there.iter().filter(back).cloned().collect::<Vec<_>>());
        }
    }
    groups.into_iter().collect()
}

/// The code of a file up to its tests, without comments.
fn without_tests(text: &str) -> String {
    let code = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let is_code = |line: &&str| !line.trim_start().starts_with("//");
    code.lines().filter(is_code).fold(String::new(), |all, line| all + line + "\n")
}

/// The text between `use` and its semicolon.
fn uses(code: &str) -> Vec<String> {
    let is_start = |line: &&str| {
        let line = line.trim_start();
        let public = line.strip_prefix("pub").map_or(line, |rest| rest.split_once(' ').map_or("", |(_, rest)| rest));
        public.starts_with("use ")
    };
    let starts = code.lines().filter(is_start).map(|line| line.as_ptr().addr() - code.as_ptr().addr());
    let tree = |at: usize| Some(code[at..].split_once("use ")?.1.split(';').next()?.split_whitespace().collect());
    starts.filter_map(tree).collect()
}

/// The paths of a tree of imports: `a::{b, c}` has two.
fn leaves(tree: &str) -> Vec<Path> {
    let split = |path: &str| path.split("::").filter(|part| !part.is_empty()).map(String::from).collect::<Path>();
    let Some((before, rest)) = tree.split_once('{') else { return vec![split(tree)] };
    let inside = rest.strip_suffix('}').unwrap_or(rest);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for letter in inside.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        match parts.last_mut() {
            Some(part) if letter != ',' || depth > 0 => part.push(letter),
            _ => parts.push(String::new()),
        }
    }
    let parts = parts.iter().filter(|part| !part.is_empty());
    parts.flat_map(|part| leaves(part)).map(|leaf| [split(before), leaf].concat()).collect()
}

/// The paths outside of imports that begin with `crate` or `super`.
fn paths(code: &str) -> Vec<Path> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = code.split(|letter: char| !is_part(letter));
    let ours = words.filter(|word| word.starts_with("crate::") || word.starts_with("super::"));
    ours.map(|word| word.split("::").filter(|part| !part.is_empty()).map(String::from).collect()).collect()
}

/// A path from the crate's root; none if it leads out of the crate.
fn absolute(path: &Path, module: &Path, sources: &BTreeMap<Path, String>) -> Option<Path> {
    let first = path.first()?.as_str();
    let ups = path.iter().take_while(|part| *part == "super").count();
    match first {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([module.as_slice(), &path[1..]].concat()),
        "super" => Some([module.get(..module.len().checked_sub(ups)?)?, &path[ups..]].concat()),
        _ => {
            let full = [module.as_slice(), path].concat();
            sources.contains_key(&full[..=module.len()]).then_some(full)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles(files: &[(&str, &str)]) -> Vec<(String, Vec<String>)> {
        let path = |name: &str| name.split("::").filter(|part| !part.is_empty()).map(String::from).collect::<Path>();
        Modules::of(&files.iter().map(|(name, text)| (path(name), (*text).into())).collect()).circles()
    }

    #[test]
    fn a_circle_through_a_name_of_the_parent_is_found() {
        let found = circles(&[
            ("", "mod a;\nmod b;\npub use a::{First, Other};\n"),
            ("a", "use crate::b::Second;\n"),
            ("b", "use crate::{\n    First,\n};\n"),
        ]);
        assert_eq!(found, [(String::new(), vec!["a".into(), "b".into()])]);
    }

    #[test]
    fn a_circle_through_an_attribute_is_found() {
        let found = circles(&[
            ("", "mod a;\nmod b;\n"),
            ("a", "#[derive(Serialize)]\n#[serde(into = \"super::b::Table\")]\npub struct First;\n"),
            ("b", "use super::a::First;\n"),
        ]);
        assert_eq!(found, [(String::new(), vec!["a".into(), "b".into()])]);
    }

    #[test]
    fn folders_count_as_one_and_tests_do_not() {
        let files = [
            ("", "mod a;\nmod b;\n"),
            ("a", "mod inner;\n"),
            ("a::inner", "fn f() { super::super::b::g(); }\n"),
            ("b", "\n#[cfg(test)]\nmod tests {\n    use crate::a::inner;\n}\n"),
        ];
        assert!(circles(&files).is_empty());
        let back = [files[0], files[1], files[2], ("b", "pub(crate) use crate::a::inner;\n")];
        assert_eq!(circles(&back).len(), 1);
    }
}
