//! The default policy: one reference for the whole stream.
//!
//! Every frame is matched with the first image, starting from the flow of the previous frame, so errors do not
//! accumulate. A *keyframe*, a recent frame that matched well, is kept as well. If the first image no longer matches,
//! the frame is searched without a start, both against the first image and against the keyframe. The flow over the
//! keyframe is refined against the first image, and the better of the two results is used. Only while the first image
//! cannot be matched at all, the keyframe is the reference and the composed flow is the result.
//!
//! A gel that was pressed at the start is recognised by its first motion. Once it has come to rest, the current frame
//! becomes the reference, unless the elastic model explains this frame as an indentation.

use super::compose::compose_into;
use super::follow::follow;
use super::start_up::StartUp;
use super::thresholds::THRESHOLDS;
use super::{Matched, ReferenceParams};
use fingervision_flow::{Estimate, FlowEstimator, FlowHistory, Picture, Reference, Start};

/// A picture that matched well and the flow that leads to it.
#[derive(Debug)]
struct Keyframe {
    id: u64,
    picture: Picture,
    /// Flow from the first reference to the keyframe.
    from_first: Estimate,
    /// The picture as reference, from the moment it is first needed.
    reference: Option<Reference>,
    is_prepared: bool,
}

/// Estimates that may become the result.
#[derive(Debug)]
struct Trials {
    /// Flow from the keyframe.
    from_key: Estimate,
    trial: Estimate,
}

impl Trials {
    /// Their memory, for pictures of the size of `out`.
    fn of<'a>(trials: &'a mut Option<Box<Self>>, out: &Estimate) -> &'a mut Self {
        let (width, height) = out.valid.size();
        let unwritten = || Estimate::unwritten(width, height);
        trials.get_or_insert_with(|| Box::new(Self { from_key: unwritten(), trial: unwritten() }))
    }
}

/// The anchored policy.
#[derive(Debug)]
pub(crate) struct Anchored {
    params: ReferenceParams,
    first: Reference,
    first_id: u64,
    has_first: bool,
    ids: u64,
    keyframe: Option<Box<Keyframe>>,
    /// Flows of the last frames that were found.
    history: FlowHistory,
    /// From the first frame that needs them.
    trials: Option<Box<Trials>>,
    frames_lost: u64,
    /// Number of consecutive frames in which a large area is lost.
    frames_incomplete: u64,
    frames_since_key: u64,
    start_up: StartUp,
}

impl Anchored {
    pub(crate) fn new(
        estimator: &FlowEstimator,
        (width, height): (usize, usize),
        centre_px: [f32; 2],
        params: &ReferenceParams,
    ) -> Self {
        Self {
            params: *params,
            first: estimator.reference(),
            first_id: 0,
            has_first: false,
            ids: 0,
            keyframe: None,
            history: FlowHistory::at_rest(width, height),
            trials: None,
            frames_lost: 0,
            frames_incomplete: 0,
            frames_since_key: 0,
            start_up: StartUp::new(params.rest_frames, centre_px),
        }
    }

    /// The first reference.
    pub(crate) fn first(&self) -> Option<&Reference> {
        self.has_first.then_some(&self.first)
    }

    /// The number of the first reference.
    pub(crate) fn first_id(&self) -> Option<u64> {
        self.has_first.then_some(self.first_id)
    }

    /// Whether the reference seems to show a pressed gel.
    pub(crate) fn is_pressed_at_start(&self) -> bool {
        self.start_up.is_pressed()
    }

    /// Stores whether the elastic model explains the last frame as an indentation.
    pub(crate) fn note_press(&mut self, is_press: bool) {
        self.start_up.note_press(is_press);
    }

    /// Drops all references; the next frame becomes the first one.
    pub(crate) fn restart(&mut self) {
        if std::mem::take(&mut self.has_first) {
            self.ids += 1;
            self.first_id = self.ids;
        }
        self.keyframe = None;
        self.history.restart();
        (self.frames_lost, self.frames_incomplete, self.frames_since_key) = (0, 0, 0);
        self.start_up.restart();
    }

    /// Matches a frame and writes its flow from the first reference.
    pub(crate) fn track(
        &mut self,
        estimator: &mut FlowEstimator,
        current: &mut Picture,
        out: &mut Estimate,
    ) -> Matched {
        if !self.has_first {
            estimator.prepare(current, &mut self.first);
            self.has_first = true;
        }
        follow(estimator, &mut self.first, current, &self.history, out);
        let zero_id = self.first_id;
        let mut reference_id = zero_id;
        if out.matched < self.params.min_matched {
            reference_id = self.rescue(estimator, current, out);
        } else {
            self.complete(estimator, current, out);
        }
        if out.matched >= self.params.min_matched {
            self.frames_lost = 0;
            self.remember(estimator, current, out, reference_id);
        } else {
            self.frames_lost += 1;
        }
        Matched {
            reference_id,
            zero_id,
            reference_count: 1 + usize::from(self.keyframe.is_some()),
            photometric_error: out.residual_levels,
        }
    }

