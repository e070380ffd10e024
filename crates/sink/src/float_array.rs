//! Arrays of floating-point numbers, in single or half precision.

use std::path::Path;

use half::f16;

use crate::arrays::{ArrayWriter, Element};
use crate::{Precision, RunOptions, SinkError};

/// A pixel type that can be written in half precision.
pub(crate) trait Narrow: Element {
    type Half: Element;

    /// The nearest number of half precision.
    fn narrowed(self) -> Self::Half;
}

impl Narrow for f32 {
    type Half = f16;

    fn narrowed(self) -> f16 {
        f16::from_f32(self)
    }
}

impl<const N: usize> Narrow for [f32; N] {
    type Half = [f16; N];

    fn narrowed(self) -> [f16; N] {
        self.map(f16::from_f32)
    }
}

/// A growing array of either precision.
#[derive(Debug)]
pub(crate) enum FloatArray<T: Narrow> {
    Single(ArrayWriter<T>),
    Half(ArrayWriter<T::Half>),
}

impl<T: Narrow> FloatArray<T> {
    pub(crate) fn create(path: &Path, size: (usize, usize), options: &RunOptions) -> Result<Self, SinkError> {
        let (width, height) = size;
        Ok(match options.precision {
            Precision::Float32 => Self::Single(ArrayWriter::create(path, width, height)?),
            Precision::Float16 => Self::Half(ArrayWriter::create(path, width, height)?),
        })
    }

    pub(crate) fn stage(&mut self, pixels: impl ExactSizeIterator<Item = T>) -> Result<(), SinkError> {
        match self {
            Self::Single(array) => array.stage(pixels),
            Self::Half(array) => array.stage(pixels.map(T::narrowed)),
        }
    }

    pub(crate) fn commit(&mut self) -> Result<(), SinkError> {
        match self {
            Self::Single(array) => array.commit(),
            Self::Half(array) => array.commit(),
        }
    }

    pub(crate) fn len_bytes(&self) -> u64 {
        match self {
            Self::Single(array) => array.len_bytes(),
            Self::Half(array) => array.len_bytes(),
        }
    }

    pub(crate) fn finish(self) -> Result<(), SinkError> {
        match self {
            Self::Single(array) => array.finish(),
            Self::Half(array) => array.finish(),
        }
    }
}
