//! The light of all lamps of a night on one point, one after the other, without a grid.

use super::Reference;
use super::shading::{Point, Surface};
use crate::camera::light::{
    LEAF_DIRECT_SHARE, LEAF_SCATTERED_SHARE, LEAST_LAMP_ALPHA_SQUARED, LEAST_SQUARE_M2, RETRO_REFLECTANCE, RETRO_SINE,
};
use crate::camera::shading::{SurfaceCoat, lamp_coat};
use cadet_base::lamp::{LampBeam, fade};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

impl Reference {
    /// Irradiance, and what a coat of this reflectance and roughness mirrors.
    pub(super) fn lamp_light(
        &self,
        s: &Surface<'_>,
        at: &Point,
        normal: Vec3,
        contact: f32,
        is_ground: bool,
    ) -> [Vec3; 2] {
        let Some(night) = &self.light.night else { return [Vec3::ZERO; 2] };
        let own = SurfaceCoat { f0: s.material.specular, roughness: s.material.roughness };
        let place = [at.world.x, at.world.y];
        let (SurfaceCoat { f0, roughness }, mirror) = lamp_coat(is_ground, normal.z, place, self.light.wetness, own);
        let point = at.view * at.distance_m;
        let (mut irradiance, mut mirrored) = (Vec3::ZERO, Vec3::ZERO);
        let throws_back = s.material.lidar.retro || s.material.pattern == Pattern::Reflector;
        for known in &night.lamps {
            let lamp = &known.lamp;
            let from_lamp = point - lamp.at;
            let distance_m = from_lamp.length().max(LEAST_SQUARE_M2.sqrt());
            let to_lamp = -from_lamp / distance_m;
            let from_above = if matches!(lamp.beam, LampBeam::Luminaire { .. }) { contact } else { 1.0 };
            let square = distance_m * distance_m;
            let strength = Vec3::from(lamp.intensity)
                * (lamp.share(from_lamp, distance_m) * from_above * fade(square, lamp.reach_m * lamp.reach_m) / square);
            let cos = normal.dot(to_lamp);
            let facing = cos.max(0.0);
            irradiance += strength
                * if s.is_leaf {
                    (facing + 0.75 * (-cos).max(0.0)) * LEAF_DIRECT_SHARE + LEAF_SCATTERED_SHARE
                } else {
                    facing
                };
            if throws_back && to_lamp.dot(at.view) < 0.0 {
                let sine = to_lamp.cross(at.view).length() / RETRO_SINE;
                irradiance += strength * facing * RETRO_REFLECTANCE / (1.0 + sine * sine);
            }
            if f0 > 0.0 && !s.is_leaf && facing > 0.0 {
                mirrored += strength * mirror * ggx(to_lamp, -at.view, normal, f0, roughness);
            }
        }
        [irradiance, mirrored]
    }
}

/// pi times F D G / (4 cos cos) times the cosine to the light.
fn ggx(to_lamp: Vec3, to_eye: Vec3, normal: Vec3, f0: f32, roughness: f32) -> f32 {
    let power = |x: f64, n: usize| std::iter::repeat_n(x, n).product::<f64>();
    let alpha2 = power(roughness.into(), 4).max(LEAST_LAMP_ALPHA_SQUARED.into());
    let alpha = alpha2.sqrt();
    let half = (to_lamp + to_eye).normalize_or_zero();
    let [nl, nv, nh, lh] =
        [normal.dot(to_lamp), normal.dot(to_eye).max(1e-3), normal.dot(half), to_lamp.dot(half)].map(f64::from);
    let distribution = alpha2 / power(nh * nh * (alpha2 - 1.0) + 1.0, 2);
    let fresnel = f64::from(f0) + (1.0 - f64::from(f0)) * power(1.0 - lh, 5);
    let smith = 2.0 * nl * nv / (2.0 * nl * nv * (1.0 - alpha) + (nl + nv) * alpha);
    (distribution * fresnel * smith / (4.0 * nl * nv) * nl) as f32
}
