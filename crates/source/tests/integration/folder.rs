//! Image folders: every kind of pixel, the order, and every fault that a folder can have.

use fingervision_image::{Frame, Pixels};
use fingervision_source::{Options, SourceError, open};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
use std::fs::{self, File};
use std::path::Path;
use tempfile::{TempDir, tempdir};
use tiff::encoder::{TiffEncoder, colortype};

const NOMINAL: Options = Options { frames_per_second: 30.0 };

fn grey(level: u8) -> DynamicImage {
    DynamicImage::ImageLuma8(ImageBuffer::from_pixel(8, 6, Luma([level])))
}

/// A folder with these images.
fn folder<'a>(images: impl IntoIterator<Item = (&'a str, DynamicImage)>) -> TempDir {
    let folder = tempdir().unwrap();
    for (name, image) in images {
        image.save(folder.path().join(name)).unwrap();
    }
    folder
}

/// Writes floating-point grey, 4×2 px.
fn save_float(path: &Path, values: [f32; 8]) {
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    encoder.write_image::<colortype::Gray32Float>(4, 2, &values).unwrap();
}

fn frames(folder: &Path) -> Vec<Frame> {
    let mut source = open(folder, &NOMINAL).unwrap();
    std::iter::from_fn(|| source.next_frame().unwrap()).collect()
}

fn open_error(path: &Path) -> SourceError {
    open(path, &NOMINAL).err().unwrap()
}

/// The error that ends a source, and how many frames came before it.
fn error_after_frames(folder: &Path) -> (usize, SourceError) {
    let mut source = open(folder, &NOMINAL).unwrap();
    for count in 0.. {
        match source.next_frame() {
            Ok(frame) => assert!(frame.is_some(), "the source ends without an error"),
            Err(error) => {
                assert_eq!(source.next_frame().unwrap(), None, "a source is at its end after an error");
                return (count, error);
            }
        }
    }
    unreachable!("frames without end")
}

fn level(frame: &Frame) -> f32 {
    frame.pixels.levels(0, 0)[0]
}

#[test]
fn frames_come_in_natural_order_at_the_nominal_rate() {
    let folder = folder([("frame10.png", grey(10)), ("frame9.png", grey(9)), ("frame8.png", grey(8))]);
    let mut source = open(folder.path(), &Options { frames_per_second: 90.0 }).unwrap();
    assert_eq!((source.size(), source.frame_count()), ((8, 6), Some(3)));
    assert!(source.description().ends_with("3 images, 8x6 px 8-bit grey, nominally 90 frames per second"));
    for (sequence, wanted) in [8.0, 9.0, 10.0].into_iter().enumerate() {
        let frame = source.next_frame().unwrap().unwrap();
        assert_eq!((frame.sequence, level(&frame)), (sequence as u64, wanted));
        assert!((frame.capture_time_s - sequence as f64 / 90.0).abs() < 1e-12);
    }
    assert!(source.next_frame().unwrap().is_none());
    assert!(source.next_frame().unwrap().is_none());
}

