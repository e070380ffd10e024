//! The cameras that are plugged in.

use std::io;

use crate::{Bus, Node, Offer};

/// A camera.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraInfo {
    /// Its node, with id, name, driver and serial number.
    pub node: Node,
    /// Whether it can be opened.
    pub access: Access,
    /// Its formats, sizes and rates; empty if it cannot be opened.
    pub offers: Vec<Offer>,
}

/// Whether a camera can be opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Access {
    /// Yes.
    Open,
    /// No: the user lacks the permission.
    Denied,
    /// No, for the reason given by the system.
    Failed(String),
}

/// The cameras of a system, without nodes that only carry metadata.
///
/// A node that cannot be opened is listed only if it is the first of its device: that is the one with the images.
#[must_use]
pub fn cameras(bus: &dyn Bus) -> Vec<CameraInfo> {
    bus.nodes().into_iter().filter_map(|node| camera(bus, node)).collect()
}

/// The nodes of the cameras, without their formats.
pub(crate) fn camera_nodes(bus: &dyn Bus) -> Vec<Node> {
    let is_camera = |node: &Node| bus.is_capture(&node.path).unwrap_or(node.index == 0);
    bus.nodes().into_iter().filter(is_camera).collect()
}

fn camera(bus: &dyn Bus, node: Node) -> Option<CameraInfo> {
    let inspected = bus.is_capture(&node.path).and_then(|is_capture| {
        let offers = if is_capture { bus.open(&node.path)?.offers()? } else { Vec::new() };
        Ok((is_capture, offers))
    });
    let (access, offers) = match inspected {
        Ok((false, _)) => return None,
        Ok((true, offers)) => (Access::Open, offers),
        Err(_) if node.index > 0 => return None,
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => (Access::Denied, Vec::new()),
        Err(error) => (Access::Failed(error.to_string()), Vec::new()),
    };
    Some(CameraInfo { node, access, offers })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake::FakeBus;

    #[test]
    fn metadata_nodes_are_hidden() {
        let bus = FakeBus::new(&["left", "right"]);
        bus.with(|world| world.metadata.push(1));
        let found = cameras(&bus);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].node.id.as_str(), &found[0].access), ("left", &Access::Open));
        assert!(!found[0].offers.is_empty());
    }

    #[test]
    fn a_camera_without_permission_is_listed_as_such() {
        let bus = FakeBus::new(&["left"]);
        bus.with(|world| world.open_error = Some(13));
        assert_eq!(cameras(&bus)[0].access, Access::Denied);
        bus.with(|world| world.open_error = Some(16));
        assert!(matches!(&cameras(&bus)[0].access, Access::Failed(reason) if reason.contains("busy")));
    }
}
