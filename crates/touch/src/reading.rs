//! The reading: everything that is computed from one frame.

use std::ops::Deref;

use fingervision_flow::FlowField;
use fingervision_image::Image;

use crate::{ReadingNumbers, TractionGrid};

/// Every quantity computed from one frame. All fields lie on the reference grid.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Reading {
    /// Everything that belongs to the whole frame; `reading.force_n` is short for `reading.numbers.force_n`.
    pub numbers: ReadingNumbers,
    /// Displacement, px.
    pub flow: FlowField,
    /// Predicted standard deviation of the flow, px; infinite where there is no measurement.
    pub deviation: Image<f32>,
    /// 1 where the flow, the density and a depth from density are valid; 0 elsewhere. It does not apply to elastic
    /// depth, which is valid where [`Reading::depth_deviation`] is finite, even if the flow is not valid there.
    pub valid: Image<u8>,
    /// Density feature `1 − density` after the guided filter, dimensionless, 0 at rest, positive where the surface
    /// expands, 0 where it is not valid; if requested.
    pub density: Option<Image<f32>>,
    /// Depth, mm, positive pressed in; if requested and the profile is calibrated.
    pub depth: Option<Image<f32>>,
    /// Expected error of an elastic depth (one standard deviation), mm; infinite where depth is not valid: beside the
    /// gel, and everywhere in a frame that is lost or does not fit the gel. Elsewhere depth is valid, even if the flow
    /// is not.
    pub depth_deviation: Option<Image<f32>>,
    /// 1 where the gel touches something; with elastic depth.
    pub contact: Option<Image<u8>>,
    /// Displacement `(x, y, z)` in gel space, mm; if requested, with elastic depth.
    pub displacement: Option<[Image<f32>; 3]>,
    /// Traction on the gel, `MPa`; if requested, with elastic depth and a known Young's modulus.
    pub traction: Option<TractionGrid>,
}

impl Reading {
    /// A reading at rest on a reference grid of this size, without the fields that have to be requested. Readings come
    /// from a tracker; this one is for tests of code that takes readings.
    #[must_use]
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            numbers: ReadingNumbers::default(),
            flow: FlowField::zero(width, height),
            deviation: Image::filled(width, height, f32::INFINITY),
            valid: Image::filled(width, height, 0),
            density: None,
            depth: None,
            depth_deviation: None,
            contact: None,
            displacement: None,
            traction: None,
        }
    }

    /// Whether both have the same fields of the same sizes.
    pub(crate) fn has_the_fields_of(&self, other: &Self) -> bool {
        let traction = |reading: &Self| reading.traction.as_ref().map(|grid| (grid.columns, grid.rows));
        let floats = |reading: &Self| {
            [&reading.density, &reading.depth, &reading.depth_deviation].map(|field| size_of_field(field.as_ref()))
        };
        self.flow.size() == other.flow.size()
            && floats(self) == floats(other)
            && size_of_field(self.contact.as_ref()) == size_of_field(other.contact.as_ref())
            && self.displacement.is_some() == other.displacement.is_some()
            && traction(self) == traction(other)
    }

    /// Takes over all values of `other`; allocates nothing if both are readings of the same tracker.
    pub fn copy_from(&mut self, other: &Self) {
        self.numbers = other.numbers;
        self.flow.copy_from(&other.flow);
        self.deviation.copy_from(&other.deviation);
        self.valid.copy_from(&other.valid);
        copy_image(&mut self.density, other.density.as_ref());
        copy_image(&mut self.depth, other.depth.as_ref());
        copy_image(&mut self.depth_deviation, other.depth_deviation.as_ref());
        copy_image(&mut self.contact, other.contact.as_ref());
        match (&mut self.displacement, &other.displacement) {
            (Some(to), Some(from)) => to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from(from)),
            (to, from) => to.clone_from(from),
        }
        match (&mut self.traction, &other.traction) {
            (Some(to), Some(from)) => {
                (to.columns, to.rows, to.cell_mm) = (from.columns, from.rows, from.cell_mm);
                to.traction_mpa.clone_from(&from.traction_mpa);
            }
            (to, from) => to.clone_from(from),
        }
    }
}

impl Deref for Reading {
    type Target = ReadingNumbers;

    fn deref(&self) -> &ReadingNumbers {
        &self.numbers
    }
}

fn size_of_field<T>(field: Option<&Image<T>>) -> Option<(usize, usize)> {
    field.map(Image::size)
}

fn copy_image<T: Clone>(to: &mut Option<Image<T>>, from: Option<&Image<T>>) {
    match (to, from) {
        (Some(to), Some(from)) => to.copy_from(from),
        (to, from) => *to = from.cloned(),
    }
}
