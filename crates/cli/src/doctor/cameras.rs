//! The cameras of this machine, and the USB ports that they are plugged into.

use std::fmt;

use fingervision_camera::usb::{RootPort, UsbDevice, findings, need_bytes_per_s};
use fingervision_camera::{Access, CameraError, CameraInfo, Mode, Offer, SizeOffer};
use serde::Serialize;

/// Cameras, ports, and their problems.
#[derive(Debug, Serialize)]
pub(super) struct CameraReport {
    cameras: Vec<CameraState>,
    usb_ports: Vec<PortState>,
    /// The problems and their solutions, one sentence each.
    problems: Vec<String>,
}

#[derive(Debug, Serialize)]
struct CameraState {
    id: String,
    name: String,
    driver: String,
    serial: Option<String>,
    node: String,
    is_usable: bool,
    formats: Vec<FormatState>,
    /// The mode in which it captures if the profile names none.
    mode: Option<String>,
}

#[derive(Debug, Serialize)]
struct FormatState {
    format: String,
    /// Whether frames of this format can be decoded.
    is_read: bool,
    /// At the highest rate; absent for formats that cannot be decoded, and for ranges of sizes.
    needs_mb_per_s: Option<f64>,
}

#[derive(Debug, Serialize)]
struct PortState {
    name: String,
    speed_mbit_per_s: f64,
    capacity_mb_per_s: f64,
    reserved_mb_per_s: f64,
    left_mb_per_s: f64,
    current_ma: u32,
    current_limit_ma: u32,
    devices: Vec<String>,
}

impl CameraReport {
    /// Finds the cameras and ports.
    #[cfg(target_os = "linux")]
    pub(super) fn find() -> Self {
        let infos = fingervision_camera::cameras(&fingervision_camera::Video4Linux::default());
        let ports = fingervision_camera::usb::root_ports(std::path::Path::new("/sys"));
        Self::new(&infos, &ports)
    }

    /// There are none on this system.
    #[cfg(not(target_os = "linux"))]
    pub(super) fn find() -> Self {
        Self::new(&[], &[])
    }

    fn new(infos: &[CameraInfo], ports: &[RootPort]) -> Self {
        let mut problems: Vec<String> = infos.iter().filter_map(access_problem).collect();
        problems.extend(findings(ports, infos));
        let names = infos.iter().filter_map(|info| info.node.usb_device.as_ref()?.file_name());
        let names: Vec<_> = names.map(|name| name.to_string_lossy().into_owned()).collect();
        let has_camera = |port: &&RootPort| port.devices.iter().any(|device| names.contains(&device.name));
        Self {
            cameras: infos.iter().map(CameraState::new).collect(),
            usb_ports: ports.iter().filter(has_camera).map(PortState::new).collect(),
            problems,
        }
    }
}

fn access_problem(info: &CameraInfo) -> Option<String> {
    let id = &info.node.id;
    match &info.access {
        Access::Open if Mode::preferred(&info.offers).is_none() => {
            Some(format!("{id} offers no format that is read: MJPG, YUYV, GREY or Y16"))
        }
        Access::Open => None,
        Access::Denied => {
            let denied = CameraError::Denied { camera: id.clone(), node: info.node.path.clone() };
            Some(format!("{denied}: {}", denied.hint()))
        }
        Access::Failed(reason) => Some(format!("{id} cannot be opened: {reason}: unplug it and plug it in again")),
    }
}

impl CameraState {
    fn new(info: &CameraInfo) -> Self {
        Self {
            id: info.node.id.clone(),
            name: info.node.card.clone(),
            driver: info.node.driver.clone(),
            serial: info.node.serial.clone(),
            node: info.node.path.display().to_string(),
            is_usable: info.access == Access::Open,
            formats: info.offers.iter().map(FormatState::new).collect(),
            mode: Mode::preferred(&info.offers).map(|mode| mode.to_string()),
        }
    }

    /// The codes of the formats that cannot be decoded, each once.
    fn unread_formats(&self) -> Vec<&str> {
        let unread = self.formats.iter().filter(|format| !format.is_read);
        let mut codes: Vec<&str> = unread.filter_map(|format| format.format.split(' ').next()).collect();
        codes.dedup();
        codes
    }
}

impl FormatState {
    fn new(offer: &Offer) -> Self {
        let fastest = match (offer.size, offer.rates.highest()) {
            (SizeOffer::One(size), Some(frames_per_second)) => {
                Some(Mode { format: offer.format, size, frames_per_second })
            }
            _ => None,
        };
        let needs_mb_per_s = fastest.as_ref().and_then(need_bytes_per_s).map(rounded_megabytes);
        Self { format: offer.to_string(), is_read: offer.format.coding(false).is_some(), needs_mb_per_s }
    }
}

impl PortState {
    fn new(port: &RootPort) -> Self {
        let left = (port.capacity_bytes_per_s - port.reserved_bytes_per_s).max(0.0);
        let name = |device: &UsbDevice| match &device.product {
            Some(product) => format!("{} {product}", device.name),
            None => device.name.clone(),
        };
        Self {
            name: port.name.clone(),
            speed_mbit_per_s: port.speed_mbps,
            capacity_mb_per_s: rounded_megabytes(port.capacity_bytes_per_s),
            reserved_mb_per_s: rounded_megabytes(port.reserved_bytes_per_s),
            left_mb_per_s: rounded_megabytes(left),
            current_ma: port.current_ma,
            current_limit_ma: port.current_limit_ma,
            devices: port.devices.iter().map(name).collect(),
        }
    }
}

