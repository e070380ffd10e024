//! The colours of the parts of the image, row by row.
//!
//! A part is half a pixel wide. Its four corners, mapped to the undeformed surface, span a quadrilateral there; the part
//! is the mean of the cells in it, weighted by area, times the light. At the gel's border the quadrilateral is cut and
//! the rest is background. Where the surface may occlude itself, the corners may lie on different parts of it: there the
//! part is the mean of many rays.

use super::cells::Place;
use super::lattice::Lattice;
use super::samples::{Samples, Scene};
use super::sight::ColourInputs;
use crate::polygon::{Point, cut, signed_area};
use fearless_simd::{Simd, f32x4, prelude::*};
use fearless_simd_macros::simd;

/// Parts of fewer cells than this are computed by rays: their corners are almost one point.
const LEAST_AREA: f32 = 1e-5;

/// A row of corners.
#[derive(Debug, Clone, Default)]
struct CornerRow {
    places: Vec<Place>,
    /// `∫ F dv` from each corner to the next.
    along: Vec<[f32; 4]>,
}

/// Colours parts.
#[derive(Debug, Clone, Default)]
pub(crate) struct PartRows {
    above: CornerRow,
    below: CornerRow,
    /// Columns of the parts that are computed by rays.
    rayed: Vec<usize>,
    polygon: Vec<Point>,
    beyond: Vec<Point>,
    kept: Vec<Point>,
}

impl PartRows {
    pub(crate) fn new(lattice: Lattice) -> Self {
        let row =
            || CornerRow { places: vec![Place::NOWHERE; lattice.columns], along: vec![[0.0; 4]; lattice.columns] };
        Self {
            above: row(),
            below: row(),
            rayed: Vec::with_capacity(lattice.columns),
            // A quadrilateral cut by four lines has eight corners at most.
            polygon: Vec::with_capacity(16),
            beyond: Vec::with_capacity(16),
            kept: Vec::with_capacity(16),
        }
    }

    /// Computes the first row of corners.
    #[simd]
    pub(crate) fn begin<S: Simd>(&mut self, simd: S, inputs: &ColourInputs) {
        self.below.take(simd, inputs, 0);
    }

    /// The colours of the next row of parts; must be called for each from the first on.
    #[simd]
    pub(crate) fn next<S: Simd>(
        &mut self,
        simd: S,
        inputs: &ColourInputs,
        (samples, scene): (&Samples, &Scene),
        row: usize,
        colours: &mut [[f32; 4]],
    ) {
        std::mem::swap(&mut self.above, &mut self.below);
        self.below.take(simd, inputs, row + 1);
        self.rayed.clear();
        self.colour_quads(simd, inputs, row, colours);
        if let Some(folds) = inputs.patches.folds_in(row) {
            self.rayed.clear();
            self.rayed.extend((0..folds.len()).filter(|&column| folds[column] != 0));
        }
        for &column in &self.rayed {
            colours[column] = samples.colour(simd, inputs, scene, (column, row));
        }
    }

    #[inline(always)]
    fn colour_quads<S: Simd>(&mut self, simd: S, inputs: &ColourInputs, row: usize, colours: &mut [[f32; 4]]) {
        let count = inputs.lattice.columns - 1;
        let stride = inputs.lattice.stride;
        let [gains_above, gains_below] = [row, row + 1].map(|row| &inputs.planes.gain[row * stride..][..=count]);
        let mut left = inputs.cells.along(simd, &self.above.places[0], &self.below.places[0]);
        for column in 0..count {
            let [a, b] = [self.above.places[column], self.above.places[column + 1]];
            let [d, c] = [self.below.places[column], self.below.places[column + 1]];
            let right = inputs.cells.along(simd, &b, &c);
            let around = f32x4::load_array(simd, self.above.along[column]) + right
                - f32x4::load_array(simd, self.below.along[column])
                - left;
            left = right;
            let area = 0.5 * ((c.u - a.u) * (d.v - b.v) - (d.u - b.u) * (c.v - a.v));
            let least = a.u.min(b.u).min(c.u.min(d.u));
            if least >= 0.0 && area > LEAST_AREA {
                let gains =
                    [gains_above[column], gains_above[column + 1], gains_below[column], gains_below[column + 1]];
                let gain = 0.25 * (gains[0] + gains[1] + gains[2] + gains[3]);
                colours[column] = (inputs.cells.mean_colour(simd, around, area) * gain).to_array();
            } else {
                colours[column] = self.odd_part(simd, inputs, (column, row), [a, b, c, d]);
            }
        }
    }

