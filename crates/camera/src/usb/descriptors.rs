//! Reads the binary descriptors of a USB device.

/// A USB device, by its descriptors.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Descriptors {
    /// The USB version in binary-coded decimals, as in `0x0200`.
    pub(super) version: u16,
    /// The device has its own power supply.
    pub(super) is_self_powered: bool,
    /// The current that it may draw, in units that depend on its speed.
    pub(super) max_power: u8,
    pub(super) alternates: Vec<Alternate>,
}

/// An alternate setting of an interface.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Alternate {
    pub(super) interface: u8,
    pub(super) setting: u8,
    pub(super) class: [u8; 2],
    pub(super) endpoints: Vec<Endpoint>,
}

impl Alternate {
    /// Whether it streams video.
    pub(super) fn is_video_stream(&self) -> bool {
        self.class == [0x0e, 0x02]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Transfer {
    Control,
    Isochronous,
    Bulk,
    Interrupt,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Endpoint {
    pub(super) transfer: Transfer,
    max_packet: u16,
    interval: u8,
    /// Bytes per interval at USB 3 speed.
    super_speed_bytes: Option<u16>,
}

impl Endpoint {
    /// Bytes per second that are reserved for it at this speed.
    pub(super) fn reserved_bytes_per_s(self, speed_mbps: f64) -> f64 {
        let exponential = |per_second: f64| per_second / f64::from(1u32 << (self.interval.clamp(1, 16) - 1));
        let per_second = match self.transfer {
            Transfer::Control | Transfer::Bulk => return 0.0,
            _ if speed_mbps > 100.0 => exponential(8000.0),
            Transfer::Isochronous => exponential(1000.0),
            Transfer::Interrupt => 1000.0 / f64::from(self.interval.max(1)),
        };
        let packet = self.max_packet & 0x7ff;
        // Up to three packets per microframe.
        let packets = 1 + (self.max_packet >> 11 & 3);
        let bytes = self.super_speed_bytes.map_or_else(|| u32::from(packet) * u32::from(packets), u32::from);
        f64::from(bytes) * per_second
    }
}

/// Reads descriptors as sysfs gives them: the device's, then those of its configurations. Descriptors behind a damaged
/// one are ignored.
pub(super) fn parse(bytes: &[u8]) -> Descriptors {
    let mut found = Descriptors::default();
    let mut rest = bytes;
    let mut is_first_configuration = true;
    while let [length, kind, ..] = *rest {
        let Some((descriptor, behind)) = rest.split_at_checked(usize::from(length)) else { break };
        if length < 2 {
            break;
        }
        rest = behind;
        match (kind, descriptor) {
            (1, &[_, _, low, high, ..]) => found.version = u16::from_le_bytes([low, high]),
            (2, &[_, _, _, _, _, _, _, attributes, power, ..]) if is_first_configuration => {
                is_first_configuration = false;
                (found.is_self_powered, found.max_power) = (attributes & 0x40 != 0, power);
            }
            // Another configuration is not in force.
            (2, _) => break,
            (4, &[_, _, interface, setting, _, class, subclass, ..]) => {
                found.alternates.push(Alternate {
                    interface,
                    setting,
                    class: [class, subclass],
                    endpoints: Vec::new(),
                });
            }
            (5, &[_, _, _, attributes, low, high, interval, ..]) => {
                let transfer = match attributes & 3 {
                    0 => Transfer::Control,
                    1 => Transfer::Isochronous,
                    2 => Transfer::Bulk,
                    _ => Transfer::Interrupt,
                };
                let max_packet = u16::from_le_bytes([low, high]);
                let endpoint = Endpoint { transfer, max_packet, interval, super_speed_bytes: None };
                if let Some(alternate) = found.alternates.last_mut() {
                    alternate.endpoints.push(endpoint);
                }
            }
            (0x30, &[_, _, _, _, low, high, ..]) => {
                let endpoint = found.alternates.last_mut().and_then(|alternate| alternate.endpoints.last_mut());
                if let Some(endpoint) = endpoint {
                    endpoint.super_speed_bytes = Some(u16::from_le_bytes([low, high]));
                }
            }
            _ => (),
        }
    }
    found
}

/// A camera of USB 2: control with an interrupt endpoint, streaming with a small and a large alternate setting.
#[cfg(test)]
pub(super) fn camera() -> Vec<u8> {
    let mut bytes = vec![18, 1, 0x00, 0x02];
    bytes.resize(18, 0);
    bytes.extend([9, 2, 0, 0, 2, 1, 0, 0x80, 250]);
    bytes.extend([9, 4, 0, 0, 1, 0x0e, 0x01, 0, 0]);
    bytes.extend([7, 5, 0x83, 3, 16, 0, 6]);
    bytes.extend([9, 4, 1, 0, 0, 0x0e, 0x02, 0, 0]);
    bytes.extend([9, 4, 1, 1, 1, 0x0e, 0x02, 0, 0]);
    bytes.extend([7, 5, 0x81, 5, 0x00, 0x02, 1]); // 512 bytes
    bytes.extend([9, 4, 1, 2, 1, 0x0e, 0x02, 0, 0]);
    bytes.extend([7, 5, 0x81, 5, 0x00, 0x14, 1]); // 3 times 1024 bytes
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cameras_alternate_settings_and_their_bandwidth_are_read() {
        let found = parse(&camera());
        assert_eq!((found.version, found.is_self_powered, found.max_power), (0x200, false, 250));
        let settings: Vec<[u8; 2]> = found.alternates.iter().map(|one| [one.interface, one.setting]).collect();
        assert_eq!(settings, [[0, 0], [1, 0], [1, 1], [1, 2]]);
        let reserved = |index: usize| {
            let endpoints = &found.alternates[index].endpoints;
            endpoints.iter().map(|endpoint| endpoint.reserved_bytes_per_s(480.0)).sum::<f64>()
        };
        // The interrupt endpoint: 16 bytes every 32 microframes.
        assert_eq!([0, 1, 2, 3].map(|index| reserved(index).round() as u32), [4000, 0, 4_096_000, 24_576_000]);
        assert!(found.alternates[3].is_video_stream() && !found.alternates[0].is_video_stream());
    }

    #[test]
    fn speed_changes_the_unit_of_intervals() {
        let endpoint = |transfer, interval| Endpoint { transfer, max_packet: 100, interval, super_speed_bytes: None };
        let rate = |endpoint: Endpoint, speed| endpoint.reserved_bytes_per_s(speed).round() as u32;
        assert_eq!(rate(endpoint(Transfer::Interrupt, 10), 12.0), 10_000);
        assert_eq!(rate(endpoint(Transfer::Isochronous, 1), 12.0), 100_000);
        assert_eq!(rate(endpoint(Transfer::Isochronous, 4), 480.0), 100_000);
        assert_eq!(rate(endpoint(Transfer::Bulk, 1), 480.0), 0);
        let fast = Endpoint { super_speed_bytes: Some(48 * 1024), ..endpoint(Transfer::Isochronous, 1) };
        assert_eq!(rate(fast, 5000.0), 393_216_000);
    }

    #[test]
    fn a_companion_gives_the_bytes_of_usb_3() {
        let mut bytes = vec![9, 4, 1, 1, 1, 0x0e, 0x02, 0, 0];
        bytes.extend([7, 5, 0x81, 5, 0x00, 0x04, 1]);
        bytes.extend([6, 0x30, 11, 3, 0x00, 0xc0]);
        assert_eq!(parse(&bytes).alternates[0].endpoints[0].super_speed_bytes, Some(48 * 1024));
    }

    #[test]
    fn damaged_descriptors_end_without_a_panic() {
        let whole = camera();
        for length in 0..whole.len() {
            parse(&whole[..length]);
            for value in [0, 1, 0xff] {
                let mut changed = whole.clone();
                changed[length] = value;
                parse(&changed);
            }
        }
    }
}
