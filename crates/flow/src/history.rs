//! The flows of the last frames, from which the next one is predicted.

use crate::FlowField;

/// The flow of the last frame and of the one before, from one reference.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowHistory {
    last: FlowField,
    earlier: FlowField,
    /// Whether `earlier` is the flow of a frame.
    has_earlier: bool,
}

impl FlowHistory {
    /// A history that begins at rest, for pictures of this size.
    #[must_use]
    pub fn at_rest(width: usize, height: usize) -> Self {
        let rest = FlowField::zero(width, height);
        Self { last: rest.clone(), earlier: rest, has_earlier: false }
    }

    /// Begins again at rest, with a new reference.
    pub fn restart(&mut self) {
        self.last.fill(0.0);
        self.has_earlier = false;
    }

    /// Adds the flow of a frame.
    pub fn push(&mut self, flow: &FlowField) {
        std::mem::swap(&mut self.last, &mut self.earlier);
        self.last.copy_from(flow);
        self.has_earlier = true;
    }

    /// The flow of the last frame; zero if there is none yet.
    #[must_use]
    pub fn last(&self) -> &FlowField {
        &self.last
    }

    /// The flow of the frame before the last one, if there was one.
    #[must_use]
    pub fn earlier(&self) -> Option<&FlowField> {
        self.has_earlier.then_some(&self.earlier)
    }
}
