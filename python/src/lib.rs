//! The Python package `fingervision`: the library and the command in one extension module.
//!
//! A binding converts its arguments, releases the interpreter, calls, and converts the result; nothing is computed here.
//! Images are copied in, so a program may change them while they are tracked, and fields are copied out when they are
//! first asked for. `package/fingervision/` has what is written in Python: exceptions, commands, and the stubs.

mod arrays;
mod camera;
mod command;
mod error;
mod fields;
mod flow;
mod pixels;
mod profile;
mod reading;
mod readings;
mod recording;
mod settings;
mod simulation;
mod tracker;
mod tracking;

use fingervision_touch::Flag;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Camera-based touch: from images of a patterned gel to displacement, depth, contact and force.
#[pymodule(gil_used = false)]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    let flags = PyDict::new(module.py());
    for flag in Flag::ALL {
        flags.set_item(flag.name(), flag.sentence())?;
    }
    module.add("FLAGS", flags)?;
    module.add_class::<profile::PyProfile>()?;
    module.add_class::<reading::PyReading>()?;
    module.add_class::<readings::PyReadings>()?;
    module.add_class::<tracker::PyTracker>()?;
    module.add_class::<flow::PyFlowEstimator>()?;
    module.add_class::<flow::PyFlow>()?;
    module.add_class::<simulation::PySimulation>()?;
    module.add_class::<simulation::PySimulatedFrame>()?;
    module.add_class::<recording::PyRecording>()?;
    module.add_class::<recording::PyFrames>()?;
    module.add_class::<recording::PyFrame>()?;
    module.add_class::<camera::PyCameraInfo>()?;
    module.add_function(wrap_pyfunction!(readings::open, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::scenes, module)?)?;
    module.add_function(wrap_pyfunction!(camera::cameras, module)?)?;
    module.add_function(wrap_pyfunction!(command::run, module)?)?;
    Ok(())
}
