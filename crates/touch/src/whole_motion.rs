//! The motion of the whole image: a shift, a rotation and a magnification, as of a camera that moves.

/// A motion of the whole image, as what undoes it: from where a point is seen to where it was,
/// `x' = x₀ + a x + b y`, `y' = y₀ + a y − b x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WholeMotion {
    origin_px: [f64; 2],
    along: f64,
    across: f64,
}

/// A motion that was fitted to a flow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FittedMotion {
    pub(crate) motion: WholeMotion,
    /// Number of samples.
    pub(crate) count: usize,
    /// Root mean square of the flow, px, and of what the motion leaves of it.
    pub(crate) flow_px: f64,
    pub(crate) left_px: f64,
}

impl WholeMotion {
    /// No motion.
    pub(crate) const NONE: Self = Self { origin_px: [0.0; 2], along: 1.0, across: 0.0 };

    /// Least-squares fit to samples of a flow: places and displacements, px. None without samples.
    pub(crate) fn fit(samples: impl Iterator<Item = ([f64; 2], [f64; 2])>) -> Option<FittedMotion> {
        let (mut count, mut place_sum, mut flow_sum) = (0_usize, [0.0; 2], [0.0; 2]);
        let (mut place_squares, mut flow_squares, mut along, mut across) = (0.0, 0.0, 0.0, 0.0);
        for ([x, y], [u, v]) in samples {
            count += 1;
            place_sum = [place_sum[0] + x, place_sum[1] + y];
            flow_sum = [flow_sum[0] + u, flow_sum[1] + v];
            place_squares += x * x + y * y;
            flow_squares += u * u + v * v;
            along += x * u + y * v;
            across += x * v - y * u;
        }
        if count == 0 {
            return None;
        }
        let ([x, y], [u, v], number) = (place_sum, flow_sum, count as f64);
        // About the mean place and relative to the mean displacement.
        let spread = (place_squares - (x * x + y * y) / number).max(f64::MIN_POSITIVE);
        let along = along - (x * u + y * v) / number;
        let across = across - (x * v - y * u) / number;
        let explained = (u * u + v * v) / number + (along * along + across * across) / spread;
        // The magnification and the sine of the rotation; where the mean place is seen.
        let (grown, turned) = (1.0 + along / spread, across / spread);
        let seen_px = [(x + u) / number, (y + v) / number];
        let square = grown * grown + turned * turned;
        let (along, across) = (grown / square, turned / square);
        let origin_px = [
            x / number - along * seen_px[0] - across * seen_px[1],
            y / number - along * seen_px[1] + across * seen_px[0],
        ];
        let motion = Self { origin_px, along, across };
        let [flow_px, left_px] = [flow_squares, (flow_squares - explained).max(0.0)].map(|sum| (sum / number).sqrt());
        Some(FittedMotion { motion, count, flow_px, left_px })
    }

    /// Where the point that is seen at a place, px, was before the motion.
    #[inline]
    pub(crate) fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [origin_x, origin_y] = self.origin_px;
        [origin_x + self.along * x + self.across * y, origin_y + self.along * y - self.across * x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(flow: impl Fn(f64, f64) -> [f64; 2]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
        let places = (0..40).map(|k| [f64::from(k % 8) * 7.0 + 3.0, f64::from(k / 8) * 11.0 + 20.0]);
        places.map(move |[x, y]| ([x, y], flow(x, y)))
    }

    #[test]
    fn a_shift_a_rotation_and_a_magnification_are_found_and_undone() {
        let flow = |x: f64, y: f64| [4.0 + 0.03 * x - 0.01 * y, 0.01 * x + 0.03 * y - 2.0];
        let found = WholeMotion::fit(samples(flow)).unwrap();
        assert_eq!(found.count, 40);
        assert!(found.left_px < 1e-6 && found.flow_px > 1.0, "{found:?}");
        for ([x, y], [u, v]) in samples(flow) {
            let before = found.motion.undo([x + u, y + v]);
            assert!((before[0] - x).abs() < 1e-9 && (before[1] - y).abs() < 1e-9, "({x}, {y}): {before:?}");
        }
    }

    #[test]
    fn a_shear_is_a_rotation_only_in_part() {
        let shear = WholeMotion::fit(samples(|_, y| [0.01 * (y - 42.0), 0.0])).unwrap();
        assert!((0.5..0.9).contains(&(shear.left_px / shear.flow_px)), "{shear:?}");
        assert!(WholeMotion::fit(std::iter::empty()).is_none());
    }

    #[test]
    fn no_motion_changes_no_bit() {
        for px in [[0.1, -0.7], [1e-9, 479.3]] {
            assert_eq!(WholeMotion::NONE.undo(px).map(f64::to_bits), px.map(f64::to_bits));
        }
    }
}
