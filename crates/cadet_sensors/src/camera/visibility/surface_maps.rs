//! Maps of what the pixels' surfaces do: which way they face, how they move, and how the image moves with them.

use super::visibility_pass::Visibility;
use crate::camera::model::SurfaceMaps;
use crate::sense::{BeamGrid, PosedScene, RigidMotion};
use cadet_base::math::{DPose3, DVec2, DVec3};

/// Which maps of surfaces are made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceMapKinds {
    /// [`SurfaceMaps::normal_cam`].
    pub normals: bool,
    /// [`SurfaceMaps::velocity_cam_m_per_s`].
    pub scene_flow: bool,
    /// [`SurfaceMaps::flow_px`], over so many seconds.
    pub optical_flow_s: Option<f64>,
}

/// How a camera and what it sees move at the instant of its image.
#[derive(Clone, Copy)]
pub struct Motions<'a> {
    /// The camera's motion.
    pub camera: RigidMotion,
    /// How an actor moves, by its id.
    pub of_actor: &'a dyn Fn(i32) -> RigidMotion,
}

/// How an actor moves, seen from the camera.
struct Seen {
    actor_id: i32,
    /// Of the actor's point in the optical center.
    velocity_cam_m_per_s: DVec3,
    angular_velocity_cam: DVec3,
    /// Takes points from where the camera sees them to where it will, if the flow is wanted.
    then_from_now: Option<DPose3>,
}

impl Visibility {
    /// What the surfaces at the pixels' centers do. `scene` is the one that was looked at, and `pixel_of` tells where in the
    /// camera's image a ray of the view's axes falls, if anywhere.
    #[must_use]
    pub fn surface_maps(
        &self,
        scene: &PosedScene,
        pixel_of: impl Fn(DVec3) -> Option<DVec2>,
        motions: &Motions<'_>,
        kinds: &SurfaceMapKinds,
    ) -> SurfaceMaps {
        if *kinds == SurfaceMapKinds::default() {
            return SurfaceMaps::default();
        }
        let world_from_cam = self.grid.world_from_grid();
        let cam_from_world = world_from_cam.inverse();
        let then_from_world =
            kinds.optical_flow_s.map(|time_s| (motions.camera.displacement(time_s) * world_from_cam).inverse());
        let seen_of = |actor_id: i32| {
            let motion = if actor_id > 0 { (motions.of_actor)(actor_id) } else { RigidMotion::default() };
            let at_eye = motion.velocity_world
                + motion.angular_velocity_world.cross(world_from_cam.translation - motion.pivot_world);
            Seen {
                actor_id,
                velocity_cam_m_per_s: cam_from_world.rotation * at_eye,
                angular_velocity_cam: cam_from_world.rotation * motion.angular_velocity_world,
                then_from_now: then_from_world
                    .zip(kinds.optical_flow_s)
                    .map(|(then_from_world, time_s)| then_from_world * motion.displacement(time_s) * world_from_cam),
            }
        };
        let room = |is_wanted: bool| if is_wanted { self.num_pixels() } else { 0 };
        let mut maps = SurfaceMaps {
            normal_cam: vec![[0.0; 3]; room(kinds.normals)],
            velocity_cam_m_per_s: vec![[0.0; 3]; room(kinds.scene_flow)],
            flow_px: vec![[f32::NAN; 2]; room(kinds.optical_flow_s.is_some())],
        };
        let mut seen = seen_of(0);
        self.each_center(|at, face, [x, y]| {
            let actor_id = scene.instances[face.instance as usize].actor_id;
            if seen.actor_id != actor_id {
                seen = seen_of(actor_id);
            }
            let point_cam = DVec3::new(x, y, 1.0) * face.exact_depth_m_at(x, y);
            if kinds.normals {
                maps.normal_cam[at] = single(face.normal_cam());
            }
            if kinds.scene_flow {
                let turned = seen.angular_velocity_cam.cross(point_cam);
                maps.velocity_cam_m_per_s[at] = single(seen.velocity_cam_m_per_s + turned);
            }
            if let Some(then_from_now) = &seen.then_from_now {
                let now = pixel_of(DVec3::new(x, y, 1.0));
                if let (Some(now), Some(then)) = (now, pixel_of(then_from_now.transform_point(point_cam))) {
                    let flow = then - now;
                    maps.flow_px[at] = [flow.x as f32, flow.y as f32];
                }
            }
        });
        maps
    }
}

fn single(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
