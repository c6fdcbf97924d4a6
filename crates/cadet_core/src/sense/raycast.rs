//! Arbitrary rays, by parry's bounding volume hierarchies.

use std::sync::Arc;

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;

use super::face_trees::{FaceTrees, LOOSE_M};
use super::posed::PosedScene;
use crate::error::{Error, Result, finite};
use crate::material::Material;
use crate::math::{DMat3, DVec3};

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
    instances: Vec<LocalFrame>,
}

struct LocalFrame {
    local_from_world: DMat3,
    origin_world: DVec3,
    over_faces: Arc<Bvh>,
}

impl RayCaster {
    /// Builds the trees.
    #[must_use]
    pub fn new(scene: Arc<PosedScene>) -> Self {
        let mut trees = FaceTrees::default();
        let mut instances = Vec::with_capacity(scene.instances.len());
        let mut boxes = Vec::with_capacity(scene.instances.len());
        for posed in &scene.instances {
            instances.push(LocalFrame {
                local_from_world: posed.placement.rotation.transpose(),
                origin_world: posed.placement.translation,
                over_faces: trees.of(&posed.mesh),
            });
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
        Ok(self.nearest(origin_world, direction_world).map(|(range_m, instance, face)| {
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

    fn nearest(&self, origin_world: DVec3, direction_world: DVec3) -> Option<(f64, u32, u32)> {
        let ray_world = Ray::new(origin_world.as_vec3(), direction_world.as_vec3());
        let best = std::cell::Cell::new(None::<(f64, u32, u32)>);
        let _ = self.over_instances.cast_ray(&ray_world, f32::MAX, |instance, _| {
            let frame = &self.instances[instance as usize];
            let origin = (frame.local_from_world * (origin_world - frame.origin_world)).as_vec3();
            let ray = Ray::new(origin, (frame.local_from_world * direction_world).as_vec3());
            let limit = best.get().map_or(f32::MAX, |b| outward(b.0));
            let _ = frame.over_faces.cast_ray(&ray, limit, |face, _| {
                let corners = self.scene.corners(instance, face).map(|p| p.as_dvec3());
                let range_m = meet(corners, origin_world, direction_world)?;
                let found = (range_m, instance, face);
                let nearer =
                    best.get().is_none_or(|b| found.0 < b.0 || (found.0 == b.0 && (found.1, found.2) < (b.1, b.2)));
                if nearer {
                    best.set(Some(found));
                }
                Some(outward(range_m))
            });
            best.get().filter(|b| b.1 == instance).map(|b| outward(b.0))
        });
        best.get()
    }
}

/// A bound in single precision that is certainly beyond `range_m`, so that equal hits and rounded boxes stay in play.
pub(super) fn outward(range_m: f64) -> f32 {
    (range_m * (1.0 + 1e-5) + 1e-3) as f32
}

/// Distance to a triangle along a unit direction, from either side.
pub(super) fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (a, b, c) = (a - origin, b - origin, c - origin);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n.dot(direction));
    let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
    let normal = (b - a).cross(c - a);
    let range = a.dot(normal) / normal.dot(direction);
    (inside && range.is_finite() && range > 0.0).then_some(range)
}
