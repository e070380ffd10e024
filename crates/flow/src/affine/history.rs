//! The flows of the last frames, from which the next one is predicted.

use super::grid::PatchGrid;
use super::nodes::NodeField;
use crate::FlowField;

/// The flow of the last frame and of the one before, from one reference, at points 8 px apart.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowHistory {
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
        Self { nodes: [nodes.clone(), nodes], has_earlier: false }
    }

    /// Begins again at rest, with a new reference.
    pub fn restart(&mut self) {
        self.nodes.iter_mut().flat_map(|nodes| &mut nodes.planes).for_each(|plane| plane.fill(0.0));
        self.has_earlier = false;
    }

    /// Adds the flow of a frame.
    pub fn push(&mut self, flow: &FlowField) {
        self.nodes.swap(0, 1);
        self.nodes[0].sample(flow);
        self.has_earlier = true;
    }

    /// Largest change of the flow between the last two frames, px. The flow before the first frame counts as zero.
    #[must_use]
    pub fn largest_change_px(&self) -> f32 {
        let [[last_u, last_v], [u, v]] = self.nodes.each_ref().map(|nodes| [&nodes.planes[0], &nodes.planes[3]]);
        let changes = last_u.iter().zip(u).zip(last_v.iter().zip(v));
        let squares = changes.map(|((a, b), (c, d))| (a - b).powi(2) + (c - d).powi(2));
        squares.take(self.nodes[0].grid.nodes()).fold(0.0, f32::max).sqrt()
    }

    /// The flow of the last frame at the nodes of the patches; zero if there is none yet.
    pub(crate) fn last_nodes(&self) -> &NodeField {
        &self.nodes[0]
    }

    /// The flow of the frame before the last one at the nodes of the patches, if there was one.
    pub(crate) fn earlier_nodes(&self) -> Option<&NodeField> {
        self.has_earlier.then_some(&self.nodes[1])
    }
}
