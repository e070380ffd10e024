//! The folder that a run writes: arrays, the table and `run.toml`.

use std::path::{Path, PathBuf};

use fingervision_image::{Frame, Image};
use fingervision_touch::Reading;

use crate::claim::{FolderKind, write_file};
use crate::{ArrayWriter, Sink, SinkError, Table};

/// What a run consists of; `run.toml` says how it was made.
const RUN: FolderKind = FolderKind {
    noun: "run",
    marker: "run.toml",
    files: &[
        "flow.npy",
        "density.npy",
        "depth.npy",
        "deviation.npy",
        "displacement.npy",
        "traction.npy",
        "valid.npy",
        "readings.csv",
        "preview.png",
        "report.html",
    ],
    images: None,
};

/// A field that a run can keep as an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Field {
    /// Displacement, px: `flow.npy`, float32 `[frame][row][column][x, y]`.
    Flow,
    /// Density feature, dimensionless: `density.npy`, float32 `[frame][row][column]`.
    Density,
    /// Depth, mm, positive pressed in: `depth.npy`, float32 `[frame][row][column]`.
    Depth,
    /// Predicted standard deviation of the flow, px: `deviation.npy`, float32 `[frame][row][column]`.
    Deviation,
}

impl Field {
    /// Every field.
    pub const ALL: [Self; 4] = [Self::Flow, Self::Density, Self::Depth, Self::Deviation];

    /// The field's name; its file has the ending `.npy`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flow => "flow",
            Self::Density => "density",
            Self::Depth => "depth",
            Self::Deviation => "deviation",
        }
    }
}

/// What a run keeps and where it may write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunOptions {
    /// Columns and rows of every field, px.
    pub size: (usize, usize),
    /// The fields to keep; `valid.npy` (uint8, 1 where the fields hold) is always kept.
    pub fields: Vec<Field>,
    /// Whether a previous run in the folder may be replaced.
    pub overwrite: bool,
}

/// What a finished run consists of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunSummary {
    /// The folder.
    pub folder: PathBuf,
    /// Readings written.
    pub frames: u64,
    /// Size of arrays and table, bytes.
    pub bytes: u64,
}

/// A folder that takes readings, one after another, in constant memory.
///
/// After every reading the files can be read up to and including it. Should the run end between two files, one of them
/// may be a frame ahead: the shortest says how many are whole.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    size: (usize, usize),
    frames: u64,
    arrays: Arrays,
    table: Table,
}

impl RunFolder {
    /// Makes a folder ready for a run and writes `run_toml`, which says how the run is made.
    ///
    /// A folder that holds a previous run is refused, or with [`RunOptions::overwrite`] its files are removed first.
    /// A folder that holds anything else is always refused.
    ///
    /// # Errors
    ///
    /// [`SinkError::Previous`] or [`SinkError::FolderNotEmpty`] if the folder is taken, [`SinkError::Write`] if it
    /// or a file in it cannot be written.
    pub fn create(path: &Path, options: &RunOptions, run_toml: &str) -> Result<Self, SinkError> {
        RUN.claim(path, options.overwrite)?;
        write_file(&path.join(RUN.marker), run_toml.as_bytes())?;
        let arrays = Arrays::create(path, options)?;
        let table = Table::create(&path.join("readings.csv"))?;
        Ok(Self { path: path.to_path_buf(), size: options.size, frames: 0, arrays, table })
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Puts all that was written onto the disk and says what it is.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses a file.
    pub fn finish(self) -> Result<RunSummary, SinkError> {
        let bytes = self.table.len_bytes() + self.arrays.len_bytes();
        self.table.finish()?;
        self.arrays.finish()?;
        Ok(RunSummary { folder: self.path, frames: self.frames, bytes })
    }
}

impl Sink for RunFolder {
    /// Appends a reading to every file of the run; the frame is not kept.
    ///
    /// # Errors
    ///
    /// [`SinkError::SizeMismatch`] or [`SinkError::FieldAbsent`] if the reading lacks what the run keeps,
    /// [`SinkError::Write`] if a file cannot take it. The reading then is in no file.
    fn write(&mut self, reading: &Reading, _frame: &Frame) -> Result<(), SinkError> {
        self.arrays.stage(reading, self.size)?;
        self.table.write(reading)?;
        self.arrays.commit()?;
        self.frames += 1;
        Ok(())
    }
}

/// The arrays that a run keeps.
#[derive(Debug)]
struct Arrays {
    flow: Option<ArrayWriter<[f32; 2]>>,
    scalars: Vec<(Field, ArrayWriter<f32>)>,
    valid: ArrayWriter<u8>,
}

impl Arrays {
    fn create(folder: &Path, options: &RunOptions) -> Result<Self, SinkError> {
        let (width, height) = options.size;
        let (mut flow, mut scalars) = (None, Vec::new());
        for field in Field::ALL.into_iter().filter(|field| options.fields.contains(field)) {
            let path = folder.join(field.name()).with_extension("npy");
            match field {
                Field::Flow => flow = Some(ArrayWriter::create(&path, width, height)?),
                _ => scalars.push((field, ArrayWriter::create(&path, width, height)?)),
            }
        }
        let valid = ArrayWriter::create(&folder.join("valid.npy"), width, height)?;
        Ok(Self { flow, scalars, valid })
    }

    fn stage(&mut self, reading: &Reading, size: (usize, usize)) -> Result<(), SinkError> {
        if let Some(array) = &mut self.flow {
            let u = expect_size(&reading.flow.u, "flow", size)?;
            let v = expect_size(&reading.flow.v, "flow", size)?;
            array.stage(u.iter().zip(v).map(|(&u, &v)| [u, v]))?;
        }
        for (field, array) in &mut self.scalars {
            let absent = SinkError::FieldAbsent { field: field.name(), sequence: reading.sequence };
            let values = scalar(reading, *field).ok_or(absent)?;
            array.stage(expect_size(values, field.name(), size)?.iter().copied())?;
        }
        self.valid.stage(expect_size(&reading.valid, "valid", size)?.iter().copied())
    }

    fn commit(&mut self) -> Result<(), SinkError> {
        if let Some(array) = &mut self.flow {
            array.commit()?;
        }
        for (_, array) in &mut self.scalars {
            array.commit()?;
        }
        self.valid.commit()
    }

    fn len_bytes(&self) -> u64 {
        let flow = self.flow.as_ref().map_or(0, ArrayWriter::len_bytes);
        let scalars: u64 = self.scalars.iter().map(|(_, array)| array.len_bytes()).sum();
        flow + scalars + self.valid.len_bytes()
    }

    fn finish(self) -> Result<(), SinkError> {
        if let Some(array) = self.flow {
            array.finish()?;
        }
        for (_, array) in self.scalars {
            array.finish()?;
        }
        self.valid.finish()
    }
}

/// The field of one value a pixel; flow has two.
fn scalar(reading: &Reading, field: Field) -> Option<&Image<f32>> {
    match field {
        Field::Flow => None,
        Field::Density => reading.density.as_ref(),
        Field::Depth => reading.depth.as_ref(),
        Field::Deviation => Some(&reading.deviation),
    }
}

fn expect_size<'a, T>(
    image: &'a Image<T>,
    field: &'static str,
    expected: (usize, usize),
) -> Result<&'a [T], SinkError> {
    let actual = image.size();
    if actual == expected { Ok(image.values()) } else { Err(SinkError::SizeMismatch { field, expected, actual }) }
}
