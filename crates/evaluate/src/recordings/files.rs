//! Reads the file formats of the recordings.

use crate::EvaluateError;
use crate::run::NpyHeader;
use fingervision_flow::FlowField;
use fingervision_image::{Image, Pixels};
use half::f16;
use image::DynamicImage;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// First bytes of a Middlebury flow file.
const FLO_SIGNATURE: &[u8] = b"PIEH";

/// A grey or colour image of 8 bits per channel, or a grey image of 16 bits.
pub(super) fn pixels(file: &Path) -> Result<Pixels, EvaluateError> {
    let image = image::open(file).map_err(|error| EvaluateError::file(file, error.to_string()))?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(match image {
        DynamicImage::ImageLuma8(image) => Pixels::Grey8(Image::from_vec(width, height, image.into_raw())?),
        DynamicImage::ImageLuma16(image) => Pixels::Grey16(Image::from_vec(width, height, image.into_raw())?),
        image => {
            let colours = image.into_rgb8().as_chunks().0.to_vec();
            Pixels::Rgb8(Image::from_vec(width, height, colours)?)
        }
    })
}

/// The pixels in which an 8-bit grey image is above mid-grey.
pub(super) fn mask(file: &Path) -> Result<Image<bool>, EvaluateError> {
    match pixels(file)? {
        Pixels::Grey8(image) => {
            let is_in = image.values().iter().map(|&level| level > 127).collect();
            Ok(Image::from_vec(image.width(), image.height(), is_in)?)
        }
        _ => Err(EvaluateError::file(file, "a mask is 8-bit grey")),
    }
}

/// The values of a 16-bit image.
pub(super) fn values_16(file: &Path) -> Result<Image<u16>, EvaluateError> {
    match pixels(file)? {
        Pixels::Grey16(image) => Ok(image),
        _ => Err(EvaluateError::file(file, "not a 16-bit grey image")),
    }
}

/// The rows of numbers of a comma-separated file; a header line is skipped.
pub(super) fn numbers(file: &Path) -> Result<Vec<Vec<f64>>, EvaluateError> {
    let reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_path(file);
    let rows = reader.and_then(|reader| {
        let rows = reader.into_deserialize().enumerate();
        rows.filter(|(number, row)| *number > 0 || row.is_ok()).map(|(_, row)| row).collect()
    });
    rows.map_err(|error| EvaluateError::file(file, error.to_string()))
}

/// A Middlebury flow file: "PIEH", width and height, then u and v of every pixel, all little-endian in four bytes.
/// Unknown flow is above 1e9.
pub(super) fn flow(file: &Path) -> Result<FlowField, EvaluateError> {
    let bytes = fs::read(file).map_err(|error| EvaluateError::file(file, error.to_string()))?;
    parse_flow(&bytes).ok_or_else(|| EvaluateError::file(file, "not a whole flow file"))
}

fn parse_flow(bytes: &[u8]) -> Option<FlowField> {
    let words = bytes.strip_prefix(FLO_SIGNATURE)?.as_chunks::<4>().0;
    let size = |word: &[u8; 4]| usize::try_from(i32::from_le_bytes(*word)).ok();
    let (width, height) = (size(words.first()?)?, size(words.get(1)?)?);
    let plane = |component: usize| {
        let values = words[2..].iter().skip(component).step_by(2).map(|word| f32::from_le_bytes(*word));
        Image::from_vec(width, height, values.collect()).ok()
    };
    Some(FlowField { u: plane(0)?, v: plane(1)? })
}

/// An array of 16-bit numbers, of floating point or whole, in a `.npz` archive.
pub(super) fn packed_array(file: &Path, name: &str) -> Result<Vec<f32>, EvaluateError> {
    let failed = |reason: &dyn ToString| EvaluateError::file(file, format!("{name}: {}", reason.to_string()));
    let mut archive =
        zip::ZipArchive::new(File::open(file).map_err(|error| failed(&error))?).map_err(|error| failed(&error))?;
    let mut entry = archive.by_name(&format!("{name}.npy")).map_err(|error| failed(&error))?;
    let header = NpyHeader::read(&mut entry).map_err(|error| failed(&error))?;
    if header.is_fortran {
        return Err(failed(&"its first index varies fastest: not supported"));
    }
    let mut bytes = Vec::new();
    entry.read_to_end(&mut bytes).map_err(|error| failed(&error))?;
    let words = bytes.as_chunks::<2>().0;
    match header.code.as_str() {
        "<f2" => Ok(words.iter().map(|word| f16::from_le_bytes(*word).to_f32()).collect()),
        "<i2" => Ok(words.iter().map(|word| f32::from(i16::from_le_bytes(*word))).collect()),
        code => Err(failed(&format!("values of type {code}, not <f2 or <i2"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flow_file_holds_pairs() {
        let mut bytes = b"PIEH".to_vec();
        bytes.extend([2_i32, 1].iter().flat_map(|size| size.to_le_bytes()));
        bytes.extend([1.5_f32, -2.0, 3.0, 1e10].iter().flat_map(|value| value.to_le_bytes()));
        let flow = parse_flow(&bytes).unwrap();
        assert_eq!((flow.u.values(), flow.v.values()), (&[1.5, 3.0][..], &[-2.0, 1e10][..]));
        assert!(parse_flow(&bytes[..bytes.len() - 4]).is_none());
        assert!(parse_flow(b"PI").is_none());
    }
}
