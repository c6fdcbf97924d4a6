//! Arbitrary rays, by parry's bounding volume hierarchies.

use std::cell::Cell;
use std::sync::Arc;

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;

use super::face_trees::{FaceTrees, LOOSE_M};
use super::instance_tree::{FaceHit, InstanceTree, outward};
use super::posed::PosedScene;
use crate::error::{Error, Result, finite};
use crate::material::Material;
use crate::math::DVec3;

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// Distance from the ray's origin.
    pub range_m: f64,
    /// 0 for the static world, at least 1 for actors.
    pub actor_id: i32,
    /// Unit normal of the triangle, turned against the ray.
    pub normal_world: DVec3,
    /// Index into [`PosedScene::instances`].
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
    /// The surface.
    pub material: Material,
}

/// Casts single rays into a scene: a tree over the instances, and below it a tree over each mesh's faces, in the mesh's
/// own frame and shared by its instances. The triangles themselves are tested in double precision.
pub struct RayCaster {
    scene: Arc<PosedScene>,
    over_instances: Bvh,
    instances: Vec<InstanceTree>,
}

impl RayCaster {
    /// Builds the trees.
    #[must_use]
    pub fn new(scene: Arc<PosedScene>) -> Self {
        let mut trees = FaceTrees::default();
        let mut instances = Vec::with_capacity(scene.instances.len());
        let mut boxes = Vec::with_capacity(scene.instances.len());
        for posed in &scene.instances {
            instances.push(InstanceTree::new(posed, &mut trees));
            boxes.push(Aabb::from_points(posed.vertices_world()).loosened(LOOSE_M));
        }
        let over_instances = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self { scene, over_instances, instances }
    }

    /// The scene that the rays meet.
    #[must_use]
    pub fn scene(&self) -> &Arc<PosedScene> {
        &self.scene
    }

    /// The first triangle, of either side and of glass too, on the ray from `origin_world` along `direction_world`,
    /// which need not be a unit vector. None for a miss.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for a direction without length.
    pub fn cast(&self, origin_world: DVec3, direction_world: DVec3) -> Result<Option<RayHit>> {
        for value in origin_world.to_array() {
            let _ = finite("ray origin", value)?;
        }
        for value in direction_world.to_array() {
            let _ = finite("ray direction", value)?;
        }
        // Scaled first: the square of a small direction may be 0.
        let largest = direction_world.abs().max_element();
        if largest == 0.0 {
            return Err(Error::OutOfRange {
                what: "ray direction",
                value: direction_world.to_string(),
                expected: "a vector that is not zero".to_owned(),
            });
        }
        let direction_world = (direction_world / largest).normalize();
        Ok(self.nearest(origin_world, direction_world).map(|FaceHit { range_m, instance, face }| {
            let posed = &self.scene.instances[instance as usize];
            let [a, b, c] = self.scene.corners(instance, face).map(|p| p.as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero();
            RayHit {
                range_m,
                actor_id: posed.actor_id,
                normal_world: if normal.dot(direction_world) > 0.0 { -normal } else { normal },
                instance,
                face,
                material: *posed.material(face),
            }
        }))
    }

    fn nearest(&self, origin_world: DVec3, direction_world: DVec3) -> Option<FaceHit> {
        let ray_world = Ray::new(origin_world.as_vec3(), direction_world.as_vec3());
        let nearest = Cell::new(None::<FaceHit>);
        let _ = self.over_instances.cast_ray(&ray_world, f32::MAX, |instance, _| {
            let limit_m = nearest.get().map_or(f32::MAX, |n| outward(n.range_m));
            let tree = &self.instances[instance as usize];
            tree.cast(&self.scene, instance, [origin_world, direction_world], limit_m, |hit| {
                if nearest.get().is_none_or(|n| hit.is_before(&n)) {
                    nearest.set(Some(hit));
                }
                Some(outward(hit.range_m))
            });
            nearest.get().filter(|n| n.instance == instance).map(|n| outward(n.range_m))
        });
        nearest.get()
    }
}
