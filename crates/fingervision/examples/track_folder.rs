//! Tracks a folder of images or a video and writes what `fingervision track` writes: arrays, a table and a picture.
//!
//! `cargo run --release -p fingervision --example track_folder -- SOURCE PROFILE.toml OUT`
#![allow(clippy::print_stdout, reason = "an example shows what it finds")]

use fingervision::{
    Field, Fields, Flags, Options, Precision, Preview, PreviewOptions, Profile, RunFolder, RunOptions, Sink, Tracker,
    open,
};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<PathBuf> = std::env::args_os().skip(1).map(Into::into).collect();
    let [source, profile, out] = arguments.as_slice() else {
        return Err("usage: track_folder SOURCE PROFILE.toml OUT".into());
    };
    let profile = Profile::load(profile)?;
    let mut source = open(source, &Options::default())?;
    println!("{}", source.description());

    let size = source.size();
    // The kind of pixels is known from the first frame on. The colour of videos and of most JPEG images is too coarse for the flow.
    let Some(mut frame) = source.next_frame()? else { return Err("there is no frame".into()) };
    let is_colour = source.tracks_in_colour(&frame.pixels);
    let mut tracker = Tracker::new(&profile, size, is_colour, Fields::default())?;

    // Before the first frame the tracker holds a reading at rest, with the fields that every reading will have.
    let fields = Field::ALL.into_iter().filter(|field| field.is_in(tracker.reading())).collect();
    let options = RunOptions {
        size: tracker.size(),
        traction_size: None,
        precision: Precision::default(),
        fields,
        overwrite: false,
    };
    let mut run = RunFolder::create(out, &options, &profile.to_toml())?;
    let mm_per_px = profile.mm_per_px().map(|size| size as f32);
    let mut preview = Preview::new(PreviewOptions { region: Some(profile.region(size)?), mm_per_px });

    loop {
        let reading = tracker.track(&frame)?;
        run.write(reading, &frame)?;
        preview.write(reading, &frame)?;
        if reading.flags != Flags::default() {
            println!("frame {}: {}", reading.sequence, reading.flags);
        }
        match source.next_frame()? {
            Some(next) => frame = next,
            None => break,
        }
    }
    preview.save(&out.join("preview.png"))?;
    let summary = run.finish()?;
    println!("{} frames, {} bytes in {}", summary.frames, summary.bytes, summary.folder.display());
    Ok(())
}
