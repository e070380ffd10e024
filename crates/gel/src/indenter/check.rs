//! The possible values of an indenter.

use std::fmt::Debug;

use fingervision_elastic::GelBlock;
use fingervision_settings::SettingsError;

use super::{Indenter, IndenterError, IndenterRelief, IndenterShape};

/// Most corners of a polygon, most pins, most letters.
const MOST_POINTS: usize = 1000;
const MOST_LETTERS: usize = 32;
/// Points at most this far behind the foremost point belong to the first contact, mm.
const FIRST_MM: f64 = 0.1;
/// Up to this height behind the foremost point the body must not be wider than the gel, mm.
const BODY_MM: f64 = 3.0;
const LENGTH: &str = "a length of 0.01 to 1000 mm";

impl Indenter {
    /// Checks every value that needs neither a file nor the gel.
    ///
    /// # Errors
    ///
    /// [`IndenterError::Setting`] or [`IndenterError::EdgesMeet`] for the first impossible value.
    pub fn validate(&self) -> Result<(), IndenterError> {
        self.shape.validate()?;
        let (fillet, slope, angle) = (self.fillet_mm, self.wall_slope, self.rotation_rad);
        check((0.01..=5.0).contains(&fillet), "fillet_mm", &fillet, "a radius of 0.01 to 5 mm")?;
        check((0.2..=20.0).contains(&slope), "wall_slope", &slope, "a slope of 0.2 to 20, where 1 is 45°")?;
        check(angle.is_finite(), "rotation_rad", &angle, "a finite angle, rad")
    }

    /// Checks that the body fits on a gel with its origin at `centre_mm`.
    pub(super) fn check_on(
        &self,
        relief: &IndenterRelief,
        block: &GelBlock,
        centre_mm: [f64; 2],
    ) -> Result<(), IndenterError> {
        let gel_mm = block.size_mm;
        let size_mm = relief.footprint_mm(BODY_MM).map(|[low, high]| high - low);
        if (0..2).any(|axis| size_mm[axis] > gel_mm[axis]) {
            let (key, value) = self.shape.size();
            return Err(IndenterError::WiderThanGel { key, value, size_mm, gel_mm });
        }
        let footprint = relief.footprint_mm(FIRST_MM);
        let face_mm = [0, 1].map(|axis| footprint[axis].map(|value| value + centre_mm[axis]));
        let is_on = |axis: usize| -0.5 * gel_mm[axis] <= face_mm[axis][0] && face_mm[axis][1] <= 0.5 * gel_mm[axis];
        if is_on(0) && is_on(1) { Ok(()) } else { Err(IndenterError::OffTheGel { centre_mm, face_mm, gel_mm }) }
    }
}

impl IndenterShape {
    fn validate(&self) -> Result<(), IndenterError> {
        match self {
            Self::Circle { radius_mm } | Self::Sphere { radius_mm } => length("radius_mm", *radius_mm),
            Self::Rectangle { size_mm } => lengths("size_mm", size_mm),
            Self::Triangle { side_mm } => length("side_mm", *side_mm),
            Self::Polygon { points_mm } => polygon(points_mm),
            Self::Crossing { bar_mm } => {
                lengths("bar_mm", bar_mm)?;
                check(bar_mm[1] < bar_mm[0], "bar_mm", bar_mm, "a length and a smaller width, mm")
            }
            Self::Ring { inner_radius_mm, outer_radius_mm } => {
                length("inner_radius_mm", *inner_radius_mm)?;
                length("outer_radius_mm", *outer_radius_mm)?;
                let allowed = format!("less than the outer radius, {outer_radius_mm} mm");
                check(inner_radius_mm < outer_radius_mm, "inner_radius_mm", inner_radius_mm, &allowed)
            }
            Self::Pins { radius_mm, centres_mm } => {
                length("radius_mm", *radius_mm)?;
                check(!centres_mm.is_empty(), "centres_mm", centres_mm, "one place or more, [[x, y], …] in mm")?;
                points("centres_mm", centres_mm)
            }
            Self::Letter { text, height_mm } => {
                let count = text.chars().count();
                let allowed = format!("1 to {MOST_LETTERS} characters, not all of them blank");
                check(!text.trim().is_empty() && count <= MOST_LETTERS, "text", text, &allowed)?;
                length("height_mm", *height_mm)
            }
            Self::HeightMap { size_mm, height_mm, .. } => {
                lengths("size_mm", size_mm)?;
                length("height_mm", *height_mm)
            }
            Self::Stl { scale, .. } => {
                let is_scale = (1e-6..=1e6).contains(scale);
                check(is_scale, "scale", scale, "the length of the file's unit, 1e-6 to 1e6 mm")
            }
        }
    }

