//! Faulty folders: one clear error with a hint.

use std::fs::{self, File};

use npyz::WriterBuilder;

use super::made_up::{HEIGHT, MadeUp, STRENGTHS, WIDTH, is_touched, true_depth};

/// Checks the error of the evaluation after `harm` has damaged its folders.
fn expect(harm: impl FnOnce(&MadeUp), what: &str, hint: &str) {
    let made_up = MadeUp::new();
    harm(&made_up);
    let (error, given) = made_up.failure();
    assert!(error.contains(what), "{error} does not say {what}");
    assert!(given.contains(hint), "the hint {given} does not say {hint}");
}

#[test]
fn folders_without_fields_are_named() {
    let no_fields = |made_up: &MadeUp| {
        made_up.remove("run/flow.npy");
        made_up.remove("run/depth.npy");
    };
    expect(no_fields, "run: it contains neither flow.npy nor depth.npy", "track --out");
    let swapped = |made_up: &MadeUp| {
        fs::rename(made_up.path("run"), made_up.path("kept")).unwrap();
        fs::rename(made_up.path("simulation"), made_up.path("run")).unwrap();
        fs::rename(made_up.path("kept"), made_up.path("simulation")).unwrap();
    };
    expect(swapped, "run: it contains neither", "give the run first");
    let no_truth = |made_up: &MadeUp| {
        made_up.remove("simulation/truth/flow.npy");
        made_up.remove("simulation/truth/depth.npy");
    };
    expect(no_truth, "simulation/truth: it contains neither flow.npy nor depth.npy", "simulate --out");
    let nothing = |made_up: &MadeUp| {
        made_up.remove("run/flow.npy");
        made_up.remove("simulation/truth/depth.npy");
    };
    expect(nothing, "run contains depth and", "--fields flow,depth");
}

#[test]
fn a_truncated_array_is_named() {
    let cut = |made_up: &MadeUp| {
        let path = made_up.path("run/depth.npy");
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    };
    expect(cut, "run/depth.npy: the header states 3 frames, but the file ends after 2", "cut short");
    let cut_in_header = |made_up: &MadeUp| {
        let path = made_up.path("run/depth.npy");
        fs::write(&path, &fs::read(&path).unwrap()[..50]).unwrap();
    };
    expect(cut_in_header, "run/depth.npy: this is not an array", "numpy.save");
    expect(|made_up| made_up.write("run/depth.npy", "depth"), "run/depth.npy: this is not an array", "numpy.save");
}

#[test]
fn arrays_of_another_kind_are_named() {
    let of_type = |made_up: &MadeUp, order: npyz::Order, code: &str| {
        let file = File::create(made_up.path("run/depth.npy")).unwrap();
        let options = npyz::WriteOptions::new().dtype(npyz::DType::Plain(code.parse().unwrap()));
        let shape = [3, HEIGHT as u64, WIDTH as u64];
        let mut writer = options.shape(&shape).order(order).writer(file).begin_nd().unwrap();
        writer.extend(std::iter::repeat_n(0.0_f32, 3 * WIDTH * HEIGHT)).unwrap();
        writer.finish().unwrap();
    };
    expect(|made_up| of_type(made_up, npyz::Order::C, ">f4"), "its values are of type >f4", "astype('<f4')");
    expect(|made_up| of_type(made_up, npyz::Order::Fortran, "<f4"), "Fortran order", "ascontiguousarray");
    let mask = |made_up: &MadeUp| made_up.array("run/valid.npy", |_, _, _| 1.0_f32);
    expect(mask, "valid.npy: its values are of type <f4, expected uint8 or bool", "astype('u1')");
}

