//! The problems that a reading can have.

/// A problem that a reading can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Flag {
    /// Most of the image does not match the reference: the fields are not valid.
    Lost,
    /// The source skipped frames just before this one.
    Dropped,
    /// The image has too little texture to be tracked.
    NoTexture,
    /// The gel already moves in the first frames: the reference may show a pressed gel.
    PressedAtStart,
    /// The mean brightness differs from the reference's by a factor above 1.25, up or down.
    LightChanged,
    /// The density's Gaussians do not overlap somewhere (3σ ≤ M).
    DensityGap,
    /// The gel is strained beyond the range of linear elasticity, on which depth and force are based.
    BeyondLinear,
    /// Contact reaches the border of the field of view: area, force and torque are those of the visible part.
    ContactCut,
    /// The flow cannot be that of this gel and camera: there is no depth and no force.
    GelMisfit,
    /// Gel and camera are outside the network's training range: depth, contact and force can be worse than their
    /// deviation says.
    OutsideTraining,
    /// The flow is valid in less than a tenth of contact, or nowhere within 24 px of a place in it, because it moves too fast,
    /// strains too much, has no pattern or is hidden by dirt: depth there is derived from the gel around it.
    ContactUntracked,
    /// The image is blurred more than the reference, by lost focus or by motion.
    OutOfFocus,
    /// Noise and motion do not explain how the image differs from the reference: blur, compression, or an image of
    /// another sensor. Deviations are larger accordingly.
    ImageMismatch,
    /// The flow's deviation is more than 1.8 times that of the images elastic depth was trained on, or less than half of the
    /// textured pixels are valid: depth, contact and force are less certain than their deviation says.
    UncertainFlow,
    /// An area of more than 0.75 % of the image was not found in it: hidden, or moved too far. Its flow is not valid;
    /// depth, contact and force are those of the rest.
    AreaLost,
    /// The first reading that is relative to a new reference: displacement, depth and force are measured from there.
    NewReference,
    /// The number of saturated pixels exceeds that of the reference by 5 % of the image, or a third of the image: they
    /// show no texture.
    Saturated,
    /// The image is so dark that its texture is lost.
    Dark,
    /// The first reading that matches the reference again, after [`Flag::Lost`].
    Found,
    /// The untouched gel has moved by more than 0.25 px since the reference was taken, or matches it clearly worse.
    /// Causes are warming, creep, ageing, or a camera that moved slowly.
    Drift,
    /// The flow of a part of the gel is never valid at rest, while that of the gel around it is, or dirt on the optics hides it.
    /// [`Reading::damaged_part`](crate::Reading) is its share of the image, at least half a percent.
    GelDamaged,
    /// The reference shows another pattern than the profile's `pattern.fingerprint`: the values of the profile are those
    /// of another sensor.
    OtherSensor,
    /// Upper or lower rows of the image are those of an earlier frame, and the gel has moved since then: displacement, depth and
    /// force of this reading, or of the one before, mix two moments.
    TornImage,
}

impl Flag {
    /// Every flag, in the order of its bit.
    pub const ALL: [Self; 23] = [
        Self::Lost,
        Self::Dropped,
        Self::NoTexture,
        Self::PressedAtStart,
        Self::LightChanged,
        Self::DensityGap,
        Self::BeyondLinear,
        Self::ContactCut,
        Self::GelMisfit,
        Self::OutsideTraining,
        Self::ContactUntracked,
        Self::OutOfFocus,
        Self::ImageMismatch,
        Self::UncertainFlow,
        Self::AreaLost,
        Self::NewReference,
        Self::Saturated,
        Self::Dark,
        Self::Found,
        Self::Drift,
        Self::GelDamaged,
        Self::OtherSensor,
        Self::TornImage,
    ];

