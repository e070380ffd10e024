//! Mutated tables of depths and of corners: numbers or an error, never a panic.

use std::fs;

use fingervision_calibrate::camera::read_corners;
use fingervision_calibrate::depth::PressFolder;
use fingervision_fuzz::{Form, Parser};

/// The most memory that a table of a few lines may take, bytes.
const MOST_BYTES: u64 = 1 << 20;

#[test]
fn a_mutated_table_of_depths_is_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["frame,depth_mm\n0,0\n1,0.5\n2,1e0\n", "depth_mm,force_z_n\n0,0\n0.25,1.5\n\n0.5,3\n"];
    let files = files.map(|text| text.as_bytes().to_vec()).to_vec();
    Parser { name: "depth.csv", form: Form::Text, files, inputs: 1500, most_bytes: MOST_BYTES }.run(|bytes| {
        fs::write(folder.path().join("depth.csv"), bytes).unwrap();
        let Ok(press) = PressFolder::open(folder.path()) else { return false };
        assert!(press.depths_mm.iter().chain(press.forces_n.iter().flatten()).all(|value| value.is_finite()));
        assert!(press.forces_n.is_none_or(|forces| forces.len() == press.depths_mm.len()));
        true
    });
}

#[test]
fn a_mutated_table_of_corners_is_read_or_refused() {
    let files = vec![b"image,x_mm,y_mm,u_px,v_px\n0,0,0,10.5,20\n0,1,0,30,40\n1,1,0,12,2e1\nb,-1,.5,3,4\n".to_vec()];
    Parser { name: "corners.csv", form: Form::Text, files, inputs: 20_000, most_bytes: MOST_BYTES }.run(|bytes| {
        let Some(images) = std::str::from_utf8(bytes).ok().and_then(|text| read_corners(text).ok()) else {
            return false;
        };
        let numbers = images.iter().flatten().flat_map(|corner| corner.board_mm.into_iter().chain(corner.px));
        assert!(numbers.into_iter().all(f64::is_finite));
        true
    });
}
