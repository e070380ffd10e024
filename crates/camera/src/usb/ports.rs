//! The root ports of a machine, and their reserved bandwidth.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::descriptors::{Descriptors, Transfer, parse};
use crate::sysfs::text;

/// A port of the machine itself, with all devices behind it, including those behind hubs.
#[derive(Debug, Clone, PartialEq)]
pub struct RootPort {
    /// Its name in sysfs, as in `1-2`: bus 1, port 2.
    pub name: String,
    /// The speed of the device at the port, Mbit/s.
    pub speed_mbps: f64,
    /// The bandwidth that can be reserved, bytes per second.
    pub capacity_bytes_per_s: f64,
    /// The reserved bandwidth, bytes per second.
    pub reserved_bytes_per_s: f64,
    /// The current that the devices without their own power supply may draw, mA.
    pub current_ma: u32,
    /// The current that the port supplies, mA.
    pub current_limit_ma: u32,
    /// The devices behind it.
    pub devices: Vec<UsbDevice>,
}

/// A device behind a root port.
#[derive(Debug, Clone, PartialEq)]
pub struct UsbDevice {
    /// Its name in sysfs, as in `1-2.4`.
    pub name: String,
    /// The product's name, if the device has one.
    pub product: Option<String>,
    /// Its speed, Mbit/s.
    pub speed_mbps: f64,
    /// It is connected at a lower speed than it supports.
    pub is_slowed: bool,
    /// The bandwidth that is reserved for it, bytes per second.
    pub reserved_bytes_per_s: f64,
    /// The largest bandwidth that it can reserve for video, bytes per second; absent if it reserves none for video.
    pub most_video_bytes_per_s: Option<f64>,
}

/// The root ports that have a device, from this folder of sysfs (`/sys`).
#[must_use]
pub fn root_ports(sys: &Path) -> Vec<RootPort> {
    let folder = sys.join("bus/usb/devices");
    let mut ports: BTreeMap<String, Vec<(UsbDevice, Descriptors)>> = BTreeMap::new();
    for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if let (Some(port), Some(device)) = (root_port_name(&name), device(&folder, &name)) {
            ports.entry(port).or_default().push(device);
        }
    }
    ports.into_iter().filter_map(|(name, devices)| root_port(name, devices)).collect()
}

/// The root port that a USB device is behind, by the device's name in sysfs: `1-2` for `1-2.4.1`. `None` for interfaces and
/// for the root hubs themselves.
#[must_use]
pub fn root_port_name(device: &str) -> Option<String> {
    let is_device = !device.contains(':') && device.contains('-');
    is_device.then(|| device.split('.').next().unwrap_or(device).to_owned())
}

fn device(folder: &Path, name: &str) -> Option<(UsbDevice, Descriptors)> {
    let own = folder.join(name);
    let speed_mbps = text(&own.join("speed"))?.parse().ok()?;
    let descriptors = parse(&fs::read(own.join("descriptors")).unwrap_or_default());
    let configuration = text(&own.join("bConfigurationValue")).unwrap_or_else(|| "1".into());
    let in_force = |interface: u8| {
        let file = folder.join(format!("{name}:{configuration}.{interface}")).join("bAlternateSetting");
        text(&file).and_then(|setting| setting.parse().ok()).unwrap_or(0)
    };
    let reserved_bytes_per_s = descriptors.alternates.iter().filter(|one| in_force(one.interface) == one.setting);
    let reserved_bytes_per_s = reserved_bytes_per_s.map(|one| reserved(&one.endpoints, speed_mbps)).sum();
    let device = UsbDevice {
        name: name.into(),
        product: text(&own.join("product")),
        speed_mbps,
        is_slowed: descriptors.version >= 0x200 && speed_mbps < 100.0 && has_video(&descriptors),
        reserved_bytes_per_s,
        most_video_bytes_per_s: most_video(&descriptors, speed_mbps),
    };
    Some((device, descriptors))
}

fn reserved(endpoints: &[super::descriptors::Endpoint], speed_mbps: f64) -> f64 {
    endpoints.iter().map(|endpoint| endpoint.reserved_bytes_per_s(speed_mbps)).sum()
}

fn has_video(descriptors: &Descriptors) -> bool {
    descriptors.alternates.iter().any(super::descriptors::Alternate::is_video_stream)
}

fn most_video(descriptors: &Descriptors, speed_mbps: f64) -> Option<f64> {
    let streams = descriptors.alternates.iter().filter(|one| one.is_video_stream());
    let isochronous = streams.filter(|one| one.endpoints.iter().any(|end| end.transfer == Transfer::Isochronous));
    isochronous.map(|one| reserved(&one.endpoints, speed_mbps)).reduce(f64::max)
}

