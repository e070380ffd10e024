//! Analytic motions of the image plane: the truth, and the inverse motion from the current image to the reference.
//!
//! Except for the shift and the star, a motion stretches every ray from a centre `c`:
//!
//! ```text
//! X = c + (x − c) (1 + h(n)),   n = ‖x − c‖
//! ```
//!
//! where the norm is Euclidean for round motions and the largest coordinate for square ones. So the inverse is one
//! scalar equation per point, `n (1 + h(n)) = N`, whatever the shape.

use crate::GelError;
use fingervision_image::Image;
use std::f64::consts::TAU;

/// The direction of [`Motion::shift`], clockwise from the x axis.
const SHIFT_ANGLE_DEGREES: f64 = 33.0;

/// Tolerance of the inverse motion, px.
const TOLERANCE_PX: f64 = 1e-12;

/// A displacement of every point of the image plane, in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// The same displacement everywhere.
    Shift {
        /// The displacement, px.
        by_px: [f64; 2],
    },
    /// A round, smooth stretch: `u(r) = A r/R · exp(½ (1 − (r/R)²))` away from the centre.
    RadialBump {
        /// The point that stays, px.
        centre_px: [f64; 2],
        /// `R`, where the displacement is largest, px.
        radius_px: f64,
        /// `A`, the largest displacement, px; positive outwards.
        amplitude_px: f64,
    },
    /// A square scaled by `s`: `u = (s − 1)(x − c)` inside, times `exp(−d/D)` outside.
    ///
    /// `d` is how far the point lies beyond the square along x or y, whichever is more. With the Euclidean distance
    /// the motion would fold at the corners for `s = 1.2`.
    ScaledSquare {
        /// `c`, the point that stays, px.
        centre_px: [f64; 2],
        /// Half a side of the square at rest, px.
        half_side_px: f64,
        /// `D`, the distance in which the displacement decays by `1/e`, px.
        decay_px: f64,
        /// `s`, dimensionless; 1 is at rest.
        scale: f64,
    },
    /// A wave along y whose period grows along x: `v(x, y) = A cos(2π (y − m) / p(x))`, the star of the DIC Challenge
    /// 2.0 (\[Reu2022\]). It shows which periods a method resolves.
    Star {
        /// `A`, the amplitude, px.
        amplitude_px: f64,
        /// `m`, the row of a crest at every period, px.
        crest_px: f64,
        /// `p` at the left border and at the right one, px.
        periods_px: [f64; 2],
        /// Distance between these borders, px.
        width_px: f64,
    },
}

/// The displacement of every reference pixel, in px.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueFlow {
    /// Displacement to the right, px.
    pub u: Image<f32>,
    /// Displacement downwards, px.
    pub v: Image<f32>,
}

impl Motion {
    /// Nothing moves.
    pub const STILL: Self = Self::Shift { by_px: [0.0; 2] };

    /// A shift by `distance_px` at 33° to the right and down, so that x and y differ in their sub-pixel parts.
    #[must_use]
    pub fn shift(distance_px: f64) -> Self {
        let (sin, cos) = SHIFT_ANGLE_DEGREES.to_radians().sin_cos();
        Self::Shift { by_px: [distance_px * cos, distance_px * sin] }
    }

    /// A round stretch, largest 80 px from the centre.
    #[must_use]
    pub fn radial_bump(centre_px: [f64; 2], amplitude_px: f64) -> Self {
        Self::RadialBump { centre_px, radius_px: 80.0, amplitude_px }
    }

    /// A scaled square of 150 px whose displacement decays over 15 px outside.
    #[must_use]
    pub fn scaled_square(centre_px: [f64; 2], scale: f64) -> Self {
        Self::ScaledSquare { centre_px, half_side_px: 75.0, decay_px: 15.0, scale }
    }