/// Megabytes with one decimal.
fn rounded_megabytes(bytes: f64) -> f64 {
    (bytes / 1e5).round() / 10.0
}

/// Lines for the report of `doctor`, whose first column has 11 characters.
impl fmt::Display for CameraReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.cameras.is_empty() {
            let none = CameraError::NoCamera;
            return writeln!(f, "cameras    none found: {}", none.hint());
        }
        for (count, camera) in self.cameras.iter().enumerate() {
            writeln!(f, "{:10} {}", if count == 0 { "cameras" } else { "" }, camera.id)?;
            let serial = camera.serial.as_ref().map(|serial| format!(", serial number {serial}")).unwrap_or_default();
            let driver = if camera.driver.is_empty() { "unknown" } else { &camera.driver };
            writeln!(f, "             {}, driver {driver}{serial}, now {}", camera.name, camera.node)?;
            for FormatState { format, needs_mb_per_s, .. } in camera.formats.iter().filter(|format| format.is_read) {
                let needs = needs_mb_per_s.map(|needs| format!("; needs up to {needs:.1} MB/s")).unwrap_or_default();
                writeln!(f, "             {format}{needs}")?;
            }
            let unread = camera.unread_formats();
            if !unread.is_empty() {
                writeln!(f, "             not read: {}", unread.join(", "))?;
            }
            if let Some(mode) = &camera.mode {
                writeln!(f, "             captures {mode} unless [capture] in the profile says otherwise")?;
            }
        }
        for (count, port) in self.usb_ports.iter().enumerate() {
            write!(f, "{:10} ", if count == 0 { "USB ports" } else { "" })?;
            write!(f, "{}, {} Mbit/s: {:.1} MB/s left, ", port.name, port.speed_mbit_per_s, port.left_mb_per_s)?;
            write!(f, "{:.1} of {:.1} reserved; ", port.reserved_mb_per_s, port.capacity_mb_per_s)?;
            writeln!(f, "{} of {} mA: {}", port.current_ma, port.current_limit_ma, port.devices.join(", "))?;
        }
        for problem in &self.problems {
            writeln!(f, "problem    {problem}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fingervision_camera::{FourCc, Node, RateOffer};

    fn camera(access: Access) -> CameraInfo {
        let node = Node {
            id: "usb-Maker_Touch_SN7-video-index0".into(),
            path: "/dev/video0".into(),
            card: "Touch Camera".into(),
            driver: "uvcvideo".into(),
            serial: Some("SN7".into()),
            index: 0,
            usb_device: Some("/sys/devices/usb1/1-2".into()),
            device: "/sys/devices/usb1/1-2/1-2:1.0".into(),
        };
        let offer = |format, rates: &[f64]| Offer {
            format,
            size: SizeOffer::One([640, 480]),
            rates: RateOffer::List(rates.to_vec()),
        };
        let offers = vec![offer(FourCc::MJPG, &[90.0, 30.0]), offer(FourCc(*b"H264"), &[30.0])];
        let offers = if access == Access::Open { offers } else { Vec::new() };
        CameraInfo { node, access, offers }
    }

    fn port() -> RootPort {
        let device = UsbDevice {
            name: "1-2".into(),
            product: Some("Touch Camera".into()),
            speed_mbps: 480.0,
            is_slowed: false,
            reserved_bytes_per_s: 4000.0,
            most_video_bytes_per_s: Some(24_576_000.0),
        };
        RootPort {
            name: "1-2".into(),
            speed_mbps: 480.0,
            capacity_bytes_per_s: 48e6,
            reserved_bytes_per_s: 20e6,
            current_ma: 500,
            current_limit_ma: 500,
            devices: vec![device],
        }
    }

    #[test]
    fn a_camera_is_shown_with_its_formats_and_its_port() {
        let shown = CameraReport::new(&[camera(Access::Open)], &[port()]).to_string();
        assert_eq!(
            shown,
            "cameras    usb-Maker_Touch_SN7-video-index0\n             \
             Touch Camera, driver uvcvideo, serial number SN7, now /dev/video0\n             \
             MJPG 640x480 at 90, 30 frames/s; needs up to 10.6 MB/s\n             \
             not read: H264\n             \
             captures MJPG 640x480 px at 90 frames/s unless [capture] in the profile says otherwise\n\
             USB ports  1-2, 480 Mbit/s: 28.0 MB/s left, 20.0 of 48.0 reserved; 500 of 500 mA: 1-2 Touch Camera\n"
        );
    }

    #[test]
    fn a_camera_without_permission_is_a_problem_with_a_remedy() {
        let shown = CameraReport::new(&[camera(Access::Denied)], &[port()]).to_string();
        let problem = shown.lines().last().unwrap();
        assert!(
            problem.starts_with("problem    usb-Maker_Touch_SN7-video-index0: no permission to open /dev/video0: ")
        );
        assert!(problem.contains("sudo usermod -aG video"), "{problem}");
    }

    #[test]
    fn no_camera_is_one_line() {
        let shown = CameraReport::new(&[], &[port()]).to_string();
        assert!(shown.starts_with("cameras    none found: "), "{shown}");
        assert_eq!(shown.lines().count(), 1);
    }

    #[test]
    fn too_little_bandwidth_is_a_problem() {
        let mut full = port();
        full.reserved_bytes_per_s = 40e6;
        let shown = CameraReport::new(&[camera(Access::Open)], &[full]).to_string();
        assert!(
            shown.contains("problem    USB port 1-2: the camera needs 10.6 MB/s, but 8.0 MB/s can be reserved"),
            "{shown}"
        );
    }
}
