//! The motion of contact along the surface as a whole.

/// Limits on the part of the squared motion in contact that is a translation and a rotation: below the first number
/// contact slides, above the second it sticks. Measured: 0.97 and more for sticking contact whose motion is larger than
/// its strain, at most 0.945 for sliding contact.
const STICKING: [f64; 2] = [0.945, 0.965];

/// A translation and a rotation along the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    centre_mm: [f64; 2],
    shift_mm: [f64; 2],
    turn: f64,
    count: f64,
    /// Sums of squares over the points, mm²: of this motion, and of the points' own.
    square: f64,
    whole_square: f64,
}

impl Motion {
    /// Least-squares motion of points, mm, with these displacements, mm; none without points.
    pub(super) fn of(points: impl Iterator<Item = ([f64; 2], [f64; 2])> + Clone) -> Option<Self> {
        let (mut at_sum, mut moved_sum, mut count) = ([0.0; 2], [0.0; 2], 0.0);
        for (at, moved) in points.clone() {
            for axis in 0..2 {
                at_sum[axis] += at[axis];
                moved_sum[axis] += moved[axis];
            }
            count += 1.0;
        }
        if count <= 0.0 {
            return None;
        }
        let (centre_mm, shift_mm) = (at_sum.map(|sum| sum / count), moved_sum.map(|sum| sum / count));
        let (mut across, mut along) = (0.0, 0.0);
        for (at, moved) in points.clone() {
            let from = [0, 1].map(|axis| at[axis] - centre_mm[axis]);
            let to = [0, 1].map(|axis| from[axis] + moved[axis] - shift_mm[axis]);
            across += from[0] * to[1] - from[1] * to[0];
            along += from[0] * to[0] + from[1] * to[1];
        }
        let mut motion = Self { centre_mm, shift_mm, turn: across.atan2(along), count, square: 0.0, whole_square: 0.0 };
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        for (at, moved) in points {
            motion.square += square(motion.moves(at));
            motion.whole_square += square(moved);
        }
        Some(motion)
    }

    /// The mean displacement of the points, mm.
    pub(super) fn shift_mm(&self) -> [f64; 2] {
        self.shift_mm
    }

    /// The displacement of a point, mm.
    pub(super) fn moves(&self, at_mm: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| at_mm[axis] - self.centre_mm[axis]);
        let (sin, cos) = self.turn.sin_cos();
        [self.shift_mm[0] + (cos - 1.0) * x - sin * y, self.shift_mm[1] + sin * x + (cos - 1.0) * y]
    }

    /// Its root mean square over the points, mm.
    pub(super) fn mean_mm(&self) -> f64 {
        (self.square / self.count).sqrt()
    }

    /// Root mean square of the points' own displacement, mm.
    pub(super) fn whole_mm(&self) -> f64 {
        (self.whole_square / self.count).sqrt()
    }

    /// The sum of its squares over the points, mm².
    pub(super) fn square(&self) -> f64 {
        self.square
    }

    /// How closely the points follow this motion, 0 to 1; 1 if none moves.
    pub(super) fn sticking(&self) -> f64 {
        if self.whole_square > 0.0 { ramp(self.square / self.whole_square, STICKING) } else { 1.0 }
    }
}

/// 0 below the first number, 1 above the second, linear in between.
pub(super) fn ramp(value: f64, [none, whole]: [f64; 2]) -> f64 {
    ((value - none) / (whole - none)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a grid, with this motion.
    fn points(moved: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<([f64; 2], [f64; 2])> {
        let places = (0..48).map(|k| [2.0 + 0.5 * f64::from(k % 8), 0.5 * f64::from(k / 8) - 1.0]);
        places.map(|at| (at, moved(at))).collect()
    }

    #[test]
    fn a_shift_and_a_turn_are_found_and_stick() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let points = points(|[x, y]| [0.4 + cos * x - sin * y - x, sin * x + cos * y - y - 0.2]);
        let motion = Motion::of(points.iter().copied()).unwrap();
        for &(at, moved) in &points {
            let found = motion.moves(at);
            assert!((0..2).all(|axis| (found[axis] - moved[axis]).abs() < 1e-9), "{found:?}, not {moved:?}");
        }
        assert!((motion.sticking() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_spreads_slides() {
        let points = points(|[x, y]| [0.1 * (x - 3.75), 0.1 * (y - 0.25)]);
        let motion = Motion::of(points.iter().copied()).unwrap();
        assert!(motion.sticking() < 1e-9 && motion.square() < 1e-9);
        assert!(Motion::of(std::iter::empty()).is_none());
    }
}
