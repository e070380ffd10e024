//! Images in a folder, where every frame is decoded from a file of its own.

use std::fs;
use std::io::Cursor;

use fingervision_fuzz::{Form, Parser};
use fingervision_source::{Options, open};
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, Rgba};
use tiff::encoder::{TiffEncoder, colortype};

/// The most memory that one of these small files may take, bytes: what the TIFF decoder allows itself for a picture, and a
/// little for its tables.
const MOST_BYTES: u64 = (256 << 20) + (64 << 10);
const SIZE: (u32, u32) = (19, 13);

fn level(x: u32, y: u32) -> u8 {
    (x * 31 + y * 57 + x * y) as u8
}

fn grey() -> DynamicImage {
    GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([level(x, y)])).into()
}

fn colour() -> DynamicImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| Rgb([level(x, y), level(y, x), 7])).into()
}

fn deep() -> DynamicImage {
    ImageBuffer::from_fn(SIZE.0, SIZE.1, |x, y| Luma([257 * u16::from(level(x, y))])).into()
}

fn transparent() -> DynamicImage {
    ImageBuffer::from_fn(SIZE.0, SIZE.1, |x, y| Rgba([level(x, y), 1, 2, level(y, x)])).into()
}

fn file(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn float_tiff() -> Vec<u8> {
    let values: Vec<f32> = (0..SIZE.0 * SIZE.1).map(|n| n as f32 / (SIZE.0 * SIZE.1) as f32).collect();
    let mut bytes = Cursor::new(Vec::new());
    TiffEncoder::new(&mut bytes).unwrap().write_image::<colortype::Gray32Float>(SIZE.0, SIZE.1, &values).unwrap();
    bytes.into_inner()
}

fn run(name: &'static str, files: Vec<Vec<u8>>, repair: impl Fn(&mut [u8])) {
    let folder = tempfile::tempdir().unwrap();
    // The first frame is decoded when the folder is opened; a folder has two at least.
    fs::write(folder.path().join("1.png"), file(&grey(), ImageFormat::Png)).unwrap();
    Parser { name, form: Form::Binary, files, inputs: 1500, most_bytes: MOST_BYTES }.run(|bytes| {
        let mut bytes = bytes.to_vec();
        repair(&mut bytes);
        fs::write(folder.path().join("0.png"), bytes).unwrap();
        open(folder.path(), &Options::default()).is_ok()
    });
}

#[test]
fn a_mutated_png_is_read_or_refused() {
    let files = [grey(), colour(), deep(), transparent()].map(|image| file(&image, ImageFormat::Png));
    run("png", files.to_vec(), with_checksums);
}

#[test]
fn a_mutated_jpeg_is_read_or_refused() {
    let files = [grey(), colour()].map(|image| file(&image, ImageFormat::Jpeg));
    run("jpeg", files.to_vec(), |_| ());
}

#[test]
fn a_mutated_tiff_is_read_or_refused() {
    let mut files = [grey(), colour(), deep(), transparent()].map(|image| file(&image, ImageFormat::Tiff)).to_vec();
    files.push(float_tiff());
    run("tiff", files, |_| ());
}

#[test]
fn a_mutated_bmp_is_read_or_refused() {
    let files = [grey(), colour(), transparent()].map(|image| file(&image, ImageFormat::Bmp));
    run("bmp", files.to_vec(), |_| ());
}

/// Gives every chunk of a PNG its right checksum, as far as lengths fit: a wrong one is refused before the content is read.
fn with_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(len) = bytes.get(at..at + 4).map(|len| u32::from_be_bytes(len.try_into().unwrap()) as usize) {
        let content = at + 4..at + 8 + len;
        let Some(checksum) = bytes.get(content.clone()).map(crc32) else { return };
        at = content.end + 4;
        if let Some(stored) = bytes.get_mut(content.end..at) {
            stored.copy_from_slice(&checksum.to_be_bytes());
        }
    }
}

/// The checksum of PNG (ISO/IEC 15948, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc: u32, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

#[test]
fn checksums_of_a_whole_file_stay() {
    let whole = file(&colour(), ImageFormat::Png);
    let mut repaired = whole.clone();
    with_checksums(&mut repaired);
    assert_eq!(repaired, whole);
}

#[test]
fn a_small_file_that_announces_a_huge_image_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = file(&colour(), ImageFormat::Bmp);
    // Width and height in the header.
    bytes[18..22].copy_from_slice(&17_000_i32.to_le_bytes());
    bytes[22..26].copy_from_slice(&17_000_i32.to_le_bytes());
    for name in ["0.bmp", "1.bmp"] {
        fs::write(folder.path().join(name), &bytes).unwrap();
    }
    let error = open(folder.path(), &Options::default()).err().unwrap().to_string();
    assert!(error.contains("17000x17000 px does not fit into a file of"), "{error}");
}
