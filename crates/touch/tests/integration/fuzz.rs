//! Mutated profiles: a profile that can be written and read again, or an error, never a panic.

use fingervision_fuzz::{Form, Parser};
use fingervision_touch::Profile;

/// The most memory that a profile may take, bytes.
const MOST_BYTES: u64 = 16 << 20;

const SENSOR: &str = "name = \"left index\"\n\
    [image]\nregion_of_interest = [10, 20, 480, 320]\n\
    [camera]\nfocal_length_px = [400.0, 400.0]\nprincipal_point_px = [239.5, 159.5]\n\
    translation_mm = [0.0, 0.0, 25.0]\n\
    [gel]\nsize_mm = [30.0, 20.0]\nthickness_mm = 10.0\nyoungs_modulus_mpa = 0.1\npoissons_ratio = 0.45\n\
    [depth]\nmethod = \"density\"\n[depth.density]\nslope_mm = 8.0\nintercept_mm = 0.01\n\
    [density]\nsigma_px = 2.5\n[flow]\nfinest_level = 1\n";
const RUN: &str = "version = \"0.1.0\"\nsource = \"made up\"\n[profile]\nname = \"unnamed\"\n";

#[test]
fn a_mutated_profile_is_read_or_refused() {
    let whole = Profile::from_toml(SENSOR).map(|profile| profile.to_toml());
    let whole = whole.unwrap_or_else(|error| panic!("{error}"));
    let files = [SENSOR, RUN, &whole].map(|text| text.as_bytes().to_vec()).to_vec();
    Parser { name: "profile", form: Form::Text, files, inputs: 3000, most_bytes: MOST_BYTES }.run(|bytes| {
        let Some(profile) = std::str::from_utf8(bytes).ok().and_then(|text| Profile::from_toml(text).ok()) else {
            return false;
        };
        let text = profile.to_toml();
        let again = Profile::from_toml(&text).unwrap_or_else(|error| panic!("written and refused: {error}\n{text}"));
        assert!(again == profile, "another profile after it was written and read again:\n{text}");
        // What a command does with any profile that it reads.
        drop((profile.elastic_sensor(), profile.mm_per_px(), profile.region((640, 480))));
        true
    });
}

#[test]
fn a_mutated_value_is_set_or_refused() {
    let files = ["1", "0.5", "[1.0, 2.0]", "true", "\"elastic\"", "{ slope_mm = 1.0 }"];
    let files = files.map(|text| text.as_bytes().to_vec()).to_vec();
    let paths = ["flow.finest_level", "density.sigma_px", "depth.density", "camera.translation_mm", "gel", "name"];
    Parser { name: "set", form: Form::Text, files, inputs: 3000, most_bytes: MOST_BYTES }.run(|bytes| {
        let Ok(text) = std::str::from_utf8(bytes) else { return false };
        let mut profile = Profile::default();
        // It does not matter which value fits which path.
        for path in paths {
            drop(profile.set(path, text));
        }
        true
    });
}