    /// If the lost area is too large for a local search, searches the whole frame and keeps the better match.
    fn complete(&mut self, estimator: &mut FlowEstimator, current: &Picture, out: &mut Estimate) {
        let pixels = out.valid.values().len() as f32;
        if out.lost_px2 <= THRESHOLDS.most_lost * pixels {
            self.frames_incomplete = 0;
            return;
        }
        self.frames_incomplete += 1;
        if (self.frames_incomplete - 1).is_multiple_of(self.params.search_interval) {
            let Trials { trial, .. } = Trials::of(&mut self.trials, out);
            estimator.estimate(&self.first, current, Start::Search(Some(&out.flow)), trial);
            if trial.matched > out.matched {
                out.copy_from(trial);
            }
        }
    }

    /// Searches a frame that does not match from the previous frame's flow. Returns the id of the reference that
    /// matches.
    fn rescue(&mut self, estimator: &mut FlowEstimator, current: &Picture, out: &mut Estimate) -> u64 {
        if let Some(id) = self.follow_keyframe(estimator, current, out) {
            return id;
        }
        if !self.frames_lost.is_multiple_of(self.params.search_interval) {
            return self.first_id;
        }
        let Trials { trial, .. } = Trials::of(&mut self.trials, out);
        estimator.estimate(&self.first, current, Start::SearchHistory(&self.history), trial);
        if trial.matched > out.matched {
            out.copy_from(trial);
        }
        self.first_id
    }

    /// Matches with the keyframe, and refines the composed flow against the first image if it matches that.
    fn follow_keyframe(&mut self, estimator: &mut FlowEstimator, current: &Picture, out: &mut Estimate) -> Option<u64> {
        let key = self.keyframe.as_deref_mut()?;
        let reference = key.reference.get_or_insert_with(|| estimator.reference());
        let Trials { from_key, trial } = Trials::of(&mut self.trials, out);
        if !key.is_prepared {
            estimator.prepare(&key.picture, reference);
            key.is_prepared = true;
            from_key.flow.fill(0.0);
        }
        std::mem::swap(&mut from_key.flow, &mut trial.flow);
        estimator.estimate(reference, current, Start::Flow(&trial.flow), from_key);
        if from_key.matched < self.params.min_matched && self.frames_lost.is_multiple_of(self.params.search_interval) {
            estimator.estimate(reference, current, Start::Search(None), from_key);
        }
        if from_key.matched < self.params.min_matched {
            return None;
        }
        compose_into(&key.from_first, from_key, trial);
        estimator.estimate(&self.first, current, Start::Flow(&trial.flow), out);
        if out.matched >= self.params.min_matched {
            return Some(self.first_id);
        }
        out.copy_from(trial);
        Some(key.id)
    }

    /// Stores a frame that was found.
    fn remember(&mut self, estimator: &FlowEstimator, current: &Picture, out: &Estimate, reference_id: u64) {
        self.history.push(&out.flow);
        self.start_up.watch(&self.history, out);
        if self.start_up.has_come_to_rest() {
            self.adopt(estimator, current);
            return;
        }
        self.frames_since_key += 1;
        // While the keyframe is the reference, it is replaced only when it also begins to fail.
        let is_due = if reference_id == self.first_id {
            self.frames_since_key >= THRESHOLDS.keyframe_interval && out.matched >= THRESHOLDS.keyframe_matched
        } else {
            self.frames_since_key >= THRESHOLDS.keyframe_interval && out.matched < THRESHOLDS.keyframe_matched
        };
        if self.keyframe.is_none() || is_due {
            self.keep(estimator, current, out);
        }
    }

    /// Makes the current frame the keyframe.
    fn keep(&mut self, estimator: &FlowEstimator, current: &Picture, out: &Estimate) {
        self.ids += 1;
        self.frames_since_key = 0;
        let key = self.keyframe.get_or_insert_with(|| {
            Box::new(Keyframe {
                id: 0,
                picture: estimator.picture(),
                from_first: out.clone(),
                reference: None,
                is_prepared: false,
            })
        });
        key.id = self.ids;
        key.picture.copy_from(current);
        key.from_first.copy_from(out);
        key.is_prepared = false;
    }

    /// Makes the current frame, at rest, the first reference.
    fn adopt(&mut self, estimator: &FlowEstimator, current: &Picture) {
        estimator.prepare(current, &mut self.first);
        self.ids += 1;
        self.first_id = self.ids;
        self.history.restart();
        self.keyframe = None;
        self.start_up.settle();
    }
}
