//! The rigid-body world and the ground in it; the one place where rapier's single precision meets our doubles.

use rapier3d::parry::query::Ray;
use rapier3d::parry::shape::TriMesh;
use rapier3d::prelude::{
    ColliderBuilder, Group, InteractionGroups, InteractionTestMode, PhysicsWorld, Pose, RigidBodyBuilder,
    RigidBodyHandle, SharedShape, Vector,
};

use crate::error::{Error, Result};
use crate::math::{DPose3, DVec3};
use crate::town::Ground;

/// One physics step, seconds.
pub const DT_S: f64 = 1.0 / 60.0;
/// Standard gravity, m/s².
pub(super) const GRAVITY_MPS2: f64 = 9.81;

const GROUND: Group = Group::GROUP_1;
const VEHICLES: Group = Group::GROUP_2;

/// Who meets whom: wheels' rays meet the ground alone, chassis meet each other.
pub(super) fn ground_only() -> InteractionGroups {
    InteractionGroups::new(Group::ALL, GROUND, InteractionTestMode::And)
}

/// The bodies, and the ground that wheels and feet touch.
pub(super) struct Physics {
    pub world: PhysicsWorld,
    ground: SharedShape,
    top_z_m: f32,
    depth_m: f32,
}

/// A point of the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroundPoint {
    pub z_m: f64,
}

impl Physics {
    pub fn new(ground: &Ground) -> Result<Self> {
        let fail = |reason: String| Error::Scene { reason: format!("ground: {reason}") };
        let bounds = crate::geometry::Bounds::of(ground.vertices.iter().copied());
        if !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return Err(fail("no vertices, or a coordinate that is not finite".to_owned()));
        }
        let vertices: Vec<Vector> = ground.vertices.to_vec();
        let mesh = TriMesh::new(vertices, ground.faces.to_vec()).map_err(|e| fail(e.to_string()))?;
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY_MPS2 as f32);
        world.integration_parameters.dt = DT_S as f32;
        // The springs push once a step; with substeps gravity would be late, and resting cars would seem to fall.
        world.integration_parameters.num_solver_iterations = 1;
        let mesh = SharedShape::new(mesh);
        // Wheels find the ground by rays; chassis never touch it, and looking for that contact would cost the most.
        let collider = ColliderBuilder::new(mesh.clone()).collision_groups(InteractionGroups::new(
            GROUND,
            GROUND,
            InteractionTestMode::And,
        ));
        world.insert_collider(collider, None);
        // Rays find the ground only once the broad phase knows it.
        world.step();
        Ok(Self { world, ground: mesh, top_z_m: bounds.max.z + 1.0, depth_m: bounds.size().z + 2.0 })
    }

    /// The uppermost ground at a place; `None` beyond the edge.
    pub fn ground_at(&self, x_m: f64, y_m: f64) -> Option<GroundPoint> {
        // A vertical ray may slip through an edge between two triangles: look a millimetre beside it.
        [(0.0, 0.0), (1e-3, 0.7e-3), (-0.8e-3, 1.1e-3)].iter().find_map(|(dx, dy)| {
            let origin = Vector::new((x_m + dx) as f32, (y_m + dy) as f32, self.top_z_m);
            let ray = Ray::new(origin, Vector::new(0.0, 0.0, -1.0));
            let toi = self.ground.cast_local_ray(&ray, self.depth_m, false)?;
            Some(GroundPoint { z_m: f64::from(self.top_z_m) - f64::from(toi) })
        })
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
