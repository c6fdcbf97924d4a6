//! Trees over the faces of meshes, kept as long as the mesh is used.

use std::collections::BTreeMap;
use std::sync::Arc;

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};

use cadet_base::geometry::Mesh;

/// How much boxes are widened: they hold the mesh as it was before posing rounded it to single precision.
pub(super) const LOOSE_M: f32 = 2e-3;

/// parry's trees, one a mesh, in the mesh's own frame. Building them takes several times as long as a scan, so that
/// whoever casts at instant after instant keeps them.
#[derive(Default)]
pub struct FaceTrees {
    /// By the mesh's address, which its own `Arc` keeps from being reused; never iterated on the way to an output.
    by_mesh: BTreeMap<usize, (Arc<Mesh>, Arc<Bvh>)>,
}

impl FaceTrees {
    /// The tree of a mesh, built where it is not there yet.
    pub(super) fn of(&mut self, mesh: &Arc<Mesh>) -> Arc<Bvh> {
        let address = Arc::as_ptr(mesh) as usize;
        let (_, tree) = self.by_mesh.entry(address).or_insert_with(|| (Arc::clone(mesh), Arc::new(over_faces(mesh))));
        Arc::clone(tree)
    }

    /// Drops the trees of meshes that nothing else holds any more: people's, whose every stride is a mesh of its own.
    pub fn forget_unused(&mut self) {
        self.by_mesh.retain(|_, (mesh, _)| Arc::strong_count(mesh) > 1);
    }

    /// Number of trees.
    #[must_use]
    pub fn len(&self) -> usize {
        self.by_mesh.len()
    }

    /// True before the first tree.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.by_mesh.is_empty()
    }
}

fn over_faces(mesh: &Mesh) -> Bvh {
    let boxes = mesh.face_numbers().map(|f| (f as usize, Aabb::from_points(mesh.corners(f)).loosened(LOOSE_M)));
    Bvh::from_iter(BvhBuildStrategy::Binned, boxes)
}
