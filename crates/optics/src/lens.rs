//! The lens: the distortion of a direction `(x, y)`, and its inverse.
//!
//! With `q = (p2, p1)` the distorted direction is the gradient of the potential `∫ r f(r) dr + r² (q · (x, y))`. Its
//! Jacobian is therefore symmetric, and the identity on the axis. On a disc about the axis where its determinant stays
//! positive it is positive definite, the potential convex, and the map one to one: that disc is the lens's range, and
//! nothing outside it is projected.

use crate::{Distortion, Radial};

/// A residual below this, relative to one plus the length of the distorted direction, ends the inversion.
const TOLERANCE: f64 = 1e-13;
const MOST_STEPS: usize = 50;
const MOST_HALVINGS: usize = 40;
/// The range is searched from this radius on with this ratio, up to about 89.9° from the axis.
const FIRST_RADIUS: f64 = 1e-3;
const LAST_RADIUS: f64 = 1e3;
const RADIUS_RATIO: f64 = 1.005;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lens {
    distortion: Distortion,
    is_pinhole: bool,
    /// Squared radius of the disc where distortion is one to one, dimensionless; infinite without limit.
    squared_range: f64,
}

impl Lens {
    pub(crate) fn new(distortion: &Distortion) -> Self {
        let Distortion { k1, k2, p1, p2, .. } = *distortion;
        let is_pinhole = [k1, k2, p1, p2].iter().all(|&value| value == 0.0);
        Self { distortion: *distortion, is_pinhole, squared_range: range(distortion).powi(2) }
    }

    /// The distorted direction; none outside its range.
    #[inline]
    pub(crate) fn distort(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        (x * x + y * y < self.squared_range).then(|| self.map([x, y]))
    }

