//! The reading: everything that one frame tells, made at once.

use fingervision_flow::FlowField;
use fingervision_image::Image;

/// Every quantity computed from one frame. All fields lie on the reference grid.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The frame's place in its source's count.
    pub sequence: u64,
    /// When the frame was exposed, s, on the source's clock.
    pub capture_time_s: f64,
    /// Frames that the source dropped since tracking began.
    pub dropped_frames: u64,
    /// Which reference the frame was matched with, counted from 0 at start-up.
    pub reference_id: u64,
    /// References held when the frame was matched.
    pub reference_count: usize,
    /// Photometric error, grey levels: under the stack policy the largest of the coarse check that decides about
    /// references, otherwise the root mean square of what the matching patches leave unexplained.
    pub photometric_error: f32,
    /// Time from the frame's arrival to this reading, ms. The one value that differs from run to run.
    pub latency_ms: f64,
    /// What is out of order.
    pub flags: Flags,
    /// Displacement, px.
    pub flow: FlowField,
    /// Predicted standard deviation of the flow, px; infinite where there is no measurement.
    pub deviation: Image<f32>,
    /// 1 where every field holds, 0 elsewhere.
    pub valid: Image<u8>,
    /// Density feature `1 − density` after the guided filter, dimensionless, 0 at rest, positive where the surface
    /// spreads, 0 where it is not valid; if asked for.
    pub density: Option<Image<f32>>,
    /// Depth, mm, positive pressed in; if asked for and the profile is calibrated.
    pub depth: Option<Image<f32>>,
    /// Largest valid depth, mm.
    pub max_depth_mm: Option<f32>,
    /// Area of contact in the undeformed surface, mm².
    pub contact_area_mm2: Option<f32>,
    /// Force on the gel `(x, y, z)`, N.
    pub force_n: Option<[f32; 3]>,
}

impl Reading {
    /// A reading at rest on a reference grid of this size, with the given planes for density and depth.
    pub(crate) fn new(width: usize, height: usize, density: Option<Image<f32>>, depth: Option<Image<f32>>) -> Self {
        Self {
            sequence: 0,
            capture_time_s: 0.0,
            dropped_frames: 0,
            reference_id: 0,
            reference_count: 0,
            photometric_error: 0.0,
            latency_ms: 0.0,
            flags: Flags::default(),
            flow: FlowField::zero(width, height),
            deviation: Image::filled(width, height, f32::INFINITY),
            valid: Image::filled(width, height, 0),
            density,
            depth,
            max_depth_mm: None,
            contact_area_mm2: None,
            force_n: None,
        }
    }
}

/// One thing that can be out of order in a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Flag {
    /// Most of the image does not match the reference: the fields do not hold.
    Lost,
    /// The source skipped frames just before this one.
    Dropped,
    /// The image has too little texture to be tracked.
    NoTexture,
    /// The gel already moves in the first frames: the reference may show a pressed gel.
    PressedAtStart,
    /// Mean light changed by a factor above 1.25, either way, since the first frame.
    LightChanged,
    /// The density's Gaussians do not overlap somewhere (3σ ≤ M).
    DensityGap,
}

impl Flag {
    /// Every flag, in the order of its bit.
    pub const ALL: [Self; 6] =
        [Self::Lost, Self::Dropped, Self::NoTexture, Self::PressedAtStart, Self::LightChanged, Self::DensityGap];

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
        }
    }
}

/// A set of [`Flag`]s. Prints as names joined by `+`, empty where all is well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u8);

impl Flags {
    /// Adds a flag.
    pub fn raise(&mut self, flag: Flag) {
        self.0 |= 1 << flag as u8;
    }

    /// Whether a flag is up.
    #[must_use]
    pub fn has(self, flag: Flag) -> bool {
        self.0 & (1 << flag as u8) != 0
    }

    /// The flags that are up.
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
}
