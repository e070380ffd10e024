//! Computes readings from frames; the same object is used live and offline.

mod channels;
mod density_stage;
mod elastic_stage;
mod planes;

use crate::health::{Seen, Watch};
use crate::references::References;
use crate::stage_times::Stopwatch;
use crate::{DepthMethod, Fields, Flag, Flags, Profile, Reading, StageTimes, TrackError};
pub use density_stage::DeferredDensity;
use density_stage::DensityStage;
use elastic_stage::ElasticStage;
use fingervision_flow::{Estimate, FlowEstimator, FlowParams, Levels, Picture, Reference, Team};
use fingervision_image::{Frame, Rect};
use planes::count_ones;
use std::time::Instant;

/// Tracks the gel through a stream of frames.
///
/// It owns all scratch memory and the reading that it returns: a frame that needs neither a new reference nor a search of the
/// whole image allocates nothing.
/// The same frames give the same bits, whatever their source; only [`ReadingNumbers::latency_ms`](crate::ReadingNumbers) differs.
#[derive(Debug)]
pub struct Tracker {
    region: Rect,
    frame_size: (usize, usize),
    flow: FlowParams,
    estimator: FlowEstimator,
    picture: Picture,
    references: References,
    /// Has planes only while a frame is matched: those of the reading, which are overwritten.
    estimate: Estimate,
    density: Option<DensityStage>,
    elastic: Option<ElasticStage>,
    watch: Watch,
    /// Time at rest after which a gel that has drifted becomes the reference automatically, s.
    rezero_after_s: Option<f64>,
    previous: Option<(u64, f64)>,
    /// The reference that the last reading is relative to.
    zero_id: Option<u64>,
    /// The reference of the readings that follow: its number, and that of its frame.
    reference: Option<(u64, u64)>,
    reading: Reading,
    times: StageTimes,
    team: Team,
}

/// Tracking is lost if less than this part of the textured patches match.
const LOST_BELOW: f32 = 0.5;
/// An area that is lost is flagged if it is more than this part of the image. Steep walls of presses that are sheared
/// by 1.5 mm take up to half of a percent.
const MOST_LOST: f32 = 0.0075;
/// An image has too little texture if less than this part of its patches can be measured.
const LEAST_TEXTURED: f32 = 0.1;
/// The flow is uncertain if less than this part of the textured pixels is valid.
const LEAST_VALID: f32 = 0.5;
/// A mean brightness that differs from the reference's by more than this factor, up or down, is flagged.
const LIGHT_FACTOR: f32 = 1.25;
/// An image less sharp than the reference by more than this factor is flagged. Presses, real and simulated ones, change
/// the sharpness by a factor of up to 1.23; blur with a standard deviation of 1 px, on images that have 0.7 px, by 1.35
/// and more.
const SHARPNESS_FACTOR: f32 = 1.3;
/// An image is flagged if the unexplained part of the variance exceeds this in half of the patches. For presses it is
/// up to 0.014.
const MOST_UNEXPLAINED: f32 = 0.05;

impl Tracker {
    /// A tracker for frames of this size.
    ///
    /// # Errors
    ///
    /// [`TrackError`] if the profile does not fit the frames or contains an impossible value.
    pub fn new(
        profile: &Profile,
        frame_size: (usize, usize),
        is_colour: bool,
        fields: Fields,
    ) -> Result<Self, TrackError> {
        profile.validate()?;
        let region = profile.region(frame_size)?;
        let (width, height) = (region.width, region.height);
        let flow = FlowParams { colour: profile.flow.colour && is_colour, ..profile.flow };
        let estimator = FlowEstimator::new(width, height, &flow)?;
        let centre_px = centre_of_perspective(profile, frame_size, region);
        let mut reading = Reading::new(width, height);
        let is_elastic = profile.depth_method() == DepthMethod::Elastic;
        let law = profile.depth.density.filter(|_| fields.depth && !is_elastic);
        let has_density = fields.density || law.is_some();
        let density = has_density.then(|| DensityStage::new(profile, law, &mut reading)).transpose()?;
        let has_elastic = is_elastic && (fields.depth || fields.displacement || fields.traction);
        let elastic = has_elastic.then(|| ElasticStage::new(profile, fields, &mut reading)).transpose()?;
        Ok(Self {
            region,
            frame_size,
            flow,
            picture: estimator.picture(),
            references: References::new(&estimator, (width, height), centre_px, &profile.references)?,
            estimator,
            estimate: Estimate::new(0, 0),
            watch: Watch::new((width, height), profile),
            rezero_after_s: profile.references.rezero_after_s,
            previous: None,
            zero_id: None,
            reference: None,
            reading,
            times: StageTimes::default(),
            team: Team::default(),
            density,
            elastic,
        })
    }