    /// The flag's name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lost => "lost",
            Self::Dropped => "dropped",
            Self::NoTexture => "no-texture",
            Self::PressedAtStart => "pressed-at-start",
            Self::LightChanged => "light-changed",
            Self::DensityGap => "density-gap",
            Self::BeyondLinear => "beyond-linear",
            Self::ContactCut => "contact-cut",
            Self::GelMisfit => "gel-misfit",
            Self::OutsideTraining => "outside-training",
            Self::ContactUntracked => "contact-untracked",
            Self::OutOfFocus => "out-of-focus",
            Self::ImageMismatch => "image-mismatch",
            Self::UncertainFlow => "uncertain-flow",
            Self::AreaLost => "area-lost",
            Self::NewReference => "new-reference",
            Self::Saturated => "saturated",
            Self::Dark => "dark",
            Self::Found => "found",
            Self::Drift => "drift",
            Self::GelDamaged => "gel-damaged",
            Self::OtherSensor => "other-sensor",
            Self::TornImage => "torn-image",
        }
    }

    /// One sentence on what the flag means and what to do, without a full stop.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Lost => {
                "most of the image does not match the reference, so no value is valid: let go of the gel, look for dirt or a covered lens, or re-zero"
            }
            Self::Dropped => {
                "frames are missing before this one: lower the rate or the resolution, or end other programs"
            }
            Self::NoTexture => {
                "the image has too little texture to be tracked: check light, focus and region of interest, or print a finer pattern"
            }
            Self::PressedAtStart => {
                "the reference probably shows a pressed gel, so all values are relative to the press: release the gel and wait, or re-zero"
            }
            Self::LightChanged => {
                "the image is brighter or darker than the reference by more than a quarter: lock exposure and gain, block other light, or re-zero"
            }
            Self::DensityGap => {
                "the surface expands too much somewhere, so the density is not valid there: increase density.sigma_px"
            }
            Self::BeyondLinear => {
                "the gel is strained beyond linear elasticity, so depth and force have larger errors: press less deeply, or drag less far"
            }
            Self::ContactCut => {
                "contact reaches the border of the image, so area, force and torque are those of the visible part: press nearer to the middle"
            }
            Self::GelMisfit => {
                "the motion cannot be that of this gel, so depth and force are not computed: check [gel] and [camera] of the profile; if the camera or the gel was moved, re-zero"
            }
            Self::OutsideTraining => {
                "the network was not trained for such a gel and camera, so depth and force have larger errors: check the profile, or measure the error with a known object"
            }
            Self::ContactUntracked => {
                "contact or a large part of it cannot be tracked, so depth there is derived from the gel around it: press or move more slowly, or look for dirt and a worn pattern"
            }
            Self::OutOfFocus => {
                "the image is more blurred than the reference: move more slowly, or focus the camera, lock the lens and re-zero"
            }
            Self::ImageMismatch => {
                "noise and motion do not explain how the image differs from the reference, so errors are larger: check focus and compression, and whether it is the same sensor"
            }
            Self::UncertainFlow => {
                "the displacement is less certain than elastic depth expects, and so are depth and force: improve light, focus or pattern"
            }
            Self::AreaLost => {
                "an area of the image is not found, so depth and force are those of the rest: look for dirt and damage, or move more slowly"
            }
            Self::NewReference => {
                "from this reading on all values are relative to a new reference: do not compare them with earlier ones"
            }
            Self::Saturated => "too many pixels are saturated and show no texture: lower exposure, gain or light",
            Self::Dark => {
                "the image is too dark to show its texture: switch on the light, uncover the lens, or raise the exposure"
            }
            Self::Found => "the image matches the reference again: the motion while it was lost was not measured",
            Self::Drift => {
                "the untouched gel differs from the reference, so small forces may be wrong: let go of the gel and re-zero"
            }
            Self::GelDamaged => {
                "a part of the gel cannot be tracked or is hidden by dirt, so its motion is only interpolated: clean the optics, look for tears and worn pattern"
            }
            Self::OtherSensor => {
                "the pattern is not that of the profile, so depth and force are computed for another sensor: use the profile of this sensor, or write the fingerprint again"
            }
            Self::TornImage => {
                "this image and an earlier one share a part, so displacement, depth and force of this reading or of the one before mix two moments: lower the rate or the resolution, or use a camera that delivers whole frames"
            }
        }
    }
}

/// A set of [`Flag`]s. Prints as names joined by `+`, empty if there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u32);

impl Flags {
    /// Adds a flag.
    pub fn raise(&mut self, flag: Flag) {
        self.0 |= 1 << flag as u8;
    }

    /// Whether a flag is set.
    #[must_use]
    pub fn has(self, flag: Flag) -> bool {
        self.0 & (1 << flag as u8) != 0
    }

    /// The flags that are set.
    pub fn iter(self) -> impl Iterator<Item = Flag> {
        Flag::ALL.into_iter().filter(move |&flag| self.has(flag))
    }
}

impl std::fmt::Display for Flags {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, flag) in self.iter().enumerate() {
            let joint = if i == 0 { "" } else { "+" };
            write!(f, "{joint}{}", flag.name())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_print_their_names() {
        let mut flags = Flags::default();
        assert_eq!(flags.to_string(), "");
        flags.raise(Flag::DensityGap);
        flags.raise(Flag::Lost);
        assert_eq!(flags.to_string(), "lost+density-gap");
    }

    #[test]
    fn every_flag_has_a_bit_of_its_own() {
        for flag in Flag::ALL {
            let mut flags = Flags::default();
            flags.raise(flag);
            assert_eq!(flags.iter().collect::<Vec<_>>(), [flag]);
            assert_eq!(flags.to_string(), flag.name());
        }
    }

    #[test]
    fn every_flag_has_a_sentence_of_its_own() {
        let sentences: std::collections::BTreeSet<_> = Flag::ALL.map(Flag::sentence).into();
        assert_eq!(sentences.len(), Flag::ALL.len());
        for flag in Flag::ALL {
            let sentence = flag.sentence();
            assert!(sentence.contains(": ") && !sentence.ends_with('.'), "what it means: what to do; {sentence}");
        }
    }
}
