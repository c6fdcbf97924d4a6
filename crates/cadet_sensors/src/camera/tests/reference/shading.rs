//! Surfaces, and the light that leaves one point of them.

use super::shadow::ShadowMap;
use super::{Key, Reference};
use crate::camera::light::{Occluder, SkyVisibility};
use crate::camera::shading::{clump, environment, highlight, luminaire_share};
use crate::camera::surfaces::textures::albedo;
use crate::camera::surfaces::windows::radiance;
use crate::camera::surfaces::{PatternPoint, hash2, value_noise, window};
use crate::sense::PosedInstance;
use crate::surface_cover::absorbs_water;
use cadet_base::geometry::{CLUSTER_FACES, LEAST_WEIGHT, Mesh, face_number};
use cadet_base::material::{Material, Pattern, Semantic};
use cadet_base::math::{DVec3, Vec3, expf};

/// A face towards the eye. `corners` are the world's, `normal` that of its plane.
pub struct Surface<'a> {
    key: Key,
    posed: &'a PosedInstance,
    corners: [DVec3; 3],
    pub(super) normal: Vec3,
    pub(super) material: &'a Material,
    pub(super) is_leaf: bool,
    is_ground: bool,
    place_hash: u32,
}

/// A point of a surface that the camera sees.
pub struct Point {
    pub(super) world: Vec3,
    pub(super) depth_m: f32,
    /// Unit vector from the eye.
    pub(super) view: Vec3,
    pub(super) distance_m: f32,
}

/// Of every face of a mesh, by its number, the one that stands for it: the first of two that are a flat quadrilateral.
pub fn firsts_of(mesh: &Mesh) -> Vec<u32> {
    let mut firsts = vec![0; mesh.clusters.len() * CLUSTER_FACES];
    for (number, group) in (0..).zip(mesh.clusters.iter()) {
        for piece in group.pieces {
            let first = usize::from(piece.first);
            for place in first..=first + usize::from(piece.is_quad()) {
                firsts[face_number(number, place) as usize] = face_number(number, first);
            }
        }
    }
    firsts
}

impl Reference {
    /// World direction of an image point, of length 1 along the optical axis.
    pub(super) fn direction(&self, [u, v]: [f64; 2]) -> DVec3 {
        let [fx, fy, cx, cy] = self.view.intrinsics_px;
        self.view.world_from_cam.rotation * DVec3::new((u - cx) / fx, (v - cy) / fy, 1.0)
    }

