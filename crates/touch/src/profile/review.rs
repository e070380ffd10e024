//! What a profile enables, before any frame is tracked.

use fingervision_elastic::GelBlock;
use fingervision_image::Rect;
use fingervision_optics::Camera;
use serde::Serialize;

use super::remarks::{self, Remark};
use super::{DepthMethod, Profile};

/// Points along each side of the grids that count what is visible.
const GRID: usize = 41;

/// What a profile enables, what the camera sees and what looks wrong.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ProfileReview {
    /// Left column, top row, width and height of the tracked region, px; absent if it is the whole frame and its size is
    /// unknown.
    pub region_of_interest: Option<[usize; 4]>,
    /// The method for depth, or none.
    pub depth: Option<DepthMethod>,
    /// Whether force is computed.
    pub has_force: bool,
    /// Size of a pixel on the undeformed surface where the optical axis meets it, mm.
    pub mm_per_px: Option<f64>,
    /// Width and height of the field of view of the region through its middle, mm on the undeformed surface.
    pub field_of_view_mm: Option<[f64; 2]>,
    /// Part of the gel's surface that the region shows, 0 to 1.
    pub gel_seen: Option<f64>,
    /// Part of the region that shows gel, 0 to 1.
    pub region_on_gel: Option<f64>,
    /// Whether gel and camera are outside the training range of the network behind elastic depth; absent without it.
    pub is_outside_training_range: Option<bool>,
    /// What is wrong, looks wrong or is missing, faults first.
    pub remarks: Vec<Remark>,
}

impl Profile {
    /// What the profile enables and what looks wrong, for frames of this size if it is known.
    #[must_use]
    pub fn review(&self, frame_size: Option<(usize, usize)>) -> ProfileReview {
        let whole = |(width, height)| Rect::whole(width, height);
        let named = self.image.map(|image| image.region_of_interest);
        let region = named.map(|[x, y, width, height]| Rect { x, y, width, height }).or(frame_size.map(whole));
        let camera = self.camera.and_then(|params| Camera::new(&params).ok());
        let scene = region.zip(camera);
        let with_gel = scene.as_ref().zip(self.gel);
        let is_elastic = self.depth_method() == DepthMethod::Elastic && self.elastic_sensor().is_ok();
        let depth = match (is_elastic, self.depth.density) {
            (true, _) => Some(DepthMethod::Elastic),
            (false, Some(_)) if self.depth_method() == DepthMethod::Density => Some(DepthMethod::Density),
            _ => None,
        };
        let outside =
            || self.elastic_sensor().is_ok_and(|(camera, gel)| self.elastic.is_outside_training(&camera, &gel));
        let mut review = ProfileReview {
            region_of_interest: region.map(|region| [region.x, region.y, region.width, region.height]),
            depth,
            has_force: is_elastic && self.gel.is_some_and(|gel| gel.youngs_modulus_mpa.is_some()),
            mm_per_px: self.mm_per_px(),
            field_of_view_mm: scene.as_ref().and_then(|(region, camera)| field_of_view_mm(region, camera)),
            gel_seen: with_gel.map(|((region, camera), gel)| gel_seen(region, camera, &gel)),
            region_on_gel: with_gel.map(|((region, camera), gel)| region_on_gel(region, camera, &gel)),
            is_outside_training_range: (is_elastic && self.elastic.network).then(outside),
            remarks: Vec::new(),
        };
        review.remarks = remarks::all(self, &review, frame_size);
        review
    }
}

/// Extent on the undeformed surface along the middle row and the middle column of the region, mm.
fn field_of_view_mm(region: &Rect, camera: &Camera) -> Option<[f64; 2]> {
    let [right, bottom] = last_px(region);
    let between = |a, b| {
        let ([ax, ay], [bx, by]) = (camera.surface_point(a, 0.0)?, camera.surface_point(b, 0.0)?);
        Some((bx - ax).hypot(by - ay))
    };
    // A pixel extends half a pixel from its centre.
    let width = between([-0.5, 0.5 * bottom], [right + 0.5, 0.5 * bottom])?;
    let height = between([0.5 * right, -0.5], [0.5 * right, bottom + 0.5])?;
    Some([width, height])
}

