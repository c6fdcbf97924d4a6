//! Meshes and the small geometry that everything shares.

mod bounds;
mod closed;
mod cluster;
mod clustering;
mod columns;
mod edges;
mod lod;
mod memo;
mod mesh;
mod mesh_builder;
mod normal_cone;
mod packed_normal;
mod pieces;
mod places;
mod solids;

pub use bounds::Bounds;
pub use cluster::{
    CLUSTER_FACES, CLUSTER_VERTICES, Cluster, ClusterFace, ClusterPiece, ClusterSummary, Clusters, LANES, Lanes,
};
pub use columns::SurfaceColumn;
pub use lod::{LazyMesh, LodSet};
pub use memo::Memo;
pub use mesh::{IndexedFaces, Mesh, face_number};
pub use mesh_builder::MeshBuilder;
pub use normal_cone::NormalCone;
pub use pieces::LEAST_WEIGHT;
pub use solids::level_ring;
