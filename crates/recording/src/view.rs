//! Messages for other programs' displays: small pictures, the camera, the surface as points.

use fingervision_image::Image;
use fingervision_optics::{Camera, Radial};
use fingervision_source::{CameraCoding, EncodedFrame};
use fingervision_touch::{Profile, Reading};

use crate::message::{
    CameraCalibration, FrameTransform, PackedElementField, PointCloud, Pose, Quaternion, RawImage, Vector3, timestamp,
};
use crate::schema::FLOAT32;

/// The largest width of a preview, px.
const PREVIEW_COLUMNS: usize = 160;
/// The largest number of points in a row of the surface.
const SURFACE_COLUMNS: usize = 96;
const M_PER_MM: f64 = 1e-3;

/// A small picture of a frame that is not JPEG: every n-th pixel; of frames in luma and chroma only luma.
pub(crate) fn preview(frame: &EncodedFrame, time_ns: u64, frame_id: &str) -> Option<RawImage> {
    let layout = frame.layout;
    // Bytes of a pixel, the first of them that are shown, and the step between these.
    let (pixel, shown, step) = match layout.coding {
        CameraCoding::MotionJpeg => return None,
        CameraCoding::Yuyv { .. } => (2, 1, 1),
        CameraCoding::Grey8 => (1, 1, 1),
        CameraCoding::Grey16 => (2, 1, 2),
        CameraCoding::Rgb8 => (3, 3, 1),
        CameraCoding::Rgb16 => (6, 3, 2),
    };
    // The high byte of 16 bits is the second.
    let first = step - 1;
    let every = layout.width.div_ceil(PREVIEW_COLUMNS).max(1);
    let row_len = layout.row_bytes.max(pixel * layout.width).max(1);
    let mut data = Vec::new();
    let mut height = 0;
    for row in frame.bytes.chunks(row_len).take(layout.height).step_by(every) {
        let row = row.get(..pixel * layout.width)?;
        for bytes in row.chunks_exact(pixel).step_by(every) {
            data.extend(bytes.iter().skip(first).step_by(step).take(shown));
        }
        height += 1;
    }
    let width = layout.width.div_ceil(every) as u32;
    let encoding = if shown == 3 { "rgb8" } else { "mono8" };
    Some(RawImage {
        timestamp: Some(timestamp(time_ns)),
        width,
        height,
        encoding: encoding.into(),
        step: width * shown as u32,
        data,
        frame_id: frame_id.into(),
    })
}

/// The camera's intrinsics in the whole frame. `None` without a camera in the profile, and for the distortion as the
/// paper prints it, for which Foxglove has no name.
pub(crate) fn calibration(
    profile: &Profile,
    frame_size: (usize, usize),
    time_ns: u64,
    frame_id: &str,
) -> Option<CameraCalibration> {
    let params = profile.camera?;
    let lens = params.distortion;
    let region = profile.region(frame_size).ok()?;
    let ([fx, fy], [u, v]) = (params.focal_length_px, params.principal_point_px);
    let (u, v) = (u + region.x as f64, v + region.y as f64);
    (lens.radial == Radial::Brown).then(|| CameraCalibration {
        timestamp: Some(timestamp(time_ns)),
        width: frame_size.0 as u32,
        height: frame_size.1 as u32,
        distortion_model: "plumb_bob".into(),
        distortion: vec![lens.k1, lens.k2, lens.p1, lens.p2, 0.0],
        intrinsics: vec![fx, 0.0, u, 0.0, fy, v, 0.0, 0.0, 1.0],
        rectification: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        projection: vec![fx, 0.0, u, 0.0, 0.0, fy, v, 0.0, 0.0, 0.0, 1.0, 0.0],
        frame_id: frame_id.into(),
    })
}

/// The gel in camera space. Its z points away from the camera here: other programs need right-handed frames.
pub(crate) fn transform(profile: &Profile, time_ns: u64, frame_ids: [&str; 2]) -> Option<FrameTransform> {
    let params = profile.camera?;
    let [x, y, z] = params.translation_mm.map(|value| M_PER_MM * value);
    let [rx, ry, rz] = params.rotation_rad;
    let angle = (rx * rx + ry * ry + rz * rz).sqrt();
    let (sine, w) = (0.5 * angle).sin_cos();
    let scale = if angle > 0.0 { sine / angle } else { 0.0 };
    let [camera, gel] = frame_ids.map(String::from);
    Some(FrameTransform {
        timestamp: Some(timestamp(time_ns)),
        parent_frame_id: camera,
        child_frame_id: gel,
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion { x: scale * rx, y: scale * ry, z: scale * rz, w }),
    })
}