    /// The motion part of the way: every displacement times `fraction`.
    ///
    /// A press in `n` frames is `motion.at(k / n)` for `k` from 0 to `n`.
    #[must_use]
    pub fn at(mut self, fraction: f64) -> Self {
        match &mut self {
            Self::Shift { by_px } => *by_px = by_px.map(|by| fraction * by),
            Self::RadialBump { amplitude_px, .. } | Self::Star { amplitude_px, .. } => *amplitude_px *= fraction,
            Self::ScaledSquare { scale, .. } => *scale = 1.0 + fraction * (*scale - 1.0),
        }
        self
    }

    /// The displacement of the reference point `(x, y)`, px.
    #[must_use]
    pub fn displacement(&self, x: f64, y: f64) -> (f64, f64) {
        match *self {
            Self::Shift { by_px } => (by_px[0], by_px[1]),
            Self::Star { .. } => (0.0, self.wave(x, y).0),
            Self::RadialBump { centre_px, .. } | Self::ScaledSquare { centre_px, .. } => {
                let (dx, dy) = (x - centre_px[0], y - centre_px[1]);
                let (h, _) = self.ray_stretch(self.norm(dx, dy));
                (h * dx, h * dy)
            }
        }
    }

    /// The reference point that lies at `(x, y)` in the current image, px: the inverse of
    /// `(x, y) + displacement(x, y)`, within 1e-10 px.
    ///
    /// The result is meaningless where the motion folds, see [`Motion::smallest_stretch`].
    #[must_use]
    pub fn reference_point(&self, x: f64, y: f64) -> (f64, f64) {
        match *self {
            Self::Shift { by_px } => (x - by_px[0], y - by_px[1]),
            Self::Star { .. } => (x, self.crossed_row(x, y)),
            Self::RadialBump { centre_px, .. } | Self::ScaledSquare { centre_px, .. } => {
                let (dx, dy) = (x - centre_px[0], y - centre_px[1]);
                let (h, _) = self.ray_stretch(self.reference_norm(self.norm(dx, dy)));
                (centre_px[0] + dx / (1.0 + h), centre_px[1] + dy / (1.0 + h))
            }
        }
    }

    /// The displacement of every pixel of an image of this size.
    #[must_use]
    pub fn flow(&self, width: usize, height: usize) -> TrueFlow {
        let displacement = |x: usize, y: usize| self.displacement(x as f64, y as f64);
        TrueFlow {
            u: Image::from_fn(width, height, |x, y| displacement(x, y).0 as f32),
            v: Image::from_fn(width, height, |x, y| displacement(x, y).1 as f32),
        }
    }

    /// Smallest ratio of a current length to its reference length along a ray, dimensionless.
    ///
    /// The motion is one-to-one if and only if it is above zero. For the round stretch it is `1 − 2A/(e R)` outwards
    /// and `1 − √e |A|/R` inwards.
    #[must_use]
    pub fn smallest_stretch(&self) -> f64 {
        // The ratio is monotone between these norms, so its least value is at one of them.
        let turns = match *self {
            Self::Shift { .. } => return 1.0,
            Self::Star { amplitude_px, periods_px: [left, right], .. } => {
                return 1.0 - amplitude_px.abs() * TAU / left.min(right);
            }
            Self::RadialBump { radius_px, .. } => [0.0, 3.0_f64.sqrt() * radius_px],
            Self::ScaledSquare { half_side_px, decay_px, .. } => {
                // Just outside the side, where the decay has begun; a small square has its turn farther out.
                [0.0, half_side_px.next_up().max(2.0 * decay_px)]
            }
        };
        turns.map(|norm| self.ray_stretch(norm).1).into_iter().fold(1.0, f64::min)
    }

    /// [`GelError::Folds`] unless the motion is one-to-one.
    pub(crate) fn validate(&self) -> Result<(), GelError> {
        let stretch = self.smallest_stretch();
        if stretch > 0.0 { Ok(()) } else { Err(GelError::Folds { stretch }) }
    }

