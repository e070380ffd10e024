//! A program that writes pictures into a loopback device.

use moq_v4l::video::Output;
use moq_v4l::video::output::Parameters;
use moq_v4l::{Format, FourCC};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Writes until it is dropped.
pub(crate) struct Producer {
    is_done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Producer {
    /// Writes the pictures in turn, so many a second.
    pub(crate) fn start(node: PathBuf, [width, height]: [u32; 2], per_second: u32, pictures: Vec<Vec<u8>>) -> Self {
        let is_done = Arc::new(AtomicBool::new(false));
        let mut device = moq_v4l::Device::with_path(node).unwrap();
        Output::set_format(&device, &Format::new(width, height, FourCC::new(b"MJPG"))).unwrap();
        Output::set_params(&device, &Parameters::with_fps(per_second)).unwrap();
        // The device captures only once something was written.
        device.write_all(&pictures[0]).unwrap();
        let end = is_done.clone();
        let write = move || {
            let start = Instant::now();
            for (count, picture) in (1u32..).zip(pictures.iter().cycle().skip(1)) {
                let due = Duration::from_secs(1) * count / per_second;
                thread::sleep(due.saturating_sub(start.elapsed()));
                if end.load(Ordering::Relaxed) {
                    return;
                }
                device.write_all(picture).unwrap();
            }
        };
        Self { is_done, thread: Some(thread::spawn(write)) }
    }
}

impl Drop for Producer {
    fn drop(&mut self) {
        self.is_done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}
