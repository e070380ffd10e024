//! Video nodes and their stable ids, from the files of the system.
//!
//! udev makes links with stable names: `/dev/v4l/by-id` from maker, model and serial number, `/dev/v4l/by-path` from
//! the port. Two cameras with the same serial number share one name by id, so they are distinguished by their ports.
//! Where udev does not run, as in a container, the id is made from the port's name in sysfs.

use std::fs;
use std::path::{Path, PathBuf};

/// A video node: that of a camera's images, or another node of the same camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// The id, which stays the same when cameras are plugged in or the system starts again.
    pub id: String,
    /// The node to open.
    pub path: PathBuf,
    /// The name of the camera.
    pub card: String,
    /// The kernel's driver.
    pub driver: String,
    /// The serial number of the USB device, if it has one.
    pub serial: Option<String>,
    /// The number of the node within its camera.
    pub index: u32,
    /// The folder of the USB device in sysfs; absent for other cameras.
    pub usb_device: Option<PathBuf>,
    /// The folder of the device in sysfs, shared by all nodes of a camera.
    pub device: PathBuf,
}

/// The video nodes of a system, in order of their numbers. The arguments are its folders `/dev` and `/sys`.
#[must_use]
pub fn nodes(dev: &Path, sys: &Path) -> Vec<Node> {
    let class = sys.join("class/video4linux");
    let mut names: Vec<(u32, String)> = names(&class).into_iter().filter_map(numbered).collect();
    names.sort();
    let mut nodes: Vec<Node> = names.iter().map(|(_, name)| node(dev, &class, name)).collect();
    let twins: Vec<usize> = (0..nodes.len()).filter(|&index| has_twin(&nodes, index)).collect();
    for index in twins {
        let node = &nodes[index];
        nodes[index].id = by_port(dev, node);
    }
    nodes
}

fn numbered(name: String) -> Option<(u32, String)> {
    Some((name.strip_prefix("video")?.parse().ok()?, name))
}

fn node(dev: &Path, class: &Path, name: &str) -> Node {
    let folder = class.join(name);
    // A virtual device has no folder.
    let device = fs::canonicalize(folder.join("device")).unwrap_or_default();
    let mut above = device.ancestors().filter(|folder| folder.is_absolute());
    let usb_device = above.find(|folder| folder.join("idVendor").is_file()).map(Path::to_owned);
    let driver = fs::canonicalize(device.join("driver")).ok();
    let driver = driver.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
    let mut node = Node {
        id: String::new(),
        path: dev.join(name),
        card: text(&folder.join("name")).unwrap_or_default(),
        driver: driver.unwrap_or_default(),
        serial: usb_device.as_deref().and_then(|usb| text(&usb.join("serial"))),
        index: text(&folder.join("index")).and_then(|index| index.parse().ok()).unwrap_or(0),
        usb_device,
        device,
    };
    node.id = link(&dev.join("v4l/by-id"), name).unwrap_or_else(|| by_port(dev, &node));
    node
}

/// The id of the port.
fn by_port(dev: &Path, node: &Node) -> String {
    let name = node.path.file_name().unwrap_or_default().to_string_lossy();
    link(&dev.join("v4l/by-path"), &name).unwrap_or_else(|| {
        let port = node.device.file_name().map(|port| port.to_string_lossy().into_owned());
        let port = port.unwrap_or_else(|| node.card.replace(' ', "_"));
        format!("path-{port}-video-index{}", node.index)
    })
}

/// Whether another camera has the same name and the same serial number; two absent numbers count as the same.
fn has_twin(nodes: &[Node], index: usize) -> bool {
    let node = &nodes[index];
    let is_twin = |other: &Node| {
        (&other.card, &other.serial, other.index) == (&node.card, &node.serial, node.index)
            && other.usb_device.is_some()
            && other.device != node.device
    };
    node.usb_device.is_some() && nodes.iter().any(is_twin)
}

/// The first link in a folder that leads to the node of this name.
fn link(folder: &Path, name: &str) -> Option<String> {
    let mut links = names(folder);
    links.sort();
    let leads_there = |link: &String| fs::read_link(folder.join(link)).is_ok_and(|target| target.ends_with(name));
    links.into_iter().find(leads_there)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok()).collect()
}

