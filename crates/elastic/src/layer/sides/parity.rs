//! Fields that are symmetric or antisymmetric about the mirror planes of a block.
//!
//! A mirror takes a field `(u_x, u_y, u_z)` at `(x, y)` to `(−u_x, u_y, u_z)` at `(−x, y)`, and likewise in y. Any field
//! is the sum of four that each mirror leaves as they are or turns into their negative, and a block does not mix them.

/// For each of the planes x = 0 and y = 0, whether its mirror leaves fields unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parity(pub(super) [bool; 2]);

/// One free value of a field of a parity: a component at a node of the quarter `x, y ≥ 0`, with its images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unknown {
    /// Elements from the centre along x and y.
    pub(super) node: [usize; 2],
    /// The component.
    pub(super) axis: usize,
    /// Number of images, including itself: 1, 2 or 4.
    pub(super) images: f64,
}

impl Parity {
    pub(super) const ALL: [Self; 4] =
        [Self([true, true]), Self([true, false]), Self([false, true]), Self([false, false])];

    /// The sign of a component under the mirror at the plane across `plane`.
    fn sign(self, plane: usize, axis: usize) -> f64 {
        if self.0[plane] == (plane == axis) { -1.0 } else { 1.0 }
    }

    /// All free values, for a quarter of `half` elements. On a plane, components that change sign there are zero.
    pub(super) fn unknowns(self, half: [usize; 2]) -> Vec<Unknown> {
        let all = (0..=half[1]).flat_map(|j| (0..=half[0]).flat_map(move |i| (0..3).map(move |axis| ([i, j], axis))));
        all.filter(|&(node, axis)| (0..2).all(|plane| node[plane] > 0 || self.sign(plane, axis) > 0.0))
            .map(|(node, axis)| {
                let images = node.iter().map(|&steps| if steps > 0 { 2.0 } else { 1.0 }).product();
                Unknown { node, axis, images }
            })
            .collect()
    }

    /// Nodes, in elements from the centre, at which an unknown's field of norm 1 is not zero, and its value there. An
    /// image that coincides with another has the value zero.
    pub(super) fn field(self, unknown: &Unknown) -> [([isize; 2], f64); 4] {
        std::array::from_fn(|image| {
            let mut value = 1.0 / unknown.images.sqrt();
            let node = [0, 1].map(|plane| {
                let steps = unknown.node[plane].cast_signed();
                if image >> plane & 1 == 0 {
                    return steps;
                }
                value *= if steps > 0 { self.sign(plane, unknown.axis) } else { 0.0 };
                -steps
            });
            (node, value)
        })
    }
}