    /// A part at the gel's border or beyond, or one that is computed by rays.
    #[simd]
    fn odd_part<S: Simd>(
        &mut self,
        simd: S,
        inputs: &ColourInputs,
        (column, row): (usize, usize),
        corners: [Place; 4],
    ) -> [f32; 4] {
        let [red, green, blue] = inputs.background;
        let background = [red, green, blue, 0.0];
        let is_on_gel = |place: &Place| place.is_on_gel();
        if corners.contains(&Place::NOWHERE) {
            if corners.iter().any(is_on_gel) {
                self.rayed.push(column);
            }
            return background;
        }
        if corners.iter().all(is_on_gel) {
            self.rayed.push(column);
            return background;
        }
        let share = self.cut_at_border(inputs, column, row);
        if share == 0.0 {
            return background;
        }
        let colour = inputs.cells.mean_colour_within(simd, &self.polygon, &mut self.kept);
        let corner = row * inputs.lattice.stride + column;
        let gain = inputs.planes.gain[corner];
        (colour * (gain * share) + f32x4::load_array(simd, background) * (1.0 - share)).to_array()
    }

    /// Leaves the gel's side of a part, at rest, in `polygon`; its share of the whole.
    fn cut_at_border(&mut self, inputs: &ColourInputs, column: usize, row: usize) -> f32 {
        let corner = row * inputs.lattice.stride + column;
        let point = |corner: usize| [inputs.planes.x[corner], inputs.planes.y[corner]].map(f64::from);
        let below = corner + inputs.lattice.stride;
        self.polygon.clear();
        self.polygon.extend([corner, corner + 1, below + 1, below].map(point));
        let whole = signed_area(&self.polygon);
        for (axis, [least, most]) in inputs.cells.borders_mm().into_iter().enumerate() {
            cut(&self.polygon, axis, most, &mut self.kept, &mut self.beyond);
            cut(&self.kept, axis, least, &mut self.beyond, &mut self.polygon);
        }
        let share = signed_area(&self.polygon) / whole;
        if share.is_finite() && share > 1e-6 { share.min(1.0) as f32 } else { 0.0 }
    }
}

impl CornerRow {
    #[inline(always)]
    fn take<S: Simd>(&mut self, simd: S, inputs: &ColourInputs, row: usize) {
        let Self { places, along } = self;
        let start = row * inputs.lattice.stride;
        let (xs, ys) = (&inputs.planes.x[start..][..places.len()], &inputs.planes.y[start..][..places.len()]);
        let [u, v] = inputs.cells.by_mm();
        let [[left, right], [top, bottom]] = inputs.cells.borders_mm().map(|border| border.map(|value| value as f32));
        for ((place, &x), &y) in places.iter_mut().zip(xs).zip(ys) {
            let is_on_gel = (left..=right).contains(&x) && (top..=bottom).contains(&y);
            *place = if is_on_gel {
                Place::new(u[0] * x + u[1] * y + u[2], v[0] * x + v[1] * y + v[2])
            } else if x.is_nan() {
                Place::NOWHERE
            } else {
                Place::BEYOND
            };
        }
        for (along, ends) in along.iter_mut().zip(places.windows(2)) {
            *along = inputs.cells.along(simd, &ends[0], &ends[1]).to_array();
        }
    }
}
