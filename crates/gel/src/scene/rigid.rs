//! A rigid patterned board in the gel's place, for the calibration of the camera.

use fingervision_elastic::{Pose, SurfaceState};

/// The board's surface at every pose, moved about `centre_mm`. Four nodes at its corners are enough: between nodes the
/// displacement is bilinear, and a rigid motion is linear.
pub(super) fn surfaces(size_mm: [f64; 2], centre_mm: [f64; 2], poses: &[Pose]) -> Vec<SurfaceState> {
    let [x_mm, y_mm] = size_mm.map(|size| vec![-0.5 * size, 0.5 * size]);
    let surface = |pose: &Pose| {
        let corners = y_mm.iter().flat_map(|&y| x_mm.iter().map(move |&x| [x, y]));
        SurfaceState {
            x_mm: x_mm.clone(),
            y_mm: y_mm.clone(),
            displacement_mm: corners.map(|corner| displacement(pose, centre_mm, corner)).collect(),
            nodal_force_n: vec![[0.0; 3]; 4],
            traction_mpa: vec![[0.0; 3]; 4],
            in_contact: vec![false; 4],
            ..SurfaceState::default()
        }
    };
    poses.iter().map(surface).collect()
}

/// How far a point of the board moves, mm: tilts about x and y, then the twist about z, then sideways and in.
fn displacement(pose: &Pose, centre_mm: [f64; 2], point: [f64; 2]) -> [f64; 3] {
    let [x, y] = [0, 1].map(|axis| point[axis] - centre_mm[axis]);
    let [(sin_x, cos_x), (sin_y, cos_y)] = pose.tilt_rad.map(f64::sin_cos);
    let (sin_z, cos_z) = pose.twist_rad.sin_cos();
    let (y_tilted, z) = (cos_x * y, sin_x * y);
    let (x_tilted, z) = (cos_y * x + sin_y * z, cos_y * z - sin_y * x);
    let turned = [cos_z * x_tilted - sin_z * y_tilted, sin_z * x_tilted + cos_z * y_tilted];
    [turned[0] - x + pose.shear_mm[0], turned[1] - y + pose.shear_mm[1], z + pose.depth_mm]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_stay() {
        let pose = Pose { depth_mm: 0.4, shear_mm: [1.0, -2.0], twist_rad: 0.3, tilt_rad: [0.1, -0.2] };
        let centre = [2.0, 1.0];
        let place = |point: [f64; 2]| {
            let moved = displacement(&pose, centre, point);
            [point[0] + moved[0], point[1] + moved[1], moved[2]]
        };
        let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let (a, b) = ([3.0, -4.0], [-5.0, 2.0]);
        assert!((distance(place(a), place(b)) - 10.0).abs() < 1e-12);
        let [x, y, z] = place(centre);
        assert!((x - 3.0).abs() < 1e-12 && (y + 1.0).abs() < 1e-12 && (z - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_sliding_board_moves_all_nodes_alike() {
        let poses = [Pose::default(), Pose { shear_mm: [0.5, 0.0], ..Pose::default() }];
        let surfaces = surfaces([60.0, 40.0], [0.0; 2], &poses);
        assert_eq!(surfaces[0].displacement_mm, [[0.0; 3]; 4]);
        assert_eq!(surfaces[1].displacement_mm, [[0.5, 0.0, 0.0]; 4]);
        assert_eq!(
            (surfaces[1].x_mm.as_slice(), surfaces[1].y_mm.as_slice()),
            (&[-30.0, 30.0][..], &[-20.0, 20.0][..])
        );
        assert!(surfaces[1].force_n.iter().all(|force| *force == 0.0));
    }
}
