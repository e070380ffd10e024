//! A rigid body against the gel's surface: its shape, its pose, the contact law, and the resulting surface.

use serde::{Deserialize, Serialize};

/// The contact law between gel and indenter. Contact forces never pull.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactLaw {
    /// A point that touches stays where it touched until it is pulled off.
    #[default]
    Stick,
    /// A point slides freely in the step in which it touches, and then stays where it is until it is pulled off. The gel is thus
    /// strained under a face when it begins to stick, more so in larger steps.
    LateStick,
    /// No shear force acts on a point.
    Frictionless,
    /// Coulomb: a point slips where the shear force would exceed this coefficient times the normal force.
    Friction(f64),
}

/// The rigid indenter's face as a height map over its own plane.
///
/// In the indenter's frame the body fills `z ≤ −height(x, y)`: its foremost point has height 0, a point farther back
/// has a positive height, in mm. `f64::INFINITY` outside the outline of the body.
pub trait Relief: Sync {
    /// Height and derivatives at a point of the indenter's plane, mm.
    fn at(&self, x_mm: f64, y_mm: f64) -> ReliefPoint;

    /// Half-extents along x and y of a box about the origin that contains the foremost 3 mm of the body, mm.
    fn half_extent_mm(&self) -> [f64; 2];

    /// Smallest and largest x and y of the body's flat face, mm, if it has one.
    fn face_mm(&self) -> Option<[[f64; 2]; 2]> {
        None
    }
}

/// The relief at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefPoint {
    /// Distance of the face behind the foremost point, mm.
    pub height_mm: f64,
    /// Its slope along x and y, dimensionless.
    pub slope: [f64; 2],
    /// Its second derivatives `[xx, xy, yy]`, 1/mm.
    pub curvature_per_mm: [f64; 3],
}

/// The pose of the indenter: a rigid motion of its frame, which at rest is the undeformed surface.
///
/// A point `ξ` of the indenter lies at `c + R ξ` with `c = (centre + shear, depth)` and `R` the twist about z after the
/// tilts about x and y through the indenter's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// Indentation depth of the indenter's origin, mm, positive towards the camera.
    pub depth_mm: f64,
    /// Displacement along the surface from where the press began, mm.
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
    /// Traction at each node, `MPa`: its force over the undeformed area that it represents.
    pub traction_mpa: Vec<[f64; 3]>,
    /// Whether a node touches the indenter.
    pub in_contact: Vec<bool>,
    /// Total force of the indenter on the gel, N.
    pub force_n: [f64; 3],
    /// Total torque of the indenter on the gel about the current centre of contact, N mm.
    pub torque_nmm: [f64; 3],
}
