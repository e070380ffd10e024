//! The tracker is as accurate as required: every figure of the accuracy tables meets its required value.

use fingervision_evaluate::recordings::{Recordings, measure_pairs};
use fingervision_evaluate::{Table, pairs, sequences};
use std::path::Path;

#[track_caller]
fn assert_met(table: &Table) {
    assert_eq!(table.short().count(), 0, "\n{table}");
}

fn recordings() -> Option<Recordings> {
    let recordings = Recordings::find(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    if recordings.is_none() {
        eprintln!("skipped: there is no folder of recordings");
    }
    recordings
}

#[test]
fn simulated_pairs_meet_their_figures() {
    let tables = pairs::measure(1).unwrap();
    assert_eq!(tables.accuracy.rows.len(), 9);
    assert_met(&tables.accuracy);
}

#[test]
fn recorded_pairs_meet_their_figures() {
    if let Some(recordings) = recordings() {
        assert_met(&measure_pairs(&recordings).unwrap());
    }
}

#[test]
fn sequences_meet_their_figures_and_are_never_worse_than_a_single_reference() {
    let table = sequences::measure(&sequences::POLICIES[..2]).unwrap();
    assert_met(&table);
    // In one sequence the two policies do not use the same reference: there `single` has a pressed gel as reference.
    for row in table.rows.iter().filter(|row| !row.name.starts_with("pressed at start")) {
        let [anchored, single] = row.values[..] else { panic!("{row:?}") };
        assert!(anchored <= single + 1e-4, "{}: {anchored} px anchored, {single} px single", row.name);
    }
}
