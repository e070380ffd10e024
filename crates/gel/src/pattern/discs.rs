//! Patterns of discs: a grid of dots, and random speckle.
//!
//! The *speckle* pattern is the one used in digital image correlation: dark discs of similar size at random places, as
//! many as cover half of the area. They may overlap, so blobs of many shapes result.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::PatternError;
use super::disc::{Disc, Ground};

/// Cells of a raster along a disc's diameter: the preferred and the least number.
const CELLS_PER_DIAMETER: f64 = 24.0;
const LEAST_PER_DIAMETER: f64 = 4.0;

/// Most cells of a raster along a side.
const MOST_CELLS: usize = 2400;

/// Part of the mean by which a speckle's diameter may be smaller or larger.
const SPREAD: f64 = 0.25;

/// Distances between neighbouring dots across and down, mm.
pub(super) fn pitch_mm(count: [usize; 2], size_mm: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|axis| size_mm[axis] / count[axis] as f64)
}

/// Evenly spaced dots, half a distance from the border, row by row.
pub(super) fn dots(count: [usize; 2], diameter_mm: f64, size_mm: [f64; 2]) -> Vec<Disc> {
    let pitch = pitch_mm(count, size_mm);
    let place = |k: usize, axis: usize| (k as f64 + 0.5) * pitch[axis];
    let radius_mm = 0.5 * diameter_mm;
    (0..count[0] * count[1])
        .map(|k| Disc { centre_mm: [place(k % count[0], 0), place(k / count[0], 1)], radius_mm })
        .collect()
}

/// The repeated surroundings of one dot. Its middle is the middle of the whole pattern: a dot if the number of dots is
/// odd, else the gap between two.
pub(super) fn dot_tile(count: [usize; 2], diameter_mm: f64, size_mm: [f64; 2]) -> Result<Ground, PatternError> {
    let pitch = pitch_mm(count, size_mm);
    let mut ground = raster(diameter_mm, pitch)?;
    let centre_mm = [0, 1].map(|axis| if count[axis] % 2 == 1 { 0.5 * pitch[axis] } else { 0.0 });
    Disc { centre_mm, radius_mm: 0.5 * diameter_mm }.copies(pitch).for_each(|disc| ground.lay(disc));
    Ok(ground)
}

/// Random discs that cover this part of the area, and the area with them. They repeat like a torus.
pub(super) fn speckle(
    diameter_mm: f64,
    coverage: f64,
    size_mm: [f64; 2],
    seed: u64,
) -> Result<(Vec<Disc>, Ground), PatternError> {
    let mut ground = raster(diameter_mm, size_mm)?;
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut draw = |low: f64, high: f64| Uniform::new(low, high).map_or(low, |range| range.sample(&mut rng));
    let mut discs = Vec::new();
    while ground.covered() < coverage {
        let centre_mm = [draw(0.0, size_mm[0]), draw(0.0, size_mm[1])];
        let disc = Disc { centre_mm, radius_mm: 0.5 * diameter_mm * draw(1.0 - SPREAD, 1.0 + SPREAD) };
        disc.copies(size_mm).for_each(|disc| ground.lay(disc));
        discs.push(disc);
    }
    Ok((discs, ground))
}

/// An empty area fine enough for discs of this size.
fn raster(diameter_mm: f64, size_mm: [f64; 2]) -> Result<Ground, PatternError> {
    let longest_mm = size_mm[0].max(size_mm[1]);
    let part_mm = (diameter_mm / CELLS_PER_DIAMETER).max(longest_mm / MOST_CELLS as f64);
    let part_mm = part_mm.min(diameter_mm / LEAST_PER_DIAMETER);
    // Rounding must not exceed the maximum by one.
    let counts = size_mm.map(|size| (size / part_mm - 1e-6).ceil());
    for (size_mm, count) in size_mm.into_iter().zip(counts) {
        if !(3.0..=MOST_CELLS as f64).contains(&count) {
            return Err(PatternError::Count { what: "raster", size_mm, part_mm, count, most: MOST_CELLS });
        }
    }
    Ok(Ground::bare(counts.map(|count| count as usize), size_mm))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_evenly_spaced() {
        let dots = dots([3, 2], 1.0, [6.0, 6.0]);
        let centres: Vec<_> = dots.iter().map(|dot| dot.centre_mm).collect();
        assert_eq!(centres, [[1.0, 1.5], [3.0, 1.5], [5.0, 1.5], [1.0, 4.5], [3.0, 4.5], [5.0, 4.5]]);
    }

    #[test]
    fn speckle_covers_what_was_asked() {
        let (discs, ground) = speckle(0.25, 0.5, [6.0, 5.0], 3).unwrap();
        assert!((ground.covered() - 0.5).abs() < 0.25 * 0.25 / 30.0, "{}", ground.covered());
        let mean = discs.iter().map(|disc| 2.0 * disc.radius_mm).sum::<f64>() / discs.len() as f64;
        assert!((mean - 0.25).abs() < 0.01, "mean diameter {mean} mm");
        // Independent random discs leave exp(−n a) of the area uncovered.
        let expected =
            std::f64::consts::LN_2 * 30.0 / (0.25 * std::f64::consts::PI * 0.0625 * (1.0 + SPREAD * SPREAD / 3.0));
        assert!((discs.len() as f64 / expected - 1.0).abs() < 0.1, "{} discs, expected {expected}", discs.len());
    }

    #[test]
    fn a_seed_names_a_speckle() {
        let discs = |seed| speckle(0.3, 0.5, [3.0, 3.0], seed).unwrap().0;
        assert_eq!(discs(5), discs(5));
        assert_ne!(discs(5), discs(6));
    }
}
