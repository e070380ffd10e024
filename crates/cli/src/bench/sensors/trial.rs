//! One trial: so many sensors at this rate for so long.

use std::num::NonZero;
use std::time::{Duration, Instant};

use fingervision_pipeline::{
    FrameTimes, Input, Interest, Message, Pipeline, PipelineError, Running, Sensor, Subscription,
};
use fingervision_touch::{Fields, Flag};

use super::film::Film;
use super::machine::Usage;
use crate::failure::Failure;
use crate::output::OutputArgs;

/// Messages that may wait: the trial reads them at once.
const CAPACITY: usize = 4096;
const WAIT: Duration = Duration::from_millis(200);

/// What a trial asks of the machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    pub(super) sensors: usize,
    /// Frames per second of each sensor.
    pub(super) rate: f64,
    pub(super) seconds: f64,
    pub(super) fields: Fields,
    /// Threads that track.
    pub(super) workers: NonZero<usize>,
}

/// What came of it.
pub(super) struct Measured {
    pub(super) load: Load,
    /// From the first frame after the references to the last reading, s.
    pub(super) seconds: f64,
    /// Names of the stages, in order.
    pub(super) stages: Vec<&'static str>,
    /// Time of each stage in each frame, ms.
    pub(super) stages_ms: Vec<Vec<f64>>,
    /// From the moment at which a frame was due to its reading, ms.
    pub(super) latency_ms: Vec<f64>,
    pub(super) dropped: u64,
    /// Frames that could not be tracked.
    pub(super) damaged: u64,
    /// Readings in which something touches the gel.
    pub(super) touched: usize,
    /// Readings that are lost or do not fit the gel.
    pub(super) lost: usize,
    pub(super) memory: Memory,
    /// Processor time, s.
    pub(super) cpu_s: Option<f64>,
    pub(super) preemptions: Option<u64>,
}

/// Memory of a trial, MiB.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Memory {
    /// Of the whole process at the end.
    pub(super) whole: Option<f64>,
    /// What each sensor added.
    pub(super) of_sensor: Option<f64>,
    /// What was added after the first third of the trial.
    pub(super) growth: Option<f64>,
}

impl Load {
    /// Plays the film on all sensors to its end.
    pub(super) fn run(self, film: &Film, output: OutputArgs) -> Result<Measured, Failure> {
        let before = Usage::now();
        let replay = film.replay(self.rate, self.seconds);
        let open = |number: usize| {
            Sensor::open(&format!("sensor-{number}"), film.profile.clone(), Input::replay(replay.clone()), self.fields)
        };
        let sensors = (0..self.sensors).map(open).collect::<Result<Vec<_>, PipelineError>>()?;
        let pipeline = Pipeline::prepare(sensors).with_workers(self.workers);
        let readings = pipeline.subscribe(Interest { capacity: CAPACITY, ..Interest::readings() });
        let frames = self.sensors as u64 * (1 + (self.seconds * self.rate).round() as u64);
        let bar = output.progress("tracking", Some(frames));
        let running = pipeline.start()?;
        let mut collector = Collector::new(self);
        let ended = collector.collect(&readings, |tracked| bar.set_position(tracked));
        bar.finish_and_clear();
        ended?;
        Ok(collector.finish(&running, &before))
    }
}

/// Gathers the readings of a trial.
struct Collector {
    measured: Measured,
    /// When the first frame behind the references was due, and what the process had used then.
    begin: Option<(f64, Usage)>,
    end_s: f64,
    third: Option<Usage>,
    /// The threads' usage at the last look, because ended threads are no longer counted.
    last: (Instant, Usage),
    tracked: u64,
}

impl Collector {
    fn new(load: Load) -> Self {
        let measured = Measured {
            load,
            seconds: 0.0,
            stages: Vec::new(),
            stages_ms: Vec::new(),
            latency_ms: Vec::new(),
            dropped: 0,
            damaged: 0,
            touched: 0,
            lost: 0,
            memory: Memory::default(),
            cpu_s: None,
            preemptions: None,
        };
        let last = (Instant::now(), Usage::now());
        Self { measured, begin: None, end_s: 0.0, third: None, last, tracked: 0 }
    }