#[test]
fn numbers_that_are_missing_in_the_names_are_missing_in_the_sequence() {
    let folder = folder([("000001.png", grey(1)), ("000002.png", grey(2)), ("000005.png", grey(5))]);
    let frames = frames(folder.path());
    assert_eq!(frames.iter().map(|frame| frame.sequence).collect::<Vec<_>>(), [0, 1, 4]);
    assert!((frames[2].capture_time_s - 4.0 / 30.0).abs() < 1e-12);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_before_it_is_opened() {
    let folder = folder([("0.png", grey(1)), ("1.png", grey(2)), ("3.png", grey(3))]);
    let pipe = folder.path().join("2.png");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for path in [folder.path(), &pipe] {
        let error = open_error(path);
        assert!(error.to_string().ends_with("2.png: a pipe, socket or device is not supported"), "{error}");
        assert!(error.hint().unwrap().contains("regular files"));
    }
}

#[test]
fn hidden_files_folders_and_other_files_are_left_alone() {
    let folder = folder([("a.png", grey(1)), ("b.png", grey(2)), (".hidden.png", grey(3))]);
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    fs::write(folder.path().join("notes.txt"), "not an image").unwrap();
    fs::write(folder.path().join("png"), "not an image").unwrap();
    assert_eq!(frames(folder.path()).len(), 2);
}

#[test]
fn content_decides_the_format_not_the_name() {
    let colour = |level| DynamicImage::from(grey(level).to_rgb8());
    let folder = folder([("a.png", colour(1)), ("b.png", colour(2)), ("c.bmp", colour(3))]);
    let bmp = folder.path().join("c.bmp");
    fs::rename(bmp, folder.path().join("c.JPG")).unwrap();
    assert_eq!(frames(folder.path()).iter().map(level).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
}

#[test]
fn depth_and_colour_are_kept_and_transparency_is_dropped() {
    let kinds: [(DynamicImage, Pixels); 8] = [
        (DynamicImage::ImageLuma8(ImageBuffer::from_pixel(2, 1, Luma([7]))), grey8(7)),
        (DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(2, 1, LumaA([7, 0]))), grey8(7)),
        (DynamicImage::ImageLuma16(ImageBuffer::from_pixel(2, 1, Luma([700]))), grey16(700)),
        (DynamicImage::ImageLumaA16(ImageBuffer::from_pixel(2, 1, LumaA([700, 0]))), grey16(700)),
        (DynamicImage::ImageRgb8(ImageBuffer::from_pixel(2, 1, Rgb([7, 8, 9]))), rgb8([7, 8, 9])),
        (DynamicImage::ImageRgba8(ImageBuffer::from_pixel(2, 1, Rgba([7, 8, 9, 0]))), rgb8([7, 8, 9])),
        (DynamicImage::ImageRgb16(ImageBuffer::from_pixel(2, 1, Rgb([7, 800, 9]))), rgb16([7, 800, 9])),
        (DynamicImage::ImageRgba16(ImageBuffer::from_pixel(2, 1, Rgba([7, 800, 9, 0]))), rgb16([7, 800, 9])),
    ];
    for (image, pixels) in kinds {
        for extension in ["png", "tif"] {
            let names = [format!("a.{extension}"), format!("b.{extension}")];
            let has_encoder = extension == "png" || !image.color().has_alpha() || image.color().has_color();
            if has_encoder {
                let folder = folder(names.iter().map(|name| (name.as_str(), image.clone())));
                assert_eq!(frames(folder.path())[1].pixels, pixels, "{:?} as {extension}", image.color());
            }
        }
    }
}

fn grey8(value: u8) -> Pixels {
    Pixels::Grey8(fingervision_image::Image::filled(2, 1, value))
}

fn grey16(value: u16) -> Pixels {
    Pixels::Grey16(fingervision_image::Image::filled(2, 1, value))
}

fn rgb8(value: [u8; 3]) -> Pixels {
    Pixels::Rgb8(fingervision_image::Image::filled(2, 1, value))
}

fn rgb16(value: [u16; 3]) -> Pixels {
    Pixels::Rgb16(fingervision_image::Image::filled(2, 1, value))
}

#[test]
fn jpeg_is_read_in_grey_and_in_colour() {
    let colour = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(20, 10, Rgb([200, 100, 50])));
    let colour = folder([("a.jpg", colour.clone()), ("b.jpeg", colour)]);
    let levels = frames(colour.path())[1].pixels.levels(19, 9);
    assert!(levels.iter().zip([200.0, 100.0, 50.0]).all(|(found, wanted)| (found - wanted).abs() < 3.0), "{levels:?}");
    let grey = folder([("a.jpg", grey(40)), ("b.jpg", grey(80))]);
    assert!(matches!(&frames(grey.path())[1].pixels, Pixels::Grey8(image) if image.at(0, 0).abs_diff(80) < 3));
}

#[test]
fn a_floating_point_tiff_becomes_16_bit() {
    let folder = tempdir().unwrap();
    for name in ["a.tif", "b.tiff"] {
        save_float(&folder.path().join(name), [0.0, 0.25, 0.5, 0.75, 1.0, 1e-9, 0.1, 0.2]);
    }
    let Pixels::Grey16(image) = &frames(folder.path())[1].pixels else { panic!("16-bit grey") };
    assert_eq!(image.values(), [0, 16384, 32768, 49151, 65535, 0, 6554, 13107]);
}

#[test]
fn a_tiff_of_several_pages_is_refused() {
    let folder = tempdir().unwrap();
    for name in ["a.tif", "b.tif"] {
        let mut encoder = TiffEncoder::new(fs::File::create(folder.path().join(name)).unwrap()).unwrap();
        for page in 0..2 {
            encoder.write_image::<colortype::Gray8>(4, 2, &[page; 8]).unwrap();
        }
    }
    let error = open_error(folder.path()).to_string();
    assert!(error.contains("a.tif") && error.contains("several pages"), "{error}");
}

