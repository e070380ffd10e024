//! Numbers frames, and counts those that are missing or repeated.
//!
//! The driver counts every frame that the camera sends, including those for which it has no free buffer. A gap in its
//! count therefore means dropped frames. After a restart the driver counts from 0 again; the number of missing frames
//! then follows from the time stamps.

/// The kind of a buffer, by its number and its time stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Arrival {
    /// A new frame.
    New {
        /// Its number since the camera was opened.
        sequence: u64,
        /// Its time, s; never before that of the previous frame.
        time_s: f64,
        /// Number of missing frames before it.
        missed: u64,
        /// The driver's clock was set back.
        is_clock_step: bool,
    },
    /// A frame that was delivered before.
    Duplicate,
}

/// Largest difference between time stamps of one frame that is delivered twice, as a fraction of the period between
/// frames.
const SAME_STAMP: f64 = 0.05;

#[derive(Debug, Clone, Copy)]
struct Last {
    /// Absent after a restart.
    driver_sequence: Option<u32>,
    stamp_s: f64,
    sequence: u64,
}

/// The numbers of one camera's frames.
#[derive(Debug)]
pub(crate) struct Numbering {
    period_s: f64,
    last: Option<Last>,
    /// Added to time stamps so that times never decrease.
    offset_s: f64,
}

impl Numbering {
    pub(crate) fn new(frames_per_second: f64) -> Self {
        Self { period_s: 1.0 / frames_per_second, last: None, offset_s: 0.0 }
    }

    /// The driver starts a new count, possibly at another rate.
    pub(crate) fn restart(&mut self, frames_per_second: f64) {
        self.period_s = 1.0 / frames_per_second;
        if let Some(last) = &mut self.last {
            last.driver_sequence = None;
        }
    }

    pub(crate) fn arrive(&mut self, driver_sequence: u32, stamp_s: f64) -> Arrival {
        let Some(last) = self.last else { return self.accept(driver_sequence, stamp_s, 0, 0, false) };
        let elapsed_s = stamp_s - last.stamp_s;
        // At least one frame: this one.
        let by_time = (elapsed_s / self.period_s).round().max(1.0) as u64;
        let steps = match last.driver_sequence.map(|before| driver_sequence.wrapping_sub(before)) {
            None => by_time,
            // Some drivers do not count at all, or begin to count late: as long as the number is 0, a new time stamp
            // is a new frame.
            Some(0) if driver_sequence == 0 && elapsed_s > SAME_STAMP * self.period_s => by_time,
            Some(0) => return Arrival::Duplicate,
            Some(ahead) if ahead < 1 << 31 => u64::from(ahead),
            Some(_) if elapsed_s > 0.5 * self.period_s => by_time,
            Some(_) => return Arrival::Duplicate,
        };
        let is_clock_step = elapsed_s <= 0.0;
        if is_clock_step {
            self.offset_s += last.stamp_s + steps as f64 * self.period_s - stamp_s;
        }
        self.accept(driver_sequence, stamp_s, last.sequence + steps, steps - 1, is_clock_step)
    }

    fn accept(&mut self, driver: u32, stamp_s: f64, sequence: u64, missed: u64, is_clock_step: bool) -> Arrival {
        self.last = Some(Last { driver_sequence: Some(driver), stamp_s, sequence });
        Arrival::New { sequence, time_s: stamp_s + self.offset_s, missed, is_clock_step }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number and missed frames of every arrival at 100 frames per second; `None` for a duplicate.
    fn arrivals(numbering: &mut Numbering, buffers: &[(u32, f64)]) -> Vec<Option<(u64, u64)>> {
        let number = |&(sequence, stamp_s): &(u32, f64)| match numbering.arrive(sequence, stamp_s) {
            Arrival::New { sequence, missed, .. } => Some((sequence, missed)),
            Arrival::Duplicate => None,
        };
        buffers.iter().map(number).collect()
    }

    #[test]
    fn a_gap_in_the_count_is_dropped_frames_and_a_repeated_number_a_duplicate() {
        let mut numbering = Numbering::new(100.0);
        let found = arrivals(&mut numbering, &[(5, 1.0), (6, 1.01), (9, 1.04), (9, 1.05), (10, 1.05), (7, 1.02)]);
        assert_eq!(found, [Some((0, 0)), Some((1, 0)), Some((4, 2)), None, Some((5, 0)), None]);
    }

    #[test]
    fn the_count_may_overflow() {
        let mut numbering = Numbering::new(100.0);
        let found = arrivals(&mut numbering, &[(u32::MAX, 1.0), (1, 1.02)]);
        assert_eq!(found, [Some((0, 0)), Some((2, 1))]);
    }

    #[test]
    fn after_a_restart_the_time_tells_how_many_frames_are_missing() {
        let mut numbering = Numbering::new(100.0);
        arrivals(&mut numbering, &[(0, 1.0), (1, 1.01)]);
        numbering.restart(100.0);
        assert_eq!(arrivals(&mut numbering, &[(0, 2.01), (1, 2.02)]), [Some((101, 99)), Some((102, 0))]);
        // The driver itself has started again.
        assert_eq!(arrivals(&mut numbering, &[(0, 2.05)]), [Some((105, 2))]);
    }

    #[test]
    fn a_driver_that_does_not_count_is_counted_by_time() {
        let mut numbering = Numbering::new(100.0);
        let found = arrivals(&mut numbering, &[(0, 1.0), (0, 1.01), (0, 1.01), (0, 1.04)]);
        assert_eq!(found, [Some((0, 0)), Some((1, 0)), None, Some((4, 2))]);
    }

    #[test]
    fn a_driver_that_begins_to_count_late_loses_no_frame() {
        let mut numbering = Numbering::new(100.0);
        let found = arrivals(&mut numbering, &[(0, 1.0), (0, 1.003), (0, 1.003), (1, 1.013), (1, 1.023), (3, 1.033)]);
        assert_eq!(found, [Some((0, 0)), Some((1, 0)), None, Some((2, 0)), None, Some((4, 1))]);
    }

    #[test]
    fn time_does_not_run_backwards_when_the_clock_is_set_back() {
        let mut numbering = Numbering::new(100.0);
        numbering.arrive(0, 100.0);
        let step = numbering.arrive(1, 40.0);
        let Arrival::New { time_s, is_clock_step: true, missed: 0, sequence: 1 } = step else { panic!("{step:?}") };
        assert!((time_s - 100.01).abs() < 1e-9, "{time_s}");
        let Arrival::New { time_s, is_clock_step: false, .. } = numbering.arrive(2, 40.01) else { panic!("a frame") };
        assert!((time_s - 100.02).abs() < 1e-9, "{time_s}");
    }
}
