//! The sensor: its specification, the presets, and the beams that follow from it.

mod beams;
mod divergence;
mod hdl64e;
mod presets;
mod spec;

pub(super) use beams::BeamLine;
pub use beams::Rays;
pub(super) use divergence::DivergentBeams;
pub use presets::PRESETS;
pub use spec::{BlindSector, LidarSpec};
