//! The PyO3 border: one thin wrapper file a core module, one error mapping, one array conversion.

mod arrays;
mod assets;
mod beam_table;
mod bev;
mod capture;
mod error;
mod evaluate;
mod ground_plane;
mod guard;
mod image;
mod lidar;
mod rig;
mod scene;
mod settings;
mod weather;

use pyo3::prelude::*;

/// Panics: how panics arrive in Python is tested with it.
#[pyfunction]
#[pyo3(name = "_panic")]
fn panic_for_tests(py: Python<'_>, text: String) -> Result<(), error::BorderError> {
    guard::detached(py, || -> cadet_core::Result<()> { panic!("{text}") })
}

/// The Rust core of cadet. Private: use the typed wrappers of the package.
#[pymodule(gil_used = false)]
fn _cadet(module: &Bound<'_, PyModule>) -> PyResult<()> {
    guard::note_panics();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<assets::Assets>()?;
    module.add_class::<assets::ActorMesh>()?;
    module.add_class::<bev::BevConfig>()?;
    module.add_class::<capture::Agent>()?;
    module.add_class::<capture::Capture>()?;
    module.add_class::<capture::Request>()?;
    module.add_class::<capture::Sighting>()?;
    module.add_class::<lidar::Lidar>()?;
    module.add_class::<rig::Camera>()?;
    module.add_class::<rig::Pose>()?;
    module.add_class::<rig::Rig>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<settings::SceneConfig>()?;
    module.add_function(wrap_pyfunction!(assets::check_props, module)?)?;
    module.add_function(wrap_pyfunction!(bev::bev_maps, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_draws, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::read_truths, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::read_detections, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::box_iou, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::nms_bev, module)?)?;
    module.add_function(wrap_pyfunction!(ground_plane::estimate_ground_plane, module)?)?;
    module.add_function(wrap_pyfunction!(image::decode_image, module)?)?;
    module.add_function(wrap_pyfunction!(image::encode_png, module)?)?;
    module.add_function(wrap_pyfunction!(settings::limits, module)?)?;
    module.add_function(wrap_pyfunction!(settings::settings, module)?)?;
    module.add_class::<weather::Weather>()?;
    module.add_function(wrap_pyfunction!(weather::weather_names, module)?)?;
    module.add_function(wrap_pyfunction!(weather::weather_preset, module)?)?;
    module.add_function(wrap_pyfunction!(weather::weather_recorded_scan, module)?)?;
    module.add_function(wrap_pyfunction!(panic_for_tests, module)?)?;
    Ok(())
}
