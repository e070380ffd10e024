//! Another program's results.

use std::path::PathBuf;

use fingervision_image::Image;

use super::Case;
use crate::experiment::ExperimentError;
use crate::run::{LastFrame, RunError};

/// Another program that takes part: `FOLDER/<case>/depth.npy`, float32 `[frames, rows, columns]`, mm, positive pressed
/// in, on the reference grid. Its last frame is evaluated. `valid.npy`, uint8, can mark the valid pixels.
///
/// The scenes of the cases are in the benchmark's folder as `cases/<case>.toml`; `simulate` makes images of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Its name in the table.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
}

impl Entry {
    /// Depth and validity in the last frame of a case. `None` if the folder has no depth for this case.
    pub(super) fn read(&self, case: &Case) -> Result<Option<[LastFrame; 2]>, ExperimentError> {
        let folder = self.folder.join(&case.name);
        let size = (case.scene.render.width, case.scene.render.height);
        let Some(depth) = LastFrame::read::<f32>(&folder.join("depth.npy"), size)? else { return Ok(None) };
        let valid = LastFrame::read::<u8>(&folder.join("valid.npy"), size)?;
        let valid = valid.unwrap_or_else(|| LastFrame { values: Image::filled(size.0, size.1, 1.0) });
        Ok(Some([depth, valid]))
    }

    /// Checks that there is a result for at least one case.
    ///
    /// # Errors
    ///
    /// [`ExperimentError::Run`] if the folder has a result for no case.
    pub(super) fn check(&self, cases: &[Case]) -> Result<(), ExperimentError> {
        let has_any = cases.iter().any(|case| self.folder.join(&case.name).join("depth.npy").is_file());
        if has_any {
            return Ok(());
        }
        let example = cases.first().map_or("case", |case| &case.name);
        let reason = format!("it contains no result such as {example}/depth.npy");
        Err(RunError::Array {
            file: self.folder.clone(),
            reason,
            hint: "make a folder for each case, named like the scenes in the folder cases of the benchmark".into(),
        }
        .into())
    }
}
