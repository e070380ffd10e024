//! Selects the reference that a frame is matched with, and composes flows over several references.

mod anchored;
mod compose;
#[cfg(test)]
mod compose_properties;
mod first_motion;
mod follow;
mod params;
mod stack;
mod start_up;
mod thresholds;

use anchored::Anchored;
use fingervision_flow::{Estimate, FlowError, FlowEstimator, FlowHistory, Picture, Reference};
use follow::follow;
use stack::Stack;

pub use params::{Policy, ReferenceParams};

/// How a frame was matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Matched {
    /// Reference that the frame was matched with, counted from 0.
    pub(crate) reference_id: u64,
    /// Reference that the flow is relative to: the first one, or the one that replaced it.
    pub(crate) zero_id: u64,
    /// Number of references that are kept.
    pub(crate) reference_count: usize,
    /// Photometric error, grey levels.
    pub(crate) photometric_error: f32,
}

/// The references of a stream, handled by one policy.
#[derive(Debug)]
pub(crate) enum References {
    Anchored(Box<Anchored>),
    Stack(Box<Stack>),
    Single(Box<Single>),
}

/// The first image alone.
#[derive(Debug)]
pub(crate) struct Single {
    reference: Reference,
    is_prepared: bool,
    id: u64,
    history: FlowHistory,
}

impl References {
    /// The references for a camera with this centre of perspective, px.
    pub(crate) fn new(
        estimator: &FlowEstimator,
        size: (usize, usize),
        centre_px: [f32; 2],
        params: &ReferenceParams,
    ) -> Result<Self, FlowError> {
        Ok(match params.policy {
            Policy::Anchored => Self::Anchored(Box::new(Anchored::new(estimator, size, centre_px, params))),
            Policy::Stack => Self::Stack(Box::new(Stack::new(size, params)?)),
            Policy::Single => Self::Single(Box::new(Single {
                reference: estimator.reference(),
                is_prepared: false,
                id: 0,
                history: FlowHistory::at_rest(size.0, size.1),
            })),
        })
    }

    /// Drops all references and forgets all frames: the next frame becomes the first reference. References continue to
    /// be numbered from the last one.
    pub(crate) fn restart(&mut self) {
        match self {
            Self::Anchored(references) => references.restart(),
            Self::Stack(references) => references.restart(),
            Self::Single(references) => references.restart(),
        }
    }

    /// Matches a frame and writes its flow from the first reference.
    pub(crate) fn track(
        &mut self,
        estimator: &mut FlowEstimator,
        current: &mut Picture,
        out: &mut Estimate,
    ) -> Matched {
        match self {
            Self::Anchored(references) => references.track(estimator, current, out),
            Self::Stack(references) => references.track(estimator, current, out),
            Self::Single(references) => references.track(estimator, current, out),
        }
    }

    /// Stores whether the elastic model explains the last frame as an indentation.
    pub(crate) fn note_press(&mut self, is_press: bool) {
        if let Self::Anchored(references) = self {
            references.note_press(is_press);
        }
    }

    /// The first reference, if there is one yet.
    pub(crate) fn first(&self) -> Option<&Reference> {
        match self {
            Self::Anchored(references) => references.first(),
            Self::Stack(references) => references.first(),
            Self::Single(references) => references.is_prepared.then_some(&references.reference),
        }
    }

    /// The number of the first reference, if there is one yet. After a frame that replaced it, this is the new one's, though the
    /// frame itself was matched with the old one ([`Matched::zero_id`]).
    pub(crate) fn first_id(&self) -> Option<u64> {
        match self {
            Self::Anchored(references) => references.first_id(),
            Self::Stack(references) => references.first_id(),
            Self::Single(references) => references.is_prepared.then_some(references.id),
        }
    }

    /// Whether the reference seems to show a pressed gel.
    pub(crate) fn is_pressed_at_start(&self) -> bool {
        matches!(self, Self::Anchored(references) if references.is_pressed_at_start())
    }
}

impl Single {
    fn restart(&mut self) {
        self.id += u64::from(self.is_prepared);
        self.is_prepared = false;
        self.history.restart();
    }

    fn track(&mut self, estimator: &mut FlowEstimator, current: &mut Picture, out: &mut Estimate) -> Matched {
        if !self.is_prepared {
            estimator.prepare(current, &mut self.reference);
            self.is_prepared = true;
        }
        follow(estimator, &mut self.reference, current, &self.history, out);
        self.history.push(&out.flow);
        Matched { reference_id: self.id, zero_id: self.id, reference_count: 1, photometric_error: out.residual_levels }
    }
}
