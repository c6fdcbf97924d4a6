//! The triangles of one instance under rays.

use std::sync::Arc;

use parry3d::partitioning::Bvh;
use parry3d::query::Ray;

use super::face_trees::FaceTrees;
use super::posed::{PosedInstance, PosedScene};
use crate::math::{DMat3, DVec3};

/// A triangle that a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceHit {
    /// Distance from the ray's origin.
    pub range_m: f64,
    /// Index into [`PosedScene::instances`].
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
}

impl FaceHit {
    /// Nearer, or of two equally near ones the earlier instance and face.
    pub(super) fn is_before(&self, other: &Self) -> bool {
        self.range_m < other.range_m
            || (self.range_m == other.range_m && (self.instance, self.face) < (other.instance, other.face))
    }
}

/// An instance's frame and the tree over its mesh's faces.
pub(super) struct InstanceTree {
    local_from_world: DMat3,
    origin_world: DVec3,
    over_faces: Arc<Bvh>,
}

impl InstanceTree {
    pub fn new(posed: &PosedInstance, trees: &mut FaceTrees) -> Self {
        Self {
            local_from_world: posed.placement.rotation.transpose(),
            origin_world: posed.placement.translation,
            over_faces: trees.of(&posed.mesh),
        }
    }

    /// Calls `found` for faces on a ray with a unit direction; it returns a range beyond which nothing matters, meters, or
    /// `None` for a face that ends no search.
    ///
    /// `instance`: the instance's number in `scene`; `limit_m`: how far the search reaches at first.
    pub fn cast(
        &self,
        scene: &PosedScene,
        instance: u32,
        [origin_world, direction_world]: [DVec3; 2],
        limit_m: f32,
        found: impl Fn(FaceHit) -> Option<f32>,
    ) {
        let local = |v: DVec3| (self.local_from_world * v).as_vec3();
        let ray = Ray::new(local(origin_world - self.origin_world), local(direction_world));
        let _ = self.over_faces.cast_ray(&ray, limit_m, |face, _| {
            let corners = scene.corners(instance, face).map(|p| p.as_dvec3());
            let range_m = meet(corners, origin_world, direction_world)?;
            found(FaceHit { range_m, instance, face })
        });
    }
}

/// A bound in single precision that is certainly beyond `range_m`, so that equal hits and rounded boxes stay in play.
pub(super) fn outward(range_m: f64) -> f32 {
    (range_m * (1.0 + 1e-5) + 1e-3) as f32
}

/// Distance to a triangle along a unit direction, from either side.
fn meet([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (a, b, c) = (a - origin, b - origin, c - origin);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| n.dot(direction));
    let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
    let normal = (b - a).cross(c - a);
    let range = a.dot(normal) / normal.dot(direction);
    (inside && range.is_finite() && range > 0.0).then_some(range)
}
