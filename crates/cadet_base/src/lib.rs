//! What all crates of the core share: math, random streams, errors, meshes, materials, and what gets labels.
//!
//! # Determinism
//!
//! No clock, no hash-map order, no platform `sin`: everything is a function of the seed. [`math`] holds the
//! transcendental functions, [`rng`] the random streams; clippy refuses the others.

pub mod actor;
pub mod error;
pub mod frames;
pub mod geometry;
pub mod instance;
pub mod lamp;
pub mod material;
pub mod math;
pub mod parallel;
pub mod plane;
pub mod rng;
pub mod road_paint;
pub mod settings;

pub use error::{Error, Result};
