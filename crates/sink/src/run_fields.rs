//! The arrays of a run, one for each field. Where float32 is stated, a run of half precision has float16.

use std::path::Path;

use fingervision_image::Image;
use fingervision_touch::{Reading, TractionGrid};

use crate::float_array::FloatArray;
use crate::{ArrayWriter, RunOptions, SinkError};

/// A field that a run can keep as an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Field {
    /// Displacement, px: `flow.npy`, float32 `[frame][row][column][x, y]`.
    Flow,
    /// Density feature, dimensionless: `density.npy`, float32 `[frame][row][column]`.
    Density,
    /// Depth, mm, positive pressed in: `depth.npy`, float32 `[frame][row][column]`.
    Depth,
    /// 1 where an elastic depth is valid, and contact and displacement with it: `depth_valid.npy`, uint8
    /// `[frame][row][column]`. If it is written, `valid.npy` refers only to flow and density.
    DepthValid,
    /// Expected error of an elastic depth, mm, infinite where it is not valid: `depth_deviation.npy`, float32
    /// `[frame][row][column]`.
    DepthDeviation,
    /// 1 where the gel touches something: `contact.npy`, uint8 `[frame][row][column]`.
    Contact,
    /// Displacement in gel space, mm: `displacement.npy`, float32 `[frame][row][column][x, y, z]`.
    Displacement,
    /// Traction on the gel, `MPa`: `traction.npy`, float32 `[frame][row][column][x, y, z]` on a grid of its own, in mm over
    /// the undeformed surface.
    Traction,
    /// Predicted standard deviation of the flow, px: `deviation.npy`, float32 `[frame][row][column]`.
    Deviation,
}

impl Field {
    /// Every field.
    pub const ALL: [Self; 9] = [
        Self::Flow,
        Self::Density,
        Self::Depth,
        Self::DepthValid,
        Self::DepthDeviation,
        Self::Contact,
        Self::Displacement,
        Self::Traction,
        Self::Deviation,
    ];

    /// The field's name; its file has the extension `.npy`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flow => "flow",
            Self::Density => "density",
            Self::Depth => "depth",
            Self::DepthValid => "depth_valid",
            Self::DepthDeviation => "depth_deviation",
            Self::Contact => "contact",
            Self::Displacement => "displacement",
            Self::Traction => "traction",
            Self::Deviation => "deviation",
        }
    }

    /// Bytes that a frame of it takes in a run.
    fn bytes_per_frame(self, options: &RunOptions) -> u64 {
        let count = |(columns, rows): (usize, usize)| (columns * rows) as u64;
        let number = options.precision.bytes() as u64;
        let pixels = count(options.size);
        match self {
            Self::Flow => 2 * number * pixels,
            Self::Density | Self::Depth | Self::DepthDeviation | Self::Deviation => number * pixels,
            Self::Displacement => 3 * number * pixels,
            Self::Traction => 3 * number * count(options.traction_size.unwrap_or_default()),
            Self::DepthValid | Self::Contact => pixels,
        }
    }

    /// Whether readings with these fields contain it.
    #[must_use]
    pub fn is_in(self, reading: &Reading) -> bool {
        match self {
            Self::Flow | Self::Deviation => true,
            Self::Density => reading.density.is_some(),
            Self::Depth => reading.depth.is_some(),
            Self::DepthValid | Self::DepthDeviation => reading.depth_deviation.is_some(),
            Self::Contact => reading.contact.is_some(),
            Self::Displacement => reading.displacement.is_some(),
            Self::Traction => reading.traction.is_some(),
        }
    }
}

impl RunOptions {
    /// Bytes that every frame adds to the run's arrays.
    #[must_use]
    pub fn bytes_per_frame(&self) -> u64 {
        let kept = Field::ALL.iter().filter(|field| self.fields.contains(field));
        let valid = (self.size.0 * self.size.1) as u64;
        valid + kept.map(|field| field.bytes_per_frame(self)).sum::<u64>()
    }
}

/// The arrays that a run keeps.
#[derive(Debug)]
pub(crate) struct RunFields {
    size: (usize, usize),
    traction_size: (usize, usize),
    flow: Option<FloatArray<[f32; 2]>>,
    scalars: Vec<(Field, FloatArray<f32>)>,
    vectors: Vec<(Field, FloatArray<[f32; 3]>)>,
    masks: Vec<(Field, ArrayWriter<u8>)>,
    valid: ArrayWriter<u8>,
}

impl RunFields {
    pub(crate) fn create(folder: &Path, options: &RunOptions) -> Result<Self, SinkError> {
        let (width, height) = options.size;
        let traction_size = options.traction_size.unwrap_or_default();
        let valid = ArrayWriter::create(&folder.join("valid.npy"), width, height)?;
        let (scalars, vectors, masks) = (Vec::new(), Vec::new(), Vec::new());
        let mut arrays = Self { size: options.size, traction_size, flow: None, scalars, vectors, masks, valid };
        for field in Field::ALL.into_iter().filter(|field| options.fields.contains(field)) {
            let path = folder.join(field.name()).with_extension("npy");
            match field {
                Field::Flow => arrays.flow = Some(FloatArray::create(&path, options.size, options)?),
                Field::Density | Field::Depth | Field::DepthDeviation | Field::Deviation => {
                    arrays.scalars.push((field, FloatArray::create(&path, options.size, options)?));
                }
                Field::DepthValid | Field::Contact => {
                    arrays.masks.push((field, ArrayWriter::create(&path, width, height)?));
                }
                Field::Displacement => {
                    arrays.vectors.push((field, FloatArray::create(&path, options.size, options)?));
                }
                Field::Traction => arrays.vectors.push((field, FloatArray::create(&path, traction_size, options)?)),
            }
        }
        Ok(arrays)
    }

