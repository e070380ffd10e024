//! Readings of a made-up press: a bump that grows and fades, with truthful units and a masked edge.

use fingervision_flow::FlowField;
use fingervision_image::{Frame, Image, Pixels};
use fingervision_touch::{Reading, TractionGrid};

/// Columns and rows of the grid of tractions.
pub(crate) const TRACTION_SIZE: (usize, usize) = (5, 3);

/// One press of `frames` frames, seen on a region of `width` by `height` px in a camera image 15 px larger all round.
pub(crate) struct Press {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) frames: usize,
}

impl Press {
    /// How far the press is at a frame, 0 to 1: it rises, holds and falls.
    fn strength(&self, frame: usize) -> f32 {
        let phase = frame as f32 / self.frames as f32;
        ((0.5 - (phase - 0.45).abs()) * 4.0 - 0.6).clamp(0.0, 1.0)
    }

    /// Distance from the bump's centre and its width, px.
    fn bump(&self, x: usize, y: usize) -> (f32, f32, f32) {
        let (dx, dy) = (x as f32 - 0.56 * self.width as f32, y as f32 - 0.45 * self.height as f32);
        (dx, dy, 0.16 * self.width as f32)
    }

    pub(crate) fn reading(&self, frame: usize) -> Reading {
        let (width, height, strength) = (self.width, self.height, self.strength(frame));
        let height_of = |x, y| {
            let (dx, dy, radius) = self.bump(x, y);
            (-(dx * dx + dy * dy) / (2.0 * radius * radius)).exp()
        };
        let outwards = |x, y| 8.0 * strength * height_of(x, y) / self.bump(x, y).2;
        let shear = |x, y| 1.2 * strength * height_of(x, y);
        let mut flow = FlowField::zero(width, height);
        flow.u = Image::from_fn(width, height, |x, y| outwards(x, y) * self.bump(x, y).0 + shear(x, y));
        flow.v = Image::from_fn(width, height, |x, y| outwards(x, y) * self.bump(x, y).1);
        let depth = Image::from_fn(width, height, |x, y| {
            let (dx, dy, radius) = self.bump(x, y);
            let ring = (dx * dx + dy * dy).sqrt() - 2.4 * radius;
            let bulge = (-ring * ring / (0.5 * radius * radius)).exp();
            strength * (1.83 * height_of(x, y) - 0.28 * bulge)
        });
        let valid = Image::from_fn(width, height, |x, y| u8::from(self.is_valid(x, y)));
        let mut reading = Reading::new(width, height);
        reading.numbers.sequence = frame as u64;
        reading.numbers.capture_time_s = 1_234.5 + frame as f64 / 90.0;
        reading.numbers.reference_count = 1;
        (reading.numbers.photometric_error, reading.numbers.latency_ms) = (2.5, 7.25);
        (reading.flow, reading.valid) = (flow, valid);
        reading.deviation = Image::filled(width, height, 0.05);
        reading.density = Some(Image::from_fn(width, height, |x, y| 0.1 * depth.at(x, y)));
        reading.depth_deviation = Some(Image::from_fn(width, height, |x, _| if x == 0 { f32::INFINITY } else { 0.02 }));
        reading.contact = Some(Image::from_fn(width, height, |x, y| u8::from(strength > 0.0 && height_of(x, y) > 0.6)));
        let displacement = [0.1, -0.2, 1.0].map(|part| Image::from_fn(width, height, |x, y| part * depth.at(x, y)));
        reading.displacement = Some(displacement);
        reading.traction = Some(Self::traction(strength));
        reading.depth = Some(depth);
        reading.numbers.max_depth_mm = Some(1.83 * strength);
        reading.numbers.contact_area_mm2 = Some(41.0 * strength);
        reading.numbers.force_n = Some([0.31 * strength, -0.04 * strength, 2.7 * strength]);
        reading.numbers.torque_nmm = Some(-1.5 * strength);
        reading
    }

    /// A grid of 5 by 3 cells, pressed in the middle.
    fn traction(strength: f32) -> TractionGrid {
        let part = |cell| if cell == 7 { [0.0, 0.01, 0.2 * strength] } else { [0.0; 3] };
        let (columns, rows) = TRACTION_SIZE;
        TractionGrid { columns, rows, cell_mm: 2.0, traction_mpa: (0..columns * rows).map(part).collect() }
    }

    /// Everything but a band on the left and a dark corner.
    fn is_valid(&self, x: usize, y: usize) -> bool {
        let corner = (self.width - x).pow(2) + y.pow(2);
        x >= self.width / 40 && corner > (self.width / 7).pow(2)
    }

    pub(crate) fn frame(&self, frame: usize) -> Frame {
        let pixels = Image::from_fn(self.width + 30, self.height + 30, |x, y| {
            let mut hash = ((x / 9) * 7_919 + (y / 9) * 104_729) as u32;
            hash = (hash ^ (hash >> 7)).wrapping_mul(2_654_435_761);
            [(hash >> 8) as u8, (hash >> 16) as u8, (hash >> 24) as u8]
        });
        let capture_time_s = 1_234.5 + frame as f64 / 90.0;
        Frame { sequence: frame as u64, capture_time_s, pixels: Pixels::Rgb8(pixels) }
    }
}
