//! Printed patterns, read back: sizes, positions and colours are the requested ones.

use std::collections::HashMap;

use fingervision_gel::{Motif, NEIGHBOUR_DISTANCE, Pattern, PatternError, Print};
use fingervision_image::Image;
use miniz_oxide::inflate::decompress_to_vec_zlib;

const PT_PER_MM: f64 = 72.0 / 25.4;

fn pattern(motif: Motif) -> Pattern {
    Pattern { motif, levels: [0, 255], ..Pattern::default() }
}

fn print(motif: Motif, size_mm: [f64; 2]) -> Print {
    Print::new(&pattern(motif), size_mm).unwrap()
}

fn colour(size_mm: [f64; 2]) -> Print {
    print(Motif::Colour { cell_mm: 0.1 }, size_mm)
}

/// The cells of a pattern, from its texture.
fn cells(motif: Motif, size_mm: [f64; 2]) -> Image<[u8; 3]> {
    let texture = pattern(motif).texture(size_mm).unwrap();
    let (columns, rows) = texture.cells().size();
    Image::from_fn(columns, rows, |x, y| texture.cells().at(x, y).map(|level| level as u8))
}

fn assert_close(value: f64, expected: f64, what: &str) {
    assert!((value / expected - 1.0).abs() < 1e-6, "{what}: {value}, expected {expected}");
}

/// The numbers behind a word of a text.
fn numbers(text: &str, word: &str) -> Vec<f64> {
    let start = text.find(word).unwrap_or_else(|| panic!("no {word}")) + word.len();
    let fields = text[start..].split(|c: char| c.is_whitespace() || "[]".contains(c)).filter(|field| !field.is_empty());
    fields.map_while(|field| field.parse().ok()).collect()
}

/// The dictionary and the content of every stream of a PDF.
fn streams(pdf: &[u8]) -> Vec<(String, Vec<u8>)> {
    let find =
        |from: usize, word: &[u8]| pdf[from..].windows(word.len()).position(|part| part == word).map(|k| from + k);
    let mut streams = Vec::new();
    let mut from = 0;
    while let Some(start) = find(from, b"stream\n") {
        let before = &pdf[from..start];
        let begin = before.windows(4).rposition(|part| part == b" obj").unwrap();
        let dictionary = String::from_utf8_lossy(&before[begin..]).into_owned();
        let length = numbers(&dictionary, "/Length")[0] as usize;
        let body = start + b"stream\n".len();
        streams.push((dictionary, decompress_to_vec_zlib(&pdf[body..body + length]).unwrap()));
        from = body + length + b"\nendstream".len();
    }
    streams
}

#[test]
fn a_pdf_has_its_size_in_points() {
    for size_mm in [[30.0, 30.0], [12.3, 45.6], [210.0, 99.9]] {
        let print = colour(size_mm);
        let pdf = print.pdf();
        let text = String::from_utf8_lossy(&pdf);
        let page = numbers(&text, "/MediaBox");
        for axis in 0..2 {
            assert_close(print.pattern_mm()[axis], size_mm[axis], "pattern");
            assert_close(page[2 + axis], print.page_mm()[axis] * PT_PER_MM, "page, pt");
        }
        assert!(text.contains("/PrintScaling /None"));
    }
}

