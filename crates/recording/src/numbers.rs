//! Converts the numbers of a reading to a message and back.

use fingervision_touch::{Flag, Flags, ReadingNumbers};

use crate::message::{Reading, timestamp};

pub(crate) fn to_message(numbers: &ReadingNumbers, captured_s: f64, time_ns: u64) -> Reading {
    let [force_x_n, force_y_n, force_z_n] = numbers.force_n.map_or([None; 3], |force| force.map(Some));
    Reading {
        timestamp: Some(timestamp(time_ns)),
        sequence: numbers.sequence,
        capture_time_s: numbers.capture_time_s,
        captured_s,
        dropped_frames: numbers.dropped_frames,
        reference_id: numbers.reference_id,
        reference_count: numbers.reference_count as u64,
        photometric_error: numbers.photometric_error,
        latency_ms: numbers.latency_ms,
        flags: numbers.flags.iter().map(|flag| flag.name().into()).collect(),
        max_depth_mm: numbers.max_depth_mm,
        contact_area_mm2: numbers.contact_area_mm2,
        force_x_n,
        force_y_n,
        force_z_n,
        torque_z_nmm: numbers.torque_nmm,
        damaged_part: numbers.damaged_part,
        mean_level: numbers.mean_level,
        saturated_part: numbers.saturated_part,
        sharpness: numbers.sharpness,
    }
}

/// Unknown flags are left out.
pub(crate) fn from_message(message: &Reading) -> ReadingNumbers {
    let mut numbers = ReadingNumbers::default();
    numbers.sequence = message.sequence;
    numbers.capture_time_s = message.capture_time_s;
    numbers.dropped_frames = message.dropped_frames;
    numbers.reference_id = message.reference_id;
    numbers.reference_count = usize::try_from(message.reference_count).unwrap_or(usize::MAX);
    numbers.photometric_error = message.photometric_error;
    numbers.latency_ms = message.latency_ms;
    numbers.flags = flags(&message.flags);
    numbers.max_depth_mm = message.max_depth_mm;
    numbers.contact_area_mm2 = message.contact_area_mm2;
    numbers.force_n = match (message.force_x_n, message.force_y_n, message.force_z_n) {
        (Some(x), Some(y), Some(z)) => Some([x, y, z]),
        _ => None,
    };
    numbers.torque_nmm = message.torque_z_nmm;
    numbers.damaged_part = message.damaged_part;
    (numbers.mean_level, numbers.saturated_part) = (message.mean_level, message.saturated_part);
    numbers.sharpness = message.sharpness;
    numbers
}

fn flags(names: &[String]) -> Flags {
    let mut flags = Flags::default();
    for flag in Flag::ALL.into_iter().filter(|flag| names.iter().any(|name| name == flag.name())) {
        flags.raise(flag);
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_come_back_as_they_were() {
        let mut numbers = ReadingNumbers::default();
        assert_eq!(from_message(&to_message(&numbers, 3.0, 1)), numbers);
        (numbers.sequence, numbers.capture_time_s, numbers.dropped_frames) = (u64::MAX, 0.1 + 0.2, 7);
        (numbers.reference_id, numbers.reference_count, numbers.photometric_error) = (3, 4, 0.1);
        (numbers.latency_ms, numbers.max_depth_mm, numbers.contact_area_mm2) = (1.5, Some(0.0), Some(12.0));
        (numbers.force_n, numbers.torque_nmm) = (Some([0.0, -0.5, 2.0]), Some(-0.0));
        (numbers.damaged_part, numbers.mean_level) = (0.25, 117.5);
        (numbers.saturated_part, numbers.sharpness) = (0.01, 1.7);
        for flag in Flag::ALL {
            numbers.flags.raise(flag);
            assert_eq!(from_message(&to_message(&numbers, 3.0, 1)), numbers);
        }
    }
}