/// The surface of the gel as points: x and y as in gel space, z away from the camera, in m, and the depth in mm.
///
/// A point is the intersection of a pixel's ray with the undeformed surface, moved by its displacement, or by its depth
/// if the displacement is not computed. `None` without depth. Pixels without a valid depth have no point.
pub(crate) fn surface(reading: &Reading, camera: &Camera, time_ns: u64, frame_id: &str) -> Option<PointCloud> {
    let depth = reading.depth.as_ref()?;
    let (width, height) = depth.size();
    let every = width.div_ceil(SURFACE_COLUMNS).max(1);
    let mut data = Vec::new();
    for (x, y) in (0..height).step_by(every).flat_map(|y| (0..width).step_by(every).map(move |x| (x, y))) {
        if !is_valid(reading, x, y) {
            continue;
        }
        let Some([gel_x, gel_y]) = camera.surface_point([x as f64, y as f64], 0.0) else { continue };
        let moved = |field: &[Image<f32>; 3]| [0, 1, 2].map(|axis: usize| f64::from(field[axis].at(x, y)));
        let depth_mm = depth.at(x, y);
        let [u, v, w] = reading.displacement.as_ref().map_or([0.0, 0.0, f64::from(depth_mm)], moved);
        let point = [gel_x + u, gel_y + v, -w].map(|value| (M_PER_MM * value) as f32);
        data.extend(point.into_iter().chain([depth_mm]).flat_map(f32::to_le_bytes));
    }
    let field = |(index, name): (usize, &&str)| PackedElementField {
        name: (*name).into(),
        offset: 4 * index as u32,
        kind: FLOAT32,
    };
    let origin = Vector3 { x: 0.0, y: 0.0, z: 0.0 };
    let upright = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    Some(PointCloud {
        timestamp: Some(timestamp(time_ns)),
        frame_id: frame_id.into(),
        pose: Some(Pose { position: Some(origin), orientation: Some(upright) }),
        point_stride: 16,
        fields: ["x", "y", "z", "depth_mm"].iter().enumerate().map(field).collect(),
        data,
    })
}

fn is_valid(reading: &Reading, x: usize, y: usize) -> bool {
    match &reading.depth_deviation {
        Some(deviation) => deviation.at(x, y).is_finite(),
        None => reading.valid.at(x, y) == 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_source::CameraLayout;

    #[test]
    fn a_preview_takes_every_nth_pixel() {
        let layout = CameraLayout { coding: CameraCoding::Rgb8, width: 400, height: 7, row_bytes: 0 };
        let bytes = (0..7 * 400_u32).flat_map(|index| [(index % 400) as u8, (index / 400) as u8, 9]).collect();
        let frame = EncodedFrame { sequence: 0, capture_time_s: 0.0, layout, bytes };
        let image = preview(&frame, 1, "x").unwrap();
        assert_eq!((image.width, image.height, image.step), (134, 3, 402));
        assert_eq!(image.data.len(), 402 * 3);
        assert_eq!(image.data[402 + 3..][..3], [3, 3, 9]);
    }

    #[test]
    fn a_rotation_becomes_its_quaternion() {
        let text = "[camera]\nfocal_length_px = [400, 400]\nprincipal_point_px = [200, 200]\ntranslation_mm = [1, 2, 30]\n\
                    rotation_rad = [0, 0, 0.2]";
        let profile = Profile::from_toml(text).unwrap();
        let FrameTransform { rotation, translation, .. } = transform(&profile, 1, ["camera", "gel"]).unwrap();
        let Quaternion { z, w, .. } = rotation.unwrap();
        assert!((z - 0.1_f64.sin()).abs() < 1e-15 && (w - 0.1_f64.cos()).abs() < 1e-15);
        assert_eq!(translation, Some(Vector3 { x: 0.001, y: 0.002, z: 0.03 }));
    }

    #[test]
    fn a_point_of_the_surface_is_where_the_camera_sees_it() {
        let text = "[camera]\nfocal_length_px = [40, 40]\nprincipal_point_px = [9.5, 9.5]\ntranslation_mm = [0, 0, 20]";
        let camera = Camera::new(&Profile::from_toml(text).unwrap().camera.unwrap()).unwrap();
        let mut reading = Reading::new(20, 20);
        reading.depth = Some(Image::filled(20, 20, 2.0));
        reading.valid = Image::from_fn(20, 20, |x, y| u8::from((x, y) == (19, 3)));
        let cloud = surface(&reading, &camera, 1, "gel").unwrap();
        let values: Vec<f32> = cloud.data.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        // 9.5 px beside the axis at 20 mm: 9.5 / 40 · 20 mm.
        let wanted = [0.00475, -0.00325, -0.002, 2.0];
        assert!(
            values.len() == 4 && values.iter().zip(wanted).all(|(is, wanted)| (is - wanted).abs() < 1e-6),
            "{values:?}"
        );
    }
}