fn root_port(name: String, mut devices: Vec<(UsbDevice, Descriptors)>) -> Option<RootPort> {
    devices.sort_by(|(a, _), (b, _)| a.name.cmp(&b.name));
    let speed_mbps = devices.iter().find(|(device, _)| device.name == name)?.0.speed_mbps;
    // A hub with its own supply powers the devices behind it.
    let supplies: Vec<String> = devices
        .iter()
        .filter(|(_, descriptors)| descriptors.is_self_powered)
        .map(|(device, _)| format!("{}.", device.name))
        .collect();
    let is_powered_elsewhere = |device: &UsbDevice| supplies.iter().any(|hub| device.name.starts_with(hub.as_str()));
    let current_ma = devices
        .iter()
        .filter(|(device, descriptors)| !descriptors.is_self_powered && !is_powered_elsewhere(device))
        .map(|(device, descriptors)| u32::from(descriptors.max_power) * if device.speed_mbps >= 5000.0 { 8 } else { 2 })
        .sum();
    let devices: Vec<UsbDevice> = devices.into_iter().map(|(device, _)| device).collect();
    Some(RootPort {
        name,
        speed_mbps,
        capacity_bytes_per_s: capacity_bytes_per_s(speed_mbps),
        reserved_bytes_per_s: devices.iter().map(|device| device.reserved_bytes_per_s).sum(),
        current_ma,
        current_limit_ma: if speed_mbps >= 5000.0 { 900 } else { 500 },
        devices,
    })
}

/// The bandwidth that the standards allow periodic transfers to reserve: 90 % of full speed and of USB 3, 80 % of high
/// speed. USB 3 sends 10 bits per byte.
fn capacity_bytes_per_s(speed_mbps: f64) -> f64 {
    let (bits, share) = match speed_mbps {
        speed if speed >= 5000.0 => (10.0, 0.9),
        speed if speed >= 480.0 => (8.0, 0.8),
        _ => (8.0, 0.9),
    };
    speed_mbps * 1e6 / bits * share
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::descriptors::camera;
    use super::*;
    use std::path::PathBuf;
    use tempfile::TempDir;

    /// A sysfs with a device per name, and the alternate setting of its streaming interface.
    pub(in super::super) fn sysfs(devices: &[(&str, &str, u8)]) -> TempDir {
        let sys = TempDir::new().unwrap();
        let folder: PathBuf = sys.path().join("bus/usb/devices");
        for (name, speed, setting) in devices {
            let own = folder.join(name);
            fs::create_dir_all(&own).unwrap();
            fs::write(own.join("speed"), format!("{speed}\n")).unwrap();
            fs::write(own.join("bConfigurationValue"), "1\n").unwrap();
            fs::write(own.join("product"), "Touch Camera\n").unwrap();
            let is_hub = devices.iter().any(|(other, ..)| other.starts_with(&format!("{name}.")));
            let hub = [[18, 1, 0, 2].as_slice(), &[0; 14], &[9, 2, 0, 0, 1, 1, 0, 0xc0, 0]].concat();
            fs::write(own.join("descriptors"), if is_hub { hub } else { camera() }).unwrap();
            let stream = folder.join(format!("{name}:1.1"));
            fs::create_dir_all(&stream).unwrap();
            fs::write(stream.join("bAlternateSetting"), format!(" {setting}\n")).unwrap();
        }
        sys
    }

    #[test]
    fn reserved_bandwidth_is_summed_behind_each_root_port() {
        let sys = sysfs(&[
            ("usb1", "480", 0),
            ("1-1", "480", 2),
            ("1-2", "480", 0),
            ("1-2.1", "480", 1),
            ("1-2.4", "480", 2),
        ]);
        let ports = root_ports(sys.path());
        let names: Vec<&str> = ports.iter().map(|port| port.name.as_str()).collect();
        assert_eq!(names, ["1-1", "1-2"]);
        // The interrupt endpoint of each camera takes 4000 bytes per second.
        let reserved = ports.iter().map(|port| port.reserved_bytes_per_s.round() as u32).collect::<Vec<_>>();
        assert_eq!(reserved, [24_576_000 + 4000, 4_096_000 + 24_576_000 + 8000]);
        assert_eq!(ports[1].devices.len(), 3);
        assert!((ports[0].capacity_bytes_per_s - 48e6).abs() < 1.0);
        assert_eq!(ports[0].devices[0].most_video_bytes_per_s.map(f64::round), Some(24_576_000.0));
    }

    #[test]
    fn a_hub_with_its_own_supply_powers_what_is_behind_it() {
        let sys = sysfs(&[("1-1", "480", 0), ("1-2", "480", 0), ("1-2.1", "480", 0)]);
        let ports = root_ports(sys.path());
        assert_eq!([ports[0].current_ma, ports[1].current_ma], [500, 0]);
        assert_eq!(ports[0].current_limit_ma, 500);
    }

    #[test]
    fn a_root_port_is_the_start_of_a_name() {
        assert_eq!(root_port_name("2-1.4.3").as_deref(), Some("2-1"));
        assert_eq!(root_port_name("2-1").as_deref(), Some("2-1"));
        assert_eq!((root_port_name("usb2"), root_port_name("2-1:1.0")), (None, None));
    }

    #[test]
    fn a_machine_without_usb_has_no_ports() {
        assert!(root_ports(TempDir::new().unwrap().path()).is_empty());
    }
}
