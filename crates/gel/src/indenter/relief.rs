//! The indenter for the mechanics: height, slope and curvature at any point.

use fingervision_elastic::{Relief, ReliefPoint};

use super::face::Face;
use super::height_field::HeightField;
use super::nearest::Nearest;
use super::profile::{Fall, Profile};

/// Depth of the part of the body in [`Relief::half_extent_mm`], mm behind the foremost point.
const FOREMOST_MM: f64 = 3.0;

/// The shape of an [`Indenter`](super::Indenter), ready to be pressed.
///
/// Height and derivatives come from one formula, so that they agree to rounding. Flat faces and the sphere are exact;
/// a height map and a mesh are cubic B-splines over a fine grid. Second derivatives jump at the ends of a fillet, and
/// slopes where two parts of the outline are equally near (in a hole, at an inner corner).
#[derive(Debug, Clone)]
pub struct IndenterRelief(Body);

#[derive(Debug, Clone)]
enum Body {
    Face {
        face: Face,
        profile: Profile,
    },
    /// A ball is a fillet about a point.
    Ball(Profile),
    Field(HeightField),
}

impl IndenterRelief {
    pub(super) fn of_face(face: Face, profile: Profile) -> Self {
        Self(Body::Face { face, profile })
    }

    pub(super) fn of_ball(profile: Profile) -> Self {
        Self(Body::Ball(profile))
    }

    pub(super) fn of_field(field: HeightField) -> Self {
        Self(Body::Field(field))
    }

    /// Whether a point of the indenter's plane lies on the foremost face, mm: on the flat face itself, without its
    /// fillet; for other bodies, less than 1 µm behind the foremost point.
    #[must_use]
    pub fn is_face(&self, x_mm: f64, y_mm: f64) -> bool {
        match &self.0 {
            Body::Face { face, .. } => face.contains([x_mm, y_mm]),
            Body::Ball(_) | Body::Field(_) => self.at(x_mm, y_mm).height_mm < 1e-3,
        }
    }

    /// Smallest and largest x and y of the part of the body that lies at most `height_mm` behind the foremost point, mm.
    #[must_use]
    pub fn footprint_mm(&self, height_mm: f64) -> [[f64; 2]; 2] {
        match &self.0 {
            Body::Face { face, profile } => {
                let reach = profile.distance_at(height_mm);
                face.extent_mm().map(|[low, high]| [low - reach, high + reach])
            }
            Body::Ball(profile) => {
                let reach = profile.distance_at(height_mm);
                [[-reach, reach]; 2]
            }
            Body::Field(field) => field.footprint_mm(height_mm),
        }
    }
}

impl Relief for IndenterRelief {
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint {
        match &self.0 {
            Body::Face { face, profile } => match face.nearest([x_mm, y_mm]) {
                Some(nearest) => beside_face(&nearest, &profile.at(nearest.distance_mm)),
                None => ReliefPoint { height_mm: 0.0, slope: [0.0; 2], curvature_per_mm: [0.0; 3] },
            },
            Body::Ball(profile) => on_ball([x_mm, y_mm], profile),
            Body::Field(field) => field.at([x_mm, y_mm]),
        }
    }

    fn half_extent_mm(&self) -> [f64; 2] {
        self.footprint_mm(FOREMOST_MM).map(|[low, high]| high.max(-low))
    }

    fn face_mm(&self) -> Option<[[f64; 2]; 2]> {
        match &self.0 {
            Body::Face { face, .. } => Some(face.extent_mm()),
            Body::Ball(_) | Body::Field(_) => None,
        }
    }
}

/// `h(d(x, y))`: slope `h′ ∇d`, curvature `h″ ∇d ∇dᵀ + h′ ∇∇d`.
fn beside_face(nearest: &Nearest, fall: &Fall) -> ReliefPoint {
    let [x, y] = nearest.away;
    let (along, across) = (fall.bend_per_mm, fall.slope * nearest.bend_per_mm);
    ReliefPoint {
        height_mm: fall.height_mm,
        slope: [fall.slope * x, fall.slope * y],
        curvature_per_mm: [along * x * x + across * y * y, (along - across) * x * y, along * y * y + across * x * x],
    }
}

fn on_ball(point: [f64; 2], profile: &Profile) -> ReliefPoint {
    let distance_mm = point[0].hypot(point[1]);
    let fall = profile.at(distance_mm);
    if distance_mm == 0.0 {
        let bend = 1.0 / profile.radius_mm();
        return ReliefPoint { height_mm: 0.0, slope: [0.0; 2], curvature_per_mm: [bend, 0.0, bend] };
    }
    let away = point.map(|value| value / distance_mm);
    beside_face(&Nearest { distance_mm, away, bend_per_mm: 1.0 / distance_mm }, &fall)
}
