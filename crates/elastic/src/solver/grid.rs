//! Storage order of the nodes of a structured grid.

/// A box of `nx · ny · nz` nodes with one layer of empty nodes around it, so that every node has 26 neighbours.
///
/// Rows along x are contiguous, then z, then y: a *slab* is all nodes of one y. Values in the empty layer stay zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Nodes along x, y and z.
    pub(crate) nodes: [usize; 3],
}

/// Least number of nodes whose rows justify a task of their own, and the same for single values.
const LEAST_ROWS: usize = 512;
pub(super) const LEAST_VALUES: usize = 8192;

impl Grid {
    /// Nodes from one row along x to the next, along z.
    pub(crate) fn row(self) -> usize {
        self.nodes[0] + 2
    }

    /// Nodes from one slab to the next.
    pub(crate) fn slab(self) -> usize {
        self.row() * (self.nodes[2] + 2)
    }

    /// Least number of slabs per thread: a coarse grid is processed by one thread.
    pub(crate) fn least_slabs(self) -> usize {
        LEAST_ROWS.div_ceil(self.slab())
    }

    /// All nodes, including the empty layer.
    pub(crate) fn len(self) -> usize {
        self.slab() * (self.nodes[1] + 2)
    }

    /// Place of a node.
    pub(crate) fn index(self, i: usize, j: usize, k: usize) -> usize {
        (j + 1) * self.slab() + self.in_slab(i, k)
    }

    /// Place of a node of the surface, counted row by row along x.
    pub(crate) fn on_surface(self, surface: usize) -> usize {
        self.index(surface % self.nodes[0], surface / self.nodes[0], 0)
    }

    /// Place of a node within its slab.
    pub(crate) fn in_slab(self, i: usize, k: usize) -> usize {
        (k + 1) * self.row() + i + 1
    }

    /// Places within a slab of all nodes, x fastest.
    pub(crate) fn slab_nodes(self) -> impl DoubleEndedIterator<Item = usize> {
        let [nx, _, nz] = self.nodes;
        (0..nz).flat_map(move |k| (0..nx).map(move |i| self.in_slab(i, k)))
    }
}