    /// The distorted direction, without a test of the range.
    #[inline]
    fn map(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        if self.is_pinhole {
            return [x, y];
        }
        let Distortion { p1, p2, .. } = self.distortion;
        let squared = x * x + y * y;
        let (factor, _) = radial(&self.distortion, squared);
        [
            x * factor + 2.0 * p1 * x * y + p2 * (squared + 2.0 * x * x),
            y * factor + p1 * (squared + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The symmetric Jacobian `[xx, xy, yy]` of the distorted direction by the direction.
    #[inline]
    pub(crate) fn jacobian(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let Distortion { p1, p2, .. } = self.distortion;
        let (factor, growth) = radial(&self.distortion, x * x + y * y);
        [
            factor + growth * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
            growth * x * y + 2.0 * (p1 * x + p2 * y),
            factor + growth * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
        ]
    }

    /// Gradient of the logarithm of the Jacobian's determinant, by x and y of the direction.
    pub(crate) fn log_determinant_gradient(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Distortion { p1, p2, .. } = self.distortion;
        let [xx, xy, yy] = self.jacobian([x, y]);
        let squared = x * x + y * y;
        let (_, growth) = radial(&self.distortion, squared);
        let bend = radial_bend(&self.distortion, squared);
        // Derivatives of the Jacobian: the potential's third ones, so the order of x and y does not matter.
        let xxx = 3.0 * growth * x + bend * x * x * x + 6.0 * p2;
        let xxy = growth * y + bend * x * x * y + 2.0 * p1;
        let xyy = growth * x + bend * x * y * y + 2.0 * p2;
        let yyy = 3.0 * growth * y + bend * y * y * y + 6.0 * p1;
        let determinant = xx * yy - xy * xy;
        [xxx * yy + xx * xyy - 2.0 * xy * xxy, xxy * yy + xx * yyy - 2.0 * xy * xyy].map(|slope| slope / determinant)
    }

    /// Derivatives of the distorted direction by k1, k2, p1 and p2: a row for x, a row for y.
    pub(crate) fn by_coefficients(&self, [x, y]: [f64; 2]) -> [[f64; 4]; 2] {
        let squared = x * x + y * y;
        let second = match self.distortion.radial {
            Radial::Brown => squared * squared,
            Radial::Printed => squared.sqrt(),
        };
        [
            [x * squared, x * second, 2.0 * x * y, squared + 2.0 * x * x],
            [y * squared, y * second, squared + 2.0 * y * y, 2.0 * x * y],
        ]
    }

    /// The direction whose distortion is `distorted`, by Newton's method with steps shortened until the residual falls;
    /// `None` if no direction in the lens's range has this distortion.
    pub(crate) fn undistort(&self, distorted: [f64; 2]) -> Option<[f64; 2]> {
        if self.is_pinhole {
            return distorted.iter().all(|value| value.is_finite()).then_some(distorted);
        }
        let length = squared(distorted).sqrt();
        let tolerance = TOLERANCE * (1.0 + length);
        // Half the range at most: the Jacobian vanishes at its end.
        let start = (0.5 * self.squared_range.sqrt() / length).min(1.0);
        let mut direction = distorted.map(|value| start * value);
        let mut residual = difference(distorted, self.map(direction));
        for _ in 0..MOST_STEPS {
            if squared(residual) <= tolerance * tolerance {
                return Some(direction);
            }
            (direction, residual) = self.newton_step(distorted, direction, residual)?;
        }
        None
    }

    /// The next direction and its residual; none if no step lowers the residual.
    fn newton_step(&self, distorted: [f64; 2], from: [f64; 2], residual: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        let [xx, xy, yy] = self.jacobian(from);
        let determinant = xx * yy - xy * xy;
        let full =
            [(yy * residual[0] - xy * residual[1]) / determinant, (xx * residual[1] - xy * residual[0]) / determinant];
        let before = squared(residual);
        let mut part = 1.0;
        for _ in 0..MOST_HALVINGS {
            let direction = [from[0] + part * full[0], from[1] + part * full[1]];
            if let Some(image) = self.distort(direction) {
                let residual = difference(distorted, image);
                if squared(residual) < before {
                    return Some((direction, residual));
                }
            }
            part *= 0.5;
        }
        None
    }
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn squared([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}

/// The radial factor `f(r)` and `f′(r) / r`, by r².
#[inline]
fn radial(distortion: &Distortion, squared: f64) -> (f64, f64) {
    let Distortion { k1, k2, .. } = *distortion;
    match distortion.radial {
        Radial::Brown => (1.0 + squared * (k1 + k2 * squared), 2.0 * k1 + 4.0 * k2 * squared),
        Radial::Printed => {
            let radius = squared.sqrt();
            // On the axis the second term only ever multiplies zero.
            let second = if radius > 0.0 { k2 / radius } else { 0.0 };
            (1.0 + k1 * squared + k2 * radius, 2.0 * k1 + second)
        }
    }
}

/// `(f′(r) / r)′ / r`, by r².
fn radial_bend(distortion: &Distortion, squared: f64) -> f64 {
    let Distortion { k2, .. } = *distortion;
    match distortion.radial {
        Radial::Brown => 8.0 * k2,
        // On the axis it only ever multiplies zero, as above.
        Radial::Printed if squared > 0.0 => -k2 / (squared * squared.sqrt()),
        Radial::Printed => 0.0,
    }
}

/// Radius of the largest disc on which the Jacobian's determinant is positive, dimensionless.
fn range(distortion: &Distortion) -> f64 {
    let is_regular = |radius: f64| least_determinant(distortion, radius) > 0.0;
    let mut inside = 0.0;
    let mut outside = FIRST_RADIUS;
    while is_regular(outside) {
        inside = outside;
        outside *= RADIUS_RATIO;
        if outside > LAST_RADIUS {
            return f64::INFINITY;
        }
    }
    loop {
        let middle = 0.5 * (inside + outside);
        if middle <= inside || middle >= outside {
            return inside;
        }
        *(if is_regular(middle) { &mut inside } else { &mut outside }) = middle;
    }
}

/// The smallest determinant of the Jacobian on a circle.
///
/// Along and across the radius the Jacobian is `[[a + 6 t c, −2 t s], [−2 t s, b + 2 t c]]` with `a = (r f)′`, `b = f`,
/// `t = r √(p1² + p2²)` and c, s the cosine and sine of the angle to `(p2, p1)`. Its determinant is quadratic in c.
fn least_determinant(distortion: &Distortion, radius: f64) -> f64 {
    let (b, growth) = radial(distortion, radius * radius);
    let a = b + growth * radius * radius;
    let t = radius * distortion.p1.hypot(distortion.p2);
    if a <= 0.0 || b <= 0.0 {
        return a.min(b);
    }
    let linear = 2.0 * t * (a + 3.0 * b);
    let cosine = if linear < 32.0 * t * t { -linear / (32.0 * t * t) } else { -1.0 };
    a * b + linear * cosine + 16.0 * t * t * cosine * cosine - 4.0 * t * t
}
