//! Searches the patches of a level one after another, so that a patch can start from the results of its neighbours.

use super::patches::{Match, PatchTemplate, SearchRules, improve, search, search_exhaustively};
use fearless_simd::Simd;
use fingervision_image::Image;

/// Largest number of starts of a patch: its own, those of two neighbours, and the result of the exhaustive search.
const MOST_STARTS: usize = 8;

/// The displacements from which a patch is searched, px.
pub(super) struct Starts {
    displacements: [(f32, f32); MOST_STARTS],
    count: usize,
}

impl Starts {
    pub(super) fn add(&mut self, displacement: (f32, f32)) {
        self.displacements[self.count] = displacement;
        self.count += 1;
    }
}

/// Searches the patches in reading order, each from its own starts and from the displacements of its left and upper
/// neighbours. Then goes through them in reverse order, and searches a patch again if the displacement of its right or
/// lower neighbour matches better.
///
/// `own_starts` receives a patch's upper left pixel. It adds at least one start, and returns whether the patch is
/// searched. A patch that is not searched takes its first start and counts as not found.
#[inline(always)]
pub(super) fn sweep<S: Simd>(
    simd: S,
    template: &PatchTemplate,
    current: &Image<f32>,
    rules: SearchRules,
    matches: &mut [Match],
    own_starts: impl Fn((usize, usize), &mut Starts) -> bool,
) {
    let layout = &template.layout;
    let columns = layout.columns;
    let none = || Starts { displacements: [(0.0, 0.0); MOST_STARTS], count: 0 };
    let of = |found: &Match| (found.u, found.v);
    for j in 0..layout.rows {
        for i in 0..columns {
            let node = j * columns + i;
            let mut starts = none();
            let is_searched = own_starts(layout.corner(i, j), &mut starts);
            let first = starts.displacements[0];
            if !is_searched {
                matches[node] = Match { u: first.0, v: first.1, error: f32::INFINITY };
                continue;
            }
            for beside in [(i > 0).then(|| node - 1), node.checked_sub(columns)].into_iter().flatten() {
                starts.add(of(&matches[beside]));
            }
            // Every second patch is enough: its neighbours start from its result.
            if rules.reach > 0 && (i + j) % 2 == 0 {
                starts.add(search_exhaustively(simd, template, current, (i, j), first, rules.reach));
            }
            matches[node] = search(simd, template, current, (i, j), &starts.displacements[..starts.count], rules);
        }
    }
    for node in (0..layout.len()).rev() {
        let (i, j) = (node % columns, node / columns);
        if !own_starts(layout.corner(i, j), &mut none()) {
            continue;
        }
        let beside = if i + 1 < columns { node + 1 } else { node };
        let below = if j + 1 < layout.rows { node + columns } else { node };
        let starts = [of(&matches[beside]), of(&matches[below])];
        matches[node] = improve(simd, template, current, (i, j), &matches[node], starts, rules);
    }
}
