//! Finds the dots of one frame in the next one.

/// A dot is searched within this part of the distance between neighbours.
const GATE: f64 = 0.45;
/// Number of nearest neighbours whose mean motion a lost dot takes.
const NEIGHBOURS: usize = 4;

/// The dots of the first image, tracked through the others.
#[derive(Debug, Clone)]
pub(super) struct Followed {
    reference_px: Vec<[f64; 2]>,
    /// The position of each dot, predicted where it was not found.
    places_px: Vec<[f64; 2]>,
    /// Motion since the frame before, px.
    motions_px: Vec<[f64; 2]>,
    is_seen: Vec<bool>,
    /// The nearest of the others in the first image, nearest first.
    neighbours: Vec<Vec<usize>>,
    /// The median distance to the nearest neighbour in the first image, px.
    pitch_px: f64,
}

impl Followed {
    /// The dots as they are first seen: two or more.
    pub(super) fn new(dots_px: &[[f64; 2]]) -> Self {
        let count = dots_px.len();
        let nearest = |dot: usize| {
            let mut others: Vec<usize> = (0..count).filter(|&other| other != dot).collect();
            others.sort_by(|&a, &b| {
                squared_distance(dots_px[dot], dots_px[a]).total_cmp(&squared_distance(dots_px[dot], dots_px[b]))
            });
            others
        };
        let neighbours: Vec<Vec<usize>> = (0..count).map(nearest).collect();
        let to_nearest = |dot: usize| squared_distance(dots_px[dot], dots_px[neighbours[dot][0]]).sqrt();
        let mut distances: Vec<f64> = (0..count).map(to_nearest).collect();
        distances.sort_by(f64::total_cmp);
        Self {
            reference_px: dots_px.to_vec(),
            places_px: dots_px.to_vec(),
            motions_px: vec![[0.0; 2]; count],
            is_seen: vec![true; count],
            pitch_px: distances[count / 2],
            neighbours,
        }
    }

    pub(super) fn reference_px(&self) -> &[[f64; 2]] {
        &self.reference_px
    }

    pub(super) fn pitch_px(&self) -> f64 {
        self.pitch_px
    }

    /// Whether each dot was found in the last image.
    pub(super) fn is_seen(&self) -> &[bool] {
        &self.is_seen
    }

    /// Displacement of a dot since the first image, px.
    pub(super) fn displacement_px(&self, dot: usize) -> [f64; 2] {
        [0, 1].map(|axis| self.places_px[dot][axis] - self.reference_px[dot][axis])
    }

    /// Finds every dot among those of the next image: the two must be each other's nearest, within reach of the
    /// position predicted from the last motion.
    pub(super) fn advance(&mut self, found_px: &[[f64; 2]]) {
        let expected: Vec<[f64; 2]> = self
            .places_px
            .iter()
            .zip(&self.motions_px)
            .map(|(place, motion)| [place[0] + motion[0], place[1] + motion[1]])
            .collect();
        let nearest_dot: Vec<Option<usize>> = found_px.iter().map(|&found| nearest(&expected, found)).collect();
        let reach = (GATE * self.pitch_px).powi(2);
        for (dot, &expected) in expected.iter().enumerate() {
            let found = nearest(found_px, expected).filter(|&found| {
                nearest_dot[found] == Some(dot) && squared_distance(found_px[found], expected) < reach
            });
            self.is_seen[dot] = found.is_some();
            if let Some(found) = found {
                let place = found_px[found];
                self.motions_px[dot] = [0, 1].map(|axis| place[axis] - self.places_px[dot][axis]);
                self.places_px[dot] = place;
            }
        }
        self.carry_the_lost();
    }

    /// A dot that is not found moves with its neighbours.
    fn carry_the_lost(&mut self) {
        for dot in (0..self.places_px.len()).filter(|&dot| !self.is_seen[dot]) {
            let seen = self.neighbours[dot].iter().filter(|&&other| self.is_seen[other]).take(NEIGHBOURS);
            let (mut sum, mut count) = ([0.0; 2], 0.0);
            for &other in seen {
                let displacement = self.displacement_px(other);
                sum = [sum[0] + displacement[0], sum[1] + displacement[1]];
                count += 1.0;
            }
            if count > 0.0 {
                let reference = self.reference_px[dot];
                self.places_px[dot] = [0, 1].map(|axis| reference[axis] + sum[axis] / count);
            }
            self.motions_px[dot] = [0.0; 2];
        }
    }
}

fn squared_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

fn nearest(places: &[[f64; 2]], to: [f64; 2]) -> Option<usize> {
    let distance = |&(_, &place): &(usize, &[f64; 2])| squared_distance(place, to);
    places.iter().enumerate().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<[f64; 2]> {
        (0..25).map(|k| [f64::from(k % 5) * 20.0, f64::from(k / 5) * 20.0]).collect()
    }

    #[test]
    fn dots_that_speed_up_are_followed_farther_than_the_reach() {
        let mut followed = Followed::new(&grid());
        for shift in [4.0, 11.0, 22.0, 36.0] {
            let mut found: Vec<_> = grid().into_iter().map(|[x, y]| [x + shift, y]).collect();
            found.reverse();
            followed.advance(&found);
            assert!(followed.is_seen().iter().all(|&seen| seen), "{shift}");
            for dot in 0..25 {
                let [x, y] = followed.displacement_px(dot);
                assert!((x - shift).abs() < 1e-9 && y.abs() < 1e-9, "dot {dot} moved by {x} {y}");
            }
        }
    }

    #[test]
    fn a_lost_dot_moves_with_its_neighbours_and_is_found_again() {
        let mut followed = Followed::new(&grid());
        for shift in [5.0, 10.0, 15.0, 20.0] {
            let mut found: Vec<_> = grid().into_iter().map(|[x, y]| [x, y + shift]).collect();
            if shift < 20.0 {
                found.remove(12);
            }
            followed.advance(&found);
            assert_eq!(followed.is_seen()[12], shift > 15.0);
            assert!((followed.displacement_px(12)[1] - shift).abs() < 1e-9);
        }
    }
}
