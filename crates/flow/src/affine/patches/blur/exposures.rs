//! The search for the exposure that explains a blurred picture best.

/// Exposure that is tried first in a sequence without a blurred picture so far.
const FIRST_EXPOSURE: f32 = 0.5;

/// Ratio of an exposure to the next one that is tried.
const RATIO: f32 = std::f32::consts::SQRT_2;

/// Shortest and longest exposure. More than 1 means that the motion has become faster since the last frame.
const RANGE: (f32, f32) = (0.15, 2.5);

/// Part of the texture's variance that a good exposure may leave unexplained.
const LEAST_UNEXPLAINED: f32 = 0.01;

/// An exposure that was the best for the last blurred picture is taken again if it leaves at most this many times as much
/// unexplained as when it was found, and at most this part.
const AS_GOOD: (f32, f32) = (1.3, 0.1);

/// Least distance of the minimum of a parabola from an exposure that was tried, relative to the distance between two of them.
const LEAST_SHIFT: f32 = 0.1;

/// An exposure, relative to the time between two frames, and the part of the texture's variance that it leaves unexplained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trial {
    pub(super) exposure: f32,
    pub(super) unexplained: f32,
}

/// Searches the minimum on a logarithmic scale: goes on in the direction that improves, until the best exposure has a worse one
/// on each side; the last trial is the minimum of the parabola through the three.
#[derive(Debug)]
pub(super) struct Exposures {
    first: f32,
    /// With at most this part unexplained, no other exposure is tried.
    enough: f32,
    best: Trial,
    /// The neighbours of the best: shorter and longer.
    beside: [Option<Trial>; 2],
    /// Whether the best was tried last.
    is_best_last: bool,
    count: usize,
    is_done: bool,
}

impl Exposures {
    /// Begins with the best exposure of the last blurred picture, if there was one.
    pub(super) fn after(last: Option<Trial>) -> Self {
        let Trial { exposure: first, unexplained } =
            last.unwrap_or(Trial { exposure: FIRST_EXPOSURE, unexplained: 0.0 });
        let enough = (AS_GOOD.0 * unexplained).clamp(LEAST_UNEXPLAINED, AS_GOOD.1);
        let best = Trial { exposure: first, unexplained: f32::INFINITY };
        Self { first, enough, best, beside: [None; 2], is_best_last: false, count: 0, is_done: false }
    }

    /// The exposure to be tried next, if any.
    pub(super) fn next(&mut self) -> Option<f32> {
        if self.is_done {
            return None;
        }
        let Trial { exposure, unexplained } = self.best;
        if unexplained == f32::INFINITY {
            return Some(self.first);
        }
        let (shorter, longer) = (exposure / RATIO, exposure * RATIO);
        if self.beside[1].is_none() && longer <= RANGE.1 {
            return Some(longer);
        }
        if self.beside[0].is_none() && shorter >= RANGE.0 {
            return Some(shorter);
        }
        self.is_done = true;
        self.vertex()
    }

    /// Adds the result of a trial. Returns whether it is the best so far.
    pub(super) fn add(&mut self, exposure: f32, unexplained: f32) -> bool {
        debug_assert!(unexplained.is_finite(), "{unexplained}");
        let trial = Trial { exposure, unexplained };
        self.count += 1;
        self.is_best_last = unexplained < self.best.unexplained;
        let is_longer = exposure > self.best.exposure;
        if self.is_best_last {
            let before = (self.best.unexplained < f32::INFINITY).then_some(self.best);
            self.beside = if is_longer { [before, None] } else { [None, before] };
            self.best = trial;
            self.is_done |= unexplained <= self.enough;
            return true;
        }
        self.beside[usize::from(is_longer)] = Some(trial);
        false
    }

    pub(super) fn best(&self) -> Trial {
        self.best
    }

    /// What the next blurred picture begins with. An exposure that was taken again keeps what it left unexplained when it was
    /// found: otherwise it could become worse from picture to picture without a new search.
    pub(super) fn memory(&self) -> Trial {
        let found = self.enough / AS_GOOD.0;
        let unexplained = if self.count == 1 { self.best.unexplained.min(found) } else { self.best.unexplained };
        Trial { unexplained, ..self.best }
    }

    /// Whether the best exposure was tried last.
    pub(super) fn is_best_last(&self) -> bool {
        self.is_best_last
    }

    /// The minimum of the parabola through the best exposure and its neighbours, unless it has been tried.
    fn vertex(&self) -> Option<f32> {
        let [shorter, longer] = self.beside;
        let excess = |trial: Trial| trial.unexplained - self.best.unexplained;
        let (below, above) = (excess(shorter?), excess(longer?));
        let shift = 0.5 * (below - above) / (below + above);
        (shift.abs() > LEAST_SHIFT).then(|| self.best.exposure * RATIO.powf(shift))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best exposure, and the number of trials, if an exposure `e` leaves `(ln e/true)² + rest` unexplained.
    fn search(last: Option<Trial>, is: f32, rest: f32) -> (f32, usize) {
        let (mut exposures, mut count) = (Exposures::after(last), 0);
        while let Some(exposure) = exposures.next() {
            exposures.add(exposure, (exposure / is).ln().powi(2) + rest);
            count += 1;
        }
        (exposures.best().exposure, count)
    }

    #[test]
    fn the_exposure_is_found_from_both_sides() {
        for is in [0.25, 0.3, 0.5, 0.8, 1.0, 1.6] {
            let (found, count) = search(None, is, 0.1);
            assert!((found / is - 1.0).abs() < 0.02 && count <= 7, "{found} instead of {is}, {count} trials");
        }
    }

    #[test]
    fn an_exposure_that_explains_everything_needs_one_trial() {
        assert_eq!(search(None, FIRST_EXPOSURE, 0.0), (FIRST_EXPOSURE, 1));
        let last = Some(Trial { exposure: 0.7, unexplained: 0.05 });
        assert_eq!(search(last, 0.72, 0.06), (0.7, 1));
        assert_eq!(search(last, 0.72, 0.07).1, 3);
    }

    #[test]
    fn an_exposure_that_gets_worse_is_searched_again() {
        let mut last = None;
        let mut searched = Vec::new();
        for picture in 0..30 {
            // The exposure becomes longer from picture to picture.
            let is = 0.5 * 1.02_f32.powi(picture);
            let (mut exposures, mut count) = (Exposures::after(last), 0);
            while let Some(exposure) = exposures.next() {
                exposures.add(exposure, 2.0 * (exposure / is).ln().powi(2) + 0.02);
                count += 1;
            }
            assert!(
                (exposures.best().exposure / is).ln().abs() < 0.2,
                "picture {picture}: {:?} for {is}",
                exposures.best()
            );
            last = Some(exposures.memory());
            searched.push(count > 1);
        }
        assert!(searched[1..].contains(&true) && searched[1..].contains(&false), "{searched:?}");
        assert!(
            search(Some(Trial { exposure: 0.7, unexplained: 0.8 }), 0.35, 0.02).1 > 1,
            "a bad match is not taken again"
        );
    }

    #[test]
    fn the_search_ends_at_the_longest_exposure() {
        let (found, count) = search(None, 9.0, 0.1);
        assert!((1.5..=2.5).contains(&found) && count <= 6, "{found}, {count} trials");
    }
}