#[test]
fn a_floating_point_pixel_outside_0_to_1_is_named() {
    for bad in [f32::NAN, f32::INFINITY, -0.1, 1.5] {
        let folder = tempdir().unwrap();
        save_float(&folder.path().join("a.tif"), [0.5; 8]);
        save_float(&folder.path().join("b.tif"), [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, bad, 0.5]);
        let (before, error) = error_after_frames(folder.path());
        assert_eq!(before, 1);
        let SourceError::PixelRange { sequence, x, y, value, .. } = error else { panic!("{error}") };
        assert_eq!((sequence, x, y), (1, 2, 1));
        assert!((value - f64::from(bad)).abs() < 1e-9 || !bad.is_finite() && !value.is_finite(), "{value}");
    }
}

#[test]
fn images_of_another_format_are_refused_with_the_command_that_converts_them() {
    let others = tempdir().unwrap();
    for name in ["a.webp", "b.WEBP", "notes.txt"] {
        fs::write(others.path().join(name), "no image").unwrap();
    }
    let error = open_error(others.path());
    assert!(error.to_string().ends_with("the format of its 2 images, .webp, is not supported"), "{error}");
    assert!(error.hint().unwrap().starts_with("convert them: magick mogrify -format png"), "{error}");
}

#[test]
fn too_few_images_are_refused_with_a_hint() {
    let none = folder([]);
    let error = open_error(none.path());
    assert!(error.to_string().ends_with("no frame: tracking needs a reference and at least one more"), "{error}");
    assert!(error.hint().unwrap().contains("PNG"));
    fs::create_dir(none.path().join("frames")).unwrap();
    assert!(open_error(none.path()).hint().unwrap().starts_with("did you mean"));
    let one = folder([("a.png", grey(1))]);
    let error = open_error(one.path());
    assert!(error.to_string().contains("one frame: tracking needs"), "{error}");
    assert_eq!(error.hint().unwrap(), "record the gel at rest first, then the touch");
    // What `simulate` writes has a preview beside the frames, or in place of them.
    fs::write(one.path().join("scene.toml"), "").unwrap();
    assert!(open_error(one.path()).hint().unwrap().contains("without --truth-only"));
    fs::create_dir(one.path().join("frames")).unwrap();
    assert!(open_error(one.path()).hint().unwrap().starts_with("did you mean"));
}

#[test]
fn a_change_of_size_or_pixels_is_named() {
    let wide = DynamicImage::ImageLuma8(ImageBuffer::from_pixel(9, 6, Luma([1])));
    let cases = [(wide, "9x6 px 8-bit grey"), (grey(1).to_rgb8().into(), "8x6 px 8-bit colour")];
    for (odd, found) in cases {
        let folder = folder([("a.png", grey(1)), ("b.png", grey(1)), ("c.png", odd), ("d.png", grey(1))]);
        let (before, error) = error_after_frames(folder.path());
        assert_eq!(before, 2);
        let wanted = format!("c.png: frame 2: {found}, expected 8x6 px 8-bit grey as before");
        assert!(error.to_string().ends_with(&wanted), "{error}");
    }
}

#[test]
fn a_file_that_only_claims_to_be_an_image_is_named() {
    let folder = folder([("a.png", grey(1)), ("b.png", grey(2))]);
    for content in ["", "hello", "GIF89a and more"] {
        fs::write(folder.path().join("c.png"), content).unwrap();
        let (before, error) = error_after_frames(folder.path());
        assert_eq!(before, 2);
        let wanted = "c.png: frame 2: not a PNG, JPEG, TIFF or BMP image";
        assert!(error.to_string().ends_with(wanted), "{error}");
    }
}

#[test]
fn an_image_that_is_cut_off_anywhere_is_an_error_with_its_name() {
    let picture = |x: u32, y: u32| Rgb([(9 * x) as u8, (13 * y) as u8, (5 * x + 7 * y) as u8]);
    let picture = DynamicImage::ImageRgb8(ImageBuffer::from_fn(33, 21, picture));
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::Bmp] {
        let extension = format.extensions_str()[0];
        let names = [format!("a.{extension}"), format!("b.{extension}")];
        let folder = folder(names.iter().map(|name| (name.as_str(), picture.clone())));
        let path = folder.path().join(&names[1]);
        let whole = fs::read(&path).unwrap();
        // The closing chunk of a PNG may be missing: every pixel is there.
        let needed = if format == ImageFormat::Png { whole.len() - 12 } else { whole.len() };
        for len in (0..needed).step_by(7).chain([needed - 1]) {
            fs::write(&path, &whole[..len]).unwrap();
            let (before, error) = error_after_frames(folder.path());
            assert_eq!(before, 1);
            let text = error.to_string();
            assert!(text.contains(&format!("{}: frame 1: ", names[1])), "{len} bytes: {text}");
            let says_so = text.ends_with("picture is cut off");
            assert!(says_so || len < whole.len() / 2 || format == ImageFormat::Tiff, "{len} bytes: {text}");
        }
    }
}

