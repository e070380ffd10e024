use super::{Profile, Remark, SENSOR, Weight};

/// The remarks after some values are changed.
fn remarks(assignments: &[(&str, &str)]) -> Vec<Remark> {
    let mut profile = Profile::from_toml(SENSOR).unwrap();
    profile.set_all(assignments.iter().copied()).unwrap();
    profile.review(Some((640, 480))).remarks
}

#[track_caller]
fn expect(assignments: &[(&str, &str)], weight: Weight, message: &str, hint: &str) {
    let remarks = remarks(assignments);
    let is_it = |remark: &&Remark| remark.message.contains(message) && remark.hint.contains(hint);
    let found = remarks.iter().find(is_it).unwrap_or_else(|| panic!("no \"{message}\" in {remarks:#?}"));
    assert_eq!(found.weight, weight, "{found:?}");
}

#[test]
fn a_valid_sensor_gives_no_remarks() {
    assert_eq!(remarks(&[]), []);
}

#[test]
fn a_region_that_is_too_small_to_track_is_a_fault() {
    let region = ("image.region_of_interest", "[300, 200, 31, 40]");
    expect(&[region], Weight::Fault, "image.region_of_interest = 31x40 px is impossible", "32 px or more");
    let remarks = Profile::default().review(Some((640, 31))).remarks;
    assert_eq!(remarks[0].weight, Weight::Fault, "{remarks:?}");
}

#[test]
fn an_impossible_value_is_a_fault_with_a_suggestion() {
    use Weight::Fault;
    expect(
        &[("gel.youngs_modulus_mpa", "600")],
        Fault,
        "gel.youngs_modulus_mpa = 600 MPa",
        "write 0.6 if this is in kPa",
    );
    expect(
        &[("gel.youngs_modulus_mpa", "0.0006")],
        Fault,
        "gel.youngs_modulus_mpa = 0.0006",
        "write 0.6 if this is in GPa",
    );
    expect(&[("gel.thickness_mm", "0.2")], Fault, "gel.thickness_mm = 0.2 mm", "measure it again");
    expect(
        &[("camera.translation_mm", "[0, 0, 1500]")],
        Fault,
        "camera.translation_mm[2] = 1500 mm",
        "write 1.5 if this is in µm",
    );
    let both = remarks(&[("gel.size_mm", "[1500, 1500]")]);
    assert_eq!(both.iter().filter(|remark| remark.message.contains("size_mm")).count(), 1, "said once: {both:#?}");
}

#[test]
fn a_lens_that_cannot_be_is_a_fault() {
    expect(
        &[("camera.focal_length_px", "[4.0, 4.0]")],
        Weight::Fault,
        "angle of view of 178.5° across",
        "size of a pixel",
    );
    expect(&[("camera.focal_length_px", "[400.0, 800.0]")], Weight::Warning, "not square", "nearly equal");
    expect(&[("camera.rotation_rad", "[0, 0, 3.0]")], Weight::Warning, "by 172°", "in rad");
    expect(&[("camera.distortion.k1", "-0.6")], Weight::Fault, "the distortion folds the image", "camera.distortion");
    // Only the corners are beyond this one's range.
    expect(&[("camera.distortion.k1", "-0.22")], Weight::Warning, "the distortion folds the image", "is not measured");
    assert_eq!(remarks(&[("camera.distortion.k1", "-0.1")]), []);
}

#[test]
fn a_principal_point_far_from_the_middle_of_the_image_is_a_warning() {
    // The region of 610x450 px begins at (15, 15) of 640x480 px, so the middle of the image is at (304.5, 224.5).
    let point = |place: &'static str| [("camera.principal_point_px", place)];
    let message = "[384.5, 224.5] is 80 px from the middle of the image of 640x480 px, usual are at most 64 px";
    expect(&point("[384.5, 224.5]"), Weight::Warning, message, "subtract the region's x and y");
    expect(&point("[384.5, 224.5]"), Weight::Warning, message, "perhaps 800x480 px");
    assert_eq!(remarks(&point("[344.5, 244.5]")), []);
    // A region at the side of the image: its own middle is not that of the image.
    let aside = ("image.region_of_interest", "[0, 15, 500, 450]");
    assert_eq!(remarks(&[aside, point("[319.5, 224.5]")[0]]), []);
}

#[test]
fn without_an_image_the_principal_point_is_compared_with_the_region() {
    let mut profile = Profile::from_toml(SENSOR).unwrap();
    assert_eq!(profile.review(None).remarks, []);
    profile.set_all([("camera.principal_point_px", "[384.5, 224.5]")]).unwrap();
    let remarks = profile.review(None).remarks;
    assert!(remarks[0].message.contains("80 px from the middle of the region of 610x450 px"), "{remarks:#?}");
    assert!(remarks[0].hint.contains("check with a recording"), "{remarks:#?}");
}

#[test]
fn a_camera_that_looks_beside_the_gel_is_a_fault() {
    expect(&[("camera.translation_mm", "[200, 0, 25]")], Weight::Fault, "does not see the gel", "translation_mm");
    expect(&[("camera.translation_mm", "[0, 0, 4]")], Weight::Warning, "% of the gel's surface", "focal_length_px");
    expect(&[("camera.translation_mm", "[0, 0, 80]")], Weight::Warning, "of the region shows gel", "crop");
}

#[test]
fn a_region_outside_the_frame_is_a_fault() {
    expect(&[("image.region_of_interest", "[100, 0, 610, 450]")], Weight::Fault, "reaches outside", "[0, 0, 640, 480]");
}

#[test]
fn a_sensor_outside_the_training_range_is_a_warning() {
    expect(&[("gel.thickness_mm", "3")], Weight::Warning, "training range", "elastic.network=false");
}

#[test]
fn a_missing_part_names_the_quantities_that_need_it() {
    let missing = |text: &str| {
        let remarks = Profile::from_toml(text).unwrap().review(None).remarks;
        assert!(remarks.iter().all(|remark| remark.weight == Weight::Missing), "{remarks:#?}");
        remarks.into_iter().map(|remark| remark.message).collect::<Vec<_>>()
    };
    assert_eq!(missing(""), ["no [camera]: no depth and no force", "no [gel]: no depth and no force"]);
    assert_eq!(missing("[gel]\nsize_mm=[30,30]\nthickness_mm=10\npoissons_ratio=0.48").len(), 2);
    let without_modulus = SENSOR.replace("youngs_modulus_mpa = 0.6", "");
    assert_eq!(missing(&without_modulus), ["no gel.youngs_modulus_mpa: no force"]);
    let density = missing("[depth]\nmethod = 'density'");
    assert_eq!(density[0], "no depth.density: no depth");
}

#[test]
fn elastic_depth_without_a_gel_is_a_fault() {
    let remarks = Profile::from_toml("[depth]\nmethod = 'elastic'").unwrap().review(None).remarks;
    assert_eq!(remarks[0].weight, Weight::Fault);
    assert!(remarks[0].message.contains("needs [camera]"), "{remarks:#?}");
}
