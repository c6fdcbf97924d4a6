//! What smooth surfaces mirror: the surroundings and the sun.

use crate::camera::light::Sky;
use crate::camera::surfaces::value_noise;
use cadet_base::math::Vec3;

/// The least square of a direction's level part by which is divided.
const LEAST_LEVEL: f32 = 1e-6;
/// The skyline: sine of its elevation where the sky is free, and how much higher it is where it is hidden.
const SKYLINE_LEAST: f32 = 0.10;
const SKYLINE_RANGE: f32 = 0.85;
/// It is uneven as roofs and crowns are: noise over the level direction, least and range.
const SKYLINE_CELLS: f32 = 7.0;
const SKYLINE_SHIFT: f32 = 31.0;
const SKYLINE_SALT: u32 = 0xE17;
const UNEVEN_LEAST: f32 = 0.65;
const UNEVEN_RANGE: f32 = 0.7;
/// Width of its edge in the mirror, by sines: of a polished surface, and by roughness.
const SHARPEST: f32 = 0.02;
const SOFTER_BY_ROUGHNESS: f32 = 0.35;
/// Streets end so far below the horizon, a sine; what stands along them has these shares of the light of sky and sun, of the
/// sun's none where one looks toward it and twice as much where one looks away.
const STREET_BELOW: f32 = 0.01;
const STREET_SKY: f32 = 0.16;
const STREET_SUN: f32 = 0.045;
/// Ground that is mirrored is darker than open ground.
const MIRRORED_GROUND: f32 = 0.8;
/// The sun is a disk: no lobe is narrower.
const LEAST_ALPHA_SQUARED: f32 = 0.002;

/// What a mirror shows: sky above the roofs and trees, a dark street below them, ground.
#[inline(always)]
pub fn environment(sky: &Sky, direction: Vec3, sky_visibility: &[f32; 4], roughness: f32) -> Vec3 {
    let d2 = direction * direction;
    let level = (d2.x + d2.y).max(LEAST_LEVEL);
    let toward_x = if direction.x < 0.0 { sky_visibility[1] } else { sky_visibility[0] };
    let toward_y = if direction.y < 0.0 { sky_visibility[3] } else { sky_visibility[2] };
    let free = (toward_x * d2.x + toward_y * d2.y) / level;
    let (x, y) = (direction.x * SKYLINE_CELLS + SKYLINE_SHIFT, direction.y * SKYLINE_CELLS + SKYLINE_SHIFT);
    let uneven = value_noise(x, y, SKYLINE_SALT);
    let skyline =
        (SKYLINE_LEAST + SKYLINE_RANGE * (1.0 - free).max(0.0).sqrt()) * (UNEVEN_LEAST + UNEVEN_RANGE * uneven);
    let soft = SHARPEST + SOFTER_BY_ROUGHNESS * roughness;
    let above = ((direction.z - skyline) / soft + 0.5).clamp(0.0, 1.0);
    let over_ground = ((direction.z + STREET_BELOW) / soft + 0.5).clamp(0.0, 1.0);
    let street = sky.sky_on_level * STREET_SKY + sky.sun * (STREET_SUN * (1.0 - direction.dot(sky.sun_world)));
    let up = Vec3::new(direction.x, direction.y, direction.z.max(0.0));
    let ground = sky.ground * MIRRORED_GROUND;
    let low = ground + (street - ground) * over_ground;
    low + (sky.radiance(up) - low) * above
}

/// The sun's own reflection, a GGX lobe about the mirrored direction (Walter et al., EGSR 2007).
#[inline(always)]
pub fn highlight(sky: &Sky, mirrored: Vec3, roughness: f32) -> Vec3 {
    let alpha2 = (roughness * roughness * roughness * roughness).max(LEAST_ALPHA_SQUARED);
    let miss = 1.0 - mirrored.dot(sky.sun_world);
    let lobe = 1.0 + miss / (2.0 * alpha2);
    sky.sun * (1.0 / (4.0 * alpha2 * lobe * lobe))
}

/// The fifth power: Schlick's approximation of Fresnel's equations (1994).
#[inline(always)]
pub fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}
