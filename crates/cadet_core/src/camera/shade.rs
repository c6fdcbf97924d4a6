//! The light that leaves a surface towards the camera.

use super::ambient::{Openness, SkyView};
use super::pattern::{self, PatternPoint};
use super::shadow::Shadows;
use super::sky::Sky;
use crate::material::{Material, Pattern, Semantic};
use crate::math::Vec3;
use crate::weather::Weather;

/// What is seen at a sample.
#[derive(Debug, Clone, Copy)]
pub struct Surface<'a> {
    /// The hit.
    pub point_world: Vec3,
    /// The hit in the mesh's frame.
    pub point_local: Vec3,
    /// Unit shading normal, on the viewer's side.
    pub normal_world: Vec3,
    /// Unit normal of the triangle, on the viewer's side.
    pub face_normal_world: Vec3,
    /// Unit normal of the triangle in the mesh's frame.
    pub face_normal_local: Vec3,
    /// Unit vector from the viewer to the hit.
    pub view_world: Vec3,
    /// Distance to the viewer, metres.
    pub distance_m: f32,
    /// Size of a pixel square to the view there, metres.
    pub pixel_m: f32,
    /// What it is made of.
    pub material: &'a Material,
    /// Hash of the face.
    pub face_hash: u32,
    /// Hash of the instance's place.
    pub place_hash: u32,
}

/// All the light of a scene.
#[derive(Debug, Clone)]
pub struct Light {
    /// Sun and sky.
    pub sky: Sky,
    /// The sun's shadows; none under an overcast sky.
    pub shadows: Option<Shadows>,
    /// What hides the sky.
    pub sky_view: SkyView,
    /// 0 is dry, 1 a film of water.
    pub wetness: f32,
    /// Extinction of the air, 1/m.
    pub extinction_per_m: f32,
    /// Cover of snow on level ground, 0..1.
    pub snow: f32,
}

/// What changes so slowly that neighbouring pixels of a face share it.
#[derive(Debug, Clone, Copy)]
pub struct Around {
    open: Openness,
    /// Light from what hides the sky.
    from_around: Vec3,
    /// Radiance of the air before the surface, were it endless.
    air: Vec3,
}

/// Haze of clear air, 1/m.
const CLEAR_AIR_PER_M: f32 = 0.000_8;

impl Light {
    /// Puts the parts together.
    #[must_use]
    pub fn new(weather: &Weather, sky: Sky, shadows: Option<Shadows>, sky_view: SkyView) -> Self {
        Self {
            sky,
            shadows,
            sky_view,
            wetness: weather.wetness as f32,
            extinction_per_m: CLEAR_AIR_PER_M + weather.extinction_per_m() as f32,
            snow: weather.snow_cover() as f32,
        }
    }

    /// What hides the sky from a surface, and the air before it.
    #[must_use]
    pub fn around(&self, s: &Surface) -> Around {
        let open = self.sky_view.openness(s.point_world, s.normal_world);
        // What hides the sky sends some light itself, from sunlit walls and ground.
        let mean_open = open[..5].iter().sum::<f32>() * 0.2;
        let from_around = self.sky.ground * (0.60 * (1.0 - mean_open));
        Around { open, from_around, air: self.air(s.view_world) }
    }

    /// Radiance of an opaque surface as it arrives at the camera.
    #[must_use]
    pub fn opaque(&self, s: &Surface, around: &Around) -> Vec3 {
        let air = 1.0 - self.clear_share(s.distance_m);
        let left = self.leaving(s, around);
        left + (around.air - left) * air
    }

