//! Options of a run: the fields to store and their number format.

use half::f16;

use crate::Field;

/// The format of floating-point numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 4 bytes, the tracker's own precision.
    #[default]
    Float32,
    /// 2 bytes with 11 significant bits: an error of up to 1 part in 2048, so 0.004 px for a flow of 8 to 16 px.
    Float16,
}

impl Precision {
    /// Bytes of a number.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Float32 => size_of::<f32>(),
            Self::Float16 => size_of::<f16>(),
        }
    }
}

/// The fields that a run stores, their format, and whether a previous run is overwritten.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunOptions {
    /// Columns and rows of every field, px.
    pub size: (usize, usize),
    /// Columns and rows of the grid of tractions, if [`Field::Traction`] is kept.
    pub traction_size: Option<(usize, usize)>,
    /// The format of floating-point numbers.
    pub precision: Precision,
    /// The fields to keep; `valid.npy` (uint8, 1 where the fields are valid) is always kept.
    pub fields: Vec<Field>,
    /// Whether a previous run in the folder may be replaced.
    pub overwrite: bool,
}

impl RunOptions {
    /// Bytes that every frame adds to the run's arrays.
    #[must_use]
    pub fn bytes_per_frame(&self) -> u64 {
        let kept = Field::ALL.iter().filter(|field| self.fields.contains(field));
        let valid = (self.size.0 * self.size.1) as u64;
        valid + kept.map(|field| self.bytes_of(*field)).sum::<u64>()
    }

    /// Bytes that a frame of it takes.
    fn bytes_of(&self, field: Field) -> u64 {
        let count = |(columns, rows): (usize, usize)| (columns * rows) as u64;
        let number = self.precision.bytes() as u64;
        let pixels = count(self.size);
        match field {
            Field::Flow => 2 * number * pixels,
            Field::Density | Field::Depth | Field::DepthDeviation | Field::Deviation => number * pixels,
            Field::Displacement => 3 * number * pixels,
            Field::Traction => 3 * number * count(self.traction_size.unwrap_or_default()),
            Field::DepthValid | Field::Contact => pixels,
        }
    }
}
