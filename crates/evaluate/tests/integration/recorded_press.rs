//! A recorded press on a real sensor, tracked from the first frame to the last.

use fingervision_evaluate::recordings::{PressEvidence, Punyo, Recordings};
use std::path::Path;
use std::sync::LazyLock;

static RECORDINGS: LazyLock<Option<Recordings>> =
    LazyLock::new(|| Recordings::find(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")));

/// The results of tracking the press; computed once for all tests.
static EVIDENCE: LazyLock<Option<PressEvidence>> = LazyLock::new(|| {
    let punyo = Punyo::open(RECORDINGS.as_ref()?).expect("mask and forces beside the frames");
    Some(PressEvidence::measure(&punyo).expect("150 frames that can be tracked"))
});

/// The data that a test needs. A test without its data prints that it is skipped.
fn or_skipped<T>(needed: &'static LazyLock<Option<T>>) -> Option<&'static T> {
    if needed.is_none() {
        eprintln!("skipped: there is no folder of recordings");
    }
    needed.as_ref()
}

#[test]
fn the_flow_at_rest_is_zero_and_the_round_trip_closes() {
    let Some(recordings) = or_skipped(&RECORDINGS) else { return };
    let table = Punyo::open(recordings).unwrap().measure_pairs().unwrap();
    assert_eq!(table.short().count(), 0, "\n{table}");
}

#[test]
fn tracked_flow_stays_at_rest() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    let at_rest = evidence.flow_at_rest_px();
    assert!(at_rest <= 0.012, "{at_rest} px");
}

#[test]
fn the_press_is_tracked_in_every_frame() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    assert_eq!(evidence.flagged, 0);
    // At the rim of the contact the flow is too rough for the patches, so it is not valid there.
    assert!(evidence.least_valid >= 0.95, "{} of the membrane is valid", evidence.least_valid);
}

/// The depth camera's image lies within 2 px of the grey one, and the two centres are defined differently: the length
/// of the flow contains both the sideways motion of the membrane and its approach. Both must show the same contact: the
/// distance between the centres is at most half the radius of the contact.
#[test]
fn the_contact_is_where_the_depth_camera_sees_it() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    let (distance, radius) = (evidence.centre_distance_px, evidence.contact_radius_px);
    assert!(distance <= 0.5 * radius, "{distance} px apart, contact of radius {radius} px");
}

/// The membrane still creeps at the end of the recording: `OpenCV`'s inverse search finds 0.043 px there.
#[test]
fn little_flow_remains_after_the_press() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    let left = evidence.flow_left_px();
    assert!(left <= 0.043, "{left} px");
}

#[test]
fn the_flow_grows_with_the_force() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    let [tracked, _] = evidence.force_correlation;
    assert!(tracked >= 0.993, "correlation {tracked}");
}

#[test]
fn valid_flow_agrees_with_a_cold_start() {
    let Some(evidence) = or_skipped(&EVIDENCE) else { return };
    assert!(evidence.apart <= 0.001, "{} of the membrane is valid but more than 1 px off", evidence.apart);
}