    /// Radiance that leaves an opaque surface.
    #[inline]
    fn leaving(&self, s: &Surface, around: &Around) -> Vec3 {
        let m = s.material;
        let ground = m.semantic.is_ground() && s.face_normal_world.z > 0.5;
        let mut albedo = self.albedo(s, ground);
        let leaf = m.pattern == Pattern::Leaves;
        let cos_sun = s.normal_world.dot(self.sky.sun_world);
        let cos_face = s.face_normal_world.dot(self.sky.sun_world);
        let lit = if leaf || (cos_sun > 0.0 && cos_face > 0.0) { self.sunlit(s, cos_face) } else { 0.0 };
        let direct = if leaf {
            // Leaves turn to all sides and let through a third of the light, yellower.
            let through = Vec3::new(0.85, 1.0, 0.35) * (0.40 * (-cos_sun).max(0.0));
            (Vec3::splat(cos_sun.max(0.0)) + through) * 0.8 + Vec3::splat(0.12)
        } else {
            Vec3::splat(cos_sun.max(0.0))
        };
        let near = if s.face_normal_world.z > 0.3 && !is_vehicle(m.semantic) {
            self.sky_view.contact(s.point_world)
        } else {
            1.0
        };
        let ambient = (self.sky.ambient(s.normal_world, &around.open) + around.from_around) * near;

        let mut film = 0.0;
        if self.wetness > 0.0 && s.normal_world.z > 0.5 {
            albedo *= 1.0 - 0.45 * self.wetness;
            if ground {
                let puddle = pattern::value_noise(s.point_world.x * 0.35, s.point_world.y * 0.35, 0xF11);
                film = (self.wetness * 1.5 - 0.9 * puddle).clamp(0.0, 1.0);
            }
        }
        let diffuse = albedo * (self.sky.sun * direct * lit + ambient);
        let (f0, roughness) = if film > 0.0 {
            (0.02, 0.45 - 0.37 * film)
        } else if leaf || m.specular <= 0.0 {
            return diffuse;
        } else {
            (m.specular, m.roughness)
        };
        let cos_view = (-s.view_world.dot(s.normal_world)).clamp(0.0, 1.0);
        let fresnel = f0 + (1.0 - f0) * fifth(1.0 - cos_view) * (1.0 - roughness) * (1.0 - roughness);
        let mirrored = s.view_world + s.normal_world * (2.0 * cos_view);
        let shine = self.environment(mirrored, &around.open, roughness) * near.max(0.3)
            + self.highlight(mirrored, roughness) * lit;
        // Metals colour what they reflect.
        let tint = if m.specular > 0.5 { m.albedo.into() } else { Vec3::ONE };
        diffuse * (1.0 - fresnel) + shine * tint * fresnel
    }

    /// Radiance of a pane with `behind` seen through it.
    #[must_use]
    pub fn pane(&self, s: &Surface, around: &Around, behind: Vec3) -> Vec3 {
        let cos_view = (-s.view_world.dot(s.normal_world)).clamp(0.0, 1.0);
        // Both faces of the pane reflect.
        let f0 = s.material.specular.max(0.045) * 1.8;
        let fresnel = (f0 + (1.0 - f0) * fifth(1.0 - cos_view)).min(1.0);
        let mirrored = s.view_world + s.normal_world * (2.0 * cos_view);
        let cos_sun = s.face_normal_world.dot(self.sky.sun_world);
        let glint = if cos_sun > 0.0 { self.highlight(mirrored, 0.15) * self.sunlit(s, cos_sun) } else { Vec3::ZERO };
        let tint = Vec3::new(0.93, 1.0, 0.95) * s.material.transmission;
        behind * tint * (1.0 - fresnel) + (self.environment(mirrored, &around.open, 0.0) + glint) * fresnel
    }

    /// The air between: haze, fog, rain.
    #[inline]
    #[must_use]
    pub fn through_air(&self, radiance: Vec3, view_world: Vec3, distance_m: f32) -> Vec3 {
        let t = self.clear_share(distance_m);
        radiance * t + self.air(view_world) * (1.0 - t)
    }

    /// Share of the light that the air lets through.
    #[inline]
    fn clear_share(&self, distance_m: f32) -> f32 {
        // exp(-x) by (1 + x/16)^-16.
        let mut t = 1.0 / (1.0 + self.extinction_per_m * distance_m * (1.0 / 16.0));
        t *= t;
        t *= t;
        t *= t;
        t * t
    }

    #[inline]
    fn air(&self, view_world: Vec3) -> Vec3 {
        self.sky.radiance(Vec3::new(view_world.x, view_world.y, view_world.z.max(0.02))) * 0.8
    }

