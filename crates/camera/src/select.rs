//! Finds a camera by its id, its serial number or a part of its name.

use crate::info::camera_nodes;
use crate::{Bus, CameraError, Node};

/// The camera with this id or serial number, or the only one whose name or id contains the text. Without a text, the only
/// camera that is plugged in.
///
/// Ids take precedence over serial numbers, and both over parts of names. Upper and lower case do not matter. A number,
/// as in `0` or `/dev/video0`, selects nothing, because it can belong to another camera after a device was plugged in.
///
/// # Errors
///
/// [`CameraError::NoCamera`], [`CameraError::NotFound`], [`CameraError::Ambiguous`], [`CameraError::Number`].
pub fn select(bus: &dyn Bus, wanted: Option<&str>) -> Result<Node, CameraError> {
    let nodes = camera_nodes(bus);
    let Some(wanted) = wanted else { return only(nodes, None) };
    let name = wanted.strip_prefix("/dev/v4l/by-id/").or_else(|| wanted.strip_prefix("/dev/v4l/by-path/"));
    let text = name.unwrap_or(wanted);
    let with_id = keep(&nodes, |node| node.id == text);
    if !with_id.is_empty() {
        return only(with_id, Some(wanted));
    }
    let with_serial =
        keep(&nodes, |node| node.serial.as_deref().is_some_and(|serial| serial.eq_ignore_ascii_case(text)));
    if !with_serial.is_empty() {
        return only(with_serial, Some(wanted));
    }
    if let Some(number) = number_in(text) {
        let path = format!("video{number}");
        let now = nodes.into_iter().find(|node| node.path.ends_with(&path)).map(|node| node.id);
        return Err(CameraError::Number { wanted: wanted.into(), now });
    }
    let part = text.to_lowercase();
    let holds_it = |name: &str| !part.is_empty() && name.to_lowercase().contains(&part);
    let matches = keep(&nodes, |node| holds_it(&node.id) || holds_it(&node.card));
    if matches.is_empty() {
        return Err(CameraError::NotFound { wanted: wanted.into(), present: ids(nodes) });
    }
    only(matches, Some(wanted))
}

/// The number of a node, as in `/dev/video1` or `1`. Digits alone count as a number only if there are at most two; more
/// may be a part of an id.
fn number_in(text: &str) -> Option<&str> {
    let number = text.trim_start_matches("/dev/").trim_start_matches("video");
    let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
    (is_number && !text.is_empty() && (number != text || text.len() <= 2)).then_some(number)
}

fn keep(nodes: &[Node], is_wanted: impl Fn(&Node) -> bool) -> Vec<Node> {
    nodes.iter().filter(|node| is_wanted(node)).cloned().collect()
}

fn ids(nodes: Vec<Node>) -> Vec<String> {
    nodes.into_iter().map(|node| node.id).collect()
}

fn only(mut nodes: Vec<Node>, wanted: Option<&str>) -> Result<Node, CameraError> {
    match (nodes.len(), nodes.pop()) {
        (1, Some(node)) => Ok(node),
        (_, None) => Err(CameraError::NoCamera),
        (_, Some(last)) => {
            nodes.push(last);
            Err(CameraError::Ambiguous { wanted: wanted.map(Into::into), matches: ids(nodes) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::FakeBus;

    fn bus() -> FakeBus {
        FakeBus::new(&[
            "usb-Maker_Touch_SN1-video-index0",
            "usb-Maker_Touch_SN2-video-index0",
            "usb-Other_Webcam-video-index0",
        ])
    }

    #[test]
    fn an_id_a_serial_number_and_a_unique_part_find_a_camera() {
        let bus = bus();
        let id = "usb-Maker_Touch_SN2-video-index0";
        for wanted in [id, "/dev/v4l/by-id/usb-Maker_Touch_SN2-video-index0", "serial-1", "SERIAL-1", "touch_sn2"] {
            assert_eq!(select(&bus, Some(wanted)).unwrap().id, id, "{wanted}");
        }
        assert_eq!(select(&bus, Some("webcam")).unwrap().path.to_str(), Some("/dev/video2"));
    }

    #[test]
    fn a_number_is_refused_and_the_id_named() {
        for wanted in ["1", "video1", "/dev/video1"] {
            let error = select(&bus(), Some(wanted)).unwrap_err();
            assert!(matches!(error, CameraError::Number { .. }), "{error}");
            assert_eq!(error.hint(), "now it is the camera usb-Maker_Touch_SN2-video-index0: use this id");
        }
        let error = select(&bus(), Some("/dev/video7")).unwrap_err();
        assert_eq!(error.hint(), "`fingervision doctor` lists the ids of all cameras");
    }

    #[test]
    fn several_matches_are_named() {
        let error = select(&bus(), Some("touch")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "\"touch\" matches several cameras: usb-Maker_Touch_SN1-video-index0, usb-Maker_Touch_SN2-video-index0"
        );
        assert!(matches!(select(&bus(), None), Err(CameraError::Ambiguous { wanted: None, .. })));
    }

    #[test]
    fn what_is_not_there_is_not_found() {
        let error = select(&bus(), Some("digit")).unwrap_err();
        assert_eq!(error.to_string(), "no camera matches \"digit\"");
        assert!(error.hint().starts_with("cameras present: usb-Maker_Touch_SN1"));
        assert!(matches!(select(&bus(), Some("")), Err(CameraError::NotFound { .. })));
        assert!(matches!(select(&FakeBus::new(&[]), None), Err(CameraError::NoCamera)));
        let without = select(&FakeBus::new(&[]), Some("left")).unwrap_err();
        assert_eq!(without.to_string(), "no camera matches \"left\"");
        assert!(without.hint().starts_with("no camera is plugged in"), "{}", without.hint());
    }

    #[test]
    fn the_only_camera_needs_no_name() {
        assert_eq!(select(&FakeBus::new(&["left"]), None).unwrap().id, "left");
    }
}
