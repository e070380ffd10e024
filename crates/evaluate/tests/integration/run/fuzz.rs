//! Mutated arrays and tables of a run: figures or an error, never a panic.

use std::fs;

use fingervision_evaluate::run::Options;
use fingervision_fuzz::{Form, Parser};

use super::made_up::{MadeUp, finish};

/// The most memory that a run of this size may take, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Mutates one file of a run and evaluates it.
fn run(name: &'static str, form: Form, file: &str) {
    let made_up = MadeUp::new();
    let path = made_up.path(file);
    let files = vec![fs::read(&path).unwrap()];
    Parser { name, form, files, inputs: 150, most_bytes: MOST_BYTES }.run(|bytes| {
        fs::write(&path, bytes).unwrap();
        made_up.open(Options { common_frames: true }).and_then(finish).is_ok()
    });
}

#[test]
fn a_mutated_array_is_evaluated_or_refused() {
    run("npy depth", Form::Binary, "run/depth.npy");
    run("npy flow", Form::Binary, "run/flow.npy");
    run("npy valid", Form::Binary, "run/valid.npy");
    run("npy true depth", Form::Binary, "simulation/truth/depth.npy");
    run("npy true contact", Form::Binary, "simulation/truth/contact.npy");
}

#[test]
fn a_mutated_table_is_evaluated_or_refused() {
    run("csv of readings", Form::Text, "run/readings.csv");
    run("csv of true forces", Form::Text, "simulation/truth/force.csv");
}

#[test]
fn a_mutated_record_is_evaluated_or_refused() {
    run("record of a run", Form::Text, "run/run.toml");
    run("profile of a simulation", Form::Text, "simulation/profile.toml");
}
