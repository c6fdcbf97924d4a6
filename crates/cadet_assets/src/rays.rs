//! Rays cast at meshes, for tests.

use parry3d::query::{Ray, RayCast};
use parry3d::shape::TriMesh;

use cadet_base::geometry::Mesh;
use cadet_base::math::Vec3;

/// Where a ray meets a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    pub point: Vec3,
    pub range_m: f32,
    pub slot: u8,
    /// The face's outside was hit.
    pub is_outside: bool,
}

/// The faces of some slots, for casting many rays at.
pub(crate) struct Target {
    shape: TriMesh,
    faces: Vec<([Vec3; 3], u8)>,
}

impl Target {
    pub fn new(mesh: &Mesh, keep: impl Fn(u8) -> bool) -> Self {
        let faces: Vec<([Vec3; 3], u8)> = mesh.triangles().filter(|(_, s)| keep(*s)).collect();
        let vertices = faces.iter().flat_map(|(c, _)| *c).collect();
        let indices = (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self { shape: TriMesh::new(vertices, indices).unwrap(), faces }
    }

    /// The first face on a ray.
    pub fn cast(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let direction = direction.normalize();
        let hit = self.shape.cast_local_ray_and_get_normal(&Ray::new(origin, direction), 100.0, false)?;
        let ([a, b, c], slot) = self.faces[hit.subshape as usize];
        let range_m = hit.time_of_impact;
        let is_outside = (b - a).cross(c - a).dot(direction) < 0.0;
        Some(Hit { point: origin + direction * range_m, range_m, slot, is_outside })
    }
}

/// All faces of some slots on a ray, the nearest first, by Moeller and Trumbore.
pub(crate) fn hits(mesh: &Mesh, origin: Vec3, direction: Vec3, keep: impl Fn(u8) -> bool) -> Vec<Hit> {
    let hit = |([a, b, c], slot): ([Vec3; 3], u8)| {
        let (e1, e2, t) = (b - a, c - a, origin - a);
        let (p, q) = (direction.cross(e2), t.cross(e1));
        let det = e1.dot(p);
        let (u, v, range_m) = (t.dot(p) / det, direction.dot(q) / det, e2.dot(q) / det);
        let is_hit = det.abs() >= 1e-9 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && range_m > 0.0;
        is_hit.then_some(Hit { point: origin + direction * range_m, range_m, slot, is_outside: det > 0.0 })
    };
    let mut found: Vec<Hit> = mesh.triangles().filter(|(_, slot)| keep(*slot)).filter_map(hit).collect();
    found.sort_by(|x, y| x.range_m.total_cmp(&y.range_m));
    found
}
