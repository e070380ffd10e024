//! Cameras: a list of those that are plugged in, their formats, and their frames.
//!
//! - [`cameras`] lists them and [`select`] finds one by its stable id, its serial number or a part of its name. A
//!   number, as in `/dev/video0`, can change when a device is plugged in, so it selects nothing.
//! - [`Camera`] captures: it sets the mode and locks the controls that the profile's `[capture]` gives, numbers the
//!   frames by the driver's count, and continues when an unplugged camera is plugged in again.
//! - [`usb`] computes the bandwidth of a USB port that is reserved, and the bandwidth that cameras need.
//!
//! [`open`] opens a camera of this machine, and [`CameraSource`] reads it like a recording.
//!
//! [`Device`] and [`Bus`] are the interface to the system. On Linux, [`Video4Linux`] implements it; elsewhere there are
//! no cameras. This crate decodes frames; it does not track, and starts no threads.

mod camera;
mod controls;
mod device;
mod error;
#[cfg(any(test, feature = "fake"))]
pub mod fake;
mod info;
mod live_source;
mod mode;
mod numbering;
mod select;
mod sysfs;
mod system;
pub mod usb;
#[cfg(target_os = "linux")]
mod v4l;
#[cfg(target_os = "linux")]
mod v4l_offers;

pub use camera::{Arrived, Camera, Captured, Counts, Event};
pub use device::{Buffer, Bus, Control, Device, Layout};
pub use error::CameraError;
pub use info::{Access, CameraInfo, cameras};
pub use live_source::CameraSource;
pub use mode::{FourCc, Mode, Offer, RateOffer, SizeOffer};
pub use select::select;
pub use sysfs::{Node, nodes};
pub use system::open;
#[cfg(target_os = "linux")]
pub use v4l::Video4Linux;