    /// Columns and rows of the reference grid: the region of interest, px.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.region.width, self.region.height)
    }

    /// Whether readings contain depth.
    #[must_use]
    pub fn has_depth(&self) -> bool {
        self.reading.depth.is_some()
    }

    /// The last reading; before the first frame one at rest, with the fields that every reading will have.
    #[must_use]
    pub fn reading(&self) -> &Reading {
        &self.reading
    }

    /// Takes the last reading out of the tracker, for a program that keeps it, without copying its fields.
    ///
    /// `spare` is a reading of this tracker that was taken before and is not needed any more: its memory is used for the
    /// next frame. Without it, or if its fields or their sizes are others, memory is allocated. Until the next frame,
    /// [`Tracker::reading`] is of no use.
    pub fn take_reading(&mut self, spare: Option<Reading>) -> Reading {
        let spare = spare.filter(|spare| spare.has_the_fields_of(&self.reading));
        let spare = spare.unwrap_or_else(|| self.reading.clone());
        let taken = std::mem::replace(&mut self.reading, spare);
        self.reading.numbers.dropped_frames = taken.dropped_frames;
        taken
    }

    /// Leaves density, and depth from it, to another place: the readings that follow lack them until they are completed.
    /// None if the readings have no density, or it was deferred before.
    pub fn defer_density(&mut self) -> Option<DeferredDensity> {
        self.density.take().map(DeferredDensity)
    }

    /// Shares the work of a frame among the threads of a team, so that its reading comes earlier. The readings are the same, bit
    /// for bit. A program with several trackers, each in a thread of its own, does not need it.
    pub fn share(&mut self, team: &Team) {
        self.estimator.share(team);
        if let Some(stage) = &mut self.elastic {
            stage.share(team);
        }
        self.team = team.clone();
    }

    /// The number of the frame that the next reading will be relative to, unless its own frame becomes the reference; absent
    /// before the first frame.
    #[must_use]
    pub fn reference_sequence(&self) -> Option<u64> {
        self.reference.map(|(_, sequence)| sequence)
    }

    /// Where the time of the last frame went; all 0 before the first.
    #[must_use]
    pub fn stage_times(&self) -> StageTimes {
        self.times
    }

    /// Makes the next frame the new reference: from there on displacement, depth and force are relative to it.
    ///
    /// All references and the history of the previous frames are dropped. The readings that follow are those of a new
    /// tracker that starts with that frame, bit for bit, with two exceptions: the numbers of frames and references and
    /// the count of dropped frames continue, and the first reading has the flag [`Flag::NewReference`]. The call itself
    /// allocates nothing; the frames that follow allocate as after a start, for example for the first keyframe.
    pub fn rezero(&mut self) {
        self.references.restart();
        self.estimator.restart();
        self.watch.restart();
        if let Some(stage) = &mut self.elastic {
            stage.restart();
        }
    }

    /// The reading of a frame. It stays valid until the next frame.
    ///
    /// # Errors
    ///
    /// [`TrackError::SizeChanged`] and [`TrackError::OutOfOrder`]; the tracker stays usable.
    pub fn track(&mut self, frame: &Frame) -> Result<&Reading, TrackError> {
        let (arrival, team) = (Instant::now(), self.team.clone());
        team.run(|| self.compute(frame))?;
        self.reading.numbers.latency_ms = arrival.elapsed().as_secs_f64() * 1e3;
        Ok(&self.reading)
    }

    /// Fills the reading of a frame.
    fn compute(&mut self, frame: &Frame) -> Result<(), TrackError> {
        let mut watch = Stopwatch::start();
        let dropped = self.check_order(frame)?;
        if self.rezero_after_s.is_some_and(|after_s| self.watch.is_rezero_due(after_s)) {
            self.rezero();
        }
        if self.references.first().is_none() {
            self.choose_channels(&frame.pixels)?;
        }
        self.picture
            .load(&frame.pixels, self.region)
            .map_err(|source| TrackError::Image { sequence: frame.sequence, source })?;
        self.previous = Some((frame.sequence, frame.capture_time_s));
        self.times.picture_ms = watch.lap_ms();

        self.exchange_planes();
        let matched = self.references.track(&mut self.estimator, &mut self.picture, &mut self.estimate);
        self.times.flow_ms = watch.lap_ms();
        let (levels, sharpness) = (self.picture.levels(), self.picture.sharpness());
        let mut flags = self.flags(dropped, sharpness);
        if self.zero_id.replace(matched.zero_id).is_some_and(|before| before != matched.zero_id) {
            flags.raise(Flag::NewReference);
            self.watch.restart();
        }
        self.check(frame.capture_time_s, levels, &mut flags);
        if let Some(id) = self.references.first_id().filter(|&id| self.reference.is_none_or(|(known, _)| known != id)) {
            self.reference = Some((id, frame.sequence));
            self.watch.take_reference(self.picture.grey());
        }
        let reading = &mut self.reading;
        reading.numbers.sequence = frame.sequence;
        reading.numbers.capture_time_s = frame.capture_time_s;
        reading.numbers.dropped_frames += dropped;
        reading.numbers.reference_id = matched.reference_id;
        reading.numbers.reference_count = matched.reference_count;
        reading.numbers.photometric_error = matched.photometric_error;
        reading.numbers.flags = flags;
        reading.numbers.damaged_part = self.watch.damaged_part();
        (reading.numbers.mean_level, reading.numbers.saturated_part) = (levels.mean, levels.saturated);
        reading.numbers.sharpness = sharpness;
        self.exchange_planes();
        self.times.checks_ms = watch.lap_ms();
        // The elastic inverse uses the validity of the flow alone, so it runs before gaps of the density are marked as
        // not valid.
        if let Some(stage) = &mut self.elastic {
            stage.run(&mut self.reading, self.watch.untouched_motion());
            let is_touched = self.reading.contact_area_mm2.is_some_and(|area| area > 0.0);
            self.references.note_press(is_touched);
            if is_touched {
                self.watch.note_contact();
            }
        }
        self.times.elastic_ms = if self.elastic.is_some() { watch.lap_ms() } else { 0.0 };
        if self.references.is_pressed_at_start() {
            self.reading.numbers.flags.raise(Flag::PressedAtStart);
        }
        if let Some(stage) = &mut self.density {
            stage.run(&mut self.reading);
        }
        self.times.density_ms = if self.density.is_some() { watch.lap_ms() } else { 0.0 };
        Ok(())
    }

    /// Lends the planes of the reading to the estimate, which overwrites them, or takes them back.
    fn exchange_planes(&mut self) {
        let Self { reading, estimate, .. } = self;
        std::mem::swap(&mut reading.flow, &mut estimate.flow);
        std::mem::swap(&mut reading.deviation, &mut estimate.deviation);
        std::mem::swap(&mut reading.valid, &mut estimate.valid);
    }

    /// Runs the checks that need the picture or more than one frame.
    fn check(&mut self, time_s: f64, levels: Levels, flags: &mut Flags) {
        let first = self.references.first().map_or(levels, Reference::levels);
        let is_lost = flags.has(Flag::Lost);
        let seen = Seen { time_s, grey: self.picture.grey(), levels, first, estimate: &self.estimate, is_lost };
        self.watch.watch(seen, flags);
        self.watch.hide_dirt(&mut self.estimate);
        let textured = self.references.first().map_or(0.0, Reference::textured);
        let (valid, pixels) = (self.estimate.valid.values(), self.estimate.valid.values().len() as f32);
        if !is_lost && (count_ones(valid) as f32) < LEAST_VALID * textured * pixels {
            flags.raise(Flag::UncertainFlow);
        }
    }

    /// Refuses a frame that does not follow the previous one; returns the number of missing frames between them.
    fn check_order(&self, frame: &Frame) -> Result<u64, TrackError> {
        let (width, height) = frame.pixels.size();
        let (expected_width, expected_height) = self.frame_size;
        if (width, height) != self.frame_size {
            let sequence = frame.sequence;
            return Err(TrackError::SizeChanged { sequence, width, height, expected_width, expected_height });
        }
        let Some((previous, previous_time_s)) = self.previous else { return Ok(0) };
        // A time that is not a number has no order.
        let is_in_time = frame.capture_time_s >= previous_time_s || previous_time_s.is_nan();
        if frame.sequence <= previous || !is_in_time {
            let (sequence, time_s) = (frame.sequence, frame.capture_time_s);
            return Err(TrackError::OutOfOrder { sequence, time_s, previous, previous_time_s });
        }
        Ok(frame.sequence - previous - 1)
    }

    fn flags(&self, dropped: u64, sharpness: f32) -> Flags {
        let mut flags = Flags::default();
        let mut raise_if = |flag: Flag, holds: bool| {
            if holds {
                flags.raise(flag);
            }
        };
        let is_lost = self.estimate.matched < LOST_BELOW;
        raise_if(Flag::Lost, is_lost);
        raise_if(Flag::Dropped, dropped > 0);
        let pixels = self.estimate.valid.values().len() as f32;
        raise_if(Flag::AreaLost, !is_lost && self.estimate.lost_px2 > MOST_LOST * pixels);
        raise_if(Flag::OutOfFocus, self.estimate.is_motion_blurred);
        raise_if(Flag::ImageMismatch, self.estimate.unexplained > MOST_UNEXPLAINED);
        if let Some(first) = self.references.first() {
            let (light, then) = (self.picture.mean_level().max(1.0), first.mean_level().max(1.0));
            raise_if(Flag::NoTexture, first.textured() < LEAST_TEXTURED);
            raise_if(Flag::LightChanged, light > then * LIGHT_FACTOR || then > light * LIGHT_FACTOR);
            raise_if(Flag::OutOfFocus, SHARPNESS_FACTOR * sharpness < first.sharpness());
        }
        flags
    }
}

/// The centre of perspective, px of the region: the camera's principal point, or without a camera the middle of the
/// whole frame.
fn centre_of_perspective(profile: &Profile, frame_size: (usize, usize), region: Rect) -> [f32; 2] {
    let middle = |size: usize, begin: usize| 0.5 * (size as f32 - 1.0) - begin as f32;
    let of_frame = [middle(frame_size.0, region.x), middle(frame_size.1, region.y)];
    profile.camera.map_or(of_frame, |camera| camera.principal_point_px.map(|at| at as f32))
}
