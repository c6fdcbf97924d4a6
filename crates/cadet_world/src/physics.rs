//! The rigid-body world and the ground in it; the one place where rapier's single precision meets our doubles.

use std::sync::Arc;

use rapier3d::control::DynamicRayCastVehicleController;
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::partitioning::Bvh;
use rapier3d::parry::query::Ray;
use rapier3d::prelude::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, Pose, QueryFilter, QueryPipelineMut,
    RigidBodyBuilder, RigidBodyHandle, SharedShape, Vector,
};

use super::ground_shape::GroundShape;
use cadet_base::error::{Error, Result};
use cadet_base::math::{DPose3, DVec2, DVec3};
use cadet_town::Town;

/// One physics step, seconds.
pub const DT_S: f64 = 1.0 / 60.0;
/// Standard gravity, m/s².
pub(super) const GRAVITY_MPS2: f64 = 9.81;

/// The ground under somebody may lie so far above the height at which they were.
const STEP_M: f64 = 1.5;

const GROUND: Group = Group::GROUP_1;
const VEHICLES: Group = Group::GROUP_2;

/// Collision groups of the wheels' rays, which meet the ground alone; chassis meet each other.
fn ground_only() -> InteractionGroups {
    InteractionGroups::new(Group::ALL, GROUND, InteractionTestMode::And)
}

/// The bodies, and the ground that wheels and feet touch.
pub(super) struct Physics {
    pub world: PhysicsWorld,
    ground: SharedShape,
    /// The ground's collider alone.
    under_wheels: Bvh,
    top_z_m: f32,
    depth_m: f32,
    has_bridges: bool,
}

/// A point of the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroundPoint {
    pub z_m: f64,
}

impl Physics {
    pub fn new(town: Arc<Town>) -> Result<Self> {
        let fail = |reason: &str| Err(Error::Scene { reason: format!("ground: {reason}") });
        if town.ground.faces.is_empty() {
            return fail("no triangles");
        }
        let has_bridges = town.ground.has_bridges();
        let ground = GroundShape::new(town);
        let bounds = ground.bounds();
        if !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return fail("no vertices, or a coordinate that is not finite");
        }
        let ground = SharedShape::new(ground);
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY_MPS2 as f32);
        world.integration_parameters.dt = DT_S as f32;
        // The springs push once a step; with substeps gravity would be late, and resting cars would seem to fall.
        world.integration_parameters.num_solver_iterations = 1;
        // Wheels find the ground by rays; chassis never touch it, and looking for that contact would cost the most.
        let collider = ColliderBuilder::new(ground.clone()).collision_groups(InteractionGroups::new(
            GROUND,
            GROUND,
            InteractionTestMode::And,
        ));
        let (index, _) = world.insert_collider(collider, None).into_raw_parts();
        let mut under_wheels = Bvh::new();
        under_wheels.insert(ground.compute_local_aabb().loosened(1.0), index);
        let (top_z_m, depth_m) = (bounds.max.z + 1.0, bounds.size().z + 2.0);
        Ok(Self { world, ground, under_wheels, top_z_m, depth_m, has_bridges })
    }

    /// Lets a vehicle's wheels cast their rays, at the ground alone, and push.
    pub fn push_wheels(&mut self, controller: &mut DynamicRayCastVehicleController) {
        let world = &mut self.world;
        let queries = QueryPipelineMut {
            dispatcher: world.narrow_phase.query_dispatcher(),
            bvh: &self.under_wheels,
            bodies: &mut world.bodies,
            colliders: &mut world.colliders,
            filter: QueryFilter::exclude_dynamic().groups(ground_only()),
        };
        controller.update_vehicle(DT_S as f32, queries);
    }

    /// The ground under a place, which may lie a step below it: decks of bridges further above are passed over. `None`
    /// beyond the edge.
    pub fn ground_at(&self, at: DVec3) -> Option<GroundPoint> {
        let from_z_m = if self.has_bridges { self.top_z_m.min((at.z + STEP_M) as f32) } else { self.top_z_m };
        // A vertical ray may slip through an edge between two triangles: look a millimeter beside it.
        [(0.0, 0.0), (1e-3, 0.7e-3), (-0.8e-3, 1.1e-3)].iter().find_map(|(dx, dy)| {
            let origin = Vector::new((at.x + dx) as f32, (at.y + dy) as f32, from_z_m);
            let ray = Ray::new(origin, Vector::new(0.0, 0.0, -1.0));
            let toi = self.ground.cast_local_ray(&ray, self.depth_m, false)?;
            Some(GroundPoint { z_m: f64::from(from_z_m) - f64::from(toi) })
        })
    }

    /// The place on the uppermost ground, decks of bridges included; at height 0 beyond the edge.
    pub fn uppermost(&self, at: DVec2) -> DVec3 {
        let ground = self.ground_at(at.extend(f64::INFINITY));
        at.extend(ground.map_or(0.0, |g| g.z_m))
    }

    /// A chassis without mass of its own: the caller gives the body its mass. The cuboid is in the box frame.
    pub fn insert_vehicle(&mut self, body: RigidBodyBuilder, size_lwh: DVec3, clearance_m: f64) -> RigidBodyHandle {
        let height_m = size_lwh.z - clearance_m;
        let half = (DVec3::new(size_lwh.x, size_lwh.y, height_m) / 2.0).as_vec3();
        let collider = ColliderBuilder::cuboid(half.x, half.y, half.z)
            .translation(Vector::new(0.0, 0.0, (clearance_m + height_m / 2.0) as f32))
            .density(0.0)
            .friction(0.3)
            .collision_groups(InteractionGroups::new(VEHICLES, VEHICLES, InteractionTestMode::And));
        self.world.insert(body, collider).0
    }

    pub fn remove(&mut self, body: RigidBodyHandle) {
        self.world.remove_body(body);
    }

    pub fn step(&mut self) {
        self.world.step();
    }
}

pub(super) fn pose_f32(pose: &DPose3) -> Pose {
    Pose::from_parts(pose.translation.as_vec3(), pose.rotation.as_quat().normalize())
}

pub(super) fn pose_f64(pose: &Pose) -> DPose3 {
    DPose3 { rotation: pose.rotation.as_dquat().normalize(), translation: pose.translation.as_dvec3() }
}
