//! Meshes and the small geometry that everything shares.

mod mesh;
mod mesh_builder;

pub use mesh::{Bounds, LodSet, Mesh};
pub use mesh_builder::MeshBuilder;
