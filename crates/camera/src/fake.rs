//! A camera without hardware, with every fault on demand, for tests of programs that use cameras.

#![allow(clippy::unwrap_used, reason = "part of tests")]

use std::collections::VecDeque;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::controls::id;
use crate::{Buffer, Bus, Control, Device, FourCc, Layout, Mode, Node, Offer, RateOffer, SizeOffer};

/// The time after which a silent camera times out, if it is waited for.
const SHORT: Duration = Duration::from_millis(10);

/// The next result of a fake camera.
#[derive(Debug, Clone)]
pub enum Coming {
    /// A frame.
    Frame {
        /// The driver's count.
        sequence: u32,
        /// The driver's time stamp, s.
        stamp_s: f64,
        /// The bytes.
        bytes: Vec<u8>,
        /// The driver reports it as damaged.
        is_damaged: bool,
    },
    /// No frame in time.
    Silence,
    /// An error of the system, by its number.
    Error(i32),
}

/// The state of all cameras of a fake system.
#[derive(Debug, Default)]
pub struct World {
    /// The ids of the cameras that are plugged in.
    pub ids: Vec<String>,
    /// Numbers of nodes that carry metadata.
    pub metadata: Vec<usize>,
    /// The next results, in order.
    pub coming: VecDeque<Coming>,
    /// The controls and their values.
    pub controls: Vec<(Control, i64)>,
    /// The error of opening, by its number.
    pub open_error: Option<i32>,
    /// The error of starting, by its number.
    pub start_error: Option<i32>,
    /// After this number of pauses, these cameras are plugged in.
    pub back: Option<(u32, Vec<String>)>,
    /// Set by `set_mode`, in order.
    pub modes: Vec<Mode>,
    /// Columns and rows of the grey frames that every camera offers, px.
    pub grey_size: [u32; 2],
    /// The rate that the driver uses, whatever is requested.
    pub forced_rate: Option<f64>,
}

/// A fake system; clones share it.
#[derive(Debug, Clone)]
pub struct FakeBus(Arc<Mutex<World>>);

impl FakeBus {
    /// With these cameras, which offer 4x2 px in 8-bit grey and 24x16 px as motion JPEG, and send nothing yet.
    #[must_use]
    pub fn new(ids: &[&str]) -> Self {
        let control = |id, most, value| (Control { id, name: "control".into(), least: 0, most }, value);
        let controls = vec![
            control(id::EXPOSURE_AUTO, 3, 3),
            control(id::EXPOSURE, 10_000, 156),
            control(id::EXPOSURE_CHANGES_RATE, 1, 1),
            control(id::GAIN, 100, 0),
            control(id::WHITE_BALANCE_AUTO, 1, 1),
            control(id::WHITE_BALANCE, 6500, 4600),
        ];
        let ids = ids.iter().map(|id| (*id).to_owned()).collect();
        Self(Arc::new(Mutex::new(World { ids, controls, grey_size: [4, 2], ..World::default() })))
    }

    /// Uses or changes the state.
    ///
    /// # Panics
    ///
    /// If a test panicked while it used the state.
    pub fn with<T>(&self, use_it: impl FnOnce(&mut World) -> T) -> T {
        use_it(&mut self.0.lock().unwrap())
    }

    /// Frames of 4x2 px in 8-bit grey, 100 a second.
    pub fn send(&self, sequences: &[u32]) {
        self.with(|world| world.coming.extend(sequences.iter().map(|sequence| frame(*sequence, 8))));
    }
}

/// A frame with this number of bytes, each of which is the frame's number.
#[must_use]
pub fn frame(sequence: u32, bytes: usize) -> Coming {
    let stamp_s = 10.0 + f64::from(sequence) / 100.0;
    Coming::Frame { sequence, stamp_s, bytes: vec![sequence as u8; bytes], is_damaged: false }
}

