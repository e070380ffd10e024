//! The arrays of a folder, read side by side.

use std::path::{Path, PathBuf};

use fingervision_sink::Field;

use super::RunError;
use super::array::FrameArray;

/// The fields that can be compared.
const COMPARED: [Field; 4] = [Field::Flow, Field::Depth, Field::Displacement, Field::Contact];

/// The file of [`Fields::depth_mask`].
pub(super) const DEPTH_MASK: &str = Field::DepthValid.file_name();

/// The arrays of a run or of a truth; those that the folder lacks are absent.
#[derive(Debug)]
pub(super) struct Fields {
    /// Flow `(x, y)`, px.
    pub(super) flow: Option<FrameArray<f32>>,
    /// Depth, mm, positive pressed in.
    pub(super) depth: Option<FrameArray<f32>>,
    /// Displacement `(x, y, z)` in gel space, mm.
    pub(super) displacement: Option<FrameArray<f32>>,
    /// 1 where the gel is touched.
    pub(super) contact: Option<FrameArray<u8>>,
    /// 1 where the fields are valid: `valid.npy` of a run, `visible.npy` of a truth.
    pub(super) mask: Option<FrameArray<u8>>,
    /// 1 where depth, displacement and contact are valid, if this differs from the flow: `depth_valid.npy` of a run.
    pub(super) depth_mask: Option<FrameArray<u8>>,
}

impl Fields {
    /// Opens the arrays of the folder.
    pub(super) fn open(folder: &Path, mask: &str) -> Result<Self, RunError> {
        let file = |field: Field| folder.join(field.file_name());
        let fields = Self {
            flow: FrameArray::open(&file(Field::Flow), 2)?,
            depth: FrameArray::open(&file(Field::Depth), 1)?,
            displacement: FrameArray::open(&file(Field::Displacement), 3)?,
            contact: FrameArray::open(&file(Field::Contact), 1)?,
            mask: FrameArray::open(&folder.join(mask), 1)?,
            depth_mask: FrameArray::open(&folder.join(DEPTH_MASK), 1)?,
        };
        let sizes = fields.sizes();
        if let [(first, (columns, rows)), ..] = sizes[..]
            && let Some((other, (width, height))) = sizes.iter().find(|(_, size)| *size != (columns, rows))
        {
            let reason = format!("it has {width}x{height} px, but {} has {columns}x{rows} px", first.display());
            let hint = "all arrays of a folder lie on one grid".into();
            return Err(RunError::Array { file: (*other).to_owned(), reason, hint });
        }
        Ok(fields)
    }

    /// Columns and rows of all arrays, px.
    pub(super) fn size(&self) -> (usize, usize) {
        self.sizes().first().map_or((0, 0), |(_, size)| *size)
    }

    /// Every file and its number of frames.
    pub(super) fn frame_counts(&self) -> Vec<(PathBuf, u64)> {
        let numbers = self.numbers().map(|array| (array.path().to_owned(), array.frames()));
        numbers.chain(self.masks().map(|array| (array.path().to_owned(), array.frames()))).collect()
    }

    /// The fields that are present, in the order of [`COMPARED`].
    fn presence(&self) -> [bool; 4] {
        [self.flow.is_some(), self.depth.is_some(), self.displacement.is_some(), self.contact.is_some()]
    }

    /// The names of the fields that are present, separated by commas.
    pub(super) fn names(&self) -> String {
        let present =
            COMPARED.iter().zip(self.presence()).filter(|(_, is_here)| *is_here).map(|(field, _)| field.name());
        present.collect::<Vec<_>>().join(", ")
    }

    /// Reads the next frame of every array.
    pub(super) fn advance(&mut self) -> Result<(), RunError> {
        let numbers = [&mut self.flow, &mut self.depth, &mut self.displacement];
        numbers.into_iter().flatten().try_for_each(FrameArray::advance)?;
        [&mut self.contact, &mut self.mask, &mut self.depth_mask]
            .into_iter()
            .flatten()
            .try_for_each(FrameArray::advance)
    }

    fn sizes(&self) -> Vec<(&Path, (usize, usize))> {
        let numbers = self.numbers().map(|array| (array.path(), array.size()));
        numbers.chain(self.masks().map(|array| (array.path(), array.size()))).collect()
    }

    fn numbers(&self) -> impl Iterator<Item = &FrameArray<f32>> {
        [&self.flow, &self.depth, &self.displacement].into_iter().flatten()
    }

    fn masks(&self) -> impl Iterator<Item = &FrameArray<u8>> {
        [&self.contact, &self.mask, &self.depth_mask].into_iter().flatten()
    }
}
