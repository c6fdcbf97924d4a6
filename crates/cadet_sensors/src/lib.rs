//! What sensors on a car measure of posed meshes: beams of LIDARs, images of cameras, and exact labels.
//!
//! Nothing here knows how a scene was made. Imports go one way: `sense ← lidar, camera ← label, rig`.

#[macro_use]
mod wide_registers;
mod zeros;

pub mod camera;
pub mod image_file;
pub mod label;
pub mod lidar;
pub mod rig;
pub mod sense;
pub mod spray;
mod surface_cover;
pub mod weather;
