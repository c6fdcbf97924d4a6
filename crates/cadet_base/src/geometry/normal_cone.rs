//! Cones of normals: whole clusters that show a viewer nothing but their backs.
//!
//! The test is the usual one of clusters of triangles (e.g. Wihlidal, "Optimizing the Graphics Pipeline with Compute",
//! GDC 2016).

use crate::math::Vec3;

/// What vertices lose when they are rounded to single precision in the world may turn small faces by as much; radians.
const ROUNDING_RAD: f32 = 0.03;

/// A cone about the normals of faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalCone {
    axis: Vec3,
    /// The sine of the half angle between the axis and the normal farthest from it; more than 1 for cones that nothing is
    /// certain of.
    sine: f32,
}

impl NormalCone {
    /// The cone of which nothing is certain.
    pub(super) const NONE: Self = Self { axis: Vec3::ZERO, sine: f32::INFINITY };

    /// The cone about the normals of triangles, corners counter-clockwise seen from outside.
    pub(super) fn of(triangles: impl Iterator<Item = [Vec3; 3]> + Clone) -> Self {
        let normals = triangles.map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero());
        let axis = normals.clone().fold(Vec3::ZERO, |sum, n| sum + n).normalize_or_zero();
        // Triangles without an area hide and show nothing.
        let cosine = normals.filter(|n| *n != Vec3::ZERO).map(|n| n.dot(axis)).fold(1.0, f32::min);
        if axis == Vec3::ZERO || cosine < 0.1 {
            return Self::NONE;
        }
        Self { axis, sine: (1.0 - cosine * cosine).max(0.0).sqrt() + ROUNDING_RAD }
    }

    /// True if the faces in a sphere show their backs to every viewer within `reach_m` of `eye`.
    #[inline(always)]
    #[must_use]
    pub fn is_turned_away(&self, center: Vec3, radius_m: f32, eye: Vec3, reach_m: f32) -> bool {
        let from_eye = center - eye;
        // From the eye to a point of a face and along its normal: at most the angle to the middle and those of cone and
        // sphere apart.
        from_eye.dot(self.axis) >= self.sine * from_eye.length() + radius_m + reach_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    fn volume([a, b, c]: [Vec3; 3], eye: Vec3) -> f64 {
        let [a, b, c, eye] = [a, b, c, eye].map(Vec3::as_dvec3);
        (a - eye).dot((b - a).cross(c - a))
    }

    #[test]
    fn what_is_turned_away_shows_its_back_to_every_eye_in_reach() {
        let mut random = Stream::from_seed("cones", 1);
        let mut vector = move |size: f64| Vec3::from_array([(); 3].map(|()| random.range(-size, size) as f32));
        let mut num_turned_away = 0;
        for i in 0..4000 {
            let roughness = [0.0, 0.1, 0.5][i % 3];
            let [center, along, across] = [vector(2.0), vector(1.0), vector(1.0)];
            let triangles: Vec<[Vec3; 3]> = (0..6)
                .map(|k| {
                    let corner = center + along * k as f32;
                    [corner, corner + along, corner + across].map(|p| p + vector(roughness))
                })
                .collect();
            let corners = || triangles.iter().flatten();
            let middle = corners().fold(Vec3::ZERO, |sum, p| sum + *p) / 18.0;
            let radius_m = corners().map(|p| p.distance(middle)).fold(0.0, f32::max);
            let cone = NormalCone::of(triangles.iter().copied());
            let (eye, reach_m) = (vector(20.0), 0.2);
            if cone.is_turned_away(middle, radius_m, eye, reach_m) {
                num_turned_away += 1;
                for moved in [Vec3::ZERO, vector(0.1), vector(0.1)] {
                    assert!(triangles.iter().all(|t| volume(*t, eye + moved) > 0.0), "{i}");
                }
            }
        }
        assert!(num_turned_away > 800, "{num_turned_away}");
    }

    #[test]
    fn a_flat_face_is_turned_away_from_behind_alone_and_a_fan_all_around_never() {
        let face = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let cone = NormalCone::of([face, [Vec3::X; 3]].into_iter());
        for (z, expected) in [(-5.0, true), (5.0, false), (-0.1, false)] {
            assert_eq!(
                cone.is_turned_away(Vec3::new(0.3, 0.3, 0.0), 1.0, Vec3::new(0.3, 0.3, z), 0.0),
                expected,
                "{z}"
            );
        }
        let both = NormalCone::of([face, [Vec3::ZERO, Vec3::Y, Vec3::X]].into_iter());
        assert!(!both.is_turned_away(Vec3::ZERO, 0.1, Vec3::new(0.0, 0.0, -5.0), 0.0));
    }
}
