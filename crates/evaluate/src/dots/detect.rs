//! Finds dark dots on a bright background, and their centres.

use fingervision_image::Image;
use nalgebra::{Matrix3, Vector3};

/// Width around a dot, px, that is included in its centre, because the blur of the optics spreads the dot beyond its
/// edge.
const MARGIN: usize = 3;
/// Least distance of a dot from the image's edge, px: nearer, blur spreads a part of the dot out of the image.
const CLEAR: usize = 2;
/// Least number of px of a dot.
const LEAST_AREA: usize = 9;
/// A dot's area lies within this factor of the median one, either way.
const AREA_FACTOR: usize = 3;

/// A connected dark region.
struct Region {
    area: usize,
    /// Left, top, right and bottom, px, all inside.
    bounds: [usize; 4],
}

/// The centres `(x, y)` of dark dots on a bright background, px, starting at the upper left.
///
/// The threshold is the one that best separates dark from bright (Otsu, *IEEE Transactions on Systems, Man and
/// Cybernetics* 9, 1979). A centre is the weighted mean position of a region's pixels and those up to 3 px around it.
/// The weight of a pixel is its difference from the background, a plane fitted to the surroundings of the dot. Negative
/// weights are kept, so that noise causes no bias. Regions within 2 px of the image's edge, and regions that differ
/// much in size from the others, do not count as dots. Anything but background within 3 px of a dot biases its centre.
#[must_use]
pub fn find_dots(grey: &Image<f32>) -> Vec<[f64; 2]> {
    let threshold = threshold(grey);
    let (labels, regions) = regions(grey, threshold);
    let mut areas: Vec<usize> = regions.iter().map(|region| region.area).filter(|&area| area >= LEAST_AREA).collect();
    areas.sort_unstable();
    let Some(&median) = areas.get(areas.len() / 2) else { return Vec::new() };
    let is_dot = |region: &Region| {
        let [left, top, right, bottom] = region.bounds;
        let is_whole = left.min(top) >= CLEAR && right + CLEAR < grey.width() && bottom + CLEAR < grey.height();
        let has_size =
            region.area >= LEAST_AREA && region.area * AREA_FACTOR >= median && region.area <= median * AREA_FACTOR;
        is_whole && has_size
    };
    let dots = regions.iter().zip(1..).filter(|(region, _)| is_dot(region));
    dots.filter_map(|(region, label)| centre(grey, &labels, region, label)).collect()
}

/// The grey level that separates dark from bright with the largest variance between both.
fn threshold(grey: &Image<f32>) -> f32 {
    let mut counts = [0.0_f64; 256];
    for &level in grey.values() {
        counts[level.clamp(0.0, 255.0) as usize] += 1.0;
    }
    let total: f64 = counts.iter().sum();
    let sum: f64 = counts.iter().zip(0..).map(|(count, level)| count * f64::from(level)).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let mut best = (0.0, 0.0..=0.0);
    for (level, count) in (0_u8..=255).zip(counts) {
        below += count;
        sum_below += count * f64::from(level);
        let above = total - below;
        if below > 0.0 && above > 0.0 {
            let apart = sum_below / below - (sum - sum_below) / above;
            let between = below * above * apart * apart;
            let level = f64::from(level) + 1.0;
            // Between two clusters every level is as good: the middle is safest.
            if between > best.0 * (1.0 + 1e-9) {
                best = (between, level..=level);
            } else if between >= best.0 * (1.0 - 1e-9) {
                best.1 = *best.1.start()..=level;
            }
        }
    }
    (0.5 * (best.1.start() + best.1.end())) as f32
}

/// The region of every pixel, counted from 1, 0 for the background; and the regions.
fn regions(grey: &Image<f32>, threshold: f32) -> (Image<u32>, Vec<Region>) {
    let (width, height) = grey.size();
    let mut labels = Image::filled(width, height, 0_u32);
    let (mut regions, mut stack) = (Vec::new(), Vec::new());
    for start_y in 0..height {
        for start_x in 0..width {
            if labels.at(start_x, start_y) != 0 || grey.at(start_x, start_y) >= threshold {
                continue;
            }
            let label = regions.len() as u32 + 1;
            let mut region = Region { area: 0, bounds: [start_x, start_y, start_x, start_y] };
            labels.row_mut(start_y)[start_x] = label;
            stack.push((start_x, start_y));
            while let Some((x, y)) = stack.pop() {
                region.take(x, y);
                let next = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
                for (x, y) in next.into_iter().filter(|&(x, y)| x < width && y < height) {
                    if labels.at(x, y) == 0 && grey.at(x, y) < threshold {
                        labels.row_mut(y)[x] = label;
                        stack.push((x, y));
                    }
                }
            }
            regions.push(region);
        }
    }
    (labels, regions)
}

impl Region {
    fn take(&mut self, x: usize, y: usize) {
        let [left, top, right, bottom] = self.bounds;
        self.area += 1;
        self.bounds = [left.min(x), top.min(y), right.max(x), bottom.max(y)];
    }
}

/// The centroid of a dot's pixels, each weighted by how much darker it is than the background. `None` if no background
/// is visible around the dot.
fn centre(grey: &Image<f32>, labels: &Image<u32>, region: &Region, label: u32) -> Option<[f64; 2]> {
    let [left, top, right, bottom] = region.bounds;
    let columns = left.saturating_sub(MARGIN)..=(right + MARGIN).min(grey.width() - 1);
    let rows = top.saturating_sub(MARGIN)..=(bottom + MARGIN).min(grey.height() - 1);
    let middle = [0.5 * (left + right) as f64, 0.5 * (top + bottom) as f64];
    let pixels = || rows.clone().flat_map(|y| columns.clone().map(move |x| (x, y)));
    let row = |x: usize, y: usize| Vector3::new(1.0, x as f64 - middle[0], y as f64 - middle[1]);
    let on_edge =
        |x: usize, y: usize| [columns.start(), columns.end()].contains(&&x) || [rows.start(), rows.end()].contains(&&y);
    // The background is a plane, because the light varies across the image.
    let (mut normal, mut moment) = (Matrix3::zeros(), Vector3::zeros());
    for (x, y) in pixels().filter(|&(x, y)| on_edge(x, y) && labels.at(x, y) == 0) {
        let row = row(x, y);
        normal += row * row.transpose();
        moment += row * f64::from(grey.at(x, y));
    }
    let ground = normal.try_inverse()? * moment;
    let mut sum = Vector3::zeros();
    for (x, y) in pixels().filter(|&(x, y)| [0, label].contains(&labels.at(x, y))) {
        let row = row(x, y);
        sum += row * (ground.dot(&row) - f64::from(grey.at(x, y)));
    }
    (sum[0] > 0.0).then(|| [middle[0] + sum[1] / sum[0], middle[1] + sum[2] / sum[0]])
}
