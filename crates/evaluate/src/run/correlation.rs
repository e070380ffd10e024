//! Pearson's correlation of pairs that come one after another.

/// Means and sums of squared deviations of pairs, kept up to date with every pair (Welford, *Technometrics* 4, 1962).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Correlation {
    count: f64,
    mean: [f64; 2],
    squares: [f64; 2],
    product: f64,
}

impl Correlation {
    pub(crate) fn push(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        let (dx, dy) = (x - self.mean[0], y - self.mean[1]);
        self.mean[0] += dx / self.count;
        self.mean[1] += dy / self.count;
        self.squares[0] += dx * (x - self.mean[0]);
        self.squares[1] += dy * (y - self.mean[1]);
        self.product += dx * (y - self.mean[1]);
    }

    /// Adds the pairs of another (Chan, Golub and `LeVeque`, 1979).
    pub(crate) fn merge(&mut self, other: &Self) {
        if other.count == 0.0 {
            return;
        }
        let count = self.count + other.count;
        let apart = [0, 1].map(|i| other.mean[i] - self.mean[i]);
        let weight = self.count * other.count / count;
        for i in 0..2 {
            self.squares[i] += other.squares[i] + apart[i] * apart[i] * weight;
            self.mean[i] += apart[i] * other.count / count;
        }
        self.product += other.product + apart[0] * apart[1] * weight;
        self.count = count;
    }

    /// The coefficient, −1 to 1; none if either number never changes.
    pub(crate) fn coefficient(&self) -> Option<f64> {
        let [x, y] = self.squares;
        (x > 0.0 && y > 0.0).then(|| (self.product / (x.sqrt() * y.sqrt())).clamp(-1.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pairs: &[(f64, f64)]) -> Correlation {
        let mut correlation = Correlation::default();
        for &(x, y) in pairs {
            correlation.push(x, y);
        }
        correlation
    }

    #[test]
    fn the_coefficient_is_pearsons() {
        // Deviations (−1.5, −.5, .5, 1.5) and (−1, −2, 2, 1): 5 / √(5 · 10).
        let coefficient = of(&[(1.0, 2.0), (2.0, 1.0), (3.0, 5.0), (4.0, 4.0)]).coefficient().unwrap();
        assert!((coefficient - 5.0 / 50_f64.sqrt()).abs() < 1e-14, "{coefficient}");
    }

    #[test]
    fn parts_merge_to_the_whole() {
        let pairs = [(1.0, 2.0), (2.0, 1.0), (3.0, 5.0), (40.0, -4.0), (7.0, 7.5)];
        for split in 0..=pairs.len() {
            let mut parts = of(&pairs[..split]);
            parts.merge(&of(&pairs[split..]));
            let (parts, whole) = (parts.coefficient().unwrap(), of(&pairs).coefficient().unwrap());
            assert!((parts - whole).abs() < 1e-14, "split at {split}: {parts} instead of {whole}");
        }
    }

    #[test]
    fn what_never_changes_correlates_with_nothing() {
        assert_eq!(of(&[(0.1, 1.0), (0.1, 2.0), (0.1, 3.0)]).coefficient(), None);
        assert_eq!(of(&[]).coefficient(), None);
    }
}
