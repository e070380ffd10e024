//! The stages that are counted, and the work of each.

use std::fmt;

use anyhow::{Result, anyhow};
use clap::ValueEnum;
use fingervision_image::{Frame, Pixels};
use fingervision_source::{CameraCoding, CameraFrameDecoder, CameraLayout};
use fingervision_touch::{DepthLine, DepthSection, ElasticMode, Fields, Profile, Reading, Tracker};
use serde::{Deserialize, Serialize};

use super::film::{Film, NEW_REFERENCE, PRESSED, PRESSED_START, REST, REST_START};

/// Marks the begin and the end of what is counted: valgrind starts a new part where it is entered, and knows it by name.
pub(super) const MARK: &str = "mark_of_counted_frames";

#[inline(never)]
fn mark_of_counted_frames() {
    std::hint::black_box(());
}

/// A part of the work whose instructions are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Stage {
    /// A frame that becomes the reference.
    Reference,
    /// Flow of a frame at rest.
    Rest,
    /// What elastic depth in live mode adds to a frame at rest.
    RestLive,
    /// What elastic depth in exact mode adds to a frame at rest.
    RestExact,
    /// Flow of a pressed frame, from colour.
    Flow,
    /// Flow of a pressed frame, from grey.
    FlowGrey,
    /// What elastic depth in live mode adds to a pressed frame.
    Live,
    /// What elastic depth in exact mode adds to a pressed frame.
    Exact,
    /// What density, filter and line add to a pressed frame.
    Density,
    /// Decoding a JPEG picture.
    Jpeg,
}

impl Stage {
    pub(crate) const ALL: [Self; 10] = [
        Self::Reference,
        Self::Rest,
        Self::RestLive,
        Self::RestExact,
        Self::Flow,
        Self::FlowGrey,
        Self::Live,
        Self::Exact,
        Self::Density,
        Self::Jpeg,
    ];

    /// The stage whose instructions are subtracted: this one only adds to it.
    pub(crate) fn base(self) -> Option<Self> {
        match self {
            Self::RestLive | Self::RestExact => Some(Self::Rest),
            Self::Live | Self::Exact | Self::Density => Some(Self::Flow),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Rest => "rest",
            Self::RestLive => "rest-live",
            Self::RestExact => "rest-exact",
            Self::Flow => "flow",
            Self::FlowGrey => "flow-grey",
            Self::Live => "live",
            Self::Exact => "exact",
            Self::Density => "density",
            Self::Jpeg => "jpeg",
        }
    }
}

/// One run of the counted program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Run {
    /// Both modes in one run: what they share, more instructions than all frames together, is prepared once.
    Elastic,
    Flow,
    Density,
    FlowGrey,
    Jpeg,
}

/// The counted stages of one tracker, in order, and the frames of each.
type Stages = &'static [(Stage, &'static [usize])];

/// How a tracker is set up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sensor {
    Exact,
    Live,
    Flow,
    FlowGrey,
    Density,
}

/// What a frame gives.
#[derive(Clone, Copy)]
pub(super) enum Output<'a> {
    Reading(&'a Reading),
    Picture(&'a Pixels),
}

impl Run {
    /// The longest first.
    pub(super) const ALL: [Self; 5] = [Self::Elastic, Self::Flow, Self::Density, Self::FlowGrey, Self::Jpeg];

    /// The stages that it counts, in order.
    pub(super) fn stages(self) -> Vec<(Stage, &'static [usize])> {
        if self == Self::Jpeg {
            return vec![(Stage::Jpeg, &PRESSED)];
        }
        self.trackers().iter().flat_map(|(_, stages)| *stages).copied().collect()
    }

    /// Its trackers, one after the other.
    fn trackers(self) -> &'static [(Sensor, Stages)] {
        match self {
            Self::Elastic => &[
                (Sensor::Exact, &[(Stage::RestExact, &REST), (Stage::Exact, &PRESSED)]),
                (Sensor::Live, &[(Stage::RestLive, &REST), (Stage::Live, &PRESSED)]),
            ],
            Self::Flow => {
                &[(Sensor::Flow, &[(Stage::Rest, &REST), (Stage::Flow, &PRESSED), (Stage::Reference, &NEW_REFERENCE)])]
            }
            Self::Density => &[(Sensor::Density, &[(Stage::Density, &PRESSED)])],
            Self::FlowGrey => &[(Sensor::FlowGrey, &[(Stage::FlowGrey, &PRESSED)])],
            Self::Jpeg => &[],
        }
    }

    pub(super) fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Processes the film; passes on the stage, the number in the film and the output of each counted frame.
    pub(super) fn play(self, film: &Film, mut each: impl FnMut(Stage, usize, Output)) -> Result<()> {
        if self == Self::Jpeg {
            return decode(film, each);
        }
        // All are kept to the end, so that the next one shares with them what it can.
        let mut trackers = Vec::new();
        for &(sensor, stages) in self.trackers() {
            let mut tracker = sensor.tracker(film)?;
            follow(&mut tracker, film, stages, &mut each)?;
            trackers.push(tracker);
        }
        Ok(())
    }
}