    /// The star's displacement along y and its derivative by y; 0 for other motions.
    fn wave(&self, x: f64, y: f64) -> (f64, f64) {
        let Self::Star { amplitude_px, crest_px, periods_px: [left, right], width_px } = *self else {
            return (0.0, 0.0);
        };
        let period = left + (right - left) * (x / width_px).clamp(0.0, 1.0);
        let (sin, cos) = (TAU * (y - crest_px) / period).sin_cos();
        (amplitude_px * cos, -amplitude_px * TAU / period * sin)
    }

    /// Solves `y + v(x, y) = current` for y, which lies within the amplitude of `current`.
    fn crossed_row(&self, x: f64, current: f64) -> f64 {
        let Self::Star { amplitude_px, .. } = *self else { return current };
        let bracket = [current - amplitude_px.abs(), current + amplitude_px.abs()];
        solve(current, bracket, |row| {
            let (v, slope) = self.wave(x, row);
            (row + v - current, 1.0 + slope)
        })
    }

    fn norm(&self, dx: f64, dy: f64) -> f64 {
        if matches!(self, Self::ScaledSquare { .. }) { dx.abs().max(dy.abs()) } else { dx.hypot(dy) }
    }

    /// `h(n)` and the stretch along the ray, `d(n (1 + h(n)))/dn`.
    fn ray_stretch(&self, norm: f64) -> (f64, f64) {
        match *self {
            Self::Shift { .. } | Self::Star { .. } => (0.0, 1.0),
            Self::RadialBump { radius_px, amplitude_px, .. } => {
                let square = (norm / radius_px).powi(2);
                let h = amplitude_px / radius_px * (0.5 * (1.0 - square)).exp();
                (h, 1.0 + h * (1.0 - square))
            }
            Self::ScaledSquare { half_side_px, decay_px, scale, .. } => {
                let beyond = norm - half_side_px;
                if beyond <= 0.0 {
                    return (scale - 1.0, scale);
                }
                let h = (scale - 1.0) * (-beyond / decay_px).exp();
                (h, 1.0 + h * (1.0 - norm / decay_px))
            }
        }
    }

    /// Solves `n (1 + h(n)) = current` for n.
    fn reference_norm(&self, current: f64) -> f64 {
        // |h| is largest at the centre and keeps its sign, so the root lies between these two.
        let (h, _) = self.ray_stretch(0.0);
        let bracket = [current.min(current / (1.0 + h)), current.max(current / (1.0 + h))];
        solve(current, bracket, |norm| {
            let (h, slope) = self.ray_stretch(norm);
            (norm * (1.0 + h) - current, slope)
        })
    }
}

