//! Opens a camera and starts it.

use fingervision_source::CameraLayout;
use fingervision_touch::CaptureSection;

use crate::controls::lock;
use crate::error::NO_SPACE;
use crate::mode::{Wish, choose, is_same_rate, rate};
use crate::{Bus, CameraError, Device, FourCc, Layout, Node, Offer};

/// A camera that has started.
pub(super) struct Started {
    pub(super) device: Box<dyn Device>,
    pub(super) layout: Layout,
    pub(super) frame_layout: CameraLayout,
    /// Settings that differ from the requested ones.
    pub(super) remarks: Vec<String>,
}

pub(super) fn start(bus: &dyn Bus, node: &Node, capture: &CaptureSection) -> Result<Started, CameraError> {
    let io = |doing| move |error| CameraError::io(&node.id, node.path.clone(), doing, error);
    let mut device = bus.open(&node.path).map_err(io("open"))?;
    let offers = device.offers().map_err(io("list formats"))?;
    let not_offered = || not_offered(node, capture, &offers);
    // An unknown name counts as a format that the camera does not offer.
    let format = capture.format.as_deref().map(|name| FourCc::from_name(name).ok_or_else(not_offered)).transpose()?;
    let wish = Wish { format, size: capture.size_px, frames_per_second: capture.frames_per_second };
    let mode = choose(&offers, wish).ok_or_else(not_offered)?;
    let layout = device.set_mode(mode).map_err(io("set the format"))?;
    if (layout.mode.format, layout.mode.size) != (mode.format, mode.size) {
        return Err(not_offered());
    }
    let mut remarks = Vec::new();
    if !is_same_rate(layout.mode.frames_per_second, mode.frames_per_second) {
        let (found, wanted) = (rate(layout.mode.frames_per_second), rate(mode.frames_per_second));
        remarks.push(format!("the rate is {found} instead of {wanted}: the driver chose it"));
    }
    remarks.extend(lock(device.as_mut(), capture).map_err(io("list controls"))?);
    device.start().map_err(|error| match error.raw_os_error() {
        Some(NO_SPACE) => CameraError::NoBandwidth { camera: node.id.clone(), mode },
        _ => io("start")(error),
    })?;
    let frame_layout = frame_layout(&layout).ok_or_else(not_offered)?;
    Ok(Started { device, layout, frame_layout, remarks })
}

fn frame_layout(layout: &Layout) -> Option<CameraLayout> {
    let coding = layout.mode.format.coding(layout.is_full_range)?;
    let [width, height] = layout.mode.size.map(|side| side as usize);
    Some(CameraLayout { coding, width, height, row_bytes: layout.row_bytes as usize })
}

/// The largest number of offers that an error lists.
const MOST_NAMED: usize = 12;

fn not_offered(node: &Node, capture: &CaptureSection, offers: &[Offer]) -> CameraError {
    let size = capture.size_px.map(|[width, height]| format!("{width}x{height} px"));
    let parts = [capture.format.clone(), size, capture.frames_per_second.map(rate)];
    let wanted: Vec<String> = parts.into_iter().flatten().collect();
    let wanted = if wanted.is_empty() { "a format that is read".into() } else { wanted.join(" ") };
    let mut offered: Vec<String> = offers.iter().take(MOST_NAMED).map(ToString::to_string).collect();
    match offers.len() {
        0 => offered.push("nothing".into()),
        count if count > MOST_NAMED => offered.push(format!("{} more", count - MOST_NAMED)),
        _ => (),
    }
    CameraError::NotOffered { camera: node.id.clone(), wanted, offered }
}
