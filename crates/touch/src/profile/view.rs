//! The part of the gel that the camera sees.

use fingervision_elastic::GelBlock;
use fingervision_image::Rect;
use fingervision_optics::Camera;

use super::Profile;

/// Points along each side of the grids on which visibility is counted.
const GRID: usize = 41;

/// The field of view of the camera on the gel; a value is absent if the profile does not determine it.
#[derive(Debug)]
pub(super) struct View {
    /// The tracked region of the frame, px.
    pub(super) region: Option<Rect>,
    /// Width and height of the field of view of the region through its middle, mm on the undeformed surface.
    pub(super) field_of_view_mm: Option<[f64; 2]>,
    /// Part of the gel's surface that the region shows, 0 to 1.
    pub(super) gel_seen: Option<f64>,
    /// Part of the region that shows gel, 0 to 1.
    pub(super) region_on_gel: Option<f64>,
    /// Part of the region beyond the range of the lens's distortion, 0 to 1: no direction is seen there.
    pub(super) beyond_lens: Option<f64>,
}

impl View {
    /// The view in frames of this size, if it is known.
    pub(super) fn new(profile: &Profile, frame_size: Option<(usize, usize)>) -> Self {
        let whole = |(width, height)| Rect::whole(width, height);
        let named = profile.image.map(|image| image.region_of_interest);
        let region = named.map(|[x, y, width, height]| Rect { x, y, width, height }).or(frame_size.map(whole));
        let camera = profile.camera.and_then(|params| Camera::new(&params).ok());
        let scene = region.zip(camera);
        let with_gel = scene.as_ref().zip(profile.gel);
        Self {
            region,
            field_of_view_mm: scene.as_ref().and_then(|(region, camera)| field_of_view_mm(region, camera)),
            gel_seen: with_gel.map(|((region, camera), gel)| gel_seen(region, camera, &gel)),
            beyond_lens: scene.as_ref().map(|(region, camera)| beyond_lens(region, camera)),
            region_on_gel: with_gel.map(|((region, camera), gel)| region_on_gel(region, camera, &gel)),
        }
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

fn beyond_lens(region: &Rect, camera: &Camera) -> f64 {
    let [right, bottom] = last_px(region);
    part_of_grid(|s, t| camera.ray([s * right, t * bottom]).is_none())
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