    fn collect(&mut self, readings: &Subscription, mut tick: impl FnMut(u64)) -> Result<(), Failure> {
        while !readings.is_done() {
            let Some(message) = readings.next(WAIT) else { continue };
            match message {
                // The reference is prepared before the sensors begin to send.
                Message::Reading { numbers, .. } if numbers.sequence == 0 => self.tracked += 1,
                Message::Reading { numbers, captured_s, ready_s, times, .. } => {
                    self.add(captured_s, ready_s, &times);
                    self.measured.touched += usize::from(numbers.contact_area_mm2.is_some_and(|area| area > 0.0));
                    let is_lost = numbers.flags.has(Flag::Lost) || numbers.flags.has(Flag::GelMisfit);
                    self.measured.lost += usize::from(is_lost);
                    tick(self.tracked);
                }
                Message::Event { text, .. } if self.tracked == 0 => {
                    return Err(Failure::new(text, "try the recording with `fingervision track`"));
                }
                _ => {}
            }
        }
        if readings.lost() > 0 {
            let message = format!("{} readings came faster than they could be counted", readings.lost());
            return Err(Failure::new(message, "use fewer sensors or a lower --rate"));
        }
        Ok(())
    }

    fn add(&mut self, captured_s: f64, ready_s: f64, times: &FrameTimes) {
        let (begin_s, _) = *self.begin.get_or_insert_with(|| (captured_s, Usage::now()));
        let named = times.stages.named();
        let all = [("waiting", times.waiting_ms), ("decode", times.decode_ms)].into_iter().chain(named);
        for (place, (name, time_ms)) in all.enumerate() {
            if self.measured.stages.len() <= place {
                self.measured.stages.push(name);
                self.measured.stages_ms.push(Vec::new());
            }
            self.measured.stages_ms[place].push(time_ms);
        }
        self.measured.latency_ms.push(1e3 * (ready_s - captured_s));
        self.end_s = self.end_s.max(ready_s);
        self.tracked += 1;
        if self.last.0.elapsed() > WAIT {
            self.last = (Instant::now(), Usage::now());
            self.end_s = ready_s;
            if ready_s - begin_s > self.measured.load.seconds / 3.0 {
                self.third.get_or_insert(self.last.1);
            }
        }
    }

    fn finish(mut self, running: &Running, before: &Usage) -> Measured {
        let (begin_s, begin) = self.begin.unwrap_or((self.end_s, Usage::now()));
        let last = self.last.1;
        self.measured.seconds = self.end_s - begin_s;
        let used = begin.cpu_s.zip(last.cpu_s).map(|(begin, last)| last - begin);
        self.measured.cpu_s = used;
        self.measured.preemptions =
            begin.preemptions.zip(last.preemptions).map(|(begin, last)| last.saturating_sub(begin));
        let none = Usage { memory_bytes: Some(0), ..Usage::default() };
        self.measured.memory = Memory {
            whole: last.more_mib(&none),
            of_sensor: last.more_mib(before).map(|mib| mib / self.measured.load.sensors as f64),
            growth: self.third.and_then(|third| last.more_mib(&third)),
        };
        for handle in running.handles() {
            let counts = handle.counts();
            self.measured.dropped += counts.dropped;
            self.measured.damaged += counts.damaged;
        }
        self.measured
    }
}

impl Measured {
    /// Whether every frame became a reading.
    pub(super) fn is_carried(&self) -> bool {
        self.dropped == 0 && self.damaged == 0
    }

    /// Readings of each sensor in a second.
    pub(super) fn sustained_rate(&self) -> f64 {
        self.latency_ms.len() as f64 / self.load.sensors as f64 / self.seconds.max(1e-3)
    }
}