#[test]
fn a_pdf_shows_the_cells_at_their_size() {
    let size_mm = [30.0, 20.0];
    let print = colour(size_mm);
    let streams = streams(&print.pdf());
    let content = String::from_utf8(streams[0].1.clone()).unwrap();
    let transforms: Vec<Vec<f64>> = content
        .lines()
        .filter_map(|line| line.strip_suffix(" cm"))
        .map(|line| line.split_whitespace().map(|field| field.parse().unwrap()).collect())
        .collect();
    let [page, image] = &transforms[..] else { panic!("{transforms:?}") };
    // Position on the page of a point of the image's unit square, mm from the upper left corner.
    let place = |x: f64, y: f64| {
        let (x, y) = (image[0] * x + image[4], image[3] * y + image[5]);
        let (x, y) = (page[0] * x + page[4], page[3] * y + page[5]);
        [x / PT_PER_MM, print.page_mm()[1] - y / PT_PER_MM]
    };
    let (upper_left, lower_right) = (place(0.0, 1.0), place(1.0, 0.0));
    for axis in 0..2 {
        assert_close(upper_left[axis], print.origin_mm()[axis], "upper left corner, mm");
        assert_close(lower_right[axis] - upper_left[axis], size_mm[axis], "image, mm");
    }
    let (dictionary, bytes) = &streams[1];
    assert!(dictionary.contains("/Interpolate false"), "{dictionary}");
    let [width, height] = ["/Width", "/Height"].map(|word| numbers(dictionary, word)[0] as usize);
    let expected = cells(Motif::Colour { cell_mm: 0.1 }, size_mm);
    let samples = width / expected.width();
    assert_eq!((width, height), (samples * expected.width(), samples * expected.height()));
    for (k, sample) in bytes.chunks_exact(3).enumerate() {
        assert_eq!(sample, expected.at(k % width / samples, k / width / samples), "sample {k}");
    }
}

#[test]
fn a_pdf_has_every_disc() {
    let print = print(Motif::Dots { count: [15, 10], diameter_mm: 1.0 }, [30.0, 20.0]);
    let content = String::from_utf8(streams(&print.pdf())[0].1.clone()).unwrap();
    let curves = content.lines().filter(|line| line.ends_with(" c")).count();
    assert_eq!(curves, 4 * 150);
    // The first circle begins at its right: 1 mm from the border, and 0.5 mm of radius.
    assert_eq!(numbers(&content, "0 g"), [1.5, 1.0]);
}

/// The SVG's elements: their names and attributes.
fn elements(svg: &str) -> Vec<(String, HashMap<String, String>)> {
    let events = svg::read(svg).unwrap();
    let tags = events.filter_map(|event| match event {
        svg::parser::Event::Tag(name, _, attributes) => Some((name, attributes)),
        _ => None,
    });
    let texts = |(name, attributes): (&str, svg::node::Attributes)| {
        (name.to_string(), attributes.into_iter().map(|(key, value)| (key, value.to_string())).collect())
    };
    tags.map(texts).collect()
}

fn number(attributes: &HashMap<String, String>, name: &str) -> f64 {
    attributes[name].trim_end_matches("mm").parse().unwrap()
}

#[test]
fn an_svg_is_in_mm() {
    for size_mm in [[30.0, 30.0], [7.7, 3.3]] {
        let print = colour(size_mm);
        let elements = elements(&print.svg());
        let (name, root) = &elements[0];
        assert_eq!(name, "svg");
        for (axis, side) in ["width", "height"].into_iter().enumerate() {
            assert!(root[side].ends_with("mm"));
            assert_close(number(root, side), print.page_mm()[axis], side);
            assert_close(numbers(&root["viewBox"], "0 0")[axis], print.page_mm()[axis], "viewBox");
        }
    }
}

