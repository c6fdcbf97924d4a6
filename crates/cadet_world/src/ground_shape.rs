//! The ground as a shape of parry's: rays find its triangles through the ground's own grid, since wheels' rays are short
//! and upright, and a tree over all of the ground would be deep.

use std::sync::Arc;

use rapier3d::parry::bounding_volume::{Aabb, BoundingSphere};
use rapier3d::parry::mass_properties::MassProperties;
use rapier3d::parry::math::{Real, Vector};
use rapier3d::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use rapier3d::parry::shape::{FeatureId, Shape, ShapeType, Triangle, TypedShape};

use cadet_base::geometry::Bounds;
use cadet_base::math::DVec2;
use cadet_town::Town;

/// The triangles of a town's ground, in the world's coordinates. Rays meet both of their sides.
#[derive(Clone)]
pub(super) struct GroundShape {
    town: Arc<Town>,
    bounds: Bounds,
}

impl GroundShape {
    /// The ground of a town.
    pub fn new(town: Arc<Town>) -> Self {
        let bounds = Bounds::of(town.ground.vertices.iter().copied());
        Self { town, bounds }
    }

    /// Bounds of all triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn triangle(&self, face: u32) -> Triangle {
        let ground = &self.town.ground;
        let [a, b, c] = ground.faces[face as usize].map(|i| ground.vertices[i as usize]);
        Triangle::new(a, b, c)
    }

    /// The nearest point of any triangle. Nobody asks in earnest, so each is looked at.
    fn nearest(&self, point: Vector, solid: bool) -> PointProjection {
        let faces = 0..self.town.ground.faces.len() as u32;
        let all = faces.map(|f| self.triangle(f).project_local_point(point, solid));
        all.min_by(|a, b| a.point.distance_squared(point).total_cmp(&b.point.distance_squared(point)))
            .unwrap_or(PointProjection::new(false, self.bounds.min))
    }
}

impl RayCast for GroundShape {
    fn cast_local_ray_and_get_normal(&self, ray: &Ray, max_toi: Real, solid: bool) -> Option<RayIntersection> {
        let [from, way] = [ray.origin, ray.dir].map(|v| DVec2::new(v.x.into(), v.y.into()));
        let to = from + way * f64::from(max_toi);
        // A hair's breadth more, so that rounding loses nothing.
        let (low, high) = (from.min(to) - 1e-3, from.max(to) + 1e-3);
        let mut best: Option<RayIntersection> = None;
        for face in self.town.ground.faces_about(low, high) {
            let limit = best.map_or(max_toi, |b| b.time_of_impact);
            match self.triangle(face).cast_local_ray_and_get_normal(ray, limit, solid) {
                Some(hit) if best.is_none() || hit.time_of_impact < limit => best = Some(hit.with_subshape(face)),
                _ => {}
            }
        }
        best
    }
}

impl PointQuery for GroundShape {
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        self.nearest(point, solid)
    }

    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        (self.nearest(point, false), FeatureId::Unknown)
    }
}

impl Shape for GroundShape {
    fn compute_local_aabb(&self) -> Aabb {
        Aabb::new(self.bounds.min, self.bounds.max)
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere::new(self.bounds.center(), self.bounds.size().length() / 2.0)
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn scale_dyn(&self, _: Vector, _: u32) -> Option<Box<dyn Shape>> {
        None
    }

    fn mass_properties(&self, _: Real) -> MassProperties {
        MassProperties::default()
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        0.0
    }

    fn ccd_angular_thickness(&self) -> Real {
        std::f32::consts::FRAC_PI_4
    }
}

#[cfg(test)]
mod tests {
    use rapier3d::parry::shape::TriMesh;

    use super::*;
    use cadet_base::rng::{Stream, StreamKey};
    use cadet_town::{PropConfig, SuburbConfig};

    #[test]
    fn rays_meet_what_they_meet_in_parrys_mesh() {
        let suburb = SuburbConfig { blocks: (2, 2), ..Default::default() };
        let town = Town::suburb(&StreamKey::scene(3), &suburb, &PropConfig::default()).unwrap();
        let mesh = TriMesh::new(town.ground.vertices.to_vec(), town.ground.faces.to_vec()).unwrap();
        let shape = GroundShape::new(Arc::new(town));
        let (min, max) = (shape.bounds().min, shape.bounds().max);
        let mut s = Stream::from_seed("rays", 0);
        let mut draw = |lo: f32, hi: f32| s.range(lo.into(), hi.into()) as f32;
        let mut num_met = 0;
        for i in 0..20_000 {
            let origin = Vector::new(draw(min.x, max.x), draw(min.y, max.y), max.z + draw(0.0, 2.0));
            // Upright, leaning, and nearly level ones.
            let lean = [0.0, 0.3, 4.0][i % 3];
            let ray = Ray::new(origin, Vector::new(draw(-lean, lean), draw(-lean, lean), -1.0));
            let reach = draw(0.5, 1.5) * (max.z - min.z + 2.0);
            let ours = shape.cast_local_ray_and_get_normal(&ray, reach, true);
            let theirs = mesh.cast_local_ray_and_get_normal(&ray, reach, true);
            let met = |hit: Option<RayIntersection>| hit.map(|h| h.time_of_impact);
            assert_eq!(met(ours), met(theirs), "{ray:?}");
            if let (Some(a), Some(b)) = (ours, theirs) {
                assert!(a.subshape != b.subshape || a.normal == b.normal, "{ray:?}");
                num_met += 1;
            }
        }
        assert!(num_met > 10_000, "{num_met} of 20000 rays met the ground");
    }

    #[test]
    fn the_nearest_point_under_a_height_is_below_it() {
        let shape = GroundShape::new(Arc::new(Town::flat()));
        let found = shape.project_local_point(Vector::new(3.0, -4.0, 2.5), false);
        assert!((found.point - Vector::new(3.0, -4.0, 0.0)).length() < 1e-6);
    }
}