/// The text of a small file, without white space around it; `None` if it is absent or empty.
pub(crate) fn text(file: &Path) -> Option<String> {
    let bytes = fs::read(file).ok()?;
    let text = String::from_utf8_lossy(&bytes).trim().to_owned();
    (!text.is_empty()).then_some(text)
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;
    use tempfile::TempDir;

    struct Machine(TempDir);

    impl Machine {
        fn new() -> Self {
            Self(TempDir::new().unwrap())
        }

        fn dev(&self) -> PathBuf {
            self.0.path().join("dev")
        }

        fn sys(&self) -> PathBuf {
            self.0.path().join("sys")
        }

        /// A camera at a USB port with a node of images and one of metadata.
        fn plug_in(&self, port: &str, number: u32, serial: &str) {
            let usb = self.sys().join("devices/usb1").join(port);
            let interface = usb.join(format!("{port}:1.0"));
            fs::create_dir_all(&interface).unwrap();
            fs::write(usb.join("idVendor"), "0c45\n").unwrap();
            fs::write(usb.join("serial"), format!("{serial}\n")).unwrap();
            let driver = self.sys().join("drivers/uvcvideo");
            fs::create_dir_all(&driver).unwrap();
            symlink(driver, interface.join("driver")).unwrap();
            for index in 0..2 {
                let class = self.sys().join(format!("class/video4linux/video{}", number + index));
                fs::create_dir_all(&class).unwrap();
                fs::write(class.join("name"), "Touch Camera: Touch Camera\n").unwrap();
                fs::write(class.join("index"), format!("{index}\n")).unwrap();
                symlink(&interface, class.join("device")).unwrap();
            }
        }

        fn link(&self, kind: &str, name: &str, node: &str) {
            let folder = self.dev().join("v4l").join(kind);
            fs::create_dir_all(&folder).unwrap();
            symlink(format!("../../{node}"), folder.join(name)).unwrap();
        }

        fn ids(&self) -> Vec<String> {
            nodes(&self.dev(), &self.sys()).into_iter().map(|node| node.id).collect()
        }
    }

    #[test]
    fn a_node_has_its_id_its_driver_and_its_serial_number() {
        let machine = Machine::new();
        machine.plug_in("1-2", 0, "SN7");
        machine.link("by-id", "usb-Maker_Touch_SN7-video-index0", "video0");
        machine.link("by-path", "pci-0-usb-0:2:1.0-video-index0", "video0");
        let nodes = nodes(&machine.dev(), &machine.sys());
        assert_eq!(nodes.len(), 2);
        let node = &nodes[0];
        assert_eq!(node.id, "usb-Maker_Touch_SN7-video-index0");
        assert_eq!((node.card.as_str(), node.driver.as_str()), ("Touch Camera: Touch Camera", "uvcvideo"));
        assert_eq!((node.serial.as_deref(), node.index), (Some("SN7"), 0));
        assert!(node.usb_device.as_ref().unwrap().ends_with("1-2"));
        assert_eq!(node.path, machine.dev().join("video0"));
    }

    #[test]
    fn numbers_are_ordered_as_numbers() {
        let machine = Machine::new();
        machine.plug_in("1-2", 9, "A");
        machine.plug_in("1-3", 2, "B");
        assert_eq!(
            machine.ids(),
            [
                "path-1-3:1.0-video-index0",
                "path-1-3:1.0-video-index1",
                "path-1-2:1.0-video-index0",
                "path-1-2:1.0-video-index1"
            ]
        );
    }

    #[test]
    fn cameras_with_the_same_serial_number_are_told_apart_by_their_ports() {
        let machine = Machine::new();
        machine.plug_in("1-2", 0, "0001");
        machine.plug_in("1-3", 2, "0001");
        machine.link("by-id", "usb-Maker_Touch_0001-video-index0", "video2");
        machine.link("by-path", "port2", "video0");
        machine.link("by-path", "port3", "video2");
        assert_eq!(machine.ids()[0], "port2");
        assert_eq!(machine.ids()[2], "port3");
    }

    #[test]
    fn a_machine_without_cameras_has_no_nodes() {
        assert!(Machine::new().ids().is_empty());
    }
}
