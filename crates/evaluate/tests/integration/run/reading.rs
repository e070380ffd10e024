//! Files that may be absent, cropped, longer or in another format, and the text of a report.

use std::fs::{self, File};

use fingervision_evaluate::run::{Options, Report};
use fingervision_sink::ArrayWriter;
use half::f16;
use npyz::WriterBuilder;
use serde_json::Value;

use super::made_up::{
    HEIGHT, MadeUp, STRENGTHS, WIDTH, Zone, depth_error, estimated_depth, finish, is_invalid, run_beside, true_depth,
    zone,
};

/// After a change of the text, look at it and run the tests with `UPDATE_TABLE=1`.
#[test]
fn the_text_is_as_recorded() {
    let made_up = MadeUp::new();
    made_up.remove("run/run.toml");
    let report = Report { run: "run".into(), truth: "simulation/truth".into(), ..made_up.evaluate().report };
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/integration/run/report.txt");
    if std::env::var_os("UPDATE_TABLE").is_some() {
        fs::write(path, report.to_string()).unwrap();
    }
    assert_eq!(report.to_string(), fs::read_to_string(path).unwrap_or_default());
}

#[test]
fn a_program_can_read_every_frame() {
    let json = serde_json::to_value(MadeUp::new().evaluate().report).unwrap();
    let frames = json["per_frame"].as_array().unwrap();
    assert_eq!(frames.len(), 3);
    assert_eq!(frames[0]["depth_mm"]["inside"], Value::Null, "nothing is touched in the first frame");
    assert_eq!(frames[2]["depth_mm"]["inside"]["pixels"], 400);
    assert_eq!((&frames[2]["true_depth_mm"], &frames[2]["true_flow_px"]), (&Value::from(2.0), &Value::from(5.0)));
    assert_eq!(json["pooled"]["pixels"]["everywhere"]["hidden"], 120);
    assert_eq!(json["force"]["true_peak_n"], 5.0);
}

#[test]
fn the_folder_of_the_arrays_will_do_as_truth() {
    let made_up = MadeUp::new();
    let report = run_beside(&made_up.path("run"), &made_up.path("simulation/truth")).report;
    assert_eq!(report.per_frame, made_up.evaluate().report.per_frame, "its profile.toml is found one up");
}

#[test]
fn arrays_alone_will_do() {
    let made_up = MadeUp::new();
    for name in ["run/valid.npy", "run/run.toml", "run/readings.csv", "run/flow.npy"] {
        made_up.remove(name);
    }
    for name in ["truth/flow.npy", "truth/displacement.npy", "truth/visible.npy", "truth/force.csv"] {
        made_up.remove(&format!("simulation/{name}"));
    }
    let report = made_up.evaluate().report;
    assert_eq!(report.fields, ["depth"]);
    // NaN is not valid, even without a mask.
    let expected = MadeUp::new().evaluate().report;
    assert_eq!(report.pooled.pixels, expected.pooled.pixels);
    assert_eq!(report.pooled.depth_mm, expected.pooled.depth_mm);
    for (note, expected) in report.notes.iter().zip(["run.toml", "valid.npy", "visible.npy", "force.csv"]) {
        assert!(note.contains(expected), "{note} does not name {expected}");
    }
    assert_eq!(report.notes.len(), 4, "{:?}", report.notes);
}

#[test]
fn flow_alone_is_compared_and_the_frame_of_largest_motion_is_shown() {
    let made_up = MadeUp::new();
    made_up.remove("run/depth.npy");
    for name in ["truth/depth.npy", "truth/contact.npy"] {
        made_up.remove(&format!("simulation/{name}"));
    }
    let outcome = made_up.evaluate();
    assert_eq!((outcome.report.deepest_frame, outcome.report.fields.as_slice()), (2, ["flow", "force"].as_slice()));
    let flow = outcome.report.pooled.flow_px.unwrap();
    assert!(flow.everywhere.is_some() && flow.inside.is_none() && flow.border.is_none() && flow.outside.is_none());
    assert_eq!(outcome.draw().width(), 1600);
}

#[test]
fn without_a_camera_only_the_contact_has_its_own_errors() {
    let made_up = MadeUp::new();
    made_up.write("simulation/profile.toml", "name = \"no camera\"\n");
    let report = made_up.evaluate().report;
    let depth = report.pooled.depth_mm.unwrap();
    assert!(depth.inside.is_some() && depth.border.is_none() && depth.outside.is_none());
    assert!(report.notes.iter().any(|note| note.contains("camera")), "{:?}", report.notes);
}

#[test]
fn where_nothing_is_touched_all_is_outside() {
    let made_up = MadeUp::new();
    made_up.array("simulation/truth/contact.npy", |_, _, _| 0_u8);
    let report = made_up.evaluate().report;
    let depth = report.pooled.depth_mm.unwrap();
    assert!(depth.inside.is_none() && depth.border.is_none());
    assert_eq!(depth.outside.unwrap().pixels, depth.everywhere.unwrap().pixels);
    assert!(report.to_string().contains("inside contact                  —"), "{report}");
    assert!(!report.to_string().contains("NaN"), "{report}");
}

