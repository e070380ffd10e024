//! The bandwidth that modes need, and the problems of the ports that cameras use.

use super::ports::{RootPort, UsbDevice, root_port_name};
use crate::{CameraInfo, FourCc, Mode};

/// Bits per pixel of motion JPEG: pictures of fine texture take two, and cameras reserve more than their pictures take.
const JPEG_BITS_PER_PX: f64 = 3.0;
/// Bytes of headers per byte of a picture.
const HEADERS: f64 = 0.02;

/// The bandwidth that a mode needs, bytes per second; an estimate for motion JPEG. `None` for formats that cannot be
/// decoded.
#[must_use]
pub fn need_bytes_per_s(mode: &Mode) -> Option<f64> {
    let bits_per_px = match mode.format {
        FourCc::MJPG | FourCc::JPEG => JPEG_BITS_PER_PX,
        FourCc::YUYV | FourCc::Y16 => 16.0,
        FourCc::GREY => 8.0,
        _ => return None,
    };
    let [width, height] = mode.size.map(f64::from);
    Some(width * height * mode.frames_per_second * bits_per_px / 8.0 * (1.0 + HEADERS))
}

/// The problems of the USB ports of these cameras, with their solutions, one sentence each. Every camera is assumed to
/// capture in the mode [`Mode::preferred`].
#[must_use]
pub fn findings(ports: &[RootPort], cameras: &[CameraInfo]) -> Vec<String> {
    ports.iter().flat_map(|port| port_findings(port, cameras)).collect()
}

fn port_findings(port: &RootPort, cameras: &[CameraInfo]) -> Vec<String> {
    let mut found = Vec::new();
    let (mut needed, mut held, mut count) = (0.0, 0.0, 0);
    for camera in cameras {
        let Some(device) = device_of(port, camera) else { continue };
        // Bandwidth that is already reserved for this camera is available to it.
        (held, count) = (held + device.reserved_bytes_per_s, count + 1);
        let id = &camera.node.id;
        if device.is_slowed {
            found.push(format!(
                "{id} is connected at {} Mbit/s though it is a USB 2 device: use another cable, hub or port",
                device.speed_mbps
            ));
        }
        let Some(mode) = Mode::preferred(&camera.offers) else { continue };
        let Some(need) = need_bytes_per_s(&mode) else { continue };
        if let Some(most) = device.most_video_bytes_per_s.filter(|most| need > *most) {
            found.push(format!(
                "{id} can reserve {}, but {mode} needs {}: use MJPG, a smaller size or a lower rate",
                megabytes(most),
                megabytes(need)
            ));
        }
        needed += device.most_video_bytes_per_s.map_or(0.0, |most| need.min(most));
    }
    let free = port.capacity_bytes_per_s - port.reserved_bytes_per_s + held;
    if needed > free {
        let cameras = if count == 1 { "the camera needs".into() } else { format!("its {count} cameras need") };
        found.push(format!(
            "USB port {}: {cameras} {}, but {} can be reserved: use a smaller size, a lower rate, or ports of different USB \
             controllers",
            port.name,
            megabytes(needed),
            megabytes(free)
        ));
    }
    if count > 0 && port.current_ma > port.current_limit_ma {
        found.push(format!(
            "USB port {}: its devices may take {} mA, and it supplies {} mA: use a hub with its own power supply",
            port.name, port.current_ma, port.current_limit_ma
        ));
    }
    found
}

/// The USB device of a camera, if it is behind this port.
fn device_of<'a>(port: &'a RootPort, camera: &CameraInfo) -> Option<&'a UsbDevice> {
    let name = camera.node.usb_device.as_ref()?.file_name()?.to_string_lossy();
    let is_behind = root_port_name(&name).is_some_and(|root| root == port.name);
    port.devices.iter().find(|device| is_behind && device.name == name)
}

/// Bytes per second in words.
fn megabytes(bytes_per_s: f64) -> String {
    format!("{:.1} MB/s", bytes_per_s / 1e6)
}

