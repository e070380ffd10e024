//! The flows of the last frames, from which the next one is predicted.

use super::grid::PatchGrid;
use super::nodes::NodeField;
use crate::FlowField;

/// The flow of the last frame and of the one before, from one reference.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowHistory {
    last: FlowField,
    /// The last flow at the nodes of the patches, and the one before.
    nodes: [NodeField; 2],
    /// Whether the second one is the flow of a frame.
    has_earlier: bool,
}

impl FlowHistory {
    /// A history that begins at rest, for pictures of this size.
    #[must_use]
    pub fn at_rest(width: usize, height: usize) -> Self {
        let nodes = NodeField::zero(PatchGrid::over(width, height));
        Self { last: FlowField::zero(width, height), nodes: [nodes.clone(), nodes], has_earlier: false }
    }

    /// Begins again at rest, with a new reference.
    pub fn restart(&mut self) {
        self.last.fill(0.0);
        self.nodes[0].planes.iter_mut().for_each(|plane| plane.fill(0.0));
        self.has_earlier = false;
    }

    /// Adds the flow of a frame.
    pub fn push(&mut self, flow: &FlowField) {
        self.nodes.swap(0, 1);
        self.nodes[0].sample(flow);
        self.last.copy_from(flow);
        self.has_earlier = true;
    }

    /// The flow of the last frame; zero if there is none yet.
    #[must_use]
    pub fn last(&self) -> &FlowField {
        &self.last
    }

    /// The same at the nodes of the patches.
    pub(crate) fn last_nodes(&self) -> &NodeField {
        &self.nodes[0]
    }

    /// The flow of the frame before the last one at the nodes of the patches, if there was one.
    pub(crate) fn earlier_nodes(&self) -> Option<&NodeField> {
        self.has_earlier.then_some(&self.nodes[1])
    }
}
