//! Surfaces, and the light that leaves one point of them.

use super::ambient::Open;
use super::{Key, Reference};
use crate::camera::face::clump;
use crate::camera::shading_pass::{environment, highlight};
use crate::camera::textures::{PatternPoint, albedo};
use crate::camera::value_noise::{hash2, value_noise};
use crate::geometry::{LEAST_WEIGHT, Mesh};
use crate::material::{Material, Pattern, Semantic};
use crate::math::{DVec3, Vec3};
use crate::sense::PosedInstance;

/// A face towards the eye. `corner` is the world's, `normal` that of its plane.
pub struct Surface<'a> {
    key: Key,
    posed: &'a PosedInstance,
    corners: [DVec3; 3],
    normal: Vec3,
    pub(super) material: &'a Material,
    place_hash: u32,
    is_quad: bool,
}

/// A point of a surface that the camera sees.
pub struct Point {
    world: Vec3,
    pub(super) depth_m: f32,
    /// Unit vector from the eye.
    view: Vec3,
    distance_m: f32,
}

/// Which face of a mesh stands for a face: the first of two that are a flat quadrilateral.
pub struct Half {
    pub first: u32,
    is_quad: bool,
}

pub fn halves_of(mesh: &Mesh) -> Vec<Half> {
    let mut halves: Vec<Half> = (0..mesh.faces.len() as u32).map(|first| Half { first, is_quad: false }).collect();
    for group in &mesh.clusters {
        for piece in group.pieces.iter().filter(|p| p.is_quad()) {
            let [first, second] = [0, 1].map(|k| group.faces[usize::from(piece.first) + k]);
            for face in [first, second] {
                halves[face as usize] = Half { first, is_quad: true };
            }
        }
    }
    halves
}

