//! The motion of the indenter, or of a rigid board, over time.

use fingervision_elastic::Pose;
use fingervision_settings::SettingsError;
use serde::{Deserialize, Serialize};

/// Most frames of a scene: six digits in a file's name, and the size of a disk.
const MOST_FRAMES: usize = 100_000;
/// Largest tilt, rad: beyond it, the face does not point towards the gel.
const LARGEST_TILT_RAD: f64 = 1.2;

/// The `[motion]` table: a motion between keyframes, divided into a number of frames.
///
/// The motion begins at rest, at 0, and is linear from keyframe to keyframe. Its frames are spread evenly over it: the
/// first shows the gel at rest, the last the last keyframe. Where the last keyframe is at `frames − 1`, the keyframes'
/// places are frame numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SceneMotion {
    /// What moves.
    pub kind: MotionKind,
    /// Where the indenter's origin meets the undeformed surface, mm.
    pub centre_mm: [f64; 2],
    /// Number of frames of the motion, both ends included.
    pub frames: usize,
    /// The keyframes, in order.
    pub keyframes: Vec<Keyframe>,
}

/// What moves in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MotionKind {
    /// The indenter moves and the gel yields.
    #[default]
    Press,
    /// The patterned surface itself moves as a rigid board; there is no indenter and no force.
    Rigid,
}

/// A pose of the motion. Missing values are those of the previous keyframe.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Its place on the course, above that of the keyframe before.
    pub at: f64,
    /// Depth of the indenter's origin, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// Sideways from where the press began, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_mm: Option<[f64; 2]>,
    /// Rotation about z, rad, from x towards y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twist_rad: Option<f64>,
    /// Rotations about x and y, rad, applied x first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_rad: Option<[f64; 2]>,
}

impl Default for SceneMotion {
    /// A press at the centre to 2 mm in 21 frames.
    fn default() -> Self {
        let keyframe = Keyframe { at: 20.0, depth_mm: Some(2.0), ..Keyframe::default() };
        Self { kind: MotionKind::Press, centre_mm: [0.0; 2], frames: 21, keyframes: vec![keyframe] }
    }
}

impl Keyframe {
    fn pose(&self, before: &Pose) -> Pose {
        Pose {
            depth_mm: self.depth_mm.unwrap_or(before.depth_mm),
            shear_mm: self.shear_mm.unwrap_or(before.shear_mm),
            twist_rad: self.twist_rad.unwrap_or(before.twist_rad),
            tilt_rad: self.tilt_rad.unwrap_or(before.tilt_rad),
        }
    }

    fn validate(&self, index: usize, before: f64) -> Result<(), SettingsError> {
        let check = |holds: bool, key: &str, value: &dyn std::fmt::Debug, allowed: String| {
            let error = || SettingsError::out_of_range(format!("motion.keyframes[{index}].{key}"), value, allowed);
            if holds { Ok(()) } else { Err(error()) }
        };
        let at = self.at;
        check(at.is_finite() && at > before, "at", &at, format!("a number above {before}, the place before it"))?;
        let depth = self.depth_mm.unwrap_or_default();
        check(depth.is_finite() && depth >= 0.0, "depth_mm", &depth, "a depth of 0 mm or more".into())?;
        let shear = self.shear_mm.unwrap_or_default();
        check(shear.iter().all(|value| value.is_finite()), "shear_mm", &shear, "two finite lengths, mm".into())?;
        let twist = self.twist_rad.unwrap_or_default();
        check(twist.is_finite(), "twist_rad", &twist, "a finite angle, rad".into())?;
        let tilt = self.tilt_rad.unwrap_or_default();
        let is_tilt = tilt.iter().all(|value| value.abs() <= LARGEST_TILT_RAD);
        check(is_tilt, "tilt_rad", &tilt, format!("two angles of at most {LARGEST_TILT_RAD} rad"))
    }
}