/// The root of an increasing function, given with its slope, within a bracket: Newton steps from `start`, halving the
/// bracket where a step would leave it.
fn solve(start: f64, [mut low, mut high]: [f64; 2], function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut root = start;
    while high - low > TOLERANCE_PX {
        let (residual, slope) = function(root);
        if residual > 0.0 {
            high = root;
        } else {
            low = root;
        }
        let step = residual / slope;
        if step.abs() <= TOLERANCE_PX {
            return root - step;
        }
        let middle = 0.5 * (low + high);
        let newton = root - step;
        root = if newton > low && newton < high { newton } else { middle };
        // Neighbouring numbers have no middle.
        if middle <= low || middle >= high {
            return root;
        }
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTRE: [f64; 2] = [304.5, 224.5];

    const STAR: Motion =
        Motion::Star { amplitude_px: 0.5, crest_px: 224.5, periods_px: [10.0, 300.0], width_px: 609.0 };

    fn motions() -> Vec<Motion> {
        let bumps = [-20.0, 5.0, 25.0, 40.0].map(|amplitude| Motion::radial_bump(CENTRE, amplitude));
        let squares = [0.8, 1.1, 1.2].map(|scale| Motion::scaled_square(CENTRE, scale));
        [Motion::STILL, Motion::shift(0.5), Motion::shift(20.0), STAR].into_iter().chain(bumps).chain(squares).collect()
    }

    fn points() -> impl Iterator<Item = (f64, f64)> {
        (0..130)
            .flat_map(|row| (0..170).map(move |column| (3.7 * f64::from(column) - 10.0, 3.6 * f64::from(row) - 9.0)))
    }

    #[test]
    fn the_inverse_motion_returns_to_the_start() {
        for motion in motions() {
            for (x, y) in points().chain([(304.5, 224.5), (379.5, 224.5), (379.5, 299.5)]) {
                let (u, v) = motion.displacement(x, y);
                let (back_x, back_y) = motion.reference_point(x + u, y + v);
                let miss = (back_x - x).hypot(back_y - y);
                assert!(miss < 1e-10, "{motion:?} misses ({x}, {y}) by {miss}");
            }
        }
    }

    #[test]
    fn nothing_folds() {
        let step = 1e-4;
        for motion in motions() {
            assert!(motion.validate().is_ok(), "{motion:?}");
            let place = |x: f64, y: f64| {
                let (u, v) = motion.displacement(x, y);
                (x + u, y + v)
            };
            for (x, y) in points() {
                let (here, right, below) = (place(x, y), place(x + step, y), place(x, y + step));
                let determinant = (right.0 - here.0) * (below.1 - here.1) - (right.1 - here.1) * (below.0 - here.0);
                assert!(determinant > 0.0, "{motion:?} at ({x}, {y})");
            }
        }
    }

    #[test]
    fn the_smallest_stretch_is_the_least_along_a_ray() {
        for motion in motions().into_iter().filter(|motion| *motion != STAR) {
            let ray = (0..4000).map(|k| motion.ray_stretch(0.1 * f64::from(k)).1);
            let least = ray.fold(f64::INFINITY, f64::min);
            let stated = motion.smallest_stretch();
            assert!(stated <= least && least - stated < 0.01, "{motion:?}: {stated} stated, {least} found");
        }
    }

    #[test]
    fn the_star_is_stretched_least_where_its_period_is_least() {
        let stretch =
            |x: f64, y: f64| 1.0 + 1e6 * (STAR.displacement(x, y + 5e-7).1 - STAR.displacement(x, y - 5e-7).1);
        let least = points().map(|(x, y)| stretch(x, y)).fold(f64::INFINITY, f64::min);
        let stated = STAR.smallest_stretch();
        assert!((-1e-6..0.01).contains(&(least - stated)), "{stated} stated, {least} found");
        let folding = Motion::Star { amplitude_px: 2.0, crest_px: 0.0, periods_px: [10.0, 300.0], width_px: 609.0 };
        assert!(matches!(folding.validate(), Err(GelError::Folds { .. })));
    }

    #[test]
    fn a_motion_that_folds_is_refused() {
        assert!(matches!(Motion::radial_bump(CENTRE, 110.0).validate(), Err(GelError::Folds { .. })));
        assert!(matches!(Motion::radial_bump(CENTRE, -50.0).validate(), Err(GelError::Folds { .. })));
        assert!(matches!(Motion::scaled_square(CENTRE, 1.26).validate(), Err(GelError::Folds { .. })));
    }

    #[test]
    fn the_bump_is_largest_at_its_radius() {
        let bump = Motion::radial_bump(CENTRE, 10.0);
        let reach = |r: f64| bump.displacement(CENTRE[0] + r, CENTRE[1]).0;
        assert!((reach(80.0) - 10.0).abs() < 1e-12);
        assert!(reach(79.0) < 10.0 && reach(81.0) < 10.0 && reach(0.0).abs() < 1e-12);
    }

    #[test]
    fn a_fraction_scales_every_displacement() {
        for motion in motions() {
            for (x, y) in [(300.0, 200.0), (400.0, 250.0)] {
                let (whole, part) = (motion.displacement(x, y), motion.at(0.3).displacement(x, y));
                assert!((part.0 - 0.3 * whole.0).abs() < 1e-12 && (part.1 - 0.3 * whole.1).abs() < 1e-12);
            }
        }
    }
}