#[test]
fn a_run_on_a_part_of_the_image_is_compared_there() {
    let made_up = MadeUp::new();
    let (left, top) = (12, 7);
    made_up.write("run/run.toml", "[profile.image]\nregion_of_interest = [12, 7, 18, 16]\n");
    let size = (18, 16);
    made_up.array_of("run/depth.npy", size, &STRENGTHS, |s, x, y| {
        s * (true_depth(x + left, y + top) + depth_error(x + left, y + top))
    });
    made_up.remove("run/flow.npy");
    made_up.array_of("run/valid.npy", size, &STRENGTHS, |_, _, _| 1_u8);
    let report = made_up.evaluate().report;
    assert_eq!(report.region, [12, 7, 18, 16]);
    let depth = report.deepest().unwrap().errors.depth_mm.unwrap();
    // All of it is in contact; the contact's border lies outside, but 1 mm of it reaches in.
    let zones = || (0..16).flat_map(|y| (0..18).map(move |x| zone(x + left, y + top)));
    let near = zones().filter(|zone| *zone == Zone::InnerBorder).count() as u64;
    assert_eq!((depth.inside.unwrap().pixels, depth.border.unwrap().pixels), (288, near));
    assert!((depth.border.unwrap().bias + 0.5).abs() < 1e-6 && depth.outside.is_none());
}

#[test]
fn float64_and_bool_are_read_as_well() {
    let made_up = MadeUp::new();
    let depth = STRENGTHS
        .iter()
        .flat_map(|&s| (0..HEIGHT).flat_map(move |y| (0..WIDTH).map(move |x| f64::from(estimated_depth(s, x, y)))));
    let valid = STRENGTHS.iter().flat_map(|_| (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| !is_invalid(x, y))));
    let shape = [3, HEIGHT as u64, WIDTH as u64];
    let create = |name: &str| File::create(made_up.path(name)).unwrap();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(create("run/depth.npy")).begin_nd().unwrap();
    writer.extend(depth).unwrap();
    writer.finish().unwrap();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(create("run/valid.npy")).begin_nd().unwrap();
    writer.extend(valid).unwrap();
    writer.finish().unwrap();
    assert_eq!(made_up.evaluate().report.per_frame, MadeUp::new().evaluate().report.per_frame);
}

#[test]
fn float16_is_read_as_well() {
    let made_up = MadeUp::new();
    let mut depth = ArrayWriter::<f16>::create(&made_up.path("run/depth.npy"), WIDTH, HEIGHT).unwrap();
    for strength in STRENGTHS {
        let values = (0..WIDTH * HEIGHT).map(|at| estimated_depth(strength, at % WIDTH, at / WIDTH));
        depth.write(values.map(f16::from_f32).collect::<Vec<_>>().into_iter()).unwrap();
    }
    depth.finish().unwrap();
    let errors =
        |made_up: &MadeUp| made_up.evaluate().report.deepest().unwrap().errors.depth_mm.unwrap().inside.unwrap();
    let (half, single) = (errors(&made_up), errors(&MadeUp::new()));
    assert_eq!(half.pixels, single.pixels);
    assert!((half.bias - single.bias).abs() < 1e-3, "{half:?}, {single:?}");
}

#[test]
fn a_run_that_was_cut_short_is_compared_as_far_as_it_goes_when_asked() {
    let made_up = MadeUp::new();
    made_up.array_of("run/depth.npy", (WIDTH, HEIGHT), &STRENGTHS[..2], estimated_depth);
    let options = Options { common_frames: true };
    let report = finish(made_up.open(options).unwrap()).unwrap().report;
    assert_eq!(report.per_frame.len(), 2);
    let whole = MadeUp::new().evaluate().report;
    assert_eq!(report.per_frame[1].errors, whole.per_frame[1].errors);
    assert!(report.notes[0].contains("depth.npy contains 2 of 3 frames"), "{:?}", report.notes);
}

#[test]
fn a_frame_costs_no_memory() {
    let made_up = MadeUp::new();
    let mut evaluation = made_up.open(Options::default()).unwrap();
    assert!(evaluation.advance().unwrap() && evaluation.advance().unwrap());
    let cost = allocation_counter::measure(|| assert!(evaluation.advance().unwrap()));
    assert_eq!(cost.count_total, 0, "{} bytes", cost.bytes_total);
}

#[test]
fn of_a_press_that_is_held_the_last_frame_is_shown() {
    let made_up = MadeUp::new();
    let strengths = [0.0, 1.0, 1.0, 0.999_5, 0.9];
    for (name, size) in [("run/depth.npy", 1.0), ("simulation/truth/depth.npy", 1.0)] {
        made_up.array_of(name, (WIDTH, HEIGHT), &strengths, |s, x, y| size * s * true_depth(x, y));
    }
    for name in ["run/flow.npy", "run/valid.npy", "run/readings.csv"] {
        made_up.remove(name);
    }
    for name in ["flow", "displacement", "contact", "visible"] {
        made_up.remove(&format!("simulation/truth/{name}.npy"));
    }
    assert_eq!(made_up.evaluate().report.deepest_frame, 3);
}
