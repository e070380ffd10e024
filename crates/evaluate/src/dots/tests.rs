use std::ops::ControlFlow;

use fingervision_gel::{PressCache, Scene, Simulation};
use fingervision_image::{Image, Pixels, Rect, grey_into};
use fingervision_optics::Camera;
use fingervision_touch::DensityParams;

use super::*;

/// A scene of dots that is solved quickly.
fn scene(motion: &str) -> Simulation {
    let text = format!(
        "[pattern]\nkind = 'dots'\n[indenter]\nshape = 'sphere'\nradius_mm = 8.0\n[mesh]\ncells = [12, 12, 3]\n\
         [camera]\nfocal_length_px = [195.0, 195.0]\n[render]\nwidth = 240\nheight = 240\nnoise_levels = 2.0\n\
         [motion]\n{motion}\n"
    );
    let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
    simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(())).unwrap();
    simulation
}

fn press() -> Simulation {
    scene("frames = 6\nkeyframes = [{ at = 5, depth_mm = 1.5 }]")
}

fn grey(pixels: &Pixels) -> Image<f32> {
    let (width, height) = pixels.size();
    let mut grey = Image::filled(width, height, 0.0);
    grey_into(pixels, Rect::whole(width, height), &mut grey).unwrap();
    grey
}

#[test]
fn centres_are_found_to_a_twentieth_of_a_pixel_in_noise() {
    let mut simulation = press();
    let camera = Camera::new(&simulation.scene().camera()).unwrap();
    let (sin, cos) = simulation.scene().pattern.rotation_rad.sin_cos();
    let found = find_dots(&grey(simulation.frame(0).unwrap()));
    let (mut count, mut worst) = (0, 0.0_f64);
    // The outermost dots lie beside the end of the gel.
    for k in (0..225).filter(|k| (1..14).contains(&(k % 15)) && (1..14).contains(&(k / 15))) {
        let [x, y] = [f64::from(k % 15) * 2.0 - 14.0, f64::from(k / 15) * 2.0 - 14.0];
        let [u, v] = camera.project([cos * x - sin * y, sin * x + cos * y, 0.0]).unwrap();
        let apart = found.iter().map(|[x, y]| (x - u).hypot(y - v)).fold(f64::INFINITY, f64::min);
        if apart < 4.0 {
            count += 1;
            worst = worst.max(apart);
        }
    }
    assert_eq!(count, 169, "dots found");
    assert!(worst < 0.05, "a centre is off by {worst} px");
}

#[test]
fn a_press_is_followed_dot_by_dot_and_between_them() {
    let mut simulation = press();
    let mut tracker = DotTracker::new(&simulation.frame(0).unwrap().clone()).unwrap();
    for frame in 1..6 {
        let pixels = simulation.frame(frame).unwrap().clone();
        let reading = tracker.track(&pixels).unwrap();
        assert!(reading.lost < 15, "{} dots are lost", reading.lost);
    }
    let flow = tracker.track(&simulation.frame(5).unwrap().clone()).unwrap().flow.clone();
    let truth = simulation.truth(5).unwrap();
    let (mut sum, mut count, mut largest) = (0.0, 0.0, 0.0_f32);
    for y in 24..206 {
        for x in 24..216 {
            let [u, v] = truth.flow.at(x, y);
            if truth.visible.at(x, y) == 1 {
                sum += (flow.u.at(x, y) - u).hypot(flow.v.at(x, y) - v);
                largest = largest.max(u.hypot(v));
                count += 1.0;
            }
        }
    }
    let error = sum / count;
    assert!(error < 0.1 && largest > 4.0 * error, "off by {error} px where {largest} px are the largest");
}

#[test]
fn the_density_of_dots_grows_with_the_press() {
    let mut simulation = press();
    let mut sensor = DotSensor::new(&simulation.frame(0).unwrap().clone(), &DensityParams::default()).unwrap();
    let mut before = 0.0;
    for frame in [2, 4, 5] {
        let pixels = simulation.frame(frame).unwrap().clone();
        let feature = sensor.read(&pixels).unwrap().feature.at(120, 115);
        assert!(feature > before + 0.01, "frame {frame}: {feature} after {before}");
        before = feature;
    }
}

#[test]
fn what_shows_no_dots_is_refused() {
    let error = DotTracker::new(&Pixels::Grey8(Image::filled(64, 48, 200))).unwrap_err();
    assert_eq!(error, DotError::TooFew { seen: 0, least: 4 });
    let mut simulation = press();
    let mut tracker = DotTracker::new(&simulation.frame(0).unwrap().clone()).unwrap();
    let other = Pixels::Grey8(Image::filled(64, 48, 200));
    assert!(matches!(tracker.track(&other), Err(DotError::SizeChanged { .. })));
}