    /// Appends a reading to every array; [`RunFields::commit`] counts it.
    ///
    /// # Errors
    ///
    /// [`SinkError::FieldAbsent`] or [`SinkError::SizeMismatch`] if the reading lacks what the run keeps,
    /// [`SinkError::Write`] if a file cannot take it.
    pub(crate) fn stage(&mut self, reading: &Reading) -> Result<(), SinkError> {
        let size = self.size;
        if let Some(field) = self.fields().find(|field| !field.is_in(reading)) {
            return Err(SinkError::FieldAbsent { field: field.name(), sequence: reading.sequence });
        }
        if let Some(array) = &mut self.flow {
            let u = expect_size(&reading.flow.u, "flow", size)?;
            let v = expect_size(&reading.flow.v, "flow", size)?;
            array.stage(u.iter().zip(v).map(|(&u, &v)| [u, v]))?;
        }
        for (field, array) in &mut self.scalars {
            if let Some(values) = scalar(reading, *field) {
                array.stage(expect_size(values, field.name(), size)?.iter().copied())?;
            }
        }
        for (field, array) in &mut self.vectors {
            match (field, &reading.displacement, &reading.traction) {
                (Field::Traction, _, Some(grid)) => stage_traction(array, grid, self.traction_size)?,
                (_, Some(displacement), _) => stage_displacement(array, displacement, size)?,
                _ => {}
            }
        }
        for (field, array) in &mut self.masks {
            let field = *field;
            match (field, &reading.contact, &reading.depth_deviation) {
                (Field::DepthValid, _, Some(deviation)) => {
                    let deviation = expect_size(deviation, field.name(), size)?;
                    array.stage(deviation.iter().map(|deviation| u8::from(deviation.is_finite())))?;
                }
                (_, Some(contact), _) => array.stage(expect_size(contact, field.name(), size)?.iter().copied())?,
                _ => {}
            }
        }
        self.valid.stage(expect_size(&reading.valid, "valid", size)?.iter().copied())
    }

    /// Counts the staged frame.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if a header cannot be rewritten.
    pub(crate) fn commit(&mut self) -> Result<(), SinkError> {
        self.flow.iter_mut().try_for_each(FloatArray::commit)?;
        self.scalars.iter_mut().try_for_each(|(_, array)| array.commit())?;
        self.vectors.iter_mut().try_for_each(|(_, array)| array.commit())?;
        self.masks.iter_mut().try_for_each(|(_, array)| array.commit())?;
        self.valid.commit()
    }

    /// Bytes of all files.
    pub(crate) fn len_bytes(&self) -> u64 {
        let flow = self.flow.as_ref().map_or(0, FloatArray::len_bytes);
        let scalars: u64 = self.scalars.iter().map(|(_, array)| array.len_bytes()).sum();
        let vectors: u64 = self.vectors.iter().map(|(_, array)| array.len_bytes()).sum();
        let masks: u64 = self.masks.iter().map(|(_, array)| array.len_bytes()).sum();
        flow + scalars + vectors + masks + self.valid.len_bytes()
    }

    /// Flushes everything to the disk.
    ///
    /// # Errors
    ///
    /// [`SinkError::Write`] if the disk refuses a file.
    pub(crate) fn finish(self) -> Result<(), SinkError> {
        self.flow.into_iter().try_for_each(FloatArray::finish)?;
        self.scalars.into_iter().try_for_each(|(_, array)| array.finish())?;
        self.vectors.into_iter().try_for_each(|(_, array)| array.finish())?;
        self.masks.into_iter().try_for_each(|(_, array)| array.finish())?;
        self.valid.finish()
    }

    /// The fields that are kept, except the flow, which every reading has.
    fn fields(&self) -> impl Iterator<Item = Field> {
        let scalars = self.scalars.iter().map(|(field, _)| *field);
        scalars.chain(self.vectors.iter().map(|(field, _)| *field)).chain(self.masks.iter().map(|(field, _)| *field))
    }
}

/// The field of one number per pixel.
fn scalar(reading: &Reading, field: Field) -> Option<&Image<f32>> {
    match field {
        Field::Density => reading.density.as_ref(),
        Field::Depth => reading.depth.as_ref(),
        Field::DepthDeviation => reading.depth_deviation.as_ref(),
        Field::Deviation => Some(&reading.deviation),
        Field::Flow | Field::DepthValid | Field::Contact | Field::Displacement | Field::Traction => None,
    }
}

fn stage_displacement(
    array: &mut FloatArray<[f32; 3]>,
    displacement: &[Image<f32>; 3],
    size: (usize, usize),
) -> Result<(), SinkError> {
    let [x, y, z] = displacement;
    let x = expect_size(x, "displacement", size)?;
    let y = expect_size(y, "displacement", size)?;
    let z = expect_size(z, "displacement", size)?;
    array.stage(x.iter().zip(y).zip(z).map(|((&x, &y), &z)| [x, y, z]))
}

fn stage_traction(
    array: &mut FloatArray<[f32; 3]>,
    grid: &TractionGrid,
    expected: (usize, usize),
) -> Result<(), SinkError> {
    let actual = (grid.columns, grid.rows);
    if actual != expected {
        return Err(SinkError::SizeMismatch { field: "traction", expected, actual });
    }
    array.stage(grid.traction_mpa.iter().copied())
}

fn expect_size<'a, T>(
    image: &'a Image<T>,
    field: &'static str,
    expected: (usize, usize),
) -> Result<&'a [T], SinkError> {
    let actual = image.size();
    if actual == expected { Ok(image.values()) } else { Err(SinkError::SizeMismatch { field, expected, actual }) }
}
