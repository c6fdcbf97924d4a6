//! Rays into a world that moves while they are cast, by parry: what a turning LIDAR needs.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Arc;

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;

use super::face_trees::{FaceTrees, LOOSE_M};
use super::instance_tree::{FaceHit, InstanceTree, outward};
use super::motion::RigidMotion;
use super::posed::{PosedInstance, PosedScene};
use crate::math::{DPose3, DVec3};

/// Casts rays at a scene whose instances move steadily about the instant at which they were posed.
///
/// The tree over the instances holds the boxes that they sweep, so that one serves every moment. A ray is taken into the
/// world as it was at the instant: an instance that has moved by D is met by D^-1 of the ray, at the same range.
pub struct MovingCaster {
    scene: Arc<PosedScene>,
    over_instances: Bvh,
    /// None for instances that were left out.
    instances: Vec<Option<MovingInstance>>,
    motions: Vec<RigidMotion>,
}

struct MovingInstance {
    tree: InstanceTree,
    /// Index into the motions, None at rest.
    motion: Option<usize>,
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceHits {
    /// The first opaque triangle.
    pub opaque: Option<FaceHit>,
    /// The first transparent one before it.
    pub transparent: Option<FaceHit>,
}

impl MovingCaster {
    /// Builds the tree over what the instances that `keep` accepts sweep within `span_s` before and after the instant
    /// of the scene. `motion_of` says how an actor (by its id) moves; what has id 0 rests.
    pub fn new(
        scene: Arc<PosedScene>,
        trees: &mut FaceTrees,
        motion_of: impl Fn(i32) -> RigidMotion,
        span_s: f64,
        keep: impl Fn(&PosedInstance) -> bool,
    ) -> Self {
        let (mut motions, mut index_of_actor) = (Vec::new(), BTreeMap::new());
        let mut instances = Vec::with_capacity(scene.instances.len());
        let mut boxes = Vec::new();
        for (index, posed) in scene.instances.iter().enumerate() {
            let motion = if posed.actor_id == 0 { RigidMotion::default() } else { motion_of(posed.actor_id) };
            let radius_m = posed.radius_m + (posed.center_world - motion.pivot_world).length();
            let swept_m = if motion.is_rest() { 0.0 } else { motion.reach_m(radius_m, span_s) };
            if !keep(posed) {
                instances.push(None);
                continue;
            }
            let motion = (!motion.is_rest()).then(|| {
                *index_of_actor.entry(posed.actor_id).or_insert_with(|| {
                    motions.push(motion);
                    motions.len() - 1
                })
            });
            instances.push(Some(MovingInstance { tree: InstanceTree::new(posed, trees), motion }));
            boxes.push((index, Aabb::from_points(posed.vertices_world()).loosened(LOOSE_M + 1.001 * swept_m as f32)));
        }
        let over_instances = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        Self { scene, over_instances, instances, motions }
    }

    /// The scene that the rays meet, at the instant 0.
    #[must_use]
    pub fn scene(&self) -> &Arc<PosedScene> {
        &self.scene
    }

    /// The world `time_s` after the instant.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Moment<'_> {
        Moment { caster: self, now_from_then: self.motions.iter().map(|m| m.displacement(time_s).inverse()).collect() }
    }
}

/// A moving world at one moment.
pub struct Moment<'a> {
    caster: &'a MovingCaster,
    now_from_then: Vec<DPose3>,
}

impl Moment<'_> {
    /// What the ray from `origin_world` along the unit vector `direction_world` meets at this moment.
    #[must_use]
    pub fn cast(&self, origin_world: DVec3, direction_world: DVec3) -> SurfaceHits {
        let caster = self.caster;
        let ray_world = Ray::new(origin_world.as_vec3(), direction_world.as_vec3());
        let (opaque, transparent) = (Cell::new(None::<FaceHit>), Cell::new(None::<FaceHit>));
        let _ = caster.over_instances.cast_ray(&ray_world, f32::MAX, |instance, _| {
            let moving = caster.instances[instance as usize].as_ref()?;
            let ray = match moving.motion {
                None => [origin_world, direction_world],
                Some(index) => {
                    let back = &self.now_from_then[index];
                    [back.transform_point(origin_world), back.rotation * direction_world]
                }
            };
            let limit_m = opaque.get().map_or(f32::MAX, |o| outward(o.range_m));
            moving.tree.cast(&caster.scene, instance, ray, limit_m, |hit| {
                let is_transparent = caster.scene.instances[instance as usize].material(hit.face).is_transparent();
                let best = if is_transparent { &transparent } else { &opaque };
                if best.get().is_none_or(|b| hit.is_before(&b)) {
                    best.set(Some(hit));
                }
                // Transparent surfaces don't end the search.
                (!is_transparent).then(|| outward(hit.range_m))
            });
            opaque.get().filter(|s| s.instance == instance).map(|s| outward(s.range_m))
        });
        let opaque = opaque.get();
        SurfaceHits { opaque, transparent: transparent.get().filter(|p| opaque.is_none_or(|s| p.range_m < s.range_m)) }
    }

    /// A direction as it stands to an instance's triangles where [`PosedScene`] has them, at the instant.
    #[must_use]
    pub fn direction_now(&self, instance: u32, direction_world: DVec3) -> DVec3 {
        match self.caster.instances[instance as usize].as_ref().and_then(|f| f.motion) {
            None => direction_world,
            Some(index) => self.now_from_then[index].rotation * direction_world,
        }
    }
}