#[cfg(test)]
mod tests {
    use super::super::ports::{root_ports, tests::sysfs};
    use super::*;
    use crate::{Access, Node, Offer, RateOffer, SizeOffer};

    fn mode(format: FourCc, size: [u32; 2], frames_per_second: f64) -> Mode {
        Mode { format, size, frames_per_second }
    }

    fn camera(usb: &str, offers: &[Mode]) -> CameraInfo {
        let node = Node {
            id: format!("camera-{usb}"),
            path: "/dev/video0".into(),
            card: "Touch Camera".into(),
            driver: "uvcvideo".into(),
            serial: None,
            index: 0,
            usb_device: Some(format!("/sys/devices/{usb}").into()),
            device: format!("/sys/devices/{usb}/{usb}:1.0").into(),
        };
        let offer = |mode: &Mode| Offer {
            format: mode.format,
            size: SizeOffer::One(mode.size),
            rates: RateOffer::List(vec![mode.frames_per_second]),
        };
        CameraInfo { node, access: Access::Open, offers: offers.iter().map(offer).collect() }
    }

    #[test]
    fn the_need_of_a_mode_is_its_pixels_times_its_rate() {
        let need = |mode| need_bytes_per_s(&mode).map(|need| (need / 1e5).round() / 10.0);
        assert_eq!(need(mode(FourCc::YUYV, [640, 480], 90.0)), Some(56.4));
        assert_eq!(need(mode(FourCc::MJPG, [640, 480], 90.0)), Some(10.6));
        assert_eq!(need(mode(FourCc(*b"H264"), [640, 480], 90.0)), None);
    }

    #[test]
    fn cameras_that_fit_their_port_are_fine() {
        let sys = sysfs(&[("1-1", "480", 0), ("1-2", "480", 0)]);
        let fast = mode(FourCc::MJPG, [640, 480], 90.0);
        assert!(findings(&root_ports(sys.path()), &[camera("1-1", &[fast]), camera("1-2", &[fast])]).is_empty());
        // A camera that captures already does not need its bandwidth again.
        let sys = sysfs(&[("1-1", "480", 2)]);
        assert!(findings(&root_ports(sys.path()), &[camera("1-1", &[fast])]).is_empty());
    }

    #[test]
    fn too_many_cameras_behind_one_port_are_found() {
        let names = ["1-1", "1-1.1", "1-1.2", "1-1.3", "1-1.4", "1-1.5"];
        let sys = sysfs(&names.map(|name| (name, "480", 0)));
        let fast = mode(FourCc::MJPG, [640, 480], 90.0);
        let cameras: Vec<CameraInfo> = names[1..].iter().map(|name| camera(name, &[fast])).collect();
        let found = findings(&root_ports(sys.path()), &cameras);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].starts_with("USB port 1-1: its 5 cameras need 52.9 MB/s, but 48.0 MB/s can be reserved"),
            "{found:?}"
        );
    }

    #[test]
    fn a_mode_beyond_the_largest_setting_of_the_camera_is_found() {
        let sys = sysfs(&[("1-1", "480", 0)]);
        let found = findings(&root_ports(sys.path()), &[camera("1-1", &[mode(FourCc::YUYV, [640, 480], 60.0)])]);
        assert_eq!(
            found,
            [
                "camera-1-1 can reserve 24.6 MB/s, but YUYV 640x480 px at 60 frames/s needs 37.6 MB/s: use MJPG, a smaller size or \
              a lower rate"
            ]
        );
    }

    #[test]
    fn a_camera_at_full_speed_and_too_much_current_are_found() {
        let sys = sysfs(&[("1-1", "12", 0)]);
        let found = findings(&root_ports(sys.path()), &[camera("1-1", &[])]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("connected at 12 Mbit/s though it is a USB 2 device"), "{found:?}");
        let mut ports = root_ports(sys.path());
        ports[0].current_ma = 750;
        assert!(findings(&ports, &[camera("1-1", &[])])[1].contains("may take 750 mA, and it supplies 500 mA"));
    }
}