    pub(super) fn surface(&self, key: Key) -> Surface<'_> {
        let posed = &self.scene.instances[key.0 as usize];
        let corners = self.scene.corners(key.0, key.1).map(|p| p.as_dvec3());
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let is_turned = normal.dot(a - self.view.world_from_cam.translation) > 0.0;
        let normal = if is_turned { -normal } else { normal }.as_vec3();
        let material = posed.material(key.1);
        let [x, y] = [posed.center_world.x, posed.center_world.y].map(|c| (c * 8.0) as i32);
        Surface {
            key,
            posed,
            corners,
            normal,
            material,
            is_leaf: material.pattern == Pattern::Leaves,
            is_ground: material.semantic.is_ground() && normal.z > 0.5,
            place_hash: hash2(x, y, 0x97AC),
        }
    }

    /// Where the ray of an image point meets a surface's plane.
    pub(super) fn point(&self, surface: &Surface<'_>, place: [f64; 2]) -> Point {
        self.point_within(surface, place, [0.0, 1e6])
    }

    /// Where the ray of an image point meets a surface's plane, no nearer and no farther than some depths.
    pub(super) fn point_within(&self, surface: &Surface<'_>, place: [f64; 2], [near, far]: [f64; 2]) -> Point {
        let (eye, direction) = (self.view.world_from_cam.translation, self.direction(place));
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
        let of = |key: Key| {
            let s = self.surface(key);
            (key.0, s.posed.mesh.face(key.1).slot, s.normal.to_array().map(|c| (c * 14.0 + 15.5) as u32))
        };
        of(a) == of(b)
    }

    pub(super) fn sky_at(&self, place: [f64; 2]) -> Vec3 {
        let view = self.direction(place).normalize().as_vec3();
        let radiance = self.light.sky.visible_radiance(view);
        // Fog hides the sky as it hides what is far.
        if self.light.extinction_per_m > 0.004 { self.through_air(radiance, view, 400.0) } else { radiance }
    }

    /// Beer-Lambert's extinction, and the air's own light (Koschmieder 1924).
    fn through_air(&self, radiance: Vec3, view: Vec3, distance_m: f32) -> Vec3 {
        let clear = expf(-self.light.extinction_per_m * distance_m);
        radiance * clear + self.light.in_scattered(view) * (1.0 - clear)
    }

    /// The albedo with its texture and snow.
    pub(super) fn albedo(&self, s: &Surface<'_>, at: &Point) -> Vec3 {
        let (m, placement) = (s.material, s.posed.placement);
        let [a, b, c] = s.posed.mesh.corners(s.key.1);
        let [u, v] = if s.is_ground {
            [at.world.x, at.world.y]
        } else if s.is_leaf {
            // Across and down the image, drawn out along the leaf.
            [DVec3::X, DVec3::Y].map(|axis| {
                let axis = (self.view.world_from_cam.rotation * axis).as_vec3();
                let aslant = (1.0 - s.normal.dot(axis) * s.normal.dot(axis)).max(0.02).sqrt();
                (at.world.as_dvec3() - s.corners[0]).as_vec3().dot(axis) / aslant
            })
        } else {
            // Along a wall and up its slope; x and y of what is level.
            let local = (placement.rotation.transpose() * (at.world.as_dvec3() - placement.translation)).as_vec3();
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let flat = Vec3::new(-normal.y, normal.x, 0.0);
            let is_level = flat.length_squared() < 0.03;
            let along = if is_level { Vec3::X } else { flat.normalize() };
            [along, if is_level { Vec3::Y } else { normal.cross(along) }].map(|axis| axis.dot(local))
        };
        let is_window = m.pattern == Pattern::Window;
        let (pane, middle) = window([a, b, c], (b - a).cross(c - a).normalize_or_zero(), s.place_hash);
        let [u, v] = if is_window {
            // From the middle of the pane.
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let along = Vec3::new(-normal.y, normal.x, 0.0).normalize_or_zero();
            let local = (placement.rotation.transpose() * (at.world.as_dvec3() - placement.translation)).as_vec3();
            [along, normal.cross(along)].map(|axis| axis.dot(local - middle))
        } else {
            [u, v]
        };
        let pixel_m = at.depth_m / self.view.intrinsics_px[0] as f32;
        let place = PatternPoint {
            u,
            v,
            pixel_m,
            footprint_m: pixel_m / at.view.dot(s.normal).abs().max(0.02).sqrt(),
            face_hash: if is_window { pane } else { hash2(s.key.1 as i32, 0, s.place_hash) },
            place_hash: s.place_hash,
        };
        let is_street_lamp = m.pattern == Pattern::Lamp && m.semantic == Semantic::Pole;
        let base = Vec3::from(m.albedo)
            * if s.is_leaf {
                clump(a, b - a, s.place_hash)
            } else if is_street_lamp {
                luminaire_share(s.normal.z)
            } else {
                1.0
            };
        let albedo = if is_window { radiance(base, &place) } else { albedo(m.pattern, base, &place) };
        // A film of water keeps the light that it mirrors back down, but for 1 / n^2.
        let soaked = self.light.wetness * (2.0 * self.normal_at(s, at).z).clamp(0.0, 1.0);
        let soaked = if absorbs_water(m) && !is_window { soaked } else { 0.0 };
        let inside = 1.0 - 1.0 / (1.328 * 1.328);
        let under_film = |a: f32| a * (1.0 - soaked * (1.0 - 0.98 * 0.98 * (1.0 - inside) / (1.0 - a * inside)));
        let albedo = Vec3::from(albedo.to_array().map(under_film));
        albedo + (Vec3::splat(0.8) - albedo) * self.under_snow(s, at)
    }

    /// The share of a surface that snow covers.
    fn under_snow(&self, s: &Surface<'_>, at: &Point) -> f32 {
        let m = s.material;
        let lies = if s.posed.is_without_snow(m) { 0.0 } else { 1.0 };
        let drift = value_noise(at.world.x * 0.6, at.world.y * 0.6, 0x5E0);
        let level = ((self.normal_at(s, at).z - 0.4) * 2.0).clamp(0.0, 1.0);
        level * (self.light.snow_cover * (0.5 + drift)).min(1.0) * lies
    }

    /// The shading normal: between those of the corners, but not far beyond the face.
    fn normal_at(&self, s: &Surface<'_>, at: &Point) -> Vec3 {
        let [a, b, c] = s.corners;
        let (ab, ac, to) = (b - a, c - a, at.world.as_dvec3() - a);
        let plane = ab.cross(ac);
        let least = f64::from(LEAST_WEIGHT);
        let per_area = 1.0 / plane.length_squared().max(1e-20);
        let wb = (to.cross(ac).dot(plane) * per_area).max(least).min(1.0 - least);
        let wc = (ab.cross(to).dot(plane) * per_area).max(least).min(1.0 - least - wb);
        let [na, nb, nc] = s.posed.mesh.corner_normals(s.key.1).map(|n| n.as_dvec3());
        let normal = (s.posed.placement.rotation * (na * (1.0 - wb - wc) + nb * wb + nc * wc)).normalize_or_zero();
        if plane.dot(s.normal.as_dvec3()) < 0.0 { -normal.as_vec3() } else { normal.as_vec3() }
    }

    /// Light that arrives at the camera: what counts with the albedo (or with what is behind), and what does not.
    pub(super) fn light(&self, s: &Surface<'_>, at: &Point, open: &SkyVisibility) -> [Vec3; 2] {
        let (sky, m, normal, wetness) = (&self.light.sky, s.material, self.normal_at(s, at), self.light.wetness);
        let (cos_face, cos_sun) = (s.normal.dot(sky.sun_world), normal.dot(sky.sun_world));
        let sees_sun = s.is_leaf || cos_face > 0.0 && (cos_sun > 0.0 || m.is_transparent());
        // From the coarser to the finer map; what none shows is lit.
        let over = |lit: f32, map: &ShadowMap| {
            let [share, weight] = map.lit(at.world, s.normal, cos_face, s.is_ground);
            lit + (share - lit) * weight
        };
        let has_sun = sees_sun && !self.shadows.is_empty();
        let lit = if has_sun { self.shadows.iter().rev().fold(1.0, over) } else { 0.0 };
        let is_above_cars = s.normal.z <= 0.3 || m.semantic.is_vehicle() || s.is_leaf;
        let left_of_sky = |body: &Occluder| body.share_left(at.world - body.center);
        let contact: f32 = if is_above_cars { 1.0 } else { self.occluders.iter().map(left_of_sky).product() };
        let toward = [open[0], open[1], open[2], open[3]];
        let cos_view = (-at.view.dot(normal)).clamp(0.0, 1.0);
        let mirrored = at.view + normal * (2.0 * cos_view);
        let schlick = |f0: f32, smooth: f32| f0 + (1.0 - f0) * [1.0 - cos_view; 5].iter().product::<f32>() * smooth;
        if m.is_transparent() {
            // Both faces of a pane reflect. What is behind has come through all of the air already, that in front too.
            let fresnel = schlick(m.specular.max(0.045) * 1.8, 1.0).min(1.0);
            let shine = environment(sky, mirrored, &toward, 0.0) + highlight(sky, mirrored, 0.15) * lit;
            let is_window = m.pattern == Pattern::Window;
            let snow = if is_window { 0.0 } else { self.under_snow(s, at) };
            let through = Vec3::new(0.93, 1.0, 0.95) * (m.transmission * (1.0 - fresnel) * (1.0 - snow));
            let [_, glints] = self.lamp_light(s, at, normal, contact, false);
            let room = if is_window { self.albedo(s, at) } else { Vec3::ZERO };
            let white = sky.sun * (cos_sun.max(0.0) * lit) + sky.ambient(normal, open) * contact;
            let bare = (shine * fresnel + glints + room) * (1.0 - snow);
            let in_front = self.through_air(bare + white * (0.8 * snow), at.view, at.distance_m);
            return [through, in_front - through * self.through_air(Vec3::ZERO, at.view, at.distance_m)];
        }
        // Leaves turn to all sides, and let three quarters as much light through as they reflect, yellower.
        let through = Vec3::new(0.85, 1.0, 0.50) * (0.75 * (-cos_sun).max(0.0));
        let facing = Vec3::splat(cos_sun.max(0.0));
        let direct = if s.is_leaf { (facing + through) * 0.9 + Vec3::splat(0.20) } else { facing };
        let around = sky.ambient(normal, open) * contact * if s.is_leaf { 1.75 * 0.6 } else { 1.0 };
        let puddle = value_noise(at.world.x * 0.35, at.world.y * 0.35, 0xF11);
        let is_wet = s.is_ground && normal.z > 0.5;
        let film = if is_wet { (wetness * 1.5 - 0.9 * puddle).clamp(0.0, 1.0) } else { 0.0 };
        let (f0, roughness) = if film > 0.0 { (0.02, 0.55 - 0.2 * film) } else { (m.specular, m.roughness) };
        let [lamps, glints] = self.lamp_light(s, at, normal, contact, s.is_ground);
        let (diffuse, glints) = match m.pattern {
            Pattern::Lamp => (Vec3::splat(self.light.lamp_radiance), Vec3::ZERO),
            Pattern::Window => (Vec3::ONE, Vec3::ZERO),
            _ => (sky.sun * direct * lit + around + lamps, glints),
        };
        let is_matt = s.is_leaf || f0 == 0.0;
        let fresnel = if is_matt { 0.0 } else { schlick(f0, (1.0 - roughness) * (1.0 - roughness)) };
        let shine = environment(sky, mirrored, &toward, roughness) * contact.max(0.3)
            + highlight(sky, mirrored, roughness) * lit;
        // Metals color what they reflect.
        let tint = if f0 > 0.5 { Vec3::from(m.albedo) } else { Vec3::ONE };
        let clear = expf(-self.light.extinction_per_m * at.distance_m);
        [diffuse * (1.0 - fresnel) * clear, self.through_air(shine * tint * fresnel + glints, at.view, at.distance_m)]
    }

    /// The visibility of the sky. Leaves near each other see the same: cells of at least 0.5 m and 1/16 to 1/32 of the
    /// distance, each leaf in one next to its own by chance.
    pub(super) fn open(&self, s: &Surface<'_>, at: &Point) -> SkyVisibility {
        if !s.is_leaf {
            return self.light.sky_probes.sky_visibility(at.world, s.normal);
        }
        let middle = (s.corners[0] + s.corners[2]) * 0.5;
        let mut cell_m = 0.5;
        while cell_m * 32.0 <= (middle - self.view.world_from_cam.translation).length() {
            cell_m *= 2.0;
        }
        let hash = hash2(s.key.1 as i32, 0, s.place_hash);
        let aside = [hash, hash >> 10, hash >> 20].map(|h| (h & 0x3FF) as f32 / 1024.0);
        let cell = (middle / cell_m).as_vec3() + Vec3::from(aside);
        self.light.sky_probes.sky_visibility(cell.floor() * cell_m as f32, Vec3::ZERO)
    }
}