    #[inline]
    fn sunlit(&self, s: &Surface, cos_face: f32) -> f32 {
        self.shadows.as_ref().map_or(0.0, |m| m.sunlit(s.point_world, s.face_normal_world, cos_face))
    }

    fn albedo(&self, s: &Surface, ground: bool) -> Vec3 {
        let m = s.material;
        let base: Vec3 = m.albedo.into();
        if m.pattern == Pattern::Plain && self.snow == 0.0 {
            return base;
        }
        let cos_view = s.view_world.dot(s.face_normal_world).abs().max(0.02);
        let footprint_m = s.pixel_m / cos_view.sqrt();
        let (u, v) = if ground {
            (s.point_world.x, s.point_world.y)
        } else {
            let n = s.face_normal_local;
            let flat = n.x * n.x + n.y * n.y;
            if flat < 0.03 {
                (s.point_local.x, s.point_local.y)
            } else {
                let scale = 1.0 / flat.sqrt();
                // Along the wall, and up its slope.
                let along = Vec3::new(-n.y * scale, n.x * scale, 0.0);
                (along.dot(s.point_local), n.cross(along).dot(s.point_local))
            }
        };
        let at = PatternPoint { u, v, footprint_m, face_hash: s.face_hash, place_hash: s.place_hash };
        let albedo = pattern::albedo(m.pattern, base, &at);
        if self.snow > 0.0 && !is_vehicle(m.semantic) {
            let drift = pattern::value_noise(s.point_world.x * 0.6, s.point_world.y * 0.6, 0x5E0);
            let worn = if m.semantic == Semantic::Road { 0.55 } else { 1.0 };
            let cover = ((s.normal_world.z - 0.4) * 2.0).clamp(0.0, 1.0) * (self.snow * worn * (0.5 + drift)).min(1.0);
            return albedo + (Vec3::splat(0.8) - albedo) * cover;
        }
        albedo
    }

    /// What a mirror shows: sky above the roofs and trees, a dark street below them, ground.
    fn environment(&self, direction: Vec3, open: &Openness, roughness: f32) -> Vec3 {
        let d2 = direction * direction;
        let level = (d2.x + d2.y).max(1e-6);
        let toward_x = open[usize::from(direction.x < 0.0)];
        let toward_y = open[2 + usize::from(direction.y < 0.0)];
        let free = (toward_x * d2.x + toward_y * d2.y) / level;
        // Sine of the skyline's elevation there, uneven as roofs and crowns are.
        let uneven = pattern::value_noise(direction.x * 7.0 + 31.0, direction.y * 7.0 + 31.0, 0xE17);
        let skyline = (0.10 + 0.85 * (1.0 - free).max(0.0).sqrt()) * (0.65 + 0.7 * uneven);
        let soft = 0.02 + 0.35 * roughness;
        let above = ((direction.z - skyline) / soft + 0.5).clamp(0.0, 1.0);
        let over_ground = ((direction.z + 0.01) / soft + 0.5).clamp(0.0, 1.0);
        let street = self.sky.sky_on_level * 0.16 + self.sky.sun * 0.030;
        let up = Vec3::new(direction.x, direction.y, direction.z.max(0.0));
        let low = self.sky.ground * 0.8 + (street - self.sky.ground * 0.8) * over_ground;
        low + (self.sky.radiance(up) - low) * above
    }

    /// The sun's own reflection, a GGX lobe about the mirrored direction.
    fn highlight(&self, mirrored: Vec3, roughness: f32) -> Vec3 {
        let alpha2 = (roughness * roughness * roughness * roughness).max(0.002);
        let miss = 1.0 - mirrored.dot(self.sky.sun_world);
        let lobe = 1.0 + miss / (2.0 * alpha2);
        self.sky.sun * (1.0 / (4.0 * alpha2 * lobe * lobe))
    }
}

#[inline]
fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}

fn is_vehicle(semantic: Semantic) -> bool {
    matches!(semantic, Semantic::Car | Semantic::Van | Semantic::Truck | Semantic::Tram | Semantic::OtherVehicle)
}
