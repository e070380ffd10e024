//! The lattice of part corners over the image, and which of them a patch may cover.

use super::node::Node;
use crate::blur::SUB_PIXELS;
use fingervision_optics::Camera;
use std::ops::Range;

/// Corners that a kernel processes together.
pub(crate) const LANES: usize = 8;

/// Margin of a patch's box beyond its corners, px, for rounding errors.
const PAD_PX: f64 = 0.02;

/// The positions of the corners of the image's parts.
///
/// A part is half a pixel wide. Corner `(i, j)` is the upper left one of part `(i, j)`; the image's first part comes
/// after `margin` others on either side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lattice {
    /// Corners along x and y: one more than parts.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Corners from a row to the next in memory, the last ones unused.
    pub(crate) stride: usize,
    margin: usize,
}

/// The corners within a box: from `left` to `right` and `top` to `bottom`, all included.
///
/// A box between two columns of corners has `left = right + 1`: it covers parts, but no corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bounds {
    pub(crate) left: i32,
    pub(crate) right: i32,
    pub(crate) top: i32,
    pub(crate) bottom: i32,
}

#[expect(clippy::cast_possible_wrap, reason = "an image has far fewer than 2^31 parts")]
impl Bounds {
    /// Nowhere on the lattice.
    pub(crate) const OUTSIDE: Self = Self { left: i32::MAX, right: i32::MIN, top: i32::MAX, bottom: i32::MIN };

    pub(crate) fn is_outside(&self) -> bool {
        *self == Self::OUTSIDE
    }

    /// The columns and rows of corners, both ranges without their ends.
    pub(crate) fn corners(&self) -> [Range<usize>; 2] {
        [(self.left, self.right), (self.top, self.bottom)].map(|(least, most)| least as usize..(most + 1) as usize)
    }

    /// The columns and rows of parts that the box overlaps, and `more` around them; without the ends.
    pub(crate) fn parts(&self, more: i32) -> [Range<usize>; 2] {
        [(self.left, self.right), (self.top, self.bottom)]
            .map(|(least, most)| (least - 1 - more).max(0) as usize..(most + 1 + more).max(0) as usize)
    }

    /// Whether the box overlaps a part.
    pub(crate) fn touches(&self, (column, row): (usize, usize)) -> bool {
        let is_in = |least: i32, part: usize, most: i32| least <= part as i32 + 1 && part as i32 <= most;
        is_in(self.left, column, self.right) && is_in(self.top, row, self.bottom)
    }
}

impl Lattice {
    pub(crate) fn new(width: usize, height: usize, margin: usize) -> Self {
        let [columns, rows] = [width, height].map(|size| SUB_PIXELS * size + 2 * margin + 1);
        // A kernel that begins at the last corner must stay in its row.
        Self { columns, rows, stride: columns + LANES, margin }
    }

    /// Position of a corner along an axis, px.
    pub(crate) fn px(&self, corner: f64) -> f64 {
        (corner - self.margin as f64) / SUB_PIXELS as f64 - 0.5
    }

    /// The corner at a pixel position along an axis; between corners a fraction.
    pub(crate) fn corner(&self, px: f64) -> f64 {
        (px + 0.5) * SUB_PIXELS as f64 + self.margin as f64
    }

    /// The corners within a patch, and `pad_px` around it. A partly visible patch may be anywhere.
    #[expect(clippy::cast_possible_wrap, reason = "an image has far fewer than 2^31 parts")]
    pub(crate) fn bounds(&self, corners: [&Node; 4], pad_px: f64) -> Bounds {
        let pixels = corners.map(|node| node.px);
        let unseen = pixels.iter().filter(|px| px[0].is_nan()).count();
        let [last_column, last_row] = [self.columns, self.rows].map(|count| count as i32 - 1);
        if unseen > 0 {
            let whole = Bounds { left: 0, right: last_column, top: 0, bottom: last_row };
            return if unseen == pixels.len() { Bounds::OUTSIDE } else { whole };
        }
        let [(left, right), (top, bottom)] = [0, 1].map(|axis| {
            let [a, b, c, d] = pixels.map(|px| px[axis]);
            let least = self.corner(a.min(b).min(c.min(d)) - pad_px);
            (least.ceil() as i32, self.corner(a.max(b).max(c.max(d)) + pad_px).floor() as i32)
        });
        if right < 0 || left > last_column || bottom < 0 || top > last_row {
            return Bounds::OUTSIDE;
        }
        Bounds { left: left.max(0), right: right.min(last_column), top: top.max(0), bottom: bottom.min(last_row) }
    }
}

/// The slope of the ray through every corner: x and y in gel space per step down. NaN if the ray does not go down, and
/// beyond the lattice.
/// goes down, and beyond the lattice.
#[derive(Debug, Clone)]
pub(crate) struct Rays {
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
}

impl Rays {
    pub(crate) fn new(lattice: Lattice, camera: &Camera) -> Self {
        let slope = |column: usize, row: usize| {
            let px = [column, row].map(|corner| lattice.px(corner as f64));
            let ray = camera.ray(px).filter(|ray| column < lattice.columns && ray.direction[2] < 0.0)?;
            let [x, y, z] = ray.direction;
            Some([-x / z, -y / z].map(|slope| slope as f32))
        };
        let slopes = (0..lattice.rows).flat_map(|row| (0..lattice.stride).map(move |column| (column, row)));
        let (x, y) =
            slopes.map(|(column, row)| slope(column, row).unwrap_or([f32::NAN; 2])).map(|[x, y]| (x, y)).unzip();
        Self { x, y }
    }
}

/// Distance between the image of a straight line as long as `length_mm` at rest and the line between its ends, px.
///
/// Only distortion bends lines. Eight times the largest value in the image at rest is used, to allow for the stretch by a
/// press.
pub(crate) fn bulge_px(lattice: Lattice, camera: &Camera, length_mm: f64) -> f64 {
    const SAMPLES: usize = 16;
    let place = |k: usize, count: usize| lattice.px((count - 1) as f64 * k as f64 / SAMPLES as f64);
    let mut most: f64 = 0.0;
    for (i, j) in (0..=SAMPLES).flat_map(|j| (0..=SAMPLES).map(move |i| (i, j))) {
        let Some(middle) = camera.surface_point([place(i, lattice.columns), place(j, lattice.rows)], 0.0) else {
            continue;
        };
        for way in [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [0.7, -0.7]] {
            let at = |sign: f64| {
                let [x, y] = [0, 1].map(|axis| middle[axis] + 0.5 * sign * length_mm * way[axis]);
                camera.project([x, y, 0.0])
            };
            if let (Some(from), Some(middle), Some(to)) = (at(-1.0), at(0.0), at(1.0)) {
                let miss = [0, 1].map(|axis| middle[axis] - 0.5 * (from[axis] + to[axis]));
                // A projective map moves the middle along the line, which is not a bulge.
                let along = [0, 1].map(|axis| to[axis] - from[axis]);
                let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
                most = most.max((miss[0] * along[1] - miss[1] * along[0]).abs() / length);
            }
        }
    }
    PAD_PX + 8.0 * most
}
