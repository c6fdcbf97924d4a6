//! The triangles of a snapshot in world coordinates: one set, the same for every sensor and for the user.
//!
//! Instances are posed on demand: a scan sees a fifth of a street's vertices. Every caller gets the same
//! bits, as a vertex always goes through [`Placement`].

use std::sync::Arc;

use super::detail::{Resolution, distance_m};
use cadet_base::geometry::{LANES, Lanes, Mesh, face_number};
use cadet_base::instance::Instance;
use cadet_base::lamp::Lamp;
use cadet_base::material::{Material, Palette};
use cadet_base::math::{DMat3, DPose3, DVec3, Vec3};

/// Where a mesh stands. World coordinates are computed in double precision and rounded to single: no sensor sees
/// anything finer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Rotation from the mesh's frame to the world's.
    pub rotation: DMat3,
    /// The origin of the mesh's frame in the world.
    pub translation: DVec3,
}

impl Placement {
    /// The placement of a pose.
    #[must_use]
    pub fn new(world_from_local: &DPose3) -> Self {
        Self { rotation: DMat3::from_quat(world_from_local.rotation), translation: world_from_local.translation }
    }

    /// A vertex in the world.
    #[inline]
    #[must_use]
    pub fn pose(&self, vertex_local: Vec3) -> Vec3 {
        let [x, y, z] = self.pose_axes(vertex_local.to_array().map(f64::from));
        Vec3::new(x as f32, y as f32, z as f32)
    }

    /// [`LANES`] vertices in the world.
    #[inline(always)]
    #[must_use]
    pub fn pose_lanes(&self, local: &Lanes) -> Lanes {
        let mut world = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let [x, y, z] = self.pose_axes([local[0][i].into(), local[1][i].into(), local[2][i].into()]);
            (world[0][i], world[1][i], world[2][i]) = (x as f32, y as f32, z as f32);
        }
        world
    }

    /// The one place that fixes the order of the sums.
    #[inline(always)]
    fn pose_axes(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (r, t) = (&self.rotation, &self.translation);
        [
            r.x_axis.x * x + r.y_axis.x * y + r.z_axis.x * z + t.x,
            r.x_axis.y * x + r.y_axis.y * y + r.z_axis.y * z + t.y,
            r.x_axis.z * x + r.y_axis.z * y + r.z_axis.z * z + t.z,
        ]
    }
}

/// One instance at its level of detail.
#[derive(Debug, Clone)]
pub struct PosedInstance {
    /// The mesh at the chosen level of detail.
    pub mesh: Arc<Mesh>,
    /// What casts its shadow in the sun.
    pub shadow_proxy: Arc<Mesh>,
    /// Its materials.
    pub palette: Arc<Palette>,
    /// Where it stands.
    pub placement: Placement,
    /// 0 for the static world, at least 1 for actors.
    pub actor_id: i32,
    /// Whether it is an actor's body.
    pub is_body: bool,
    /// Whether snow does not stay on it.
    pub sheds_snow: bool,
    /// Middle of the bounding sphere.
    pub center_world: DVec3,
    /// Radius of the bounding sphere.
    pub radius_m: f64,
}

impl PosedInstance {
    /// The material of a face.
    #[inline]
    #[must_use]
    pub fn material(&self, face: u32) -> &Material {
        &self.palette.materials()[usize::from(self.mesh.face(face).slot)]
    }

    /// Whether snow does not stay where it has this material: on vehicles that drive. It does stay on their riders.
    #[inline]
    #[must_use]
    pub fn is_without_snow(&self, material: &Material) -> bool {
        self.sheds_snow && material.semantic.is_vehicle()
    }

    /// True if some of its bounding sphere is nearer to a place than `reach_m`.
    #[must_use]
    pub fn is_within(&self, place_world: DVec3, reach_m: f64) -> bool {
        (self.center_world - place_world).length() - self.radius_m < reach_m
    }

    /// The corners of a face in the world.
    #[inline]
    #[must_use]
    pub fn corners_world(&self, face: u32) -> [Vec3; 3] {
        self.mesh.corners(face).map(|corner| self.placement.pose(corner))
    }

    /// The unit normal of a face in the world; zero for a face without area.
    #[must_use]
    pub fn normal_world(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.mesh.corners(face).map(|corner| corner.as_dvec3());
        self.placement.rotation * (b - a).cross(c - a).normalize_or_zero()
    }

    /// The places of its corners in the world, in the mesh's order.
    pub fn places_world(&self) -> impl Iterator<Item = Vec3> {
        self.mesh.places().map(|place| self.placement.pose(place))
    }
}

/// All triangles of a scene.
#[derive(Debug, Clone, Default)]
pub struct IndexedTriangles {
    /// In the world.
    pub vertices: Vec<Vec3>,
    /// Three indices of vertices a triangle.
    pub faces: Vec<[u32; 3]>,
    /// The instance of each triangle, and its face in that one's mesh.
    pub owners: Vec<(u32, u32)>,
}