fn gel_seen(region: &Rect, camera: &Camera, gel: &GelBlock) -> f64 {
    let [right, bottom] = last_px(region);
    let [width, height] = gel.size_mm;
    part_of_grid(|s, t| {
        let seen = camera.project([(s - 0.5) * width, (t - 0.5) * height, 0.0]);
        seen.is_some_and(|[u, v]| (-0.5..=right + 0.5).contains(&u) && (-0.5..=bottom + 0.5).contains(&v))
    })
}

fn region_on_gel(region: &Rect, camera: &Camera, gel: &GelBlock) -> f64 {
    let [right, bottom] = last_px(region);
    let [width, height] = gel.size_mm;
    part_of_grid(|s, t| {
        let point = camera.surface_point([s * right, t * bottom], 0.0);
        point.is_some_and(|[x, y]| 2.0 * x.abs() <= width && 2.0 * y.abs() <= height)
    })
}

/// The centre of the last pixel, px in the region.
fn last_px(region: &Rect) -> [f64; 2] {
    [region.width, region.height].map(|length| length as f64 - 1.0)
}

/// The part of a grid over the unit square at whose points `holds` is true.
fn part_of_grid(holds: impl Fn(f64, f64) -> bool) -> f64 {
    let at = |k: usize| (k as f64 + 0.5) / GRID as f64;
    let count = (0..GRID * GRID).filter(|k| holds(at(k % GRID), at(k / GRID))).count();
    count as f64 / (GRID * GRID) as f64
}

#[cfg(test)]
mod tests {
    use super::super::SENSOR;
    use super::*;

    /// The profile of the documentation, with a region that shows the whole gel.
    fn square_sensor() -> Profile {
        let mut profile = Profile::from_toml(SENSOR).unwrap();
        let region = ("image.region_of_interest", "[0, 0, 480, 480]");
        profile.set_all([region, ("camera.principal_point_px", "[239.5, 239.5]")]).unwrap();
        profile
    }

    #[test]
    fn a_sensor_that_its_camera_sees_to_the_edges_is_found_so() {
        let review = square_sensor().review(None);
        let [width, height] = review.field_of_view_mm.unwrap();
        assert!((width - 30.0).abs() < 1e-9 && (height - 30.0).abs() < 1e-9, "{width} x {height} mm");
        assert_eq!((review.gel_seen, review.region_on_gel), (Some(1.0), Some(1.0)));
        assert_eq!((review.depth, review.has_force), (Some(DepthMethod::Elastic), true));
        assert_eq!(review.is_outside_training_range, Some(false));
    }

    #[test]
    fn half_the_gel_is_seen_where_the_image_is_half_as_wide() {
        let mut profile = square_sensor();
        profile.set("image.region_of_interest", "[0, 0, 240, 480]").unwrap();
        let review = profile.review(None);
        assert!((review.gel_seen.unwrap() - 0.5).abs() < 0.02, "{review:?}");
        assert_eq!(review.region_on_gel, Some(1.0));
    }

    #[test]
    fn what_is_absent_switches_off_what_needs_it() {
        let review = Profile::default().review(None);
        assert_eq!((review.depth, review.region_of_interest, review.mm_per_px), (None, None, None));
        assert_eq!(Profile::default().review(Some((64, 48))).region_of_interest, Some([0, 0, 64, 48]));
        let line = Profile::from_toml("[depth]\ndensity = { slope_mm = 15.0, intercept_mm = 0.0 }").unwrap();
        assert_eq!(line.review(None).depth, Some(DepthMethod::Density));
    }
}
