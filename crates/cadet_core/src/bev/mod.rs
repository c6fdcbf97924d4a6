//! Bird's-eye-view maps of a point cloud: heights and densities in cells on the ground plane.

mod maps;
mod spec;

pub use maps::maps;
pub use spec::{BevSpec, Feature, HeightRule};
