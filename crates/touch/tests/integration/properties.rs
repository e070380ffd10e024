//! Properties of every profile and of every motion of the gel, tested on random ones.

use fingervision_elastic::GelBlock;
use fingervision_flow::FlowField;
use fingervision_image::Image;
use fingervision_optics::CameraParams;
use fingervision_touch::{DensityEstimator, DensityMethod, DensityParams, DepthMethod, ImageSection, Profile};
use proptest::option;
use proptest::prelude::*;

fn camera() -> impl Strategy<Value = CameraParams> {
    (50.0..2000.0_f64, 50.0..2000.0_f64, -100.0..1000.0_f64, -100.0..1000.0_f64, 5.0..100.0_f64).prop_map(|(fx, fy, x, y, distance)| {
        let text = format!(
            "[camera]\nfocal_length_px = [{fx:?}, {fy:?}]\nprincipal_point_px = [{x:?}, {y:?}]\ntranslation_mm = [0.0, 0.0, {distance:?}]\n"
        );
        Profile::from_toml(&text).unwrap().camera.unwrap()
    })
}

fn gel() -> impl Strategy<Value = GelBlock> {
    (5.0..100.0_f64, 5.0..100.0_f64, 0.02..4.0_f64, 0.05..0.499_f64, option::of(0.01..10.0_f64)).prop_map(
        |(width, height, relative_thickness, ratio, modulus)| {
            let thickness = relative_thickness * width.max(height);
            let modulus = modulus.map(|modulus| format!("youngs_modulus_mpa = {modulus:?}\n")).unwrap_or_default();
            let text = format!(
                "[gel]\nsize_mm = [{width:?}, {height:?}]\nthickness_mm = {thickness:?}\npoissons_ratio = {ratio:?}\n{modulus}"
            );
            Profile::from_toml(&text).unwrap().gel.unwrap()
        },
    )
}

fn profile() -> impl Strategy<Value = Profile> {
    let method = option::of(prop_oneof![Just(DepthMethod::Density), Just(DepthMethod::Elastic)]);
    let region = option::of([0..1000_usize, 0..1000, 64..1000, 64..1000]);
    (any::<String>(), region, option::of(camera()), option::of(gel()), method, 1.5..8.0, 0.1..5.0_f32).prop_map(
        |(name, region, camera, gel, method, sigma_px, noise)| {
            let mut profile = Profile { name, camera, gel, ..Profile::default() };
            profile.image = region.map(|region_of_interest| ImageSection { region_of_interest });
            profile.depth.method = method;
            profile.density.sigma_px = sigma_px;
            profile.flow.noise_levels = noise;
            profile
        },
    )
}

const SIZE: (usize, usize) = (96, 80);
/// Distance from the border at which the gel starts to move, px.
const STILL_PX: f32 = 20.0;

/// Motion that fades out towards the border: waves of up to 4 px, half as long as the image and longer.
fn flow() -> impl Strategy<Value = FlowField> {
    let wave = || (-4.0_f32..4.0, -0.1_f32..0.1, -0.1_f32..0.1, 0.0_f32..6.3);
    (wave(), wave()).prop_map(|(u, v)| {
        let fade = |at: f32, side: usize| ((at.min(side as f32 - 1.0 - at) - STILL_PX) / 10.0).clamp(0.0, 1.0);
        let plane = |(peak, across, down, phase): (f32, f32, f32, f32)| {
            Image::from_fn(SIZE.0, SIZE.1, |x, y| {
                let (x, y) = (x as f32, y as f32);
                peak * (across * x + down * y + phase).sin() * fade(x, SIZE.0) * fade(y, SIZE.1)
            })
        };
        FlowField { u: plane(u), v: plane(v) }
    })
}

/// The sum of the density over all pixels of the current image.
fn total(method: DensityMethod, flow: &FlowField) -> f64 {
    let params = DensityParams { sigma_px: 2.5, method, ..DensityParams::default() };
    let mut density = Image::filled(SIZE.0, SIZE.1, 0.0);
    DensityEstimator::new(SIZE.0, SIZE.1, &params).unwrap().current_density_into(flow, &mut density);
    density.values().iter().map(|&density| f64::from(density)).sum()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn a_profile_that_is_written_and_read_again_is_the_same(profile in profile()) {
        let text = profile.to_toml();
        let again = Profile::from_toml(&text);
        prop_assert!(again.is_ok(), "{}\n{text}", again.unwrap_err());
        prop_assert_eq!(&again.unwrap(), &profile, "\n{}", text);
    }

    #[test]
    fn a_value_that_is_set_is_the_only_one_that_changes(profile in profile(), sigma_px in 1.5..8.0) {
        let mut changed = profile.clone();
        changed.set("density.sigma_px", &format!("{sigma_px:?}")).unwrap();
        let mut expected = profile;
        expected.density.sigma_px = sigma_px;
        prop_assert_eq!(changed, expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    #[test]
    fn motion_within_the_image_keeps_the_density_s_total(flow in flow()) {
        let still = FlowField::zero(SIZE.0, SIZE.1);
        for method in [DensityMethod::Fast, DensityMethod::Exact] {
            let (before, after) = (total(method, &still), total(method, &flow));
            prop_assert!((after / before - 1.0).abs() < 1e-5, "{method:?}: {before}, then {after}");
        }
    }
}
