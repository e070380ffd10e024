//! The page as PDF.

use fingervision_image::Image;
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, TextStr};

use super::page::{Artwork, Page};

/// Points per mm: a point is 1/72 inch.
const PT_PER_MM: f64 = 72.0 / 25.4;

/// A sample of the cells' image is at most this wide, mm: about 1200 to the inch.
const SAMPLE_MM: f64 = 0.0212;

/// Most samples along a side.
const MOST_SAMPLES: usize = 8192;

/// A circle of radius 1 as four curves: distance of their control points from their ends.
const CURVATURE: f64 = 0.552_284_749_8;

/// Compression level, 0 to 10.
const COMPRESSION: u8 = 6;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const IMAGE: Ref = Ref::new(5);
const INFO: Ref = Ref::new(6);
const IMAGE_NAME: Name<'_> = Name(b"Cells");

pub(super) fn write(page: &Page) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let mut catalog = pdf.catalog(CATALOG);
    catalog.pages(PAGES);
    catalog.viewer_preferences().insert(Name(b"PrintScaling")).primitive(Name(b"None"));
    catalog.finish();
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let [width, height] = page.size_mm.map(|mm| (mm * PT_PER_MM) as f32);
    let mut entry = pdf.page(PAGE);
    entry.media_box(Rect::new(0.0, 0.0, width, height)).parent(PAGES).contents(CONTENT);
    match &page.artwork {
        Artwork::Cells(_) => entry.resources().x_objects().pair(IMAGE_NAME, IMAGE).finish(),
        Artwork::Discs { .. } => entry.resources().finish(),
    }
    entry.finish();
    pdf.stream(CONTENT, &compress_to_vec_zlib(&content(page), COMPRESSION)).filter(Filter::FlateDecode);
    if let Artwork::Cells(cells) = &page.artwork {
        write_cells(&mut pdf, cells, page.pattern_mm[0] / cells.width() as f64);
    }
    let mut info = pdf.document_info(INFO);
    info.title(TextStr("Pattern at true scale")).subject(TextStr(&page.caption)).producer(TextStr("fingervision"));
    info.finish();
    pdf.finish()
}

/// The cells as an image, several samples a cell.
fn write_cells(pdf: &mut Pdf, cells: &Image<[u8; 3]>, cell_mm: f64) {
    let (columns, rows) = cells.size();
    let fine_enough = (cell_mm / SAMPLE_MM).ceil() as usize;
    let samples = fine_enough.min(MOST_SAMPLES / columns.max(rows)).max(1);
    let mut bytes = Vec::with_capacity(3 * samples * samples * columns * rows);
    for row in cells.rows() {
        let start = bytes.len();
        bytes.extend(row.iter().flat_map(|colour| std::iter::repeat_n(colour, samples)).flatten());
        let end = bytes.len();
        (1..samples).for_each(|_| bytes.extend_from_within(start..end));
    }
    let bytes = compress_to_vec_zlib(&bytes, COMPRESSION);
    let mut image = pdf.image_xobject(IMAGE, &bytes);
    image.filter(Filter::FlateDecode);
    let [width, height] = [columns, rows].map(|cells| i32::try_from(samples * cells).unwrap_or(i32::MAX));
    image.width(width).height(height);
    image.color_space().device_rgb();
    image.bits_per_component(8).interpolate(false);
}

/// Everything on the page, in mm from its upper left corner.
fn content(page: &Page) -> Vec<u8> {
    let mut content = Content::new();
    let scale = PT_PER_MM as f32;
    content.transform([scale, 0.0, 0.0, -scale, 0.0, (page.size_mm[1] * PT_PER_MM) as f32]);
    content.save_state();
    draw_artwork(page, &mut content);
    content.restore_state();
    content.set_line_cap(LineCapStyle::RoundCap).set_line_join(LineJoinStyle::RoundJoin);
    for stroke in &page.strokes {
        content.set_line_width(stroke.width_mm as f32);
        let mut points = stroke.points_mm.iter().map(|point| point.map(|mm| mm as f32));
        if let Some([x, y]) = points.next() {
            content.move_to(x, y);
        }
        for [x, y] in points {
            content.line_to(x, y);
        }
        content.stroke();
    }
    content.finish().into_vec()
}

fn draw_artwork(page: &Page, content: &mut Content) {
    let ([x, y], [width, height]) = (page.origin_mm, page.pattern_mm);
    match &page.artwork {
        Artwork::Cells(_) => {
            // An image fills the unit square, its first row uppermost where y points up.
            content.transform([width, 0.0, 0.0, -height, x, y + height].map(|value| value as f32));
            content.x_object(IMAGE_NAME);
        }
        Artwork::Discs { discs, dark, bright } => {
            content.transform([1.0, 0.0, 0.0, 1.0, x as f32, y as f32]);
            content.set_fill_gray(f32::from(*bright) / 255.0);
            content.rect(0.0, 0.0, width as f32, height as f32).fill_nonzero();
            content.rect(0.0, 0.0, width as f32, height as f32).clip_nonzero().end_path();
            content.set_fill_gray(f32::from(*dark) / 255.0);
            for disc in discs {
                draw_circle(disc.centre_mm, disc.radius_mm, content);
            }
        }
    }
}

fn draw_circle(centre: [f64; 2], radius: f64, content: &mut Content) {
    let at = |x: f64, y: f64| [(centre[0] + radius * x) as f32, (centre[1] + radius * y) as f32];
    let [x, y] = at(1.0, 0.0);
    content.move_to(x, y);
    for (c, s) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
        // A quarter from the direction (c, s) to (−s, c).
        let [x1, y1] = at(c - CURVATURE * s, s + CURVATURE * c);
        let [x2, y2] = at(-s + CURVATURE * c, c + CURVATURE * s);
        let [x3, y3] = at(-s, c);
        content.cubic_to(x1, y1, x2, y2, x3, y3);
    }
    content.fill_nonzero();
}