/// A light source in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosedLamp {
    /// In the world.
    pub lamp: Lamp,
    /// The actor that carries it; 0 for the static world and the car that carries the sensors.
    pub actor_id: i32,
}

/// The very triangles that the sensors see.
#[derive(Debug, Clone)]
pub struct PosedScene {
    /// The instances, in the snapshot's order, without those that are too far to matter.
    pub instances: Vec<PosedInstance>,
    /// What shines at night.
    pub lamps: Vec<PosedLamp>,
}

impl PosedScene {
    /// As [`PosedScene::for_resolution`], for sensors as fine as KITTI's.
    #[must_use]
    pub fn new(instances: &[Instance], viewer_world: DVec3) -> Self {
        Self::for_resolution(instances, viewer_world, Resolution::KITTI)
    }

    /// Chooses levels of detail by the distance to `viewer_world` (the ego) and the sensors' resolution, and leaves out what is
    /// too small at its distance.
    #[must_use]
    pub fn for_resolution(instances: &[Instance], viewer_world: DVec3, resolution: Resolution) -> Self {
        let mut scene = Self { instances: Vec::with_capacity(instances.len()), lamps: Vec::new() };
        let detail = resolution.reach_factor();
        for instance in instances {
            let distance_m = distance_m(instance, viewer_world);
            // Wheels and drivers wear the palette of their vehicle.
            if instance.is_body || instance.actor_id == 0 {
                let placed = |lamp: &Lamp| lamp.placed(&instance.world_from_local);
                let posed = |lamp| PosedLamp { lamp: placed(lamp), actor_id: instance.actor_id };
                scene.lamps.extend(instance.palette.lamps().iter().map(posed));
            }
            let Some((mesh, shadow_proxy)) = instance.shape.select_with_shadow_proxy(distance_m, detail) else {
                continue;
            };
            let placement = Placement::new(&instance.world_from_local);
            scene.instances.push(PosedInstance {
                mesh: Arc::clone(mesh),
                shadow_proxy: Arc::clone(shadow_proxy),
                palette: Arc::clone(&instance.palette),
                placement,
                actor_id: instance.actor_id,
                is_body: instance.is_body,
                sheds_snow: instance.sheds_snow,
                center_world: placement.rotation * mesh.bounds.center().as_dvec3() + placement.translation,
                radius_m: f64::from(mesh.bounds.size().length()) / 2.0 + 1e-3,
            });
        }
        scene
    }

    /// Returns the scene with its actors elsewhere: `displacement_of` tells by their ids what takes them from where
    /// they are.
    #[must_use]
    pub fn moved(&self, displacement_of: impl Fn(i32) -> DPose3) -> Self {
        let mut scene = self.clone();
        for instance in scene.instances.iter_mut().filter(|i| i.actor_id > 0) {
            let displacement = displacement_of(instance.actor_id);
            let Placement { rotation, translation } = &mut instance.placement;
            *rotation = DMat3::from_quat(displacement.rotation) * *rotation;
            *translation = displacement.transform_point(*translation);
            instance.center_world = displacement.transform_point(instance.center_world);
        }
        for posed in scene.lamps.iter_mut().filter(|posed| posed.actor_id > 0) {
            posed.lamp = posed.lamp.placed(&displacement_of(posed.actor_id));
        }
        scene
    }

    /// Adds lamps to the scene, such as those of the car that carries the sensors.
    #[must_use]
    pub fn with_lamps(mut self, lamps_world: &[Lamp]) -> Self {
        self.lamps.extend(lamps_world.iter().map(|lamp| PosedLamp { lamp: *lamp, actor_id: 0 }));
        self
    }

    /// All triangles as one indexed mesh in the world, instance after instance.
    #[must_use]
    pub fn indexed_triangles(&self) -> IndexedTriangles {
        let mut all = IndexedTriangles::default();
        for (index, instance) in (0..).zip(&self.instances) {
            for (number, cluster) in (0..).zip(instance.mesh.clusters.iter()) {
                let start = all.vertices.len() as u32;
                all.vertices.extend(cluster.places().map(|place| instance.placement.pose(place)));
                all.faces.extend(cluster.faces.iter().map(|face| face.corners.map(|corner| start + u32::from(corner))));
                all.owners.extend((0..cluster.faces.len()).map(|place| (index, face_number(number, place))));
            }
        }
        all
    }

    /// The corners of a face in the world.
    #[inline]
    #[must_use]
    pub fn corners(&self, instance: u32, face: u32) -> [Vec3; 3] {
        self.instances[instance as usize].corners_world(face)
    }

    /// Number of triangles.
    #[must_use]
    pub fn num_triangles(&self) -> usize {
        self.instances.iter().map(|i| i.mesh.num_faces()).sum()
    }
}
