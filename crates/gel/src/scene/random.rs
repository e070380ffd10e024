//! Random scenes, for sweeps.

use std::f64::consts::PI;

use fingervision_elastic::ContactLaw;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::{Keyframe, Scene};
use crate::{Indenter, IndenterShape};

/// Number of random positions that are tried for an indenter before the middle is used.
const MOST_TRIES: usize = 100;

/// Presses of the default sensor of many kinds.
///
/// Shape and size, place and angle, a depth of 0.3 to 2 mm, tilt, in half of the scenes shear, in a quarter a twist;
/// ν from 0.3 to 0.49; sticking, frictionless or with friction; pattern and noise. Lengths are whole micrometres. The
/// same seed gives the same scenes; scene n does not depend on how many are drawn.
#[derive(Debug, Clone)]
pub struct RandomScenes {
    rng: Pcg64Mcg,
    next: usize,
}

impl RandomScenes {
    /// The scenes of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { rng: Pcg64Mcg::seed_from_u64(seed), next: 0 }
    }
}

impl Iterator for RandomScenes {
    type Item = Scene;

    fn next(&mut self) -> Option<Scene> {
        let mut dice = Dice(Pcg64Mcg::seed_from_u64(self.rng.next_u64()));
        let mut scene = Scene { name: format!("random-{:04}", self.next), ..Scene::default() };
        self.next += 1;
        let (shape, noun) = dice.shape();
        scene.indenter = Indenter { rotation_rad: dice.between(-PI, PI), ..Indenter::new(shape) };
        scene.gel.poissons_ratio = dice.between(0.3, 0.49);
        scene.contact.law = dice.contact();
        scene.motion.keyframes = dice.keyframes();
        let depth_mm = scene.motion.largest_depth_mm();
        scene.about = format!("{noun}, {depth_mm} mm deep, drawn at random");
        dice.place(&mut scene);
        (scene.pattern.seed, scene.render.seed) = (dice.seed(), dice.seed());
        Some(scene)
    }
}

struct Dice(Pcg64Mcg);

impl Dice {
    /// A number between two others, on thousandths.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let range = Uniform::new_inclusive((1e3 * low).ceil() as i64, (1e3 * high).floor() as i64);
        range.map_or(low, |range| range.sample(&mut self.0) as f64 / 1e3)
    }

    fn one_of(&mut self, count: u64) -> u64 {
        self.0.next_u64() % count
    }

    /// A seed that a file can hold.
    fn seed(&mut self) -> u64 {
        self.0.next_u64() >> 32
    }

    fn shape(&mut self) -> (IndenterShape, &'static str) {
        match self.one_of(8) {
            0 => (IndenterShape::Circle { radius_mm: self.between(1.5, 5.0) }, "disc"),
            1 => (IndenterShape::Rectangle { size_mm: [self.between(3.0, 11.0), self.between(2.5, 8.0)] }, "rectangle"),
            2 => (IndenterShape::Triangle { side_mm: self.between(5.0, 11.0) }, "triangle"),
            3 => (IndenterShape::Crossing { bar_mm: [self.between(7.0, 13.0), self.between(1.5, 3.5)] }, "crossing"),
            4 => {
                let inner_radius_mm = self.between(1.0, 3.0);
                let outer_radius_mm = inner_radius_mm + self.between(1.2, 2.5);
                (IndenterShape::Ring { inner_radius_mm, outer_radius_mm: thousandths(outer_radius_mm) }, "ring")
            }
            5 => (IndenterShape::Sphere { radius_mm: self.between(3.0, 12.0) }, "ball"),
            6 => {
                let pin = |dice: &mut Self| [dice.between(-4.0, 4.0), dice.between(-4.0, 4.0)];
                let centres_mm = (0..=self.one_of(4)).map(|_| pin(self)).collect();
                (IndenterShape::Pins { radius_mm: self.between(0.8, 1.8), centres_mm }, "pins")
            }
            _ => {
                let letter = char::from(b'A' + self.one_of(26) as u8);
                (IndenterShape::Letter { text: letter.into(), height_mm: self.between(7.0, 12.0) }, "letter")
            }
        }
    }

    fn contact(&mut self) -> ContactLaw {
        match self.one_of(3) {
            0 => ContactLaw::Stick,
            1 => ContactLaw::Frictionless,
            _ => ContactLaw::Friction(self.between(0.2, 1.2)),
        }
    }

    /// A press, and in some scenes a shear or a twist after it.
    fn keyframes(&mut self) -> Vec<Keyframe> {
        let tilt_rad = [self.between(-0.08, 0.08), self.between(-0.08, 0.08)];
        let press = Keyframe {
            at: 10.0,
            depth_mm: Some(self.between(0.3, 2.0)),
            tilt_rad: Some(tilt_rad),
            ..Keyframe::default()
        };
        let shear_mm = (self.one_of(2) == 0).then(|| [self.between(-1.0, 1.0), self.between(-1.0, 1.0)]);
        let twist_rad = (self.one_of(4) == 0).then(|| self.between(-0.17, 0.17));
        if shear_mm.is_none() && twist_rad.is_none() {
            return vec![Keyframe { at: 20.0, ..press }];
        }
        vec![press, Keyframe { at: 20.0, shear_mm, twist_rad, ..Keyframe::default() }]
    }

    /// Puts the indenter somewhere on the gel, at least 2 mm from where it would hang over.
    fn place(&mut self, scene: &mut Scene) {
        let [width, height] = scene.gel.size_mm;
        for _ in 0..MOST_TRIES {
            let [x, y] = [self.between(-0.4 * width, 0.4 * width), self.between(-0.4 * height, 0.4 * height)];
            let fits = [[2.0, 2.0], [2.0, -2.0], [-2.0, 2.0], [-2.0, -2.0]].iter().all(|[right, down]| {
                scene.motion.centre_mm = [x + right, y + down];
                scene.relief().is_ok()
            });
            scene.motion.centre_mm = [x, y];
            if fits {
                return;
            }
        }
        scene.motion.centre_mm = [0.0; 2];
    }
}

fn thousandths(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}
