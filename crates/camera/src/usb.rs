//! The reserved bandwidth of each USB root port, and the bandwidth that cameras need.
//!
//! USB reserves bandwidth for isochronous and interrupt endpoints before they start: their packet size times their
//! rate. A camera offers several alternate settings of its streaming interface with packets of different sizes; its
//! driver selects one that is large enough for the mode. If the port has too little left, the start fails, and the
//! system's message is "no space left on device". The reserved bandwidth follows from the descriptors of all devices
//! behind a root port and from their current alternate settings, both in sysfs.
//!
//! Limits: ports of one controller may share its bandwidth, which sysfs does not show. Bulk endpoints reserve nothing.
//! The bandwidth of motion JPEG is an estimate, because the size of its pictures depends on what they show.

mod descriptors;
mod need;
mod ports;

pub use need::{findings, need_bytes_per_s};
pub use ports::{RootPort, UsbDevice, root_port_name, root_ports};
