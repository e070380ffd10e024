//! Matching a frame that follows others.

use fingervision_flow::{Estimate, FlowEstimator, FlowHistory, Picture, Reference, Start};

/// Matches a frame with a reference, from the flows of the frames before, after both are made to fit each other: the frame gets the
/// light of the reference, and the reference the noise of the last frames.
pub(super) fn follow(
    estimator: &mut FlowEstimator,
    reference: &mut Reference,
    current: &mut Picture,
    history: &FlowHistory,
    out: &mut Estimate,
) {
    estimator.correct_light(reference, current, history);
    estimator.adapt(reference);
    estimator.estimate(reference, current, Start::History(history), out);
}
