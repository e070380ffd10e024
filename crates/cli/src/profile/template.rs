//! The text of a profile to start from: known values, and the others as comments that explain how to find them.

use crate::failure::Failure;

use super::known::Known;

/// The text of a profile with the known values.
///
/// # Errors
///
/// A width of the view without a width in px.
pub(super) fn text(known: &Known) -> Result<String, Failure> {
    let name = toml::Value::String(known.name.clone().unwrap_or_else(|| "my sensor".into()));
    Ok(format!(
        "# The profile of one sensor. `fingervision profile show FILE` prints all its values, `fingervision profile check FILE\n\
         # RECORDING` checks it. Lengths are in mm, positions in the image in px. What follows a # is a comment.\n\
         name = {name}\n\n{image}\n{camera}\n{gel}\n{DEPTH}",
        image = image(known),
        camera = camera(known)?,
        gel = gel(known),
    ))
}

const DEPTH: &str = "\
# [depth]
# method = \"elastic\"       # from the gel's elasticity, the default with [camera] and [gel]; or \"density\"
# density = { slope_mm = 15.2, intercept_mm = 0.0 }   # `fingervision calibrate depth PRESSES --profile FILE` fits it
";

fn image(known: &Known) -> String {
    let heading = "# The part of the camera's image that shows the gel: x, y, width, height, px. Without this table it is the whole image.\n";
    let whole = known.image_size.map(|[width, height]| [0, 0, width, height]);
    match known.region_of_interest.or(whole) {
        Some(region) => format!("{heading}[image]\nregion_of_interest = {region:?}\n"),
        None => format!("{heading}# [image]\n# region_of_interest = [15, 15, 610, 450]\n"),
    }
}

fn camera(known: &Known) -> Result<String, Failure> {
    let size = known.region_of_interest.map(|[_, _, width, height]| [width, height]).or(known.image_size);
    let size = size.map(|size| size.map(|side| side as f64));
    let focal_length_px = match (known.view_width_mm, known.distance_mm, size) {
        (Some(view_mm), Some(distance_mm), Some([width, _])) => {
            Some((width * distance_mm / view_mm * 10.0).round() / 10.0)
        }
        (Some(view_mm), _, None) => {
            return Err(Failure::new(
                format!("--view-width-mm {view_mm} gives no focal length without the image's width"),
                "give --image-size, as in 640x480, or --region-of-interest",
            ));
        }
        _ => known.focal_length_px,
    };
    let is_known = focal_length_px.is_some() && known.distance_mm.is_some() && size.is_some();
    let (off, focal) = (if is_known { "" } else { "# " }, focal_length_px.unwrap_or(400.0));
    let [cx, cy] = size.unwrap_or([640.0, 480.0]).map(|side| 0.5 * (side - 1.0));
    let distance = known.distance_mm.unwrap_or(25.0);
    let worth = if is_known {
        "This is a first estimate: good enough to try depth, too inaccurate for measurements."
    } else {
        "Not used until the # is removed: together with [gel] it gives depth, contact and displacement."
    };
    Ok(format!(
        "# The camera. {worth}\n\
         # `fingervision calibrate camera BOARD --step-mm 0.5 --profile FILE --prior distance_mm={distance:?}±0.5` fits all of it.\n\
         {off}[camera]\n\
         {off}focal_length_px = [{focal:?}, {focal:?}]\n\
         {off}principal_point_px = [{cx:?}, {cy:?}]       # in the region of interest\n\
         {off}translation_mm = [0.0, 0.0, {distance:?}]   # position of the gel's centre relative to the lens; the last value is the distance\n"
    ))
}

fn gel(known: &Known) -> String {
    let is_known = known.gel_size_mm.is_some() && known.thickness_mm.is_some();
    let off = if is_known { "" } else { "# " };
    let ([width, height], thickness) = (known.gel_size_mm.unwrap_or([30.0; 2]), known.thickness_mm.unwrap_or(10.0));
    let worth = if is_known { "" } else { " Not used until the # is removed: measure size and thickness." };
    let (no_force, modulus) = match known.youngs_modulus_mpa {
        Some(modulus) => (off, modulus),
        None => ("# ", 0.6),
    };
    format!(
        "# The gel.{worth} `fingervision calibrate gel PRESSES --profile FILE` fits all values except the size.\n\
         {off}[gel]\n\
         {off}size_mm = [{width:?}, {height:?}]\n\
         {off}thickness_mm = {thickness:?}\n\
         {off}poissons_ratio = {ratio:?}      # silicone is nearly incompressible\n\
         {no_force}youngs_modulus_mpa = {modulus:?}   # stiffness: without it there is no force\n",
        ratio = known.poissons_ratio,
    )
}

#[cfg(test)]
mod tests {
    use fingervision_touch::Profile;

    use super::*;

    fn known() -> Known {
        Known { poissons_ratio: 0.48, ..Known::default() }
    }

    #[test]
    fn what_is_not_known_is_not_in_force() {
        let profile = Profile::from_toml(&text(&known()).unwrap()).unwrap();
        assert_eq!(profile, Profile { name: "my sensor".into(), ..Profile::default() });
    }

    #[test]
    fn every_comment_is_a_value_once_its_mark_is_taken_away() {
        let text = text(&known()).unwrap();
        let in_force = |line: &str| match line.strip_prefix("# ") {
            Some(rest)
                if rest.starts_with('[') || rest.split_once(" = ").is_some_and(|(key, _)| !key.contains(' ')) =>
            {
                rest.to_string()
            }
            _ => line.to_string(),
        };
        let all: Vec<String> = text.lines().map(in_force).collect();
        let profile = Profile::from_toml(&all.join("\n")).unwrap();
        assert!(profile.image.is_some() && profile.camera.is_some() && profile.gel.is_some(), "{text}");
        assert!(profile.gel.unwrap().youngs_modulus_mpa.is_some() && profile.depth.density.is_some(), "{text}");
    }

    #[test]
    fn the_focal_length_follows_from_what_is_seen() {
        let (image_size, distance_mm, view_width_mm) = (Some([480, 480]), Some(25.0), Some(30.0));
        let known = Known { name: Some("a \"quoted\" name".into()), image_size, distance_mm, view_width_mm, ..known() };
        let profile = Profile::from_toml(&text(&known).unwrap()).unwrap();
        let camera = profile.camera.unwrap();
        assert_eq!((camera.focal_length_px, camera.principal_point_px), ([400.0; 2], [239.5; 2]));
        assert_eq!(profile.name, "a \"quoted\" name");
        let without_size = Known { image_size: None, ..known };
        assert!(text(&without_size).unwrap_err().to_string().contains("--view-width-mm 30"));
    }
}
