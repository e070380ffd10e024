//! The arrays of a run, one for each field. Where float32 is stated, a run of half precision has float16.

use std::path::Path;

use fingervision_image::Image;
use fingervision_touch::{Reading, TractionGrid};

use crate::float_array::FloatArray;
use crate::{ArrayWriter, Field, RunOptions, SinkError};

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
            let path = folder.join(field.file_name());
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
