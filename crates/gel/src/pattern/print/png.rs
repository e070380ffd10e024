//! The page as PNG.

use fingervision_image::Image;
use png::{BitDepth, ColorType, Encoder, PixelDimensions, Unit};

use super::page::{Artwork, Page};
use super::stroke::Stroke;
use crate::PatternError;
use crate::pattern::disc::{Disc, Ground};

/// Most px of a picture.
const MOST_PIXELS: f64 = 2e8;

pub(super) fn write(page: &Page, px_per_m: u32) -> Result<Vec<u8>, PatternError> {
    let px_per_mm = f64::from(px_per_m) * 1e-3;
    let counts = page.size_mm.map(|mm| (mm * px_per_mm).ceil().max(1.0));
    if counts[0] * counts[1] > MOST_PIXELS {
        return Err(PatternError::TooManyPixels { width: counts[0], height: counts[1], px_per_m });
    }
    let [width, height] = counts.map(|count| count as usize);
    let mut picture = Image::filled(width, height, [255; 3]);
    // Everything is shifted by a fraction of a px, so that the pattern begins on a border between two.
    let origin = page.origin_mm.map(|mm| (mm * px_per_mm).round());
    draw_artwork(page, px_per_mm, origin.map(|px| px as usize), &mut picture);
    let moved = [0, 1].map(|axis| origin[axis] - page.origin_mm[axis] * px_per_mm);
    for stroke in &page.strokes {
        draw_stroke(stroke, px_per_mm, moved, &mut picture);
    }
    Ok(encode(&picture, px_per_m, &page.caption))
}

fn encode(picture: &Image<[u8; 3]>, px_per_m: u32, caption: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width() as u32, picture.height() as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_pixel_dims(Some(PixelDimensions { xppu: px_per_m, yppu: px_per_m, unit: Unit::Meter }));
    let text = encoder.add_text_chunk("Description".into(), caption.into());
    let written = text.and_then(|()| encoder.write_header()).and_then(|mut writer| {
        writer.write_image_data(picture.values().as_flattened())?;
        writer.finish()
    });
    written.expect("memory takes every byte of a picture that is as large as it says");
    bytes
}

/// Draws the pattern with its upper left corner on that of px `origin`.
fn draw_artwork(page: &Page, px_per_mm: f64, origin: [usize; 2], picture: &mut Image<[u8; 3]>) {
    match &page.artwork {
        Artwork::Cells(cells) => {
            let cells_per_px = cells.width() as f64 / (page.pattern_mm[0] * px_per_mm);
            let [columns, rows] = [cells.width(), cells.height()].map(|count| Share::of_all(count, cells_per_px));
            paint(picture, origin, &columns, &rows, |column, row| cells.at(column, row).map(f64::from));
        }
        Artwork::Discs { discs, dark, bright } => {
            let ground = ground(discs, page.pattern_mm, px_per_mm);
            let grey = ground.grey(f64::from(*dark), f64::from(*bright));
            let shares = page.pattern_mm.map(|mm| Share::of_px(mm * px_per_mm));
            paint(picture, origin, &shares[0], &shares[1], |x, y| [f64::from(grey.at(x, y)); 3]);
        }
    }
}

fn ground(discs: &[Disc], pattern_mm: [f64; 2], px_per_mm: f64) -> Ground {
    let counts = pattern_mm.map(|mm| (mm * px_per_mm).ceil().max(1.0));
    let mut ground = Ground::bare(counts.map(|count| count as usize), counts.map(|count| count / px_per_mm));
    for disc in discs {
        ground.lay(*disc);
    }
    ground
}

/// Coverage of a px by one part of the pattern along an axis.
#[derive(Debug, Clone, Copy)]
struct Share {
    px: usize,
    part: usize,
    /// 0 to 1.
    weight: f64,
}

/// Remainder of a share by rounding, dimensionless.
const ROUNDING: f64 = 1e-6;

impl Share {
    /// The shares of this many cells in the px that they cover, px by px.
    fn of_all(cells: usize, cells_per_px: f64) -> Vec<Vec<Self>> {
        let px = (cells as f64 / cells_per_px - ROUNDING).ceil() as usize;
        let of_px = |px: usize| {
            let (from, to) = (px as f64 * cells_per_px, (px + 1) as f64 * cells_per_px);
            let parts = (from + ROUNDING).floor() as usize..((to - ROUNDING).ceil() as usize).min(cells);
            let share = |part: usize| (to.min((part + 1) as f64) - from.max(part as f64)) / cells_per_px;
            parts.map(|part| Self { px, part, weight: share(part) }).collect()
        };
        (0..px).map(of_px).collect()
    }

    /// The shares of parts that are px themselves, the last one perhaps partial.
    fn of_px(length: f64) -> Vec<Vec<Self>> {
        let px = (length - ROUNDING).ceil() as usize;
        (0..px).map(|px| vec![Self { px, part: px, weight: (length - px as f64).min(1.0) }]).collect()
    }
}

/// Every px is the mean of its parts, white where there are none.
fn paint(
    picture: &mut Image<[u8; 3]>,
    [left, top]: [usize; 2],
    columns: &[Vec<Share>],
    rows: &[Vec<Share>],
    colour: impl Fn(usize, usize) -> [f64; 3],
) {
    for row in rows {
        for column in columns {
            let mut levels = [255.0; 3];
            for Share { part: y, weight: down, .. } in row {
                for Share { part: x, weight: across, .. } in column {
                    for (level, colour) in levels.iter_mut().zip(colour(*x, *y)) {
                        *level += down * across * (colour - 255.0);
                    }
                }
            }
            let (x, y) = (left + column[0].px, top + row[0].px);
            picture.row_mut(y)[x] = levels.map(|level| level.round() as u8);
        }
    }
}

/// Darkens the px under a stroke, by the distance of their centre from its border.
fn draw_stroke(stroke: &Stroke, px_per_mm: f64, moved: [f64; 2], picture: &mut Image<[u8; 3]>) {
    // A line thinner than a px would fade.
    let half_width = (0.5 * stroke.width_mm * px_per_mm).max(0.5);
    // Px have their centres at whole numbers, lengths begin at the border of the first one.
    let place = |mm: [f64; 2]| [0, 1].map(|axis| mm[axis] * px_per_mm + moved[axis] - 0.5);
    for ends in stroke.points_mm.windows(2) {
        let (a, b) = (place(ends[0]), place(ends[1]));
        let reach = |axis: usize, size: usize| {
            let (low, high) = (a[axis].min(b[axis]) - half_width - 1.0, a[axis].max(b[axis]) + half_width + 1.0);
            low.max(0.0) as usize..(high.max(0.0) as usize + 1).min(size)
        };
        let (width, height) = picture.size();
        for y in reach(1, height) {
            for x in reach(0, width) {
                let distance = distance([x as f64, y as f64], a, b);
                let ink = (half_width + 0.5 - distance).clamp(0.0, 1.0);
                let level = (255.0 * (1.0 - ink)).round() as u8;
                let px = &mut picture.row_mut(y)[x];
                *px = px.map(|old| old.min(level));
            }
        }
    }
}

/// From a point to a segment.
fn distance(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let [along_x, along_y] = [b[0] - a[0], b[1] - a[1]];
    let [x, y] = [point[0] - a[0], point[1] - a[1]];
    let share = ((x * along_x + y * along_y) / (along_x * along_x + along_y * along_y)).clamp(0.0, 1.0);
    (x - share * along_x).hypot(y - share * along_y)
}
