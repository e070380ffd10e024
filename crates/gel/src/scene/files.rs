//! The files that a scene names: finds, reads and copies them.

use std::fs;
use std::path::{Path, PathBuf};

use super::{Scene, SceneError};
use crate::{Indenter, IndenterError, IndenterRelief, IndenterShape};

impl Scene {
    /// Names of the copied height map and mesh beside the scene's file.
    pub const FILES_BESIDE: [&str; 2] = ["indenter.png", "indenter.stl"];

    /// The file that the scene needs, if it needs one.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.indenter.file()
    }

    /// The same scene with its file beside the scene's own, by one of [`Scene::FILES_BESIDE`], and the file to be copied
    /// there.
    #[must_use]
    pub fn with_file_beside(&self) -> (Self, Option<PathBuf>) {
        let mut scene = self.clone();
        let [height_map, mesh] = Self::FILES_BESIDE;
        let beside = if matches!(scene.indenter.shape, IndenterShape::Stl { .. }) { mesh } else { height_map };
        let file = file_mut(&mut scene.indenter).map(|file| std::mem::replace(file, beside.into()));
        (scene, file)
    }

    /// Makes the file's name relative to this folder.
    pub(super) fn seek_files_from(&mut self, folder: &Path) {
        if let Some(file) = file_mut(&mut self.indenter) {
            *file = folder.join(&file);
        }
    }

    /// The indenter's face, if it fits the gel.
    pub(super) fn relief(&self) -> Result<IndenterRelief, SceneError> {
        Ok(self.indenter.relief_on(&self.gel, self.motion.centre_mm, Path::new(""))?)
    }

    /// The indenter without the name of its file, and the file's content: the same body wherever its file is.
    pub(super) fn indenter_by_content(&self) -> Result<(Indenter, Vec<u8>), SceneError> {
        let mut indenter = self.indenter.clone();
        let Some(file) = file_mut(&mut indenter) else { return Ok((indenter, Vec::new())) };
        let file = std::mem::take(file);
        let unreadable = |error: std::io::Error| IndenterError::Read { file: file.clone(), kind: error.kind() };
        let content = fs::read(&file).map_err(unreadable)?;
        Ok((indenter, content))
    }
}

fn file_mut(indenter: &mut Indenter) -> Option<&mut PathBuf> {
    match &mut indenter.shape {
        IndenterShape::HeightMap { file, .. } | IndenterShape::Stl { file, .. } => Some(file),
        _ => None,
    }
}