impl Reference {
    pub(super) fn surface(&self, key: Key) -> Surface<'_> {
        let posed = &self.scene.instances[key.0 as usize];
        let corners = self.scene.corners(key.0, key.1).map(|p| p.as_dvec3());
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let is_turned = normal.dot(a - self.view.world_from_cam.translation) > 0.0;
        let [x, y] = [posed.center_world.x, posed.center_world.y].map(|c| (c * 8.0) as i32);
        Surface {
            key,
            posed,
            corners,
            normal: if is_turned { -normal } else { normal }.as_vec3(),
            material: posed.material(key.1),
            place_hash: hash2(x, y, 0x97AC),
            is_quad: self.halves[key.0 as usize][key.1 as usize].is_quad,
        }
    }

    /// Where the ray of an image point meets a surface's plane.
    pub(super) fn point(&self, surface: &Surface<'_>, u: f64, v: f64) -> Point {
        self.point_between(surface, u, v, [0.0, 1e6])
    }

    /// The same, no nearer and no farther than some depths.
    pub(super) fn point_between(&self, surface: &Surface<'_>, u: f64, v: f64, [near, far]: [f64; 2]) -> Point {
        let (eye, direction) = (self.view.world_from_cam.translation, self.direction(u, v));
        let normal = surface.normal.as_dvec3();
        let inverse_depth = normal.dot(direction) / normal.dot(surface.corners[0] - eye);
        let (depth_m, length) = (1.0 / inverse_depth.max(1.0 / far).min(1.0 / near), direction.length());
        Point {
            world: (eye + direction * depth_m).as_vec3(),
            depth_m: depth_m as f32,
            view: (direction / length).as_vec3(),
            distance_m: (depth_m * length) as f32,
        }
    }

    pub(super) fn are_of_one_plant(&self, a: Key, b: Key) -> bool {
        a.0 == b.0 && self.scene.instances[a.0 as usize].palette.is_plant()
    }

    /// True for two faces of one instance, one material, and, but for what the eye does not see, one normal.
    pub(super) fn look_alike(&self, a: Key, b: Key) -> bool {
        let [s, t] = [a, b].map(|key| self.surface(key));
        let steps = |n: Vec3| n.to_array().map(|c| (c * 14.0 + 15.5) as u32);
        let slot = |s: &Surface| s.posed.mesh.slots[s.key.1 as usize];
        a.0 == b.0 && slot(&s) == slot(&t) && steps(s.normal) == steps(t.normal)
    }

    pub(super) fn sky_at(&self, u: f64, v: f64) -> Vec3 {
        let view = self.direction(u, v).normalize().as_vec3();
        let radiance = self.sky.visible_radiance(view);
        // Fog hides the sky as it hides what is far.
        if self.extinction_per_m > 0.004 { self.through_air(radiance, view, 400.0) } else { radiance }
    }

    /// Beer-Lambert's extinction, and the air's own light (Koschmieder 1924).
    fn through_air(&self, radiance: Vec3, view: Vec3, distance_m: f32) -> Vec3 {
        let clear = crate::math::expf(-self.extinction_per_m * distance_m);
        let air = self.sky.radiance(Vec3::new(view.x, view.y, view.z.max(0.02))) * 0.8;
        radiance * clear + air * (1.0 - clear)
    }

    fn is_ground(s: &Surface<'_>) -> bool {
        s.material.semantic.is_ground() && s.normal.z > 0.5
    }

    /// The albedo with its texture and snow.
    pub(super) fn albedo(&self, s: &Surface<'_>, at: &Point) -> Vec3 {
        let (m, [a, b, c]) =
            (s.material, s.posed.mesh.faces[s.key.1 as usize].map(|i| s.posed.mesh.vertices[i as usize]));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let is_leaf = m.pattern == Pattern::Leaves;
        let rotation = s.posed.placement.rotation;
        let [u, v] = if Self::is_ground(s) {
            [at.world.x, at.world.y]
        } else if is_leaf {
            // Across and down the image, drawn out along the leaf.
            [DVec3::X, DVec3::Y].map(|axis| {
                let axis = (self.view.world_from_cam.rotation * axis).as_vec3();
                let aslant = (1.0 - s.normal.dot(axis) * s.normal.dot(axis)).max(0.02).sqrt();
                (at.world.as_dvec3() - s.corners[0]).as_vec3().dot(axis) / aslant
            })
        } else {
            // Along a wall and up its slope; x and y of what is level.
            let local = (rotation.transpose() * (at.world.as_dvec3() - s.posed.placement.translation)).as_vec3();
            let flat = Vec3::new(-normal.y, normal.x, 0.0);
            let is_level = flat.length_squared() < 0.03;
            let along = if is_level { Vec3::X } else { flat.normalize() };
            [along, if is_level { Vec3::Y } else { normal.cross(along) }].map(|axis| axis.dot(local))
        };
        let cos_view = at.view.dot(s.normal).abs().max(0.02);
        let pixel_m = at.depth_m / self.view.intrinsics[0] as f32;
        let place = PatternPoint {
            u,
            v,
            pixel_m,
            footprint_m: pixel_m / cos_view.sqrt(),
            face_hash: hash2(s.key.1 as i32, 0, s.place_hash),
            place_hash: s.place_hash,
        };
        let base = Vec3::from(m.albedo) * if is_leaf { clump(a, b - a, s.place_hash) } else { 1.0 };
        let albedo = albedo(m.pattern, base, &place);
        let worn = if m.semantic == Semantic::Road { 0.55 } else { 1.0 };
        let lies = if is_vehicle(m.semantic) { 0.0 } else { 1.0 };
        let drift = value_noise(at.world.x * 0.6, at.world.y * 0.6, 0x5E0);
        let level = ((self.normal_at(s, at).z - 0.4) * 2.0).clamp(0.0, 1.0);
        albedo + (Vec3::splat(0.8) - albedo) * level * (self.snow * worn * (0.5 + drift)).min(1.0) * lies
    }

    /// The shading normal.
    fn normal_at(&self, s: &Surface<'_>, at: &Point) -> Vec3 {
        let [a, b, c] = s.corners;
        let (ab, ac, to) = (b - a, c - a, at.world.as_dvec3() - a);
        let (d11, d12, d22) = (ab.dot(ab), ab.dot(ac), ac.dot(ac));
        let inverse = 1.0 / (d11 * d22 - d12 * d12).max(1e-20);
        // Not beyond the face.
        let least = if s.is_quad { f64::from(LEAST_WEIGHT) } else { 0.0 };
        let wb = ((d22 * to.dot(ab) - d12 * to.dot(ac)) * inverse).max(least).min(1.0 - least);
        let wc = ((d11 * to.dot(ac) - d12 * to.dot(ab)) * inverse).max(least).min(1.0 - least - wb);
        let normals = s.posed.mesh.faces[s.key.1 as usize].map(|i| s.posed.mesh.normals[i as usize].as_dvec3());
        let is_turned = (b - a).cross(c - a).dot(s.normal.as_dvec3()) < 0.0;
        let flat = s.posed.placement.rotation.transpose() * s.normal.as_dvec3() * if is_turned { -1.0 } else { 1.0 };
        let is_even = normals.iter().all(|n| (*n - normals[0]).length_squared() < 1e-6);
        if s.material.pattern != Pattern::Leaves && is_even && normals[0].dot(flat) >= 0.999_9 {
            return s.normal;
        }
        let local = normals[0] * (1.0 - wb - wc) + normals[1] * wb + normals[2] * wc;
        let normal = (s.posed.placement.rotation * local).normalize_or_zero().as_vec3();
        if is_turned { -normal } else { normal }
    }

    /// Light that arrives at the camera: what counts with the albedo (or with what is behind), and what does not.
    pub(super) fn light(&self, s: &Surface<'_>, at: &Point, open: &Open) -> [Vec3; 2] {
        let (sky, m, normal) = (&self.sky, s.material, self.normal_at(s, at));
        let is_leaf = m.pattern == Pattern::Leaves;
        let (cos_face, cos_sun) = (s.normal.dot(sky.sun_world), normal.dot(sky.sun_world));
        let sees_sun = is_leaf || cos_face > 0.0 && (cos_sun > 0.0 || m.is_transparent());
        let lit = match self.shadows.iter().find_map(|map| map.lit(at.world, s.normal, cos_face)) {
            _ if !sees_sun || self.shadows.is_empty() => 0.0,
            lit => lit.unwrap_or(1.0),
        };
        let is_above_cars = s.normal.z <= 0.3 || is_vehicle(m.semantic) || is_leaf;
        let contact = if is_above_cars { 1.0 } else { self.ambient.contact(at.world) };
        let toward = [open[0], open[1], open[2], open[3]];
        let cos_view = (-at.view.dot(normal)).clamp(0.0, 1.0);
        let mirrored = at.view + normal * (2.0 * cos_view);
        let schlick = |f0: f32, smooth: f32| f0 + (1.0 - f0) * [1.0 - cos_view; 5].iter().product::<f32>() * smooth;
        if m.is_transparent() {
            // Both faces of a pane reflect. What is behind has come through the air already.
            let fresnel = schlick(m.specular.max(0.045) * 1.8, 1.0).min(1.0);
            let shine = environment(sky, mirrored, &toward, 0.0) + highlight(sky, mirrored, 0.15) * lit;
            return [Vec3::new(0.93, 1.0, 0.95) * (m.transmission * (1.0 - fresnel)), shine * fresnel];
        }
        let around = sky.ambient_with_bounce(normal, open) * contact;
        let wet = if normal.z > 0.5 { 1.0 - 0.45 * self.wetness } else { 1.0 };
        if is_leaf {
            // Leaves turn to all sides, let a third of the light through, yellower, and get it through their neighbors.
            let through = Vec3::new(0.85, 1.0, 0.50) * (0.40 * (-cos_sun).max(0.0));
            let direct = (Vec3::splat(cos_sun.max(0.0)) + through) * 0.8 + Vec3::splat(0.12);
            return self.of_air((sky.sun * direct * lit + around * 1.3) * wet, Vec3::ZERO, at);
        }
        let diffuse = (sky.sun * cos_sun.max(0.0) * lit + around) * wet;
        let puddle = value_noise(at.world.x * 0.35, at.world.y * 0.35, 0xF11);
        let is_wet = Self::is_ground(s) && normal.z > 0.5;
        let film = if is_wet { (self.wetness * 1.5 - 0.9 * puddle).clamp(0.0, 1.0) } else { 0.0 };
        let (f0, roughness) = if film > 0.0 { (0.02, 0.55 - 0.2 * film) } else { (m.specular, m.roughness) };
        let fresnel = if f0 > 0.0 { schlick(f0, (1.0 - roughness) * (1.0 - roughness)) } else { 0.0 };
        let shine = environment(sky, mirrored, &toward, roughness) * contact.max(0.3)
            + highlight(sky, mirrored, roughness) * lit;
        // Metals color what they reflect.
        let tint = if f0 > 0.5 { Vec3::from(m.albedo) } else { Vec3::ONE };
        self.of_air(diffuse * (1.0 - fresnel), shine * tint * fresnel, at)
    }

    fn of_air(&self, diffuse: Vec3, specular: Vec3, at: &Point) -> [Vec3; 2] {
        let added = self.through_air(specular, at.view, at.distance_m);
        [diffuse * crate::math::expf(-self.extinction_per_m * at.distance_m), added]
    }

    /// The visibility of the sky. Leaves near each other see the same: cells of at least 0.5 m and 1/16 to 1/32 of the distance, each leaf in one next
    /// to its own by chance.
    pub(super) fn open(&self, s: &Surface<'_>, at: &Point) -> Open {
        if s.material.pattern != Pattern::Leaves {
            return self.ambient.open(at.world, s.normal);
        }
        let middle = (s.corners[0] + s.corners[2]) * 0.5;
        let mut cell_m = 0.5;
        while cell_m * 32.0 <= (middle - self.view.world_from_cam.translation).length() {
            cell_m *= 2.0;
        }
        let hash = hash2(s.key.1 as i32, 0, s.place_hash);
        let aside = [hash, hash >> 10, hash >> 20].map(|h| (h & 0x3FF) as f32 / 1024.0);
        let cell = (middle / cell_m).as_vec3() + Vec3::from(aside);
        self.ambient.open(cell.floor() * cell_m as f32, Vec3::ZERO)
    }
}

fn is_vehicle(semantic: Semantic) -> bool {
    matches!(semantic, Semantic::Car | Semantic::Van | Semantic::Truck | Semantic::Tram | Semantic::OtherVehicle)
}
