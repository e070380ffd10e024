//! The sensor that a scene simulates.

use fingervision_gel::Scene;
use fingervision_touch::{ImageSection, Profile};

/// The profile of the simulated sensor: camera and gel.
#[must_use]
pub fn simulated_profile(scene: &Scene) -> Profile {
    let name = format!("simulated: {}", scene.name);
    // Images of another size are then refused.
    let image = ImageSection { region_of_interest: [0, 0, scene.render.width, scene.render.height] };
    Profile { name, image: Some(image), camera: Some(scene.camera()), gel: Some(scene.gel), ..Profile::default() }
}
