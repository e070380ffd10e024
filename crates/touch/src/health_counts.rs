//! How often each problem occurred in a run.

use serde::{Serialize, Serializer};

use crate::{Flag, ReadingNumbers};

/// Counts of flags over the readings of a run. Serialised as a table from a flag's name to its count, without zeros.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HealthCounts {
    readings: u64,
    /// For each flag, in the order of [`Flag::ALL`].
    flagged: [u64; Flag::ALL.len()],
    damaged_part: f32,
}

impl HealthCounts {
    /// Counts a reading.
    pub fn count(&mut self, numbers: &ReadingNumbers) {
        self.readings += 1;
        for (flag, count) in Flag::ALL.into_iter().zip(&mut self.flagged) {
            *count += u64::from(numbers.flags.has(flag));
        }
        self.damaged_part = self.damaged_part.max(numbers.damaged_part);
    }

    /// Number of readings.
    #[must_use]
    pub fn readings(&self) -> u64 {
        self.readings
    }

    /// The flags that were ever set, in the order of [`Flag::ALL`], with the number of readings that have them.
    pub fn flagged(&self) -> impl Iterator<Item = (Flag, u64)> {
        Flag::ALL.into_iter().zip(self.flagged).filter(|(_, count)| *count > 0)
    }

    /// The largest part of the image in which the flow was never valid or hidden by dirt, 0 to 1; see [`Flag::GelDamaged`].
    #[must_use]
    pub fn damaged_part(&self) -> f32 {
        self.damaged_part
    }
}

impl Serialize for HealthCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.flagged().map(|(flag, count)| (flag.name(), count)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_counted_and_the_largest_damage_is_kept() {
        let mut counts = HealthCounts::default();
        for (flags, damaged_part) in [(&[][..], 0.0), (&[Flag::Lost, Flag::GelDamaged], 0.02), (&[Flag::Lost], 0.01)] {
            let mut numbers = ReadingNumbers { damaged_part, ..ReadingNumbers::default() };
            for &flag in flags {
                numbers.flags.raise(flag);
            }
            counts.count(&numbers);
        }
        assert_eq!(counts.readings(), 3);
        assert_eq!(counts.flagged().collect::<Vec<_>>(), [(Flag::Lost, 2), (Flag::GelDamaged, 1)]);
        assert!((counts.damaged_part() - 0.02).abs() < 1e-6);
        assert_eq!(toml::to_string(&counts).unwrap(), "lost = 2\ngel-damaged = 1\n");
    }
}
