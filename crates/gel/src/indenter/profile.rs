//! The fall-off of a face beyond its edge: a circular fillet, then a straight wall.

/// Height behind the face over the distance `d` from it.
///
/// With fillet radius `r` and wall slope `s`: `h = r − √(r² − d²)` until its slope reaches `s`, at `d = r·s/√(1 + s²)`;
/// beyond, `h` grows by `s` per mm. Height and slope are continuous, the second derivative jumps at both ends of the
/// fillet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    radius_mm: f64,
    wall_slope: f64,
    /// Distance at which the wall begins.
    wall_from_mm: f64,
    wall_height_mm: f64,
}

/// The profile at a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fall {
    pub(super) height_mm: f64,
    /// First derivative, dimensionless.
    pub(super) slope: f64,
    /// Second derivative, 1/mm.
    pub(super) bend_per_mm: f64,
}

impl Profile {
    pub(super) fn new(radius_mm: f64, wall_slope: f64) -> Self {
        let stretch = wall_slope.hypot(1.0);
        let (wall_from_mm, wall_height_mm) = (radius_mm * wall_slope / stretch, radius_mm * (1.0 - 1.0 / stretch));
        Self { radius_mm, wall_slope, wall_from_mm, wall_height_mm }
    }

    pub(super) fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// The profile at a distance of 0 mm or more.
    pub(super) fn at(&self, distance_mm: f64) -> Fall {
        let (d, r) = (distance_mm, self.radius_mm);
        if d >= self.wall_from_mm {
            let height_mm = self.wall_height_mm + self.wall_slope * (d - self.wall_from_mm);
            return Fall { height_mm, slope: self.wall_slope, bend_per_mm: 0.0 };
        }
        let root = (r * r - d * d).sqrt();
        // d² / (r + root) is r − root without cancellation.
        Fall { height_mm: d * d / (r + root), slope: d / root, bend_per_mm: r * r / (root * root * root) }
    }

    /// The distance at which a height is reached, mm.
    pub(super) fn distance_at(&self, height_mm: f64) -> f64 {
        if height_mm >= self.wall_height_mm {
            return self.wall_from_mm + (height_mm - self.wall_height_mm) / self.wall_slope;
        }
        (height_mm * (2.0 * self.radius_mm - height_mm)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fillet_is_a_circle_and_the_wall_straight() {
        let profile = Profile::new(0.3, 3.0);
        for d in [0.0, 0.05, 0.17, 0.28] {
            let expected = 0.3 - (0.09_f64 - d * d).sqrt();
            assert!((profile.at(d).height_mm - expected).abs() < 1e-15, "{d}");
        }
        let from = 0.3 * 3.0 / 10.0_f64.sqrt();
        let wall = |d: f64| 0.3 - 0.3 / 10.0_f64.sqrt() + 3.0 * (d - from);
        for d in [from, 0.4, 2.0] {
            assert!((profile.at(d).height_mm - wall(d)).abs() < 1e-15, "{d}");
            assert_eq!((profile.at(d).slope, profile.at(d).bend_per_mm), (3.0, 0.0));
        }
    }

    #[test]
    fn height_and_slope_are_continuous() {
        let profile = Profile::new(0.3, 3.0);
        let from = 0.9 / 10.0_f64.sqrt();
        let (below, above) = (profile.at(from - 1e-12), profile.at(from + 1e-12));
        assert!((below.height_mm - above.height_mm).abs() < 1e-11);
        assert!((below.slope - above.slope).abs() < 1e-9);
        assert!(profile.at(1e-12).slope < 1e-11);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (profile, step) = (Profile::new(0.3, 3.0), 1e-6);
        for d in [0.01, 0.1, 0.2, 0.27, 0.5] {
            let [before, after] = [d - step, d + step].map(|d| profile.at(d));
            let slope = (after.height_mm - before.height_mm) / (2.0 * step);
            let bend = (after.slope - before.slope) / (2.0 * step);
            assert!((profile.at(d).slope - slope).abs() < 1e-8, "{d}: {slope}");
            assert!(
                (profile.at(d).bend_per_mm / bend.max(1e-3) - 1.0).abs() < 1e-6 || bend.abs() < 1e-6,
                "{d}: {bend}"
            );
        }
    }

    #[test]
    fn a_height_is_found_at_its_distance() {
        let profile = Profile::new(0.5, 2.0);
        for height in [0.0, 0.1, 0.25, 0.4, 3.0] {
            assert!((profile.at(profile.distance_at(height)).height_mm - height).abs() < 1e-14, "{height}");
        }
    }
}