#[test]
fn arrays_of_another_shape_are_named() {
    let scalar = |made_up: &MadeUp| made_up.array("run/flow.npy", |_, _, _| 0.0_f32);
    expect(scalar, "flow.npy: its shape is [3, 30, 40], expected [frames, rows, columns, 2]", "first dimension");
    let vector = |made_up: &MadeUp| made_up.array("run/depth.npy", |_, _, _| [0.0_f32; 2]);
    expect(vector, "depth.npy: its shape is [3, 30, 40, 2], expected [frames, rows, columns], none", "dimension");
    let empty = |made_up: &MadeUp| made_up.array_of("run/depth.npy", (WIDTH, HEIGHT), &[], |_, _, _| 0.0_f32);
    expect(empty, "its shape is [0, 30, 40]", "");
    let other = |made_up: &MadeUp| made_up.array_of("run/depth.npy", (WIDTH, 29), &STRENGTHS, |_, _, _| 0.0_f32);
    expect(other, "depth.npy: it has 40x29 px, but", "one grid");
}

#[test]
fn different_numbers_of_frames_are_named() {
    let fewer = |made_up: &MadeUp| {
        made_up.array_of("run/depth.npy", (WIDTH, HEIGHT), &STRENGTHS[..2], |s, x, y| s * true_depth(x, y));
    };
    expect(fewer, "run/depth.npy contains 2 frames, run/flow.npy contains 3", "--common-frames");
    let table = |made_up: &MadeUp| {
        made_up.write("run/readings.csv", "force_x_n,force_y_n,force_z_n\n1,2,3\n");
    };
    expect(table, "run/readings.csv contains 1 frames", "--common-frames");
}

#[test]
fn grids_that_do_not_fit_are_named() {
    let smaller = |made_up: &MadeUp| {
        made_up.remove("run/flow.npy");
        made_up.remove("run/valid.npy");
        made_up.array_of("run/depth.npy", (20, 15), &STRENGTHS, |_, _, _| 0.0_f32);
    };
    expect(
        smaller,
        "the run's grid [0, 0, 20, 15] is not inside the truth's grid [0, 0, 40, 30]",
        "region_of_interest",
    );
    let region = "[profile.image]\nregion_of_interest = [0, 0, 20, 15]\n";
    let other_region = |made_up: &MadeUp| made_up.write("run/run.toml", region);
    expect(
        other_region,
        "run/run.toml: the region of interest [0, 0, 20, 15] differs in size from the arrays, 40x30 px",
        "correct image.region_of_interest",
    );
}

#[test]
fn files_that_say_what_cannot_be_are_named() {
    let syntax = |made_up: &MadeUp| made_up.write("run/run.toml", "[profile\n");
    expect(syntax, "run.toml, line 1: ", "TOML");
    let camera = |made_up: &MadeUp| {
        let text = super::made_up::PROFILE.replace("25.0]", "-25.0]");
        made_up.write("simulation/profile.toml", &text);
    };
    expect(camera, "profile.toml: camera.translation_mm = [0.0, 0.0, -25.0] is impossible", "above 0 mm");
    let unknown = |made_up: &MadeUp| {
        made_up.write("simulation/profile.toml", &format!("{}focus_mm = 2\n", super::made_up::PROFILE));
    };
    expect(unknown, "unknown key camera.focus_mm", "");
    let table = |made_up: &MadeUp| made_up.write("simulation/truth/force.csv", "frame,force_x_n\n");
    expect(table, "force.csv, line 1: there is no column force_y_n", "column names");
}

#[test]
fn a_valid_pixel_without_a_number_is_named() {
    let harm = |made_up: &MadeUp| {
        made_up.array("run/flow.npy", |s, x, y| match (s > 0.9, x, y) {
            (true, 17, 5) => [0.0, f32::INFINITY],
            _ => [f32::from(u8::from(is_touched(x, y))); 2],
        });
        made_up.array("run/depth.npy", |_, _, _| 0.0_f32);
    };
    expect(harm, "run/flow.npy: frame 2, pixel (17, 5) is not finite, but valid.npy marks it", "set valid.npy to 0");
}
