//! Small recordings of a patterned sheet.

use fingervision_calibrate::check::{Check, RecordingCheck, What};
use fingervision_gel::{Light, Motion, Sheet, SheetRenderer};
use fingervision_image::{Frame, Pixels};

pub(crate) const SIZE: (usize, usize) = (128, 96);

/// The conditions of a recording.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Camera {
    pub(crate) blur_px: f64,
    pub(crate) gain: f32,
    /// Contrast relative to that of a good image.
    pub(crate) contrast: f32,
}

impl Camera {
    /// In focus, well lit.
    pub(crate) const GOOD: Self = Self { blur_px: 0.7, gain: 1.0, contrast: 1.0 };
    pub(crate) const BLURRED: Self = Self { blur_px: 5.0, ..Self::GOOD };
    /// The pattern is not visible.
    pub(crate) const WITHOUT_PATTERN: Self = Self { contrast: 0.02, ..Self::GOOD };
    pub(crate) const OVEREXPOSED: Self = Self { gain: 2.0, ..Self::GOOD };
    pub(crate) const DARK: Self = Self { gain: 0.2, ..Self::GOOD };

    /// One image for each motion, each with its own noise.
    pub(crate) fn record(self, motions: impl Iterator<Item = Motion>) -> Vec<Frame> {
        let (width, height) = SIZE;
        let Self { blur_px, contrast, .. } = self;
        let renderer = SheetRenderer::new(&Sheet { width, height, blur_px, ..Sheet::default() }).unwrap();
        let frame = |(number, motion): (usize, Motion)| {
            let mut pixels = renderer.render(&motion, Light::uniform(self.gain), number as u64).unwrap();
            for level in pixels.values_mut().as_flattened_mut().iter_mut().filter(|_| contrast < 1.0) {
                *level = (128.0 + contrast * (f32::from(*level) - 128.0)).round() as u8;
            }
            Frame { sequence: number as u64, capture_time_s: number as f64 / 30.0, pixels: Pixels::Rgb8(pixels) }
        };
        motions.enumerate().map(frame).collect()
    }
}

pub(crate) fn judged(mut check: Box<dyn Check>, frames: &[Frame]) -> RecordingCheck {
    for frame in frames {
        check.push(frame);
    }
    check.finish()
}

/// Checks that this fault, and no other, is reported, with a hint.
pub(crate) fn expect_only(what: What, check: &RecordingCheck) {
    let found: Vec<What> = check.faults.iter().map(|fault| fault.what).collect();
    assert_eq!(found, [what], "{:?}", check.faults);
    let fault = &check.faults[0];
    assert!(!fault.measured.is_empty() && !fault.allowed.is_empty() && !fault.remedy.is_empty(), "{fault:?}");
}
