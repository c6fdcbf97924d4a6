//! Rays into a world that moves while they are cast, by parry: what a turning LIDAR needs.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Arc;

use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;

use super::face_trees::{FaceTrees, LOOSE_M};
use crate::sense::grids::{FaceHit, SurfaceHits};
use crate::sense::scene::{PosedInstance, PosedScene, RigidMotion};
use cadet_base::math::{DMat3, DPose3, DVec3};

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
    local_from_world: DMat3,
    origin_world: DVec3,
    over_faces: Arc<Bvh>,
    /// Index into the motions, None at rest.
    motion: Option<usize>,
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
            instances.push(Some(MovingInstance {
                local_from_world: posed.placement.rotation.transpose(),
                origin_world: posed.placement.translation,
                over_faces: trees.of(&posed.mesh),
                motion,
            }));
            boxes.push((index, Aabb::from_points(posed.places_world()).loosened(LOOSE_M + 1.001 * swept_m as f32)));
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
        let instant_from_moment = (0..self.motions.len()).map(|motion| self.instant_from_moment(motion, time_s));
        Moment { caster: self, instant_from_moment: instant_from_moment.collect() }
    }

    /// How an instance moves; None at rest, or where it was left out.
    pub(crate) fn motion_of(&self, instance: usize) -> Option<&RigidMotion> {
        self.instances[instance].as_ref().and_then(|i| i.motion).map(|motion| &self.motions[motion])
    }

    /// A direction `time_s` after the instant as it stands to an instance's triangles where [`PosedScene`] has them.
    #[must_use]
    pub fn direction_at_instant(&self, instance: u32, direction_world: DVec3, time_s: f64) -> DVec3 {
        match self.instances[instance as usize].as_ref().and_then(|f| f.motion) {
            None => direction_world,
            Some(motion) => self.instant_from_moment(motion, time_s).rotation * direction_world,
        }
    }

    /// Takes what is fixed to the bodies of a motion from where it is `time_s` after the instant to where it was at it.
    fn instant_from_moment(&self, motion: usize, time_s: f64) -> DPose3 {
        self.motions[motion].displacement(time_s).inverse()
    }
}

/// A moving world at one moment.
pub struct Moment<'a> {
    caster: &'a MovingCaster,
    /// By motions.
    instant_from_moment: Vec<DPose3>,
}

impl Moment<'_> {
    /// What the ray from `origin_world` along the unit vector `direction_world` meets at this moment.
    #[must_use]
    pub fn cast(&self, origin_world: DVec3, direction_world: DVec3) -> SurfaceHits {
        let [opaque, transparent] = self.nearest(origin_world, direction_world);
        SurfaceHits { opaque, transparent: transparent.filter(|t| opaque.is_none_or(|o| t.range_m < o.range_m)) }
    }

    /// A ray as it stands to the bodies of a motion where the scene has them.
    #[inline]
    fn ray_at_instant(&self, motion: Option<usize>, origin_world: DVec3, direction_world: DVec3) -> (DVec3, DVec3) {
        match motion {
            None => (origin_world, direction_world),
            Some(index) => {
                let back = &self.instant_from_moment[index];
                (back.transform_point(origin_world), back.rotation * direction_world)
            }
        }
    }

    /// How a ray meets a triangle; None if it passes beside.
    pub(crate) fn cast_at(
        &self,
        [origin_world, direction_world]: [DVec3; 2],
        instance: u32,
        face: u32,
    ) -> Option<FaceHit> {
        let motion = self.caster.instances[instance as usize].as_ref()?.motion;
        let (origin, direction) = self.ray_at_instant(motion, origin_world, direction_world);
        let corners = self.caster.scene.corners(instance, face).map(|p| p.as_dvec3());
        meet(corners, origin, direction).map(|(range_m, cos_incidence)| FaceHit {
            range_m,
            instance,
            face,
            cos_incidence,
        })
    }

    /// The first triangle on a ray, opaque or transparent.
    pub(super) fn first(&self, origin_world: DVec3, direction_world: DVec3) -> Option<FaceHit> {
        let hits = self.nearest(origin_world, direction_world).into_iter().flatten();
        hits.reduce(|a, b| if b.is_before(&a) { b } else { a })
    }

    /// The nearest opaque triangle, and the nearest transparent one that is not behind it.
    fn nearest(&self, origin_world: DVec3, direction_world: DVec3) -> [Option<FaceHit>; 2] {
        let caster = self.caster;
        let ray_world = Ray::new(origin_world.as_vec3(), direction_world.as_vec3());
        let (opaque, transparent) = (Cell::new(None::<FaceHit>), Cell::new(None::<FaceHit>));
        let _ = caster.over_instances.cast_ray(&ray_world, f32::MAX, |instance, _| {
            let moving = caster.instances[instance as usize].as_ref()?;
            let (origin, direction) = self.ray_at_instant(moving.motion, origin_world, direction_world);
            let local = |v: DVec3| (moving.local_from_world * v).as_vec3();
            let ray = Ray::new(local(origin - moving.origin_world), local(direction));
            let limit_m = opaque.get().map_or(f32::MAX, |o| outward(o.range_m));
            let _ = moving.over_faces.cast_ray(&ray, limit_m, |face, _| {
                let corners = caster.scene.corners(instance, face).map(|p| p.as_dvec3());
                let (range_m, cos_incidence) = meet(corners, origin, direction)?;
                let hit = FaceHit { range_m, instance, face, cos_incidence };
                let is_transparent = caster.scene.instances[instance as usize].material(face).is_transparent();
                let best = if is_transparent { &transparent } else { &opaque };
                if best.get().is_none_or(|b| hit.is_before(&b)) {
                    best.set(Some(hit));
                }
                // Transparent surfaces don't end the search.
                (!is_transparent).then(|| outward(range_m))
            });
            opaque.get().filter(|o| o.instance == instance).map(|o| outward(o.range_m))
        });
        [opaque.get(), transparent.get()]
    }
}

/// A bound in single precision that is certainly beyond `range_m`, so that equal hits and rounded boxes stay in play.
fn outward(range_m: f64) -> f32 {
    (range_m * (1.0 + 1e-5) + 1e-3) as f32
}

/// Distance to a triangle along a unit direction, from either side, and the cosine of the incidence angle.
fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f32)> {
    let (a, b, c) = (a - origin, b - origin, c - origin);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n.dot(direction));
    let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
    let normal = (b - a).cross(c - a);
    let facing = normal.dot(direction);
    let range = a.dot(normal) / facing;
    (inside && range.is_finite() && range > 0.0).then(|| (range, (facing.abs() / normal.length()) as f32))
}
