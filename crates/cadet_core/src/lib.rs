//! The core of cadet: suburb scenes, their physics, the beams of a LIDAR and a camera, and exact labels.
//!
//! Data flows one way, and so do the imports (`ARCHITECTURE.md`): `base ← assets ← town ← world ← scene` and
//! `base ← sensors ← scene`, each a crate of its own that this one passes on.
//!
//! # Frames and units
//!
//! `_world` is x east, y north, z up; `_velo` x forward, y left, z up; `_cam` x right, y down, z forward.
//! Meters, radians and seconds everywhere unless a name says otherwise.

pub mod bev;
pub mod evaluate;
pub mod ground_plane;
pub mod scene;

pub use cadet_assets as assets;
pub use cadet_base::{
    Error, Result, actor, error, frames, geometry, instance, lamp, material, math, parallel, plane, rng, road_paint,
    settings,
};
pub use cadet_sensors::{camera, image_file, label, lidar, rig, sense, spray, weather};
pub use cadet_town as town;
pub use cadet_world as world;
pub use nalgebra;