#[test]
fn an_svg_has_every_cell_at_its_place() {
    let size_mm = [4.0, 3.0];
    let expected = cells(Motif::Colour { cell_mm: 0.1 }, size_mm);
    let elements = elements(&colour(size_mm).svg());
    let scale = elements.iter().find_map(|(_, attributes)| attributes.get("transform")?.strip_prefix("scale("));
    assert_close(scale.unwrap().trim_end_matches(')').parse().unwrap(), 0.1, "mm per cell");
    let mut found = 0;
    for (_, attributes) in elements.iter().filter(|(name, _)| name == "path") {
        let place = numbers(&attributes["d"].replace('h', " h"), "M");
        let colour = expected.at(place[0] as usize, place[1] as usize);
        assert_eq!(attributes["fill"], format!("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]), "{place:?}");
        assert!(attributes["d"].ends_with("h1v1h-1z"));
        found += 1;
    }
    assert_eq!(found, 40 * 30);
}

#[test]
fn an_svg_has_every_disc_at_its_place() {
    let print = print(Motif::Dots { count: [3, 2], diameter_mm: 0.7 }, [6.0, 6.0]);
    let discs: Vec<[f64; 3]> = elements(&print.svg())
        .iter()
        .filter(|(name, _)| name == "circle")
        .map(|(_, attributes)| ["cx", "cy", "r"].map(|name| number(attributes, name)))
        .collect();
    let expected = [1.5, 4.5].map(|y| [1.0, 3.0, 5.0].map(|x| [x, y, 0.35])).concat();
    assert_eq!(discs, expected);
}

struct Picture {
    px_per_mm: f64,
    image: Image<[u8; 3]>,
    text: String,
}

fn read_png(bytes: &[u8]) -> Picture {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut values = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut values).unwrap();
    let info = reader.info();
    let dims = info.pixel_dims.unwrap();
    assert!(dims.unit == png::Unit::Meter && dims.xppu == dims.yppu);
    let text = info.uncompressed_latin1_text[0].text.clone();
    let (pixels, rest) = values.as_chunks::<3>();
    assert!(rest.is_empty());
    let image = Image::from_vec(info.width as usize, info.height as usize, pixels.to_vec()).unwrap();
    Picture { px_per_mm: f64::from(dims.xppu) * 1e-3, image, text }
}

#[test]
fn a_png_has_every_cell_on_whole_pixels() {
    let size_mm = [6.0, 4.5];
    let print = colour(size_mm);
    let px_per_m = print.even_px_per_m(47_244).unwrap();
    assert_eq!(px_per_m, 50_000, "1270 dpi");
    let Picture { px_per_mm, image, text } = read_png(&print.png(px_per_m).unwrap());
    assert_close(px_per_mm * 0.1, 5.0, "px per cell");
    for (axis, size) in [image.width(), image.height()].into_iter().enumerate() {
        assert!((size as f64 - print.page_mm()[axis] * px_per_mm).abs() < 1.0 + 1e-6, "{size} px");
    }
    assert_eq!(text, print.caption());
    let expected = cells(Motif::Colour { cell_mm: 0.1 }, size_mm);
    let [left, top] = print.origin_mm().map(|mm| (mm * px_per_mm).round() as usize);
    for (x, y) in (0..300).flat_map(|x| (0..225).map(move |y| (x, y))) {
        assert_eq!(image.at(left + x, top + y), expected.at(x / 5, y / 5), "px ({x}, {y})");
    }
    let distance = |a: [u8; 3], b: [u8; 3]| {
        a.into_iter().zip(b).map(|(a, b)| (f32::from(a) - f32::from(b)).powi(2)).sum::<f32>().sqrt()
    };
    for (x, y) in (0..59).flat_map(|x| (1..44).map(move |y| (x, y))) {
        let cell = |x: usize, y: usize| image.at(left + 5 * x + 2, top + 5 * y + 2);
        for neighbour in [cell(x + 1, y - 1), cell(x + 1, y), cell(x + 1, y + 1), cell(x, y + 1)] {
            let distance = distance(cell(x, y), neighbour);
            assert!(distance >= NEIGHBOUR_DISTANCE, "cell ({x}, {y}) lies {distance} from its neighbour");
        }
    }
}

/// Sum of the darkness of a picture's pattern, in whole black px.
fn ink(print: &Print, picture: &Picture) -> f64 {
    let [left, top] = print.origin_mm().map(|mm| (mm * picture.px_per_mm).round() as usize);
    let [width, height] = print.pattern_mm().map(|mm| (mm * picture.px_per_mm).ceil() as usize);
    let places = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
    places.map(|(x, y)| 1.0 - f64::from(picture.image.at(x, y)[0]) / 255.0).sum()
}

#[test]
fn a_png_has_discs_of_their_area() {
    for (size_mm, px_per_m) in [([6.0, 4.0], 10_000), ([6.03, 4.01], 11_811)] {
        let print = print(Motif::Dots { count: [3, 2], diameter_mm: 0.9 }, size_mm);
        let picture = read_png(&print.png(px_per_m).unwrap());
        let expected = 6.0 * 0.25 * std::f64::consts::PI * (0.9 * picture.px_per_mm).powi(2);
        let ink = ink(&print, &picture);
        assert!((ink / expected - 1.0).abs() < 1e-3, "{ink} px, expected {expected} px");
    }
}

#[test]
fn speckle_covers_half_of_every_print() {
    let print = print(Motif::Speckle { diameter_mm: 0.25, coverage: 0.5 }, [6.0, 4.0]);
    let picture = read_png(&print.png(47_244).unwrap());
    let covered = ink(&print, &picture) / (24.0 * picture.px_per_mm * picture.px_per_mm);
    assert!((covered - 0.5).abs() < 0.005, "{covered}");
}

#[test]
fn cells_that_px_do_not_divide_are_mixed_by_area() {
    let motif = Motif::Colour { cell_mm: 0.1 };
    let print = print(motif, [3.0, 3.0]);
    assert!(!print.is_even(47_244) && print.is_even(50_000));
    let Picture { px_per_mm, image, .. } = read_png(&print.png(47_244).unwrap());
    let expected = cells(motif, [3.0, 3.0]);
    let [left, top] = print.origin_mm().map(|mm| (mm * px_per_mm).round() as usize);
    // Px 4 is [4, 5] across and cell 0 ends at 4.7244: its red is mixed of both.
    let red = |column: usize| f64::from(expected.at(column, 0)[0]);
    let mixed = 0.7244 * red(0) + 0.2756 * red(1);
    assert!((f64::from(image.at(left + 4, top)[0]) - mixed).abs() <= 0.51, "{mixed}");
    assert_eq!(image.at(left + 3, top), expected.at(0, 0));
    // The last cell ends in px 141, of which it covers 0.732; the rest is paper.
    let edge = 255.0 + 0.732 * (f64::from(expected.at(29, 0)[0]) - 255.0);
    assert!((f64::from(image.at(left + 141, top)[0]) - edge).abs() <= 0.51, "{edge}");
}

#[test]
fn the_same_pattern_gives_the_same_bytes() {
    for motif in [Motif::Colour { cell_mm: 0.2 }, Motif::Speckle { diameter_mm: 0.5, coverage: 0.5 }] {
        let [a, b] = [(); 2].map(|()| print(motif, [5.0, 4.0]));
        assert!(a.pdf() == b.pdf() && a.svg() == b.svg() && a.png(20_000).unwrap() == b.png(20_000).unwrap());
    }
    let other = Pattern { seed: 2, ..pattern(Motif::Colour { cell_mm: 0.2 }) };
    assert_ne!(Print::new(&other, [5.0, 4.0]).unwrap().pdf(), print(Motif::Colour { cell_mm: 0.2 }, [5.0, 4.0]).pdf());
}

#[test]
fn a_size_between_whole_cells_is_rounded() {
    let print = print(Motif::Colour { cell_mm: 0.4 }, [3.0, 5.3]);
    let [width, height] = print.pattern_mm();
    assert!((width - 3.2).abs() < 1e-12 && (height - 5.2).abs() < 1e-12, "{width} by {height} mm");
    assert!(print.caption().contains("8 x 13 cells, 3.2 x 5.2 mm"), "{}", print.caption());
}

#[test]
fn the_caption_says_how_to_make_the_pattern_again() {
    let caption = colour([30.0, 30.0]).caption().to_string();
    for fact in ["colour", "cell 0.1 mm", "300 x 300 cells", "30 x 30 mm", "levels 0-255", "seed 1", "100 %"] {
        assert!(caption.contains(fact), "no \"{fact}\" in \"{caption}\"");
    }
}

#[test]
fn a_picture_that_is_too_large_is_refused() {
    let error = colour([30.0, 30.0]).png(1_000_000).unwrap_err();
    assert!(matches!(error, PatternError::TooManyPixels { .. }), "{error}");
    assert!(error.hint().contains("PDF or SVG"));
}

#[test]
fn a_resolution_that_divides_the_cells_is_the_nearest() {
    let even = |cell_mm| print(Motif::Colour { cell_mm }, [30.0, 30.0]).even_px_per_m(47_244);
    for (cell_mm, expected) in [(0.05, 40_000), (0.15, 40_000), (0.25, 48_000), (0.11, 100_000)] {
        let px_per_m = even(cell_mm);
        assert_eq!(px_per_m, Some(expected), "cells of {cell_mm} mm");
    }
}
