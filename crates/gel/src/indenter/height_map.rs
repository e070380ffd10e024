//! A grey image as a relief.

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, DecodingError, Transformations};

use super::IndenterError;
use super::grid::HeightGrid;

/// Most columns or rows of an image.
const MOST_PIXELS: u32 = 4096;

/// A grey image on a rectangle: white is foremost, black lies `depth_mm` behind it, the first row is at the top (smallest
/// y). Values are used directly, without a gamma.
#[derive(Debug, Clone)]
pub(super) struct HeightMap {
    columns: usize,
    rows: usize,
    /// 0 black, 1 white, row-major.
    whiteness: Vec<f64>,
    size_mm: [f64; 2],
    depth_mm: f64,
}

impl HeightMap {
    /// The map in a PNG file of 8 or 16 bit grey. Transparency and colour are refused.
    pub(super) fn read(file: &Path, size_mm: [f64; 2], depth_mm: f64) -> Result<Self, IndenterError> {
        let refused = |why: String| IndenterError::NoHeightMap { file: file.to_owned(), why };
        let mut decoder = Decoder::new(Cursor::new(super::read(file)?));
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(|error| refused(why(&error)))?;
        let [width, height] = [reader.info().width, reader.info().height];
        if [width, height].iter().any(|side| !(2..=MOST_PIXELS).contains(side)) {
            return Err(refused(format!("it has {width}x{height} px: 2x2 to {MOST_PIXELS}x{MOST_PIXELS} can be used")));
        }
        let (colour, depth) = reader.output_color_type();
        if colour != ColorType::Grayscale {
            return Err(refused(format!("it is an image in {}", kind(colour))));
        }
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or_default()];
        reader.next_frame(&mut bytes).map_err(|error| refused(why(&error)))?;
        let whiteness = if depth == BitDepth::Sixteen {
            let values = bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
            values.map(|value| f64::from(value) / 65535.0).collect()
        } else {
            bytes.iter().map(|&value| f64::from(value) / 255.0).collect()
        };
        Ok(Self { columns: width as usize, rows: height as usize, whiteness, size_mm, depth_mm })
    }

    /// The heights over a grid. Pixels that are denser than the nodes are averaged.
    pub(super) fn over(&self, grid: &mut HeightGrid) {
        let step_mm = grid.step_mm;
        let parts = [0, 1].map(|axis| {
            let pitch = self.size_mm[axis] / [self.columns, self.rows][axis] as f64;
            (step_mm / pitch).ceil().clamp(1.0, 16.0) as usize
        });
        let offset = |part: usize, parts: usize| ((part as f64 + 0.5) / parts as f64 - 0.5) * step_mm;
        let is_body = |point: [f64; 2]| (0..2).all(|axis| point[axis].abs() <= 0.5 * self.size_mm[axis] + 1e-9);
        grid.fill(|[x, y]| {
            if !is_body([x, y]) {
                return f64::INFINITY;
            }
            let places = (0..parts[1]).flat_map(|row| (0..parts[0]).map(move |column| (column, row)));
            let at = |(column, row)| self.at([x + offset(column, parts[0]), y + offset(row, parts[1])]);
            places.map(at).sum::<f64>() / (parts[0] * parts[1]) as f64
        });
    }

    /// The height at a point, bilinear between the pixels' centres, mm.
    fn at(&self, point: [f64; 2]) -> f64 {
        let counts = [self.columns, self.rows];
        let [(column, x), (row, y)] = [0, 1].map(|axis| {
            let count = counts[axis] as f64;
            let place = ((point[axis] / self.size_mm[axis] + 0.5) * count - 0.5).clamp(0.0, count - 1.0);
            let before = place.floor().min(count - 2.0);
            (before as usize, place - before)
        });
        let white = |column: usize, row: usize| self.whiteness[row * self.columns + column];
        let of_row = |row: usize| (1.0 - x) * white(column, row) + x * white(column + 1, row);
        (1.0 - ((1.0 - y) * of_row(row) + y * of_row(row + 1))) * self.depth_mm
    }
}

fn kind(colour: ColorType) -> &'static str {
    match colour {
        ColorType::Grayscale => "grey",
        ColorType::GrayscaleAlpha => "grey with transparency",
        ColorType::Rgb | ColorType::Indexed => "colour",
        ColorType::Rgba => "colour with transparency",
    }
}

fn why(error: &DecodingError) -> String {
    match error {
        DecodingError::IoError(_) => "it is cut off".into(),
        DecodingError::LimitsExceeded => "it takes more memory than allowed".into(),
        other => format!("it is not a complete PNG ({other})"),
    }
}
