//! The triangles of a snapshot in world coordinates: one set, the same for every sensor and for the user.

use std::ops::Range;
use std::sync::Arc;

use crate::geometry::Mesh;
use crate::instance::Instance;
use crate::material::{Material, Palette};
use crate::math::{DMat3, DVec3, Vec3};

/// One instance, its level of detail chosen and its vertices posed.
#[derive(Debug, Clone)]
pub struct PosedInstance {
    /// The mesh at the chosen level of detail.
    pub mesh: Arc<Mesh>,
    /// Its materials.
    pub palette: Arc<Palette>,
    /// Rotation from the mesh's frame to the world's.
    pub world_from_local: DMat3,
    /// Its vertices in [`PosedScene::vertices_world`].
    pub vertices: Range<usize>,
    /// 0 for the static world, at least 1 for actors.
    pub actor_id: i32,
    /// Middle of the bounding sphere.
    pub center_world: DVec3,
    /// Radius of the bounding sphere.
    pub radius_m: f64,
}

impl PosedInstance {
    /// The material of a face.
    #[must_use]
    pub fn material(&self, face: u32) -> &Material {
        &self.palette.0[usize::from(self.mesh.slots[face as usize])]
    }
}

/// The very triangles that the sensors see.
#[derive(Debug, Clone)]
pub struct PosedScene {
    /// All vertices, instance after instance, in single precision: no sensor sees anything finer.
    pub vertices_world: Vec<Vec3>,
    /// The instances, in the snapshot's order, without those that are too far to matter.
    pub instances: Vec<PosedInstance>,
}

impl PosedScene {
    /// Chooses levels of detail by the distance to `viewer_world` (the ego), leaves out what is too small at its
    /// distance, and poses every vertex.
    #[must_use]
    pub fn new(instances: &[Instance], viewer_world: DVec3) -> Self {
        let chosen: Vec<(&Instance, &Arc<Mesh>)> =
            instances.iter().filter_map(|i| Some((i, level_for(i, viewer_world)?))).collect();
        let num_vertices = chosen.iter().map(|(_, mesh)| mesh.vertices.len()).sum();
        let mut scene =
            Self { vertices_world: Vec::with_capacity(num_vertices), instances: Vec::with_capacity(chosen.len()) };
        for (instance, mesh) in chosen {
            let rotation = DMat3::from_quat(instance.world_from_local.rotation);
            let translation = instance.world_from_local.translation;
            let start = scene.vertices_world.len();
            scene
                .vertices_world
                .extend(mesh.vertices.iter().map(|v| (rotation * v.as_dvec3() + translation).as_vec3()));
            let center_world = rotation * mesh.bounds.center().as_dvec3() + translation;
            let radius_m = f64::from(mesh.bounds.size().length()) / 2.0 + 1e-3;
            scene.instances.push(PosedInstance {
                palette: Arc::clone(&instance.palette),
                world_from_local: rotation,
                vertices: start..scene.vertices_world.len(),
                actor_id: instance.actor_id,
                mesh: Arc::clone(mesh),
                center_world,
                radius_m,
            });
        }
        scene
    }

    /// The corners of a face in the world.
    #[must_use]
    pub fn corners(&self, instance: u32, face: u32) -> [Vec3; 3] {
        let posed = &self.instances[instance as usize];
        let vertices = &self.vertices_world[posed.vertices.clone()];
        posed.mesh.faces[face as usize].map(|i| vertices[i as usize])
    }

    /// Number of triangles.
    #[must_use]
    pub fn num_triangles(&self) -> usize {
        self.instances.iter().map(|i| i.mesh.faces.len()).sum()
    }
}

/// The level of detail of an instance, by the distance from the viewer to the bounds of its finest level, so that the
/// choice does not depend on the choice.
fn level_for(instance: &Instance, viewer_world: DVec3) -> Option<&Arc<Mesh>> {
    let bounds = &instance.shape.finest().bounds;
    let middle = instance.world_from_local.transform_point(bounds.center().as_dvec3());
    let distance_m = ((middle - viewer_world).length() - f64::from(bounds.size().length()) / 2.0).max(0.0);
    instance.shape.select(distance_m as f32)
}
