//! The first message to a page: the sensors and the flags.

use fingervision_pipeline::SensorHandle;
use fingervision_touch::Flag;
use serde::Serialize;

/// The first message to a page.
#[derive(Debug, Serialize)]
pub(crate) struct Hello {
    version: &'static str,
    sensors: Vec<SensorHello>,
    /// Name and sentence of every flag.
    flags: Vec<(&'static str, &'static str)>,
}

#[derive(Debug, Serialize)]
struct SensorHello {
    name: String,
    description: String,
    /// Columns and rows of the fields, px.
    size: (usize, usize),
    /// Columns and rows of the camera's image, px.
    frame_size: (usize, usize),
    /// The fields' part of the image: x, y, width, height, px.
    region: [usize; 4],
    mm_per_px: Option<f64>,
    gel_size_mm: Option<[f64; 2]>,
    gel_thickness_mm: Option<f64>,
}

impl Hello {
    pub(crate) fn new(handles: &[SensorHandle]) -> Self {
        let sensors = handles.iter().map(SensorHello::new).collect();
        let flags = Flag::ALL.iter().map(|flag| (flag.name(), flag.sentence())).collect();
        Self { version: env!("CARGO_PKG_VERSION"), sensors, flags }
    }
}

impl SensorHello {
    fn new(handle: &SensorHandle) -> Self {
        let (profile, frame_size) = (handle.profile(), handle.frame_size());
        // The tracker accepted this region.
        let region = profile
            .region(frame_size)
            .map_or([0, 0, frame_size.0, frame_size.1], |region| [region.x, region.y, region.width, region.height]);
        Self {
            name: handle.name().into(),
            description: handle.description().into(),
            size: handle.size(),
            frame_size,
            region,
            mm_per_px: profile.mm_per_px(),
            gel_size_mm: profile.gel.map(|gel| gel.size_mm),
            gel_thickness_mm: profile.gel.map(|gel| gel.thickness_mm),
        }
    }
}
