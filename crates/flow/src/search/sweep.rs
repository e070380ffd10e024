//! The search of a level's patches, one after the other, so that neighbours help each other.

use super::patches::{Match, PatchTemplate, SearchRules, best_place, reconsider, search};
use fearless_simd::Simd;
use fingervision_image::Image;

/// Most starts of a patch: its own, two neighbours' and the best place within reach.
const MOST_STARTS: usize = 8;

/// The places that a patch is searched from, px.
pub(super) struct Starts {
    places: [(f32, f32); MOST_STARTS],
    count: usize,
}

impl Starts {
    pub(super) fn add(&mut self, place: (f32, f32)) {
        self.places[self.count] = place;
        self.count += 1;
    }
}

/// Searches the patches in reading order, each from its own starts and from its left and upper neighbour's displacement, and
/// then, in reverse order, those for which the right or lower neighbour's displacement is better.
///
/// `own_starts` gets a patch's upper left pixel, adds its starts, at least one, and returns whether the patch is searched at
/// all; one that is not takes its first start and counts as not found.
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
    let none = || Starts { places: [(0.0, 0.0); MOST_STARTS], count: 0 };
    let displacement = |found: &Match| (found.u, found.v);
    for j in 0..layout.rows {
        for i in 0..columns {
            let node = j * columns + i;
            let mut starts = none();
            let is_searched = own_starts(layout.corner(i, j), &mut starts);
            let first = starts.places[0];
            if !is_searched {
                matches[node] = Match { u: first.0, v: first.1, error: f32::INFINITY };
                continue;
            }
            for beside in [(i > 0).then(|| node - 1), node.checked_sub(columns)].into_iter().flatten() {
                starts.add(displacement(&matches[beside]));
            }
            // Neighbours share what every second patch finds.
            if rules.reach > 0 && (i + j) % 2 == 0 {
                starts.add(best_place(simd, template, current, (i, j), first, rules.reach));
            }
            matches[node] = search(simd, template, current, (i, j), &starts.places[..starts.count], rules);
        }
    }
    for node in (0..layout.len()).rev() {
        let (i, j) = (node % columns, node / columns);
        if !own_starts(layout.corner(i, j), &mut none()) {
            continue;
        }
        let beside = if i + 1 < columns { node + 1 } else { node };
        let below = if j + 1 < layout.rows { node + columns } else { node };
        let starts = [displacement(&matches[beside]), displacement(&matches[below])];
        matches[node] = reconsider(simd, template, current, (i, j), &matches[node], starts, rules);
    }
}
