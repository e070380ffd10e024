//! Flat faces: which points they contain, and the distance of other points from them.

use super::nearest::Nearest;
use super::outline::Outline;

/// A flat face.
#[derive(Debug, Clone)]
pub(super) enum Face {
    /// Straight edges.
    Outline(Outline),
    /// Round faces of one radius, which may overlap.
    Discs { radius_mm: f64, centres_mm: Vec<[f64; 2]> },
    /// A ring between two circles about the origin.
    Ring { inner_radius_mm: f64, outer_radius_mm: f64 },
}

impl Face {
    /// Whether a point lies on the face.
    pub(super) fn contains(&self, point: [f64; 2]) -> bool {
        match self {
            Self::Outline(outline) => outline.contains(point),
            _ => self.nearest(point).is_none(),
        }
    }

    /// The vector from the face to a point; absent on the face.
    pub(super) fn nearest(&self, point: [f64; 2]) -> Option<Nearest> {
        match self {
            Self::Outline(outline) => outline.nearest(point),
            Self::Discs { radius_mm, centres_mm } => {
                let square = |centre: &[f64; 2]| (point[0] - centre[0]).powi(2) + (point[1] - centre[1]).powi(2);
                let centre = centres_mm.iter().min_by(|a, b| square(a).total_cmp(&square(b)))?;
                beyond_circle([point[0] - centre[0], point[1] - centre[1]], *radius_mm)
            }
            Self::Ring { inner_radius_mm, outer_radius_mm } => {
                within_circle(point, *inner_radius_mm).or_else(|| beyond_circle(point, *outer_radius_mm))
            }
        }
    }

    /// Smallest and largest coordinate along x and y, mm.
    pub(super) fn extent_mm(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Outline(outline) => outline.extent_mm(),
            Self::Discs { radius_mm, centres_mm } => [0, 1].map(|axis| {
                let along = centres_mm.iter().map(|centre| centre[axis]);
                let widest = [f64::INFINITY, f64::NEG_INFINITY];
                let [low, high] = along.fold(widest, |[low, high], value| [low.min(value), high.max(value)]);
                [low - radius_mm, high + radius_mm]
            }),
            Self::Ring { outer_radius_mm, .. } => [[-outer_radius_mm, *outer_radius_mm]; 2],
        }
    }
}

fn beyond_circle(from_centre: [f64; 2], radius_mm: f64) -> Option<Nearest> {
    let length = from_centre[0].hypot(from_centre[1]);
    (length > radius_mm).then(|| Nearest {
        distance_mm: length - radius_mm,
        away: from_centre.map(|value| value / length),
        bend_per_mm: 1.0 / length,
    })
}

/// From a circle inwards. In the middle all directions are equally near, and there is none: the mean of all.
fn within_circle(from_centre: [f64; 2], radius_mm: f64) -> Option<Nearest> {
    let length = from_centre[0].hypot(from_centre[1]);
    if length == 0.0 {
        return Some(Nearest { distance_mm: radius_mm, away: [0.0; 2], bend_per_mm: 0.0 });
    }
    (length < radius_mm).then(|| Nearest {
        distance_mm: radius_mm - length,
        away: from_centre.map(|value| -value / length),
        bend_per_mm: -1.0 / length,
    })
}