#[test]
fn a_file_that_vanishes_midway_is_an_error() {
    let folder = folder([("a.png", grey(1)), ("b.png", grey(2))]);
    let mut source = open(folder.path(), &NOMINAL).unwrap();
    fs::remove_file(folder.path().join("b.png")).unwrap();
    assert!(source.next_frame().unwrap().is_some());
    assert!(matches!(source.next_frame(), Err(SourceError::NotFound { .. })));
}

#[test]
fn what_is_no_source_is_refused_with_a_hint() {
    let folder = folder([("a.png", grey(1))]);
    let text = folder.path().join("notes.txt");
    fs::write(&text, "hello").unwrap();
    let recording = folder.path().join("recording.mcap");
    fs::write(&recording, b"\x89MCAP0\r\n").unwrap();
    let cases = [
        (folder.path().join("a.png"), "a.png: a single image is not supported"),
        (text, "notes.txt: this kind of file is not supported"),
        (recording, "recording.mcap: a recording is not supported"),
        ("/dev/video0".into(), "/dev/video0: a camera is not supported"),
        (folder.path().join("missing"), "missing: no such file or folder"),
    ];
    for (path, message) in cases {
        let error = open_error(&path);
        assert!(error.to_string().ends_with(message), "{error}");
        assert!(error.hint().is_some(), "{error}");
    }
}

#[test]
fn a_rate_that_no_camera_has_is_refused() {
    let folder = folder([("a.png", grey(1)), ("b.png", grey(2))]);
    for frames_per_second in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = open(folder.path(), &Options { frames_per_second }).err().unwrap();
        assert!(matches!(error, SourceError::Rate { .. }), "{error}");
    }
}

#[test]
fn a_folder_goes_on_behind_an_image_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    for frame in 0..4 {
        image::GrayImage::new(8, 6).save(folder.path().join(format!("{frame}.png"))).unwrap();
    }
    fs::write(folder.path().join("1.png"), "no image").unwrap();
    image::GrayImage::new(6, 6).save(folder.path().join("2.png")).unwrap();
    let mut source = open(folder.path(), &Options::default()).unwrap();
    assert!(!source.resume(), "there is nothing to go on from");
    let mut sequences = Vec::new();
    for _ in 0..6 {
        match source.next_frame() {
            Ok(frame) => sequences.extend(frame.map(|frame| frame.sequence)),
            Err(_) => assert!(source.resume() && !source.resume()),
        }
    }
    assert_eq!(sequences, [0, 3]);
}

#[test]
fn the_colour_of_jpeg_images_is_full_only_if_it_is_not_subsampled() {
    use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
    let pixels: Vec<u8> = (0..3 * 32 * 16).map(|i| (7 * i % 251) as u8).collect();
    let cases = [(SamplingFactor::F_1_1, true), (SamplingFactor::F_2_1, false), (SamplingFactor::F_2_2, false)];
    for (sampling, is_full) in cases {
        let folder = tempdir().unwrap();
        for name in ["0.jpg", "1.jpg"] {
            let mut encoder = Encoder::new_file(folder.path().join(name), 90).unwrap();
            encoder.set_sampling_factor(sampling);
            encoder.encode(&pixels, 32, 16, ColorType::Rgb).unwrap();
        }
        let mut source = open(folder.path(), &NOMINAL).unwrap();
        let frame = source.next_frame().unwrap().unwrap();
        assert_eq!((source.has_full_colour(), source.tracks_in_colour(&frame.pixels)), (is_full, is_full));
    }
    let folder = folder([("0.png", grey(3)), ("1.png", grey(4))]);
    let mut source = open(folder.path(), &NOMINAL).unwrap();
    let frame = source.next_frame().unwrap().unwrap();
    assert!(source.has_full_colour() && !source.tracks_in_colour(&frame.pixels), "grey has no colour to track in");
}
