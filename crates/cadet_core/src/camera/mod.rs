//! The camera: model and calibration, shading, sky, shadows, noise, PNG.

mod model;

pub use model::{Calibration, CameraModel};
