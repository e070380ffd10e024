//! Dense optical flow between two images, without a sensor, a profile or a tracker.
//!
//! `cargo run --release -p fingervision --example flow_alone`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use fingervision::{Estimate, FlowEstimator, FlowParams, Image, Pixels, Rect, Start, flow_colours, write_png};

const SIZE: (usize, usize) = (160, 120);

/// A random pattern of cells of 3 px, moved to the right.
fn image(shift: usize) -> Pixels {
    Pixels::Grey8(Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (column, row) = (((x + 9 - shift) / 3) as u32, (y / 3) as u32);
        let mixed = column.wrapping_mul(73_856_093) ^ row.wrapping_mul(19_349_663);
        (mixed.wrapping_mul(2_654_435_761) >> 24) as u8
    }))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (width, height) = SIZE;
    let whole = Rect::whole(width, height);
    let mut estimator = FlowEstimator::new(width, height, &FlowParams::default())?;

    // Everything that depends only on the reference is computed once.
    let mut picture = estimator.picture();
    picture.load(&image(0), whole)?;
    let mut reference = estimator.reference();
    estimator.prepare(&picture, &mut reference);

    // Without a start; `Start::History` starts from the flows of the frames before.
    picture.load(&image(4), whole)?;
    let mut estimate = Estimate::new(width, height);
    estimator.estimate(&reference, &picture, Start::Search(None), &mut estimate);

    let measured = estimate.flow.u.values().iter().zip(estimate.valid.values()).filter(|(_, valid)| **valid == 1);
    let (sum, count) = measured.fold((0.0, 0), |(sum, count), (u, _)| (sum + (u - 4.0).abs(), count + 1));
    let mean_error = sum / count as f32;
    println!("{count} of {} px are valid; the shift of 4 px is off by {mean_error:.4} px on average", width * height);

    if let Some(file) = std::env::args().nth(1) {
        write_png(&flow_colours(&estimate.flow, &estimate.valid, 4.0), file.as_ref())?;
        println!("{file} shows the flow as colour");
    }
    Ok(())
}
