use crate::ParameterError;
use serde::{Deserialize, Serialize};

/// Which reference image a frame is matched with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// Every frame is matched with the first image, starting from the flow of the previous frame. A later image is used
    /// only while the first one does not match. No drift accumulates.
    #[default]
    Anchored,
    /// The stack of references of [Du2021], as published.
    ///
    /// [Du2021]: https://doi.org/10.1109/LRA.2021.3061306
    Stack,
    /// Every frame is matched with the first image only, starting from the flow of the previous frame.
    Single,
}

impl Policy {
    /// The policy's name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Anchored => "anchored",
            Self::Stack => "stack",
            Self::Single => "single",
        }
    }
}

/// Parameters of the references.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReferenceParams {
    /// Which reference a frame is matched with.
    pub policy: Policy,
    /// Anchored and stack: a frame counts as matched while at least this part of the textured patches match, 0 to 1.
    pub min_matched: f32,
    /// Anchored: number of frames between two searches without a start while the gel is lost.
    pub search_interval: u64,
    /// Anchored: if the gel was pressed at the start, number of consecutive frames without motion after its release
    /// before a new reference is taken.
    pub rest_frames: u64,
    /// If the reference has drifted ([`Flag::Drift`](crate::Flag)) and nothing has touched the gel for this time, s, the
    /// next frame becomes the reference; absent: never. A press that grows by less than 0.05 px/s looks like drift.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rezero_after_s: Option<f64>,
    /// Stack: a largest photometric error above this adds the frame to the stack, grey levels.
    pub push_error: f32,
    /// Stack: a largest photometric error below this against an older reference drops all later ones, grey levels.
    pub loop_error: f32,
    /// Stack: columns and rows of the coarse flow.
    pub coarse_grid: [usize; 2],
    /// Stack: largest number of references; at the limit frames are matched with the newest.
    pub max_references: usize,
}

impl Default for ReferenceParams {
    fn default() -> Self {
        Self {
            policy: Policy::Anchored,
            min_matched: 0.7,
            search_interval: 15,
            rest_frames: 30,
            rezero_after_s: None,
            push_error: 10.0,
            loop_error: 5.0,
            coarse_grid: [61, 45],
            max_references: 64,
        }
    }
}

impl ReferenceParams {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] naming the first value that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = |holds: bool, key: &'static str, value: f64, allowed: &'static str| {
            if holds { Ok(()) } else { Err(ParameterError { key, value, allowed }) }
        };
        let matched = f64::from(self.min_matched);
        check(matched > 0.0 && matched <= 1.0, "references.min_matched", matched, "above 0, at most 1")?;
        for (key, count) in
            [("references.search_interval", self.search_interval), ("references.rest_frames", self.rest_frames)]
        {
            check(count > 0, key, count as f64, "at least 1 frame")?;
        }
        let after_s = self.rezero_after_s.unwrap_or(1.0);
        check(after_s > 0.0 && after_s.is_finite(), "references.rezero_after_s", after_s, "above 0 s")?;
        for (key, error) in [("references.push_error", self.push_error), ("references.loop_error", self.loop_error)] {
            check(error > 0.0 && error <= 255.0, key, f64::from(error), "above 0, at most 255 grey levels")?;
        }
        for size in self.coarse_grid {
            check((32..=4096).contains(&size), "references.coarse_grid", size as f64, "32 to 4096 columns and rows")?;
        }
        let most = self.max_references;
        check((1..=10_000).contains(&most), "references.max_references", most as f64, "1 to 10000")
    }
}
