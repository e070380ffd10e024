//! Checks that run and truth belong to the same scene.

use std::path::{Path, PathBuf};

use fingervision_settings::Document;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::RunError;

const SCENE_FILE: &str = "scene.toml";
/// The prefixes of the location of a simulated scene and of its options.
const SIMULATED: &str = "sim:";
const OPTIONS: char = '?';

/// The source in a run's `run.toml`; anything but text is ignored.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum Source {
    Described(String),
    Other(IgnoredAny),
}

#[derive(Debug, Deserialize)]
struct Scene {
    name: Option<String>,
}

/// Refuses a truth whose scene differs from the tracked one, if both are known.
pub(super) fn expect_same_scene(
    run: &Path,
    source: Option<&Source>,
    [truth, truth_folder]: [&Path; 2],
) -> Result<(), RunError> {
    let Some(Source::Described(source)) = source else { return Ok(()) };
    let truth_scene = name_in(&truth.join(SCENE_FILE)).or_else(|| name_in(&truth_folder.join("..").join(SCENE_FILE)));
    match (scene_of(source), truth_scene) {
        (Some(run_scene), Some(truth_scene)) if run_scene != truth_scene => {
            Err(RunError::OtherScene { run: run.to_owned(), run_scene, truth: truth.to_owned(), truth_scene })
        }
        _ => Ok(()),
    }
}

/// The scene that a source shows: `sim:letter?draft: 21 images, …` or `letter/frames: 21 images, …`.
fn scene_of(source: &str) -> Option<String> {
    let (location, _) = source.rsplit_once(": ")?;
    let Some(scene) = location.strip_prefix(SIMULATED) else {
        return name_in(&Path::new(location).parent()?.join(SCENE_FILE));
    };
    let scene = scene.split(OPTIONS).next()?;
    let file = PathBuf::from(scene);
    if file.extension().is_some() { name_in(&file) } else { Some(scene.into()) }
}

/// The name in a scene file; none if it cannot be read, or has none.
fn name_in(file: &Path) -> Option<String> {
    let document = Document::new("scene");
    let text = document.read(file).ok()?;
    document.parse::<Scene>(&text).ok()?.name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_of_a_source_is_known_by_its_name() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(SCENE_FILE), "name = 'mine'\n[gel]\nthickness_mm = 9").unwrap();
        let of = |location: String| scene_of(&format!("{location}: 21 images, 480x480 px 8-bit colour"));
        let root = folder.path().display();
        assert_eq!(of("sim:letter".into()).as_deref(), Some("letter"));
        assert_eq!(of("sim:letter?draft&fps=60".into()).as_deref(), Some("letter"));
        assert_eq!(of(format!("sim:{root}/scene.toml")).as_deref(), Some("mine"));
        assert_eq!(of(format!("{root}/frames")).as_deref(), Some("mine"));
        assert_eq!(of("nowhere/frames".into()), None);
    }
}
