//! The host's monotonic clock, which most V4L2 drivers also use for their time stamps.

use rustix::time::{ClockId, clock_gettime};

/// Seconds since the host started; the clock is never set.
#[must_use]
pub fn host_time_s() -> f64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// A time stamp counts as one of this clock if it is at most this old, s.
const OLDEST_STAMP_S: f64 = 10.0;

/// When a frame that has just arrived was captured, from its time stamp. If the time stamp belongs to another clock,
/// the present time is used.
pub(crate) fn captured_s(stamp_s: f64) -> f64 {
    let now = host_time_s();
    if (0.0..OLDEST_STAMP_S).contains(&(now - stamp_s)) { stamp_s } else { now }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_on() {
        let before = host_time_s();
        assert!(host_time_s() >= before && before > 0.0);
    }

    #[test]
    fn a_stamp_of_another_clock_is_replaced_by_the_time_of_arrival() {
        let now = host_time_s();
        assert!((captured_s(now - 0.02) - (now - 0.02)).abs() < 1e-12);
        for other in [now - 100.0, now + 100.0, f64::NAN, 0.0 - now] {
            let captured = captured_s(other);
            assert!((now..now + 1.0).contains(&captured), "{other}: {captured} at {now}");
        }
    }
}
