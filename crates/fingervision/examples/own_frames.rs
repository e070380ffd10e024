//! Tracks frames from your own program, such as those of a camera's driver, and prints the result of each.
//!
//! `cargo run --release -p fingervision --example own_frames`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use fingervision::{Fields, Flag, Frame, Image, Pixels, Profile, Tracker};

const SIZE: (usize, usize) = (160, 120);

/// In place of a camera: bytes in rows, red, green and blue for every pixel. The pattern moves right by 1 px a frame.
fn grab(shot: usize) -> Vec<u8> {
    let level = |x: usize, y: usize, channel: usize| {
        let cell = [(x + 40 - shot) / 3, y / 3, channel].map(|number| number as u32);
        let mixed =
            cell[0].wrapping_mul(73_856_093) ^ cell[1].wrapping_mul(19_349_663) ^ cell[2].wrapping_mul(83_492_791);
        (mixed.wrapping_mul(2_654_435_761) >> 24) as u8
    };
    let (width, height) = SIZE;
    (0..height).flat_map(|y| (0..width).flat_map(move |x| (0..3).map(move |channel| level(x, y, channel)))).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An uncalibrated sensor: only the flow is computed. `Profile::load` reads a sensor's file.
    let profile = Profile::default();
    // The first frame shows the gel untouched. The tracker owns its memory: make it once, then pass it every frame.
    let mut tracker = Tracker::new(&profile, SIZE, true, Fields::NONE)?;
    for shot in 0..10 {
        let colours: Vec<[u8; 3]> = grab(shot).chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
        let frame = Frame {
            sequence: shot as u64,              // the camera's own count: a gap means frames that it dropped
            capture_time_s: shot as f64 / 90.0, // the camera's own clock
            pixels: Pixels::Rgb8(Image::from_vec(SIZE.0, SIZE.1, colours)?),
        };
        let reading = tracker.track(&frame)?;
        if reading.flags.has(Flag::Lost) {
            println!("frame {shot}: lost, its fields do not hold");
            continue;
        }
        let (x, y) = (SIZE.0 / 2, SIZE.1 / 2);
        let (u, v) = (reading.flow.u.at(x, y), reading.flow.v.at(x, y));
        let deviation = reading.deviation.at(x, y);
        println!("frame {shot}: the middle moved by ({u:+.3}, {v:+.3}) px, give or take {deviation:.3} px");
    }
    Ok(())
}
