//! The video of a run, read back by the reader of recordings' own rules: chunks of JPEG pictures in AVI.

use std::fs;
use std::path::Path;

use crate::synthetic::Press;
use fingervision_image::Rect;
use fingervision_sink::{Overlay, PreviewOptions, Sink};
use fingervision_touch::Reading;
use image::RgbImage;

const PRESS: Press = Press { width: 122, height: 90, frames: 24 };

fn overlay(path: &Path) -> Overlay {
    let region = Rect { x: 15, y: 15, width: PRESS.width, height: PRESS.height };
    let options = PreviewOptions { region: Some(region), mm_per_px: Some(0.06) };
    Overlay::create(path, (PRESS.width, PRESS.height), options).unwrap()
}

/// The pictures of a video, by their chunks.
fn pictures(path: &Path) -> Vec<RgbImage> {
    let file = fs::read(path).unwrap();
    let mut pictures = Vec::new();
    let mut at = file.windows(4).position(|letters| letters == b"movi").unwrap() + 4;
    while file.get(at..at + 4) == Some(b"00dc") {
        let len = u32::from_le_bytes(file[at + 4..at + 8].try_into().unwrap()) as usize;
        pictures.push(image::load_from_memory(&file[at + 8..at + 8 + len]).unwrap().into_rgb8());
        at += 8 + len + len % 2;
    }
    pictures
}

fn of(change: fn(&mut Reading)) -> RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("overlay.avi");
    let mut video = overlay(&path);
    let mut reading = PRESS.reading(10);
    change(&mut reading);
    video.write(&reading, &PRESS.frame(10)).unwrap();
    video.finish().unwrap();
    pictures(&path).remove(0)
}

/// The largest difference in a part of two pictures, levels.
fn difference(a: &RgbImage, b: &RgbImage, x: std::ops::Range<u32>, y: std::ops::Range<u32>) -> u8 {
    let places = y.flat_map(|y| x.clone().map(move |x| (x, y)));
    let levels = places.flat_map(|(x, y)| (0..3).map(move |channel| (x, y, channel)));
    levels.map(|(x, y, channel)| a[(x, y)][channel].abs_diff(b[(x, y)][channel])).max().unwrap()
}

#[test]
fn every_reading_is_a_picture_whether_the_video_is_closed_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("overlay.avi");
    let mut video = overlay(&path);
    for frame in 0..4 {
        video.write(&PRESS.reading(frame), &PRESS.frame(frame)).unwrap();
        assert_eq!(pictures(&path).len(), frame + 1, "readable while it grows");
    }
    video.finish().unwrap();
    let pictures = pictures(&path);
    assert_eq!(pictures.len(), 4);
    let (width, height) = pictures[0].dimensions();
    assert!(width % 2 == 0 && height % 2 == 0, "{width}x{height} px");
    // Frames are 1/90 s apart.
    let file = fs::read(&path).unwrap();
    assert_eq!(u32::from_le_bytes(file[32..36].try_into().unwrap()), 11_111, "µs a frame");
}

#[test]
fn contact_is_drawn_where_its_points_are_now_and_force_below() {
    let whole = of(|_| {});
    let camera = (40..406, 92..362);
    let without_contact = of(|reading| reading.contact = None);
    assert!(difference(&whole, &without_contact, camera.0.clone(), camera.1.clone()) > 60, "the outline is drawn");
    let still = of(|reading| {
        reading.flow.u.values_mut().fill(0.0);
        reading.flow.v.values_mut().fill(0.0);
    });
    assert!(difference(&whole, &still, camera.0.clone(), camera.1.clone()) > 60, "the outline moves with the gel");
    let without_force = of(|reading| reading.numbers.force_n = None);
    assert!(difference(&whole, &without_force, camera.0, camera.1) < 40);
    assert!(difference(&whole, &without_force, 40..460, 370..480) > 60, "the force is written below");
    let flat = of(|reading| reading.depth.as_mut().unwrap().values_mut().fill(0.0));
    assert!(difference(&whole, &flat, 510..800, 92..362) > 60, "depth is drawn beside it");
}
