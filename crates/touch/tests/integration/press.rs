//! Presses whose truth is known, as the sensor sees them.

use fingervision_elastic::GelBlock;
use fingervision_flow::FlowField;
use fingervision_gel::{Scene, Simulation};
use fingervision_image::Image;
use fingervision_optics::Camera;
use fingervision_touch::{ElasticDepth, ElasticFields, ElasticMode, ElasticParams};

use crate::solved::solve;

pub(crate) const SIZE: (usize, usize) = (240, 240);

/// A frame of a press, by default its last, and an inverse for its gel and camera.
pub(crate) struct Press {
    pub(crate) flow: FlowField,
    pub(crate) deviation: Image<f32>,
    pub(crate) valid: Image<u8>,
    pub(crate) depth_mm: Image<f32>,
    pub(crate) lateral_mm: Image<[f32; 3]>,
    pub(crate) contact: Image<u8>,
    pub(crate) force_n: [f64; 3],
    pub(crate) gel: GelBlock,
    pub(crate) camera: Camera,
}

impl Press {
    /// The last frame of a scene that is solved on the draft mesh.
    pub(crate) fn new(indenter: &str, law: &str, motion: &str) -> Self {
        let [last] = Self::frames(indenter, law, motion, [4]);
        last
    }

    /// Some of its five frames.
    pub(crate) fn frames<const N: usize>(indenter: &str, law: &str, motion: &str, frames: [usize; N]) -> [Self; N] {
        // Friction is a table, the other laws are names.
        let law = if law.starts_with('{') { law.to_owned() } else { format!("'{law}'") };
        let text = format!(
            "name = 'press'\n[camera]\nfocal_length_px = [200.0, 200.0]\n[contact]\nlaw = {law}\n[indenter]\n{indenter}\n\
             [motion]\nframes = 5\n{motion}\n[render]\nwidth = 240\nheight = 240\n[mesh]\nresolution = 'draft'\n"
        );
        let scene = Scene::from_toml(&text).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        solve(&mut simulation);
        frames.map(|frame| Self::frame(&mut simulation, &scene, frame))
    }

    fn frame(simulation: &mut Simulation, scene: &Scene, frame: usize) -> Self {
        let force_n = simulation.states()[frame].force_n;
        let truth = simulation.truth(frame).unwrap();
        let part = |axis: usize| Image::from_fn(SIZE.0, SIZE.1, |x, y| truth.flow.at(x, y)[axis]);
        let flow = FlowField { u: part(0), v: part(1) };
        let valid = Image::from_fn(SIZE.0, SIZE.1, |x, y| u8::from(truth.flow.at(x, y)[0].is_finite()));
        Self {
            flow,
            deviation: Image::filled(SIZE.0, SIZE.1, 0.02),
            valid,
            depth_mm: truth.depth.clone(),
            lateral_mm: truth.displacement.clone(),
            contact: truth.contact.clone(),
            force_n,
            gel: scene.gel,
            camera: Camera::new(&scene.camera()).unwrap(),
        }
    }

    pub(crate) fn inverse(&self, mode: ElasticMode) -> ElasticDepth {
        ElasticDepth::new(&self.camera, &self.gel, SIZE, &ElasticParams { mode, ..ElasticParams::default() }).unwrap()
    }

    /// Mean error of depth over the image, mm, and the overlap of contact.
    pub(crate) fn judge(&self, fields: &ElasticFields) -> (f64, f64) {
        let depths = fields.depth_mm.values().iter().zip(self.depth_mm.values());
        let error: f64 = depths.map(|(found, truth)| f64::from((found - truth).abs())).sum();
        let contacts = fields.contact.values().iter().zip(self.contact.values());
        let count = |holds: fn(u8, u8) -> bool| contacts.clone().filter(|(a, b)| holds(**a, **b)).count() as f64;
        (error / (SIZE.0 * SIZE.1) as f64, count(|a, b| a & b == 1) / count(|a, b| a | b == 1))
    }
}

/// Whether a force is found to a part of its true value.
pub(crate) fn close(found: f32, wanted: f64, relative: f64) -> bool {
    (f64::from(found) - wanted).abs() <= relative * wanted.abs()
}
