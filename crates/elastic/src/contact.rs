//! A rigid body against the gel's surface: its shape, where it stands, how it holds, what the gel's surface does.

use serde::{Deserialize, Serialize};

/// What happens between gel and indenter where they touch. Contact never pulls.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactLaw {
    /// A point that touches stays where it touched until it is pulled off.
    #[default]
    Stick,
    /// Nothing holds a point sideways.
    Frictionless,
    /// Coulomb: a point slips where the shear force would exceed this coefficient times the normal force.
    Friction(f64),
}

/// The rigid indenter's face as a height map over its own plane.
///
/// In the indenter's frame the body fills `z ≤ −height(x, y)`: its foremost point has height 0, a point that lies
/// farther back a positive height, in mm. `f64::INFINITY` where there is no body.
pub trait Relief: Sync {
    /// Height and derivatives at a point of the indenter's plane, mm.
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint;

    /// Half-extents along x and y of a box about the origin that holds the foremost 3 mm of the body, mm.
    fn half_extent_mm(&self) -> [f64; 2];

    /// Smallest and largest x and y of the body's flat face, mm, if it has one.
    fn face_mm(&self) -> Option<[[f64; 2]; 2]> {
        None
    }
}

/// The relief at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefPoint {
    /// How far the face lies behind the foremost point, mm.
    pub height_mm: f64,
    /// Its slope along x and y, dimensionless.
    pub slope: [f64; 2],
    /// Its second derivatives `[xx, xy, yy]`, 1/mm.
    pub curvature_per_mm: [f64; 3],
}

/// Where the indenter stands: a rigid motion of its frame, whose rest is the undeformed surface.
///
/// A point `ξ` of the indenter lies at `c + R ξ` with `c = (centre + shear, depth)` and `R` the twist about z after the
/// tilts about x and y through the indenter's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// How deep the indenter's origin is pressed in, mm, positive towards the camera.
    pub depth_mm: f64,
    /// Sideways from where the press began, mm.
    pub shear_mm: [f64; 2],
    /// Rotation about z, rad, from x towards y.
    pub twist_rad: f64,
    /// Rotations about x and y, rad, applied x first.
    pub tilt_rad: [f64; 2],
}

/// The gel's surface after a step, at the nodes of a rectangular grid over the undeformed surface.
///
/// Between nodes the displacement is bilinear.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceState {
    /// Grid lines along x, mm, from one side of the gel to the other.
    pub x_mm: Vec<f64>,
    /// Grid lines along y, mm.
    pub y_mm: Vec<f64>,
    /// Displacement of each node, mm, `[y][x]` row-major.
    pub displacement_mm: Vec<[f64; 3]>,
    /// Force of the indenter on each node, N.
    pub nodal_force_n: Vec<[f64; 3]>,
    /// Traction at each node, `MPa`: its force over the undeformed area that it stands for.
    pub traction_mpa: Vec<[f64; 3]>,
    /// Whether a node touches the indenter.
    pub in_contact: Vec<bool>,
    /// Total force of the indenter on the gel, N.
    pub force_n: [f64; 3],
    /// Total torque of the indenter on the gel about the centre of contact where that now is, N mm.
    pub torque_nmm: [f64; 3],
}