impl SceneMotion {
    /// Checks every value on its own.
    ///
    /// # Errors
    ///
    /// [`SettingsError::OutOfRange`] naming the first impossible value.
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        let frames = self.frames;
        if !(2..=MOST_FRAMES).contains(&frames) {
            return Err(SettingsError::out_of_range("motion.frames", frames, format!("2 to {MOST_FRAMES} frames")));
        }
        let centre = self.centre_mm;
        if !centre.iter().all(|value| value.is_finite()) {
            return Err(SettingsError::out_of_range("motion.centre_mm", centre, "two finite lengths, mm"));
        }
        if self.keyframes.is_empty() {
            let keyframes: [Keyframe; 0] = [];
            return Err(SettingsError::out_of_range("motion.keyframes", keyframes, "one keyframe or more"));
        }
        let mut before = 0.0;
        for (index, keyframe) in self.keyframes.iter().enumerate() {
            keyframe.validate(index, before)?;
            before = keyframe.at;
        }
        Ok(())
    }

    /// The pose of every frame.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose> {
        let stops = self.stops();
        let end = stops.last().map_or(0.0, |stop| stop.0);
        let last = self.frames.max(2) - 1;
        let pose = |frame: usize| {
            let at = frame as f64 * end / last as f64;
            let next = stops.partition_point(|stop| stop.0 < at).clamp(1, stops.len().max(2) - 1);
            let (Some((from, start)), Some((to, goal))) = (stops.get(next - 1), stops.get(next)) else {
                return Pose::default();
            };
            start.towards(goal, (at - from) / (to - from))
        };
        (0..self.frames).map(pose).collect()
    }

    /// Places and whole poses of rest and all keyframes.
    fn stops(&self) -> Vec<(f64, Pose)> {
        let mut stops = vec![(0.0, Pose::default())];
        let mut before = Pose::default();
        for keyframe in &self.keyframes {
            before = keyframe.pose(&before);
            stops.push((keyframe.at, before));
        }
        stops
    }

    /// The largest depth of the course, mm.
    #[must_use]
    pub fn largest_depth_mm(&self) -> f64 {
        self.stops().iter().map(|(_, pose)| pose.depth_mm).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press_then_shear() -> SceneMotion {
        let press = Keyframe { at: 10.0, depth_mm: Some(1.0), ..Keyframe::default() };
        let shear = Keyframe { at: 20.0, shear_mm: Some([1.5, 0.0]), ..Keyframe::default() };
        SceneMotion { keyframes: vec![press, shear], ..SceneMotion::default() }
    }

    fn refusal(change: impl FnOnce(&mut SceneMotion)) -> String {
        let mut motion = press_then_shear();
        change(&mut motion);
        motion.validate().unwrap_err().to_string()
    }

    #[test]
    fn frames_lie_on_straight_lines_between_keyframes() {
        let poses = press_then_shear().poses();
        assert_eq!(poses.len(), 21);
        assert_eq!(poses[0], Pose::default());
        assert_eq!(poses[10], Pose { depth_mm: 1.0, ..Pose::default() });
        assert!((poses[5].depth_mm - 0.5).abs() < 1e-12);
        assert!((poses[15].shear_mm[0] - 0.75).abs() < 1e-12);
        assert_eq!(poses[20], Pose { depth_mm: 1.0, shear_mm: [1.5, 0.0], ..Pose::default() });
    }

    #[test]
    fn another_number_of_frames_shows_the_same_course() {
        for frames in [2, 3, 5, 41, 100] {
            let poses = SceneMotion { frames, ..press_then_shear() }.poses();
            assert_eq!(poses.len(), frames);
            assert_eq!(poses[frames - 1], Pose { depth_mm: 1.0, shear_mm: [1.5, 0.0], ..Pose::default() });
        }
        let poses = SceneMotion { frames: 41, ..press_then_shear() }.poses();
        assert!((poses[10].depth_mm - 0.5).abs() < 1e-12);
    }

    #[test]
    fn an_impossible_motion_is_refused() {
        assert_eq!(
            refusal(|motion| motion.keyframes[1].depth_mm = Some(-0.5)),
            "motion.keyframes[1].depth_mm = -0.5 is impossible: it must be a depth of 0 mm or more"
        );
        assert!(refusal(|motion| motion.keyframes[1].at = 10.0).contains("keyframes[1].at = 10.0"));
        assert!(refusal(|motion| motion.keyframes[0].at = 0.0).contains("a number above 0"));
        assert!(
            refusal(|motion| motion.keyframes[0].shear_mm = Some([f64::NAN, 0.0])).contains("shear_mm = [NaN, 0.0]")
        );
        assert!(refusal(|motion| motion.keyframes[0].twist_rad = Some(f64::INFINITY)).contains("twist_rad = inf"));
        assert!(refusal(|motion| motion.keyframes[0].tilt_rad = Some([0.0, 1.3])).contains("at most 1.2 rad"));
        assert!(refusal(|motion| motion.keyframes.clear()).contains("motion.keyframes = []"));
        assert!(refusal(|motion| motion.frames = 1).contains("motion.frames = 1"));
        assert!(refusal(|motion| motion.centre_mm[0] = f64::NAN).contains("motion.centre_mm = [NaN, 0.0]"));
    }
}
