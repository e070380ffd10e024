//! The quantities that a profile enables, before any frame is tracked.

use serde::Serialize;

use super::remarks::{self, Remark, Weight};
use super::view::View;
use super::{DepthMethod, Profile};

/// The quantities that a profile enables, the field of view of the camera, and problems.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ProfileReview {
    /// Left column, top row, width and height of the tracked region, px; absent if it is the whole frame and its size
    /// is unknown.
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
    /// Wrong, suspicious and missing values, faults first.
    pub remarks: Vec<Remark>,
}

impl ProfileReview {
    /// The values with which tracking fails, or its numbers are wrong.
    pub fn faults(&self) -> impl Iterator<Item = &Remark> {
        self.remarks.iter().filter(|remark| remark.weight == Weight::Fault)
    }
}

impl Profile {
    /// The review of a profile, for frames of this size if it is known.
    #[must_use]
    pub fn review(&self, frame_size: Option<(usize, usize)>) -> ProfileReview {
        let view = View::new(self, frame_size);
        let is_elastic = self.has_elastic_depth();
        let depth = match (is_elastic, self.depth.density) {
            (true, _) => Some(DepthMethod::Elastic),
            (false, Some(_)) if self.depth_method() == DepthMethod::Density => Some(DepthMethod::Density),
            _ => None,
        };
        ProfileReview {
            region_of_interest: view.region.map(|region| [region.x, region.y, region.width, region.height]),
            depth,
            has_force: is_elastic && self.gel.is_some_and(|gel| gel.youngs_modulus_mpa.is_some()),
            mm_per_px: self.mm_per_px(),
            field_of_view_mm: view.field_of_view_mm,
            gel_seen: view.gel_seen,
            region_on_gel: view.region_on_gel,
            is_outside_training_range: self.is_outside_training_range(),
            remarks: remarks::all(self, &view, frame_size),
        }
    }
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