impl Bus for FakeBus {
    fn nodes(&self) -> Vec<Node> {
        let node = |(number, id): (usize, &String)| Node {
            id: id.clone(),
            path: PathBuf::from(format!("/dev/video{number}")),
            card: id.trim_end_matches("-video-index0").replace('_', " "),
            driver: "fake".into(),
            serial: Some(format!("serial-{number}")),
            index: 0,
            usb_device: None,
            device: PathBuf::new(),
        };
        self.with(|world| world.ids.iter().enumerate().map(node).collect())
    }

    fn is_capture(&self, node: &Path) -> io::Result<bool> {
        let number = node.to_string_lossy().trim_start_matches("/dev/video").parse().unwrap();
        self.with(|world| match world.open_error {
            Some(error) => Err(io::Error::from_raw_os_error(error)),
            None => Ok(!world.metadata.contains(&number)),
        })
    }

    fn open(&self, _: &Path) -> io::Result<Box<dyn Device>> {
        self.with(|world| world.open_error).map_or(Ok(()), |error| Err(io::Error::from_raw_os_error(error)))?;
        Ok(Box::new(FakeDevice { world: self.clone(), bytes: Vec::new() }))
    }

    fn pause(&self, _: Duration) {
        self.with(|world| match world.back.take() {
            Some((0, ids)) => world.ids = ids,
            Some((pauses, ids)) => world.back = Some((pauses - 1, ids)),
            None => (),
        });
    }
}

struct FakeDevice {
    world: FakeBus,
    bytes: Vec<u8>,
}

impl Device for FakeDevice {
    fn offers(&self) -> io::Result<Vec<Offer>> {
        let offer = |format, size, rates: &[f64]| Offer {
            format,
            size: SizeOffer::One(size),
            rates: RateOffer::List(rates.to_vec()),
        };
        let grey_size = self.world.with(|world| world.grey_size);
        Ok(vec![offer(FourCc::GREY, grey_size, &[100.0, 50.0]), offer(FourCc::MJPG, [24, 16], &[90.0])])
    }

    fn controls(&self) -> io::Result<Vec<Control>> {
        Ok(self.world.with(|world| world.controls.iter().map(|(control, _)| control.clone()).collect()))
    }

    fn control(&self, id: u32) -> io::Result<i64> {
        let value = self
            .world
            .with(|world| world.controls.iter().find(|(control, _)| control.id == id).map(|(_, value)| *value));
        value.ok_or(io::ErrorKind::InvalidInput.into())
    }

    fn set_control(&mut self, id: u32, value: i64) -> io::Result<()> {
        self.world.with(|world| {
            let found = world.controls.iter_mut().find(|(control, _)| control.id == id);
            let (control, current) = found.ok_or(io::ErrorKind::InvalidInput)?;
            *current = value.clamp(control.least, control.most);
            Ok(())
        })
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<Layout> {
        self.world.with(|world| {
            world.modes.push(mode);
            let mode = Mode { frames_per_second: world.forced_rate.unwrap_or(mode.frames_per_second), ..mode };
            Ok(Layout { mode, row_bytes: 0, is_full_range: false })
        })
    }

    fn start(&mut self) -> io::Result<()> {
        self.world.with(|world| world.start_error).map_or(Ok(()), |error| Err(io::Error::from_raw_os_error(error)))
    }

    fn next(&mut self, wait: Duration) -> io::Result<Buffer<'_>> {
        match self.world.with(|world| world.coming.pop_front()) {
            Some(Coming::Frame { sequence, stamp_s, bytes, is_damaged }) => {
                self.bytes = bytes;
                Ok(Buffer { bytes: &self.bytes, sequence, stamp_s, is_damaged })
            }
            Some(Coming::Silence) | None => {
                std::thread::sleep(wait.min(SHORT));
                Err(io::ErrorKind::TimedOut.into())
            }
            Some(Coming::Error(number)) => Err(io::Error::from_raw_os_error(number)),
        }
    }

    fn stop(&mut self) {}
}
