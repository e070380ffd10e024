//! Checks of whether readings can be trusted. They use only the picture, or more than one frame.

mod damage;
mod dirt;
mod rest;
mod thresholds;
mod torn;
mod untouched_motion;

use damage::Damage;
use dirt::Dirt;
use fingervision_flow::{Estimate, Levels};
use fingervision_image::Image;
use rest::Rest;
use thresholds::THRESHOLDS;
use torn::Torn;

use crate::whole_motion::WholeMotion;
use crate::{Fingerprint, Flag, Flags, Profile};

/// The inputs of the checks for one frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<'a> {
    /// When the frame was exposed, s.
    pub(crate) time_s: f64,
    /// The frame's grey levels.
    pub(crate) grey: &'a Image<f32>,
    /// Their mean, contrast and saturation.
    pub(crate) levels: Levels,
    /// Those of the reference.
    pub(crate) first: Levels,
    /// The result of matching the frame with the reference.
    pub(crate) estimate: &'a Estimate,
    /// Whether the frame is lost: it does not match.
    pub(crate) is_lost: bool,
}

/// Runs the checks over a stream of frames. A frame allocates nothing.
#[derive(Debug)]
pub(crate) struct Watch {
    /// Noise of the camera, grey levels.
    noise_levels: f32,
    rest: Rest,
    damage: Damage,
    dirt: Dirt,
    torn: Torn,
    /// The fingerprint in the profile.
    fingerprint: Option<Fingerprint>,
    /// Whether the reference shows another sensor; `None` before it was compared.
    is_other: Option<bool>,
    was_lost: bool,
    time_s: f64,
}

impl Watch {
    /// For images of this size, px, of this sensor.
    pub(crate) fn new(size: (usize, usize), profile: &Profile) -> Self {
        let (rest, damage) = (Rest::new(size), Damage::new(size));
        Self {
            noise_levels: profile.flow.noise_levels,
            rest,
            damage,
            dirt: Dirt::new(size, profile.flow.noise_levels),
            torn: Torn::new(size),
            fingerprint: profile.fingerprint(),
            is_other: None,
            was_lost: false,
            time_s: f64::NAN,
        }
    }

    /// Begins again with a new reference.
    pub(crate) fn restart(&mut self) {
        self.rest.restart();
        self.damage.restart();
        self.dirt.restart();
        self.torn.restart();
        self.was_lost = false;
        self.is_other = None;
    }

    /// Takes the grey levels of a reference, to which the flow of the next frames is relative.
    pub(crate) fn take_reference(&mut self, grey: &Image<f32>) {
        self.dirt.take_reference(grey);
    }

    /// Takes a frame and raises its flags.
    pub(crate) fn watch(&mut self, seen: Seen<'_>, flags: &mut Flags) {
        let mut raise_if = |flag: Flag, holds: bool| {
            if holds {
                flags.raise(flag);
            }
        };
        raise_if(Flag::Saturated, is_saturated(seen.levels, seen.first));
        let is_dark = self.is_dark(seen.levels, seen.first);
        raise_if(Flag::Dark, is_dark);
        if !is_dark && !seen.is_lost {
            let Self { is_other, fingerprint, .. } = self;
            // Compared once: from then on the frames match the reference.
            is_other.get_or_insert_with(|| fingerprint.is_some_and(|fingerprint| !fingerprint.matches(seen.grey)));
        }
        let is_torn = self.torn.watch(seen.grey, seen.estimate);
        raise_if(Flag::TornImage, is_torn);
        raise_if(Flag::OtherSensor, self.is_other == Some(true));
        raise_if(Flag::Found, std::mem::replace(&mut self.was_lost, seen.is_lost) && !seen.is_lost);
        self.time_s = seen.time_s;
        let is_at_rest = self.rest.watch(seen.time_s, seen.estimate, seen.is_lost);
        raise_if(Flag::Drift, self.rest.is_drifted());
        if !seen.is_lost {
            self.damage.watch(&seen.estimate.valid, is_at_rest);
            let has_same_light = (seen.levels.mean - seen.first.mean).abs() <= THRESHOLDS.same_light * seen.first.mean;
            if !is_at_rest && has_same_light && !is_torn && !seen.estimate.is_motion_blurred {
                self.dirt.watch(seen.grey, seen.estimate);
            }
        }
        raise_if(Flag::GelDamaged, self.damage.part() > 0.0 || self.dirt.is_large());
    }

    /// Marks the flow that dirt on the optics hides as not valid.
    pub(crate) fn hide_dirt(&self, estimate: &mut Estimate) {
        self.dirt.hide(estimate);
    }

    /// The part of the image that is damaged or hidden by dirt, 0 to 1.
    pub(crate) fn damaged_part(&self) -> f32 {
        (self.damage.part() + self.dirt.part()).min(1.0)
    }

    /// Notes that the last frame shows contact.
    pub(crate) fn note_contact(&mut self) {
        self.rest.disturb();
    }

    /// The motion of the whole image since the reference on the untouched gel, as far as it is sure.
    pub(crate) fn untouched_motion(&self) -> WholeMotion {
        self.rest.untouched_motion()
    }

    /// Whether the reference has drifted and nothing has touched the gel for this time, s.
    pub(crate) fn is_rezero_due(&self, after_s: f64) -> bool {
        self.rest.is_drifted() && self.rest.since_s().is_some_and(|since_s| self.time_s - since_s >= after_s)
    }

    fn is_dark(&self, now: Levels, first: Levels) -> bool {
        let is_darker =
            now.mean < THRESHOLDS.dark_mean * first.mean && now.contrast < THRESHOLDS.dark_contrast * first.contrast;
        let noise = THRESHOLDS.black_contrast * self.noise_levels;
        is_darker || (now.mean < THRESHOLDS.black_levels && now.contrast < noise)
    }
}

fn is_saturated(now: Levels, first: Levels) -> bool {
    now.saturated > (first.saturated + THRESHOLDS.more_saturated).min(THRESHOLDS.most_saturated)
}

/// From the second to the first.
fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// Square of the length.
fn length2([u, v]: [f32; 2]) -> f32 {
    u * u + v * v
}

/// The flow at a place, where it is valid.
fn flow_at(estimate: &Estimate, (x, y): (usize, usize)) -> Option<[f32; 2]> {
    (estimate.valid.at(x, y) == 1).then(|| [estimate.flow.u.at(x, y), estimate.flow.v.at(x, y)])
}
