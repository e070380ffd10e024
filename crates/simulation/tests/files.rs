//! The folder and the picture of a simulation. The tests use a sliding board, which needs no solver.

#![expect(clippy::unwrap_used, reason = "test helpers may panic, like tests")]

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use fingervision_gel::{PressCache, Scene, Simulation};
use fingervision_image::{Image, Pixels};
use fingervision_simulation::{SimulatedFrame, SimulationFolder, SimulationPreview};
use fingervision_sink::SinkError;
use fingervision_touch::Profile;

fn board(width: usize, height: usize, colour: bool) -> Simulation {
    let mut scene = Scene::find("board").unwrap();
    (scene.render.width, scene.render.height, scene.render.colour) = (width, height, colour);
    scene.motion.frames = 4;
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.solve(&PressCache::OFF, &mut |_| ControlFlow::Continue(())).unwrap();
    simulation
}

/// Calls `take` with every frame; the artificial forces grow from frame to frame.
fn each_frame(simulation: &mut Simulation, has_images: bool, mut take: impl FnMut(&SimulatedFrame)) {
    for frame in 0..simulation.states().len() {
        let pixels: Option<Pixels> = has_images.then(|| simulation.frame(frame).unwrap().clone());
        let force_n = [-0.5 * frame as f64, 0.0, frame as f64];
        let truth = simulation.truth(frame).unwrap();
        take(&SimulatedFrame { depth_mm: 0.0, force_n, torque_z_nmm: -0.0, pixels: pixels.as_ref(), truth });
    }
}

fn shape(path: &Path) -> Vec<u64> {
    npyz::NpyFile::new(fs::File::open(path).unwrap()).unwrap().shape().to_vec()
}

#[test]
fn every_frame_can_be_read_while_the_folder_grows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/sim");
    let mut simulation = board(32, 24, false);
    let mut written = SimulationFolder::create(&path, simulation.scene(), true, false).unwrap();
    let mut count = 0;
    each_frame(&mut simulation, true, |frame| {
        written.write(frame).unwrap();
        count += 1;
        assert_eq!(shape(&path.join("truth/flow.npy")), [count, 24, 32, 2]);
        assert_eq!(shape(&path.join("truth/visible.npy")), [count, 24, 32]);
        let Some(Pixels::Grey8(expected)) = frame.pixels else { panic!("grey was asked for") };
        let image = image::open(path.join(format!("frames/{:06}.png", count - 1))).unwrap();
        assert_eq!(image.as_luma8().unwrap().as_raw().as_slice(), expected.values());
    });
    assert_eq!(written.finish().unwrap(), 4);
    let table = fs::read_to_string(path.join("truth/force.csv")).unwrap();
    assert_eq!(table.lines().last(), Some("3,0,-1.5,0,3,0"));
}

#[test]
fn the_profile_is_the_scenes_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = board(32, 24, true);
    SimulationFolder::create(folder.path(), simulation.scene(), false, false).unwrap();
    let profile = Profile::load(&folder.path().join("profile.toml")).unwrap();
    assert_eq!((profile.camera, profile.gel), (Some(simulation.scene().camera()), Some(simulation.scene().gel)));
    assert_eq!(profile.name, "simulated: board");
    let scene = Scene::load(&folder.path().join("scene.toml")).unwrap();
    assert_eq!(scene.camera(), simulation.scene().camera());
    assert!(!folder.path().join("frames").exists());
}

#[test]
fn a_folder_that_holds_anything_else_is_never_touched() {
    let folder = tempfile::tempdir().unwrap();
    let simulation = board(32, 24, true);
    fs::write(folder.path().join("run.toml"), "a run").unwrap();
    let error = SimulationFolder::create(folder.path(), simulation.scene(), true, true).unwrap_err();
    assert!(error.to_string().ends_with("contains files that are not a simulation"), "{error}");

    let folder = tempfile::tempdir().unwrap();
    SimulationFolder::create(folder.path(), simulation.scene(), true, false).unwrap();
    fs::write(folder.path().join("frames/000007.png"), "a frame").unwrap();
    fs::write(folder.path().join("frames/mine.png"), "mine").unwrap();
    let error = SimulationFolder::create(folder.path(), simulation.scene(), true, false).unwrap_err();
    assert!(matches!(error, SinkError::Previous { noun: "simulation", .. }), "{error}");
    SimulationFolder::create(folder.path(), simulation.scene(), true, true).unwrap();
    assert!(!folder.path().join("frames/000007.png").exists(), "a frame of the previous one is removed");
    assert!(folder.path().join("frames/mine.png").exists(), "what it did not write stays");
}

#[test]
fn a_frame_without_its_image_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut simulation = board(32, 24, true);
    let mut written = SimulationFolder::create(folder.path(), simulation.scene(), true, false).unwrap();
    each_frame(&mut simulation, false, |frame| {
        assert_eq!(written.write(frame).unwrap_err().to_string(), "frame 0 has no image");
    });
    assert_eq!(shape(&folder.path().join("truth/flow.npy"))[0], 0);
}

fn picture(simulation: &mut Simulation, has_images: bool) -> Image<[u8; 3]> {
    let mut preview = SimulationPreview::new(simulation.scene(), simulation.states().len());
    each_frame(simulation, has_images, |frame| preview.write(frame));
    preview.draw().unwrap()
}

#[test]
fn any_size_can_be_drawn() {
    for (width, height) in [(1, 1), (300, 7), (7, 300), (64, 48)] {
        let mut simulation = board(width, height, width % 2 == 0);
        let (whole, truth) = (picture(&mut simulation, true), picture(&mut simulation, false));
        assert_eq!((whole.width(), truth.width()), (1600, 1600), "{width}x{height}");
        assert!(truth.height() < whole.height(), "without images there is no strip of them");
    }
}

#[test]
fn nothing_seen_is_nothing_drawn() {
    let simulation = board(32, 24, true);
    let preview = SimulationPreview::new(simulation.scene(), 4);
    assert!(matches!(preview.draw(), Err(SinkError::NoReadings)));
}
