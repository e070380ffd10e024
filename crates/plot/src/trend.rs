//! One number over time, in bounded memory.

/// Number of steps before neighbours are merged.
const MOST_STEPS: usize = 2048;

/// A number over the frames of a run, however long it is: when memory is full, neighbouring steps are merged and keep the
/// larger number, so peaks are kept.
#[derive(Debug)]
pub struct Trend {
    steps: Vec<Step>,
    frames_per_step: u64,
    frames: u64,
    start_s: f64,
}

/// Some consecutive frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time of the first of them since the run's first frame, s.
    pub time_s: f64,
    /// Place of the first of them in the run, from 0.
    pub frame: u64,
    /// The largest number among them; NaN where there is none.
    pub peak: f32,
}

impl Default for Trend {
    fn default() -> Self {
        Self::new()
    }
}

impl Trend {
    /// No frame yet.
    #[must_use]
    pub fn new() -> Self {
        Self { steps: Vec::with_capacity(MOST_STEPS), frames_per_step: 1, frames: 0, start_s: 0.0 }
    }

    /// Takes the number of the next frame; NaN where it has none.
    pub fn push(&mut self, time_s: f64, value: f32) {
        if self.frames == 0 {
            self.start_s = time_s;
        }
        match self.steps.last_mut() {
            Some(step) if !self.frames.is_multiple_of(self.frames_per_step) => step.peak = step.peak.max(value),
            _ => {
                if self.steps.len() == MOST_STEPS {
                    self.join_neighbours();
                }
                self.steps.push(Step { time_s: time_s - self.start_s, frame: self.frames, peak: value });
            }
        }
        self.frames += 1;
    }

    /// Frames taken so far.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Time of the first frame on the source's clock, s.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// The steps in order.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    fn join_neighbours(&mut self) {
        for i in 0..MOST_STEPS / 2 {
            let (first, second) = (self.steps[2 * i], self.steps[2 * i + 1]);
            self.steps[i] = Step { peak: first.peak.max(second.peak), ..first };
        }
        self.steps.truncate(MOST_STEPS / 2);
        self.frames_per_step *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_in_bounded_memory() {
        let mut trend = Trend::new();
        for frame in 0..100_000 {
            trend.push(10.0 + f64::from(frame) * 0.01, if frame == 77_777 { 9.0 } else { f32::NAN });
        }
        assert!(trend.steps().len() <= MOST_STEPS);
        let peaks: Vec<_> = trend.steps().iter().filter(|step| !step.peak.is_nan()).collect();
        assert_eq!(peaks.len(), 1);
        assert!((peaks[0].time_s - 777.77).abs() < 0.64 + 1e-9, "{peaks:?}");
        assert_eq!(trend.frames(), 100_000);
    }

    #[test]
    fn every_frame_is_a_step_while_memory_lasts() {
        let mut trend = Trend::new();
        for frame in 0..5u8 {
            trend.push(f64::from(frame), f32::from(frame));
        }
        assert_eq!(trend.steps()[4], Step { time_s: 4.0, frame: 4, peak: 4.0 });
    }
}