    /// The key that a body's width depends on, and its value.
    fn size(&self) -> (&'static str, String) {
        match self {
            Self::Circle { radius_mm } | Self::Sphere { radius_mm } => ("radius_mm", radius_mm.to_string()),
            Self::Rectangle { size_mm } | Self::HeightMap { size_mm, .. } => ("size_mm", format!("{size_mm:?}")),
            Self::Triangle { side_mm } => ("side_mm", side_mm.to_string()),
            Self::Polygon { points_mm } => ("points_mm", listed(points_mm)),
            Self::Crossing { bar_mm } => ("bar_mm", format!("{bar_mm:?}")),
            Self::Ring { outer_radius_mm, .. } => ("outer_radius_mm", outer_radius_mm.to_string()),
            Self::Pins { centres_mm, .. } => ("centres_mm", listed(centres_mm)),
            Self::Letter { height_mm, .. } => ("height_mm", height_mm.to_string()),
            Self::Stl { scale, .. } => ("scale", scale.to_string()),
        }
    }
}

/// Points in words, a long list as their number.
fn listed(points: &[[f64; 2]]) -> String {
    if points.len() > 8 { format!("{} points", points.len()) } else { format!("{points:?}") }
}

fn check(holds: bool, key: &str, value: &impl Debug, allowed: &str) -> Result<(), IndenterError> {
    let error = || SettingsError::out_of_range(format!("indenter.{key}"), value, allowed);
    if holds { Ok(()) } else { Err(error().into()) }
}

fn length(key: &str, value: f64) -> Result<(), IndenterError> {
    check((0.01..=1000.0).contains(&value), key, &value, LENGTH)
}

fn lengths(key: &str, values: &[f64; 2]) -> Result<(), IndenterError> {
    let allowed = format!("two of them, each {LENGTH}");
    check(values.iter().all(|value| (0.01..=1000.0).contains(value)), key, values, &allowed)
}

fn points(key: &str, points: &[[f64; 2]]) -> Result<(), IndenterError> {
    check(points.len() <= MOST_POINTS, key, &points.len(), &format!("at most {MOST_POINTS} points"))?;
    let is_near = |point: &&[f64; 2]| point.iter().all(|value| value.abs() <= 1000.0);
    match points.iter().find(|point| !is_near(point)) {
        Some(point) => check(false, key, point, "coordinates of -1000 to 1000 mm"),
        None => Ok(()),
    }
}

/// Checks that the outline of the corners encloses an area and does not intersect itself.
fn polygon(corners: &[[f64; 2]]) -> Result<(), IndenterError> {
    let key = "points_mm";
    check(corners.len() >= 3, key, &corners, "three corners or more, [[x, y], …] in mm")?;
    points(key, corners)?;
    let count = corners.len();
    let edge = |n: usize| [corners[n], corners[(n + 1) % count]];
    for [from, to] in (0..count).map(edge) {
        let is_edge = (from[0] - to[0]).hypot(from[1] - to[1]) >= 0.001;
        check(is_edge, key, &[from, to], "corners at least 0.001 mm apart; the outline is closed by itself")?;
    }
    for first in 0..count {
        for second in first + 1..count {
            let places_mm = [edge(first), edge(second)];
            let is_fault = match second - first {
                1 => folds(places_mm),
                last if last == count - 1 => folds([edge(second), edge(first)]),
                _ => meet(places_mm),
            };
            if is_fault {
                return Err(IndenterError::EdgesMeet { edges: [first, second], places_mm });
            }
        }
    }
    Ok(())
}

/// Twice the area of the triangle `a b c`, positive where it turns from x towards y.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether two edges, of which the second begins where the first ends, lie on each other.
fn folds([[from, corner], [_, to]]: [[[f64; 2]; 2]; 2]) -> bool {
    let back = [0, 1].map(|axis| from[axis] - corner[axis]);
    let on = [0, 1].map(|axis| to[axis] - corner[axis]);
    turn(corner, from, to) == 0.0 && back[0] * on[0] + back[1] * on[1] > 0.0
}

/// Whether two edges cross or touch.
fn meet([[a, b], [c, d]]: [[[f64; 2]; 2]; 2]) -> bool {
    let touches = |p: [f64; 2], q: [f64; 2], point: [f64; 2]| {
        let is_beside = |axis: usize| (p[axis].min(q[axis])..=p[axis].max(q[axis])).contains(&point[axis]);
        turn(p, q, point) == 0.0 && is_beside(0) && is_beside(1)
    };
    let parts = |p: [f64; 2], q: [f64; 2], one: [f64; 2], other: [f64; 2]| turn(p, q, one) * turn(p, q, other) < 0.0;
    let crosses = parts(a, b, c, d) && parts(c, d, a, b);
    crosses || touches(a, b, c) || touches(a, b, d) || touches(c, d, a) || touches(c, d, b)
}
