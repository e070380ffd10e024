//! The binary message with the fields of one reading. Numbers are little-endian.
//!
//! | bytes | type | meaning |
//! | --- | --- | --- |
//! | 0 | u32 | 1: the kind of message |
//! | 4 | u32 | the sensor's index |
//! | 8, 16, 24 | f64 | sequence; times of capture and of the reading, s of the host's clock |
//! | 32, 36 | u32 | columns and rows of the fields; each cell is the mean of a block of pixels |
//! | 40 | f32 | one step of the first field, mm or px |
//! | 44 | u32 | the first field: 0 depth, mm; 1 length of the displacement, px |
//! | 48, 52 | u32 | columns and rows of the arrows |
//! | 56 | u32 | bytes of the picture, a JPEG of the region of interest or of the whole frame; 0: none |
//! | 60 | u32 | 1 if the picture is the whole frame, else 0 |
//!
//! Then follow the first field (i16 steps, −32768 where it is not valid), contact (u8, 1 in contact), the displacement
//! along the surface at the arrows (f32 x, y, in mm or px), the traction there (f32 x, y, z, MPa; NaN without one), and
//! the picture. Each part begins at a multiple of four bytes.

use fingervision_image::Image;
use fingervision_pipeline::Snapshot;
use fingervision_touch::Reading;

use crate::arrows::ArrowGrid;

/// The kind of this message.
const FIELDS: u32 = 1;
/// The most columns of a field that is sent.
const MOST_COLUMNS: usize = 256;
/// Steps of depth and of displacement: smaller than the noise, and 32,767 of them exceed the values of any gel.
const DEPTH_STEP_MM: f32 = 0.001;
const FLOW_STEP_PX: f32 = 0.01;
/// Marks a cell without a valid value.
const NOT_VALID: i16 = i16::MIN;

/// The picture that is sent with the fields.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Picture<'a> {
    pub(crate) jpeg: &'a [u8],
    pub(crate) is_whole_frame: bool,
}

/// Side of the block of pixels that becomes one cell, px.
pub(crate) fn block(width: usize) -> usize {
    width.div_ceil(MOST_COLUMNS).max(1)
}

/// The message with a snapshot's fields.
pub(crate) fn fields(sensor: usize, snapshot: &Snapshot, arrows: &ArrowGrid, picture: Picture) -> Vec<u8> {
    let reading = &snapshot.reading;
    let (width, height) = reading.valid.size();
    let block = block(width);
    let (columns, rows) = (width / block, height / block);
    let field = Field::of(reading);
    let [arrow_columns, arrow_rows] = arrows.size();
    let bytes = 64 + 3 * columns * rows + 20 * arrow_columns * arrow_rows + picture.jpeg.len() + 16;
    let mut out = Vec::with_capacity(bytes);
    out.extend([FIELDS, sensor as u32].into_iter().flat_map(u32::to_le_bytes));
    let times = [reading.sequence as f64, snapshot.captured_s, snapshot.ready_s];
    out.extend(times.into_iter().flat_map(f64::to_le_bytes));
    out.extend([columns as u32, rows as u32].into_iter().flat_map(u32::to_le_bytes));
    out.extend(field.step.to_le_bytes());
    let rest = [
        u32::from(field.depth.is_none()),
        arrow_columns as u32,
        arrow_rows as u32,
        picture.jpeg.len() as u32,
        u32::from(picture.is_whole_frame),
    ];
    out.extend(rest.into_iter().flat_map(u32::to_le_bytes));
    let cells = |of: &dyn Fn(usize, usize) -> i16, out: &mut Vec<u8>| {
        for row in 0..rows {
            out.extend((0..columns).flat_map(|column| of(column * block, row * block).to_le_bytes()));
        }
        pad(out);
    };
    cells(&|x, y| field.cell(x, y, block), &mut out);
    for row in 0..rows {
        out.extend((0..columns).map(|column| contact(reading.contact.as_ref(), column * block, row * block, block)));
    }
    pad(&mut out);
    arrows.write(reading, &mut out);
    out.extend_from_slice(picture.jpeg);
    out
}

fn pad(out: &mut Vec<u8>) {
    out.resize(out.len().next_multiple_of(4), 0);
}

/// 1 if at least half of the block is in contact.
fn contact(contact: Option<&Image<u8>>, left: usize, top: usize, block: usize) -> u8 {
    let Some(contact) = contact else { return 0 };
    let rows = (top..top + block).map(|y| &contact.row(y)[left..left + block]);
    let touched: usize = rows.flatten().map(|value| usize::from(*value)).sum();
    u8::from(2 * touched >= block * block)
}

/// The field that the map shows: depth, or if it is not computed the length of the displacement.
struct Field<'a> {
    reading: &'a Reading,
    depth: Option<&'a Image<f32>>,
    step: f32,
}

impl<'a> Field<'a> {
    fn of(reading: &'a Reading) -> Self {
        let depth = reading.depth.as_ref();
        Self { reading, depth, step: if depth.is_some() { DEPTH_STEP_MM } else { FLOW_STEP_PX } }
    }

    /// The mean of the valid pixels of a block, in steps.
    fn cell(&self, left: usize, top: usize, block: usize) -> i16 {
        let (mut sum, mut count) = (0.0, 0);
        for y in top..top + block {
            for x in left..left + block {
                if self.is_valid(x, y) {
                    sum += self.value(x, y);
                    count += 1;
                }
            }
        }
        let steps = sum / count as f32 / self.step;
        if steps.is_finite() { steps.round().clamp(-32_767.0, 32_767.0) as i16 } else { NOT_VALID }
    }

    fn is_valid(&self, x: usize, y: usize) -> bool {
        match (&self.depth, &self.reading.depth_deviation) {
            (Some(_), Some(deviation)) => deviation.at(x, y).is_finite(),
            _ => self.reading.valid.at(x, y) == 1,
        }
    }

    fn value(&self, x: usize, y: usize) -> f32 {
        let flow = &self.reading.flow;
        self.depth.map_or_else(|| flow.u.at(x, y).hypot(flow.v.at(x, y)), |depth| depth.at(x, y))
    }
}