impl Sensor {
    fn tracker(self, film: &Film) -> Result<Tracker> {
        let mut profile = film.profile()?;
        let depth = Fields { depth: true, ..Fields::NONE };
        let fields = match self {
            Self::Live | Self::Exact => {
                profile.elastic.mode = if self == Self::Live { ElasticMode::Live } else { ElasticMode::Exact };
                depth
            }
            Self::Density => {
                let line = DepthLine { slope_mm: 15.2, intercept_mm: 0.0 };
                let section = DepthSection { density: Some(line.into()), ..DepthSection::default() };
                profile = Profile { image: profile.image, depth: section, ..Profile::default() };
                Fields { density: true, ..depth }
            }
            Self::Flow | Self::FlowGrey => Fields::NONE,
        };
        Ok(Tracker::new(&profile, film.size(), self != Self::FlowGrey, fields)?)
    }
}

/// Takes frame 0 as the reference, then counts one stage after the other.
fn follow(
    tracker: &mut Tracker,
    film: &Film,
    stages: Stages,
    each: &mut impl FnMut(Stage, usize, Output),
) -> Result<()> {
    let mut sequence = 0;
    let mut frame_of = |number: usize| {
        let pixels = Pixels::Rgb8(film.frame(number).clone());
        sequence += 1;
        Frame { sequence, capture_time_s: sequence as f64 / 90.0, pixels }
    };
    tracker.track(&frame_of(0))?;
    for &(stage, counted) in stages {
        let start: &[usize] = match stage {
            Stage::Rest | Stage::RestLive | Stage::RestExact => &REST_START,
            Stage::Reference => &[],
            _ => &PRESSED_START,
        };
        for &number in start {
            tracker.track(&frame_of(number))?;
        }
        for &number in counted {
            let frame = frame_of(number);
            mark_of_counted_frames();
            if stage == Stage::Reference {
                tracker.rezero();
            }
            let reading = tracker.track(&frame)?;
            mark_of_counted_frames();
            each(stage, number, Output::Reading(reading));
        }
    }
    Ok(())
}

/// Decodes the pressed frames. The first decoded frame, which allocates, is not counted.
fn decode(film: &Film, mut each: impl FnMut(Stage, usize, Output)) -> Result<()> {
    let (width, height) = film.size();
    let layout = CameraLayout { coding: CameraCoding::MotionJpeg, width, height, row_bytes: 0 };
    let mut decoder = CameraFrameDecoder::for_tracking(layout);
    let mut pixels = decoder.decode(&film.coded(0)?).map_err(|error| anyhow!("frame 0: {error}"))?;
    for &number in &PRESSED {
        let bytes = film.coded(number)?;
        mark_of_counted_frames();
        let decoded = decoder.decode_into(&bytes, &mut pixels);
        mark_of_counted_frames();
        decoded.map_err(|error| anyhow!("frame {number}: {error}"))?;
        each(Stage::Jpeg, number, Output::Picture(&pixels));
    }
    Ok(())
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_is_counted_once() {
        let counted: Vec<Stage> = Run::ALL.iter().flat_map(|run| run.stages()).map(|(stage, _)| stage).collect();
        for stage in Stage::ALL {
            assert_eq!(counted.iter().filter(|&&other| other == stage).count(), 1, "{stage}");
        }
        assert_eq!(counted.len(), Stage::ALL.len());
    }
}
