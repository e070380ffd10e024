//! Depth, contact, displacement and force from the flow, by the gel's elasticity.

use fingervision_flow::Team;
use fingervision_image::Image;

use super::planes::largest_valid;
use crate::whole_motion::WholeMotion;
use crate::{ElasticDepth, ElasticFields, Fields, Flag, Profile, Reading, TrackError};

/// Fills the fields of a reading that follow from elasticity.
#[derive(Debug)]
pub(super) struct ElasticStage {
    inverse: ElasticDepth,
}

impl ElasticStage {
    /// A stage for this profile; allocates the planes of the reading that it will fill.
    ///
    /// # Errors
    ///
    /// [`TrackError`] if the profile lacks camera or gel, or the camera does not see the gel.
    pub(super) fn new(profile: &Profile, fields: Fields, reading: &mut Reading) -> Result<Self, TrackError> {
        let (camera, gel) = profile.elastic_sensor()?;
        let size = reading.flow.size();
        let mut inverse = ElasticDepth::new(&camera, &gel, size, &profile.elastic)?;
        let plane = |value: f32| Image::filled(size.0, size.1, value);
        // Between two frames the planes belong to the reading.
        reading.depth = fields.depth.then(|| Image::filled(0, 0, 0.0));
        reading.depth_deviation = Some(Image::filled(0, 0, 0.0));
        reading.contact = Some(Image::filled(0, 0, 0));
        exchange_planes(inverse.fields_mut(), reading);
        clear(reading);
        if fields.displacement {
            inverse.prepare_displacement();
        }
        reading.displacement = fields.displacement.then(|| [(); 3].map(|()| plane(0.0)));
        reading.traction = inverse.fields().traction_mpa.clone().filter(|_| fields.traction);
        Ok(Self { inverse })
    }

    /// Sets the threads that share the work.
    pub(super) fn share(&mut self, team: &Team) {
        self.inverse.share(team);
    }

    /// Forgets the previous frames.
    pub(super) fn restart(&mut self) {
        self.inverse.restart();
    }

    /// Fills the fields from the reading's flow without a motion of the whole image, that of the untouched gel. They are empty for a frame
    /// that is lost or does not fit the gel.
    pub(super) fn run(&mut self, reading: &mut Reading, untouched_motion: WholeMotion) {
        if reading.flags.has(Flag::Lost) || reading.flags.has(Flag::NoTexture) {
            self.inverse.skip();
            clear(reading);
            return;
        }
        exchange_planes(self.inverse.fields_mut(), reading);
        self.inverse.note(reading.flags.has(Flag::TornImage), untouched_motion);
        let found = self.inverse.solve(&reading.flow, &reading.deviation, &reading.valid);
        for (flag, holds) in [
            (Flag::BeyondLinear, found.is_beyond_linear),
            (Flag::ContactCut, found.is_cut),
            (Flag::GelMisfit, found.is_misfit),
            (Flag::OutsideTraining, found.is_outside_training),
            (Flag::ContactUntracked, found.is_untracked),
            (Flag::UncertainFlow, found.is_flow_uncertain),
        ] {
            if holds {
                reading.numbers.flags.raise(flag);
            }
        }
        if found.is_unexplained {
            exchange_planes(self.inverse.fields_mut(), reading);
            clear(reading);
            return;
        }
        if let Some(displacement) = &mut reading.displacement {
            self.inverse.displacement_into(&reading.flow, displacement);
        }
        let found = self.inverse.fields_mut();
        let deepest = || largest_valid(&found.depth_mm, &found.on_gel);
        reading.numbers.max_depth_mm = if found.is_at_rest { Some(0.0) } else { deepest() };
        exchange_planes(found, reading);
        if let (Some(traction), Some(found)) = (&mut reading.traction, &found.traction_mpa) {
            traction.traction_mpa.copy_from_slice(&found.traction_mpa);
        }
        reading.numbers.contact_area_mm2 = Some(found.contact_area_mm2);
        (reading.numbers.force_n, reading.numbers.torque_nmm) = (found.force_n, found.torque_nmm);
    }
}

/// Lends the planes of the reading to the solver, which overwrites them, or takes them back.
fn exchange_planes(found: &mut ElasticFields, reading: &mut Reading) {
    if let Some(depth) = &mut reading.depth {
        std::mem::swap(depth, &mut found.depth_mm);
    }
    if let Some(deviation) = &mut reading.depth_deviation {
        std::mem::swap(deviation, &mut found.deviation_mm);
    }
    if let Some(contact) = &mut reading.contact {
        std::mem::swap(contact, &mut found.contact);
    }
}

/// Clears the fields: infinite deviation, no contact, no force.
fn clear(reading: &mut Reading) {
    let planes = reading.depth.iter_mut().chain(reading.displacement.iter_mut().flatten());
    planes.for_each(|plane| plane.values_mut().fill(0.0));
    reading.depth_deviation.iter_mut().for_each(|plane| plane.values_mut().fill(f32::INFINITY));
    reading.contact.iter_mut().for_each(|plane| plane.values_mut().fill(0));
    reading.traction.iter_mut().for_each(|grid| grid.traction_mpa.fill([0.0; 3]));
    (reading.numbers.max_depth_mm, reading.numbers.contact_area_mm2) = (None, None);
    (reading.numbers.force_n, reading.numbers.torque_nmm) = (None, None);
}
