//! The core of cadet: suburb scenes, their physics, the beams of a LIDAR and a camera, and exact labels.
//!
//! Data flows one way, and so do the imports (`ARCHITECTURE.md`):
//! `geometry, material ← assets ← town ← world ← sense ← lidar, camera, label ← scene`.
//!
//! # Frames and units
//!
//! `_world` is x east, y north, z up; `_velo` x forward, y left, z up; `_cam` x right, y down, z forward.
//! Meters, radians and seconds everywhere unless a name says otherwise.
//!
//! # Determinism
//!
//! No clock, no hash-map order, no platform `sin`: everything is a function of the seed. [`math`] holds the
//! transcendental functions, [`rng`] the random streams; clippy refuses the others.

#[macro_use]
mod wide_registers;
mod zeros;

pub mod actor;
pub mod assets;
pub mod bev;
pub mod camera;
pub mod error;
pub mod evaluate;
pub mod frames;
pub mod geometry;
pub mod ground_plane;
pub mod image_file;
pub mod instance;
pub mod label;
pub mod lamp;
pub mod lidar;
pub mod material;
pub mod math;
pub mod parallel;
pub mod plane;
pub mod rig;
pub mod rng;
pub mod road_paint;
pub mod scene;
pub mod sense;
pub mod settings;
pub mod spray;
pub mod town;
pub mod weather;
pub mod world;

pub use error::{Error, Result};
pub use nalgebra;
