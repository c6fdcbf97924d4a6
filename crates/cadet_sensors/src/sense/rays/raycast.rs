//! Arbitrary rays, by parry's bounding volume hierarchies.

use std::sync::Arc;

use super::face_trees::FaceTrees;
use super::moving::MovingCaster;
use crate::sense::grids::{FaceHit, Hits};
use crate::sense::scene::{PosedScene, RigidMotion};
use cadet_base::error::{Error, Result, finite};
use cadet_base::material::Material;
use cadet_base::math::DVec3;

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

/// Casts single rays into a scene, by the trees of a [`MovingCaster`] in which nothing moves.
pub struct RayCaster(MovingCaster);

impl RayCaster {
    /// Builds the trees.
    #[must_use]
    pub fn new(scene: Arc<PosedScene>) -> Self {
        Self(MovingCaster::new(scene, &mut FaceTrees::default(), |_| RigidMotion::default(), 0.0, |_| true))
    }

    /// The scene that the rays meet.
    #[must_use]
    pub fn scene(&self) -> &Arc<PosedScene> {
        self.0.scene()
    }

    /// What beams meet first, of glass too: where each starts, and its unit direction.
    pub(crate) fn cast_beams(&self, beams_world: impl Iterator<Item = [DVec3; 2]>, hits: &mut Hits) {
        let still = self.0.at(0.0);
        for (at, [origin_world, direction_world]) in beams_world.enumerate() {
            if let Some(hit) = still.first(origin_world, direction_world) {
                hits.put(at, &hit);
            }
        }
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
        let first = self.0.at(0.0).first(origin_world, direction_world);
        Ok(first.map(|FaceHit { range_m, instance, face, .. }| {
            let posed = &self.scene().instances[instance as usize];
            let [a, b, c] = self.scene().corners(instance, face).map(|p| p.as_dvec3());
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
}
