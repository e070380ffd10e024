//! The results of `fingervision bench --sensors`.

use std::collections::BTreeMap;
use std::fmt;

use fearless_simd::Level;
use serde::Serialize;

use super::film::Film;
use super::trial::{Load, Measured, Memory};
use crate::bench::report::percentile;
use crate::doctor::instruction_set;

/// The load that was found, and what was measured with it.
#[derive(Debug, Serialize)]
pub(super) struct SensorsReport {
    /// What the sensors saw.
    frames: String,
    /// Columns and rows of the camera's frames, px.
    size: (usize, usize),
    /// Mean length of a coded frame, bytes.
    jpeg_bytes: f64,
    instruction_set: String,
    threads: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    found: Option<Found>,
    sensors: usize,
    /// Frames per second that each sensor sends.
    rate: f64,
    seconds: f64,
    /// Readings per second of each sensor.
    sustained_rate: f64,
    readings: usize,
    dropped_frames: u64,
    damaged_frames: u64,
    /// Readings in which something touches the gel.
    touched_readings: usize,
    /// Readings that are lost or do not fit the gel.
    lost_readings: usize,
    /// From the moment at which a frame is due to its reading.
    latency_ms: Percentiles,
    stages_ms: BTreeMap<&'static str, Percentiles>,
    #[serde(skip)]
    order: Vec<&'static str>,
    memory_mib: Option<f64>,
    /// What each sensor adds; not known after several trials.
    sensor_memory_mib: Option<f64>,
    /// What was added in the last two thirds of the time.
    memory_growth_mib: Option<f64>,
    /// Processors in use on average.
    cpus: Option<f64>,
    /// Times per second at which a thread had to make room for another one.
    preemptions_per_second: Option<f64>,
}

/// The result of a search.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Found {
    /// The largest number of sensors.
    Sensors(usize),
    /// The highest rate, frames per second.
    Rate(f64),
}

/// Percentiles of times, ms.
#[derive(Debug, Clone, Copy, Serialize)]
struct Percentiles {
    p50: f64,
    p95: f64,
    p99: f64,
    max: f64,
}

impl Percentiles {
    fn of(mut times_ms: Vec<f64>) -> Self {
        if times_ms.is_empty() {
            times_ms.push(f64::NAN);
        }
        times_ms.sort_unstable_by(f64::total_cmp);
        let [p50, p95, p99, max] = [50.0, 95.0, 99.0, 100.0].map(|percent| percentile(&times_ms, percent));
        Self { p50, p95, p99, max }
    }
}

impl SensorsReport {
    pub(super) fn new(film: &Film, measured: Measured, found: Option<Found>) -> Self {
        let sustained_rate = measured.sustained_rate();
        let Measured { load: Load { sensors, rate, workers, .. }, seconds, stages, stages_ms, latency_ms, .. } =
            measured;
        let Memory { whole, of_sensor, growth } = measured.memory;
        let times = stages.iter().copied().zip(stages_ms);
        // A stage that does not run has no time.
        let times: BTreeMap<_, _> = times.filter(|(_, times)| times.iter().any(|&time| time > 0.0)).collect();
        Self {
            frames: film.description.clone(),
            size: (film.layout.width, film.layout.height),
            jpeg_bytes: film.frame_bytes().round(),
            instruction_set: instruction_set(Level::new()),
            threads: workers.get(),
            found,
            sensors,
            rate,
            seconds,
            sustained_rate,
            readings: latency_ms.len(),
            dropped_frames: measured.dropped,
            damaged_frames: measured.damaged,
            touched_readings: measured.touched,
            lost_readings: measured.lost,
            latency_ms: Percentiles::of(latency_ms),
            order: stages,
            stages_ms: times.into_iter().map(|(name, times)| (name, Percentiles::of(times))).collect(),
            memory_mib: whole,
            sensor_memory_mib: of_sensor,
            memory_growth_mib: growth,
            cpus: measured.cpu_s.map(|cpu_s| cpu_s / seconds.max(1e-3)),
            preemptions_per_second: measured.preemptions.map(|count| count as f64 / seconds.max(1e-3)),
        }
    }
}

impl fmt::Display for SensorsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frames, size: (width, height), jpeg_bytes, instruction_set, threads, sensors, rate, .. } = self;
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        writeln!(f, "{frames}: {width}x{height} px, motion JPEG, {:.0} kB a frame", jpeg_bytes / 1e3)?;
        writeln!(f, "{threads} thread{}, {instruction_set}", plural(*threads))?;
        match self.found {
            Some(Found::Sensors(most)) => {
                writeln!(f, "largest number     {most} sensor{} at {rate:.1} frames/s", plural(most))?;
            }
            Some(Found::Rate(rate)) => {
                writeln!(f, "highest rate       {rate:.1} frames/s of {sensors} sensor{}", plural(*sensors))?;
            }
            None => {}
        }
        let Self { seconds, sustained_rate, readings, dropped_frames, touched_readings, .. } = self;
        writeln!(
            f,
            "load               {sensors} sensor{} at {rate:.1} frames/s for {seconds:.1} s",
            plural(*sensors)
        )?;
        writeln!(f, "sustained          {sustained_rate:.1} readings/s of each")?;
        write!(f, "frames             {readings} tracked, {touched_readings} touched, {dropped_frames} dropped")?;
        if self.damaged_frames > 0 {
            write!(f, ", {} damaged", self.damaged_frames)?;
        }
        if self.lost_readings > 0 {
            write!(f, ", {} lost", self.lost_readings)?;
        }
        writeln!(f, "\nms                    p50     p95     p99     max")?;
        let row = |f: &mut fmt::Formatter<'_>, name: &str, times: &Percentiles| {
            let Percentiles { p50, p95, p99, max } = times;
            writeln!(f, "  {name:<16}{p50:>8.2}{p95:>8.2}{p99:>8.2}{max:>8.2}")
        };
        for (name, times) in self.order.iter().filter_map(|name| Some((name, self.stages_ms.get(name)?))) {
            row(f, name, times)?;
        }
        row(f, "due to reading", &self.latency_ms)?;
        if let Some(memory) = self.memory_mib {
            write!(f, "memory             {memory:.0} MiB")?;
            self.sensor_memory_mib.map_or(Ok(()), |of_sensor| write!(f, ", {of_sensor:.1} MiB a sensor"))?;
            self.memory_growth_mib
                .map_or(Ok(()), |growth| write!(f, "; {growth:.1} MiB more after a third of the time"))?;
            writeln!(f)?;
        }
        let (Some(cpus), Some(preemptions)) = (self.cpus, self.preemptions_per_second) else { return Ok(()) };
        writeln!(f, "processors         {cpus:.2} in use, {preemptions:.0} preemptions/s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_those_of_the_sorted_times() {
        let times = (0..=100).rev().map(f64::from).collect();
        let Percentiles { p50, p95, p99, max } = Percentiles::of(times);
        assert_eq!([p50, p95, p99, max].map(|time_ms| time_ms.round() as u32), [50, 95, 99, 100]);
        assert!(Percentiles::of(Vec::new()).p50.is_nan());
    }
}
