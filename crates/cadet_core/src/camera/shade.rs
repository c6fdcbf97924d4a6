//! The light that leaves surfaces towards the camera: many pairs of one shader variant at a time.
//!
//! Every pair goes through the same IEEE operations in the same order whatever the instruction set, so that the bytes are
//! the same with wide registers and without.

use multiversion::multiversion;

use super::face::{Flags, ShaderVariant};
use super::light::{Light, transmittance};
use super::shading_batch::{ShadingBatch, ShadingCamera, get, put};
use super::shading_queue::{BATCH_SIZE, BATCH_STRIDE};
use super::sky::Sky;
use super::textures::{self, PatternPoint};
use super::value_noise::value_noise;
use crate::material::Pattern;
use crate::math::Vec3;

/// Where the pairs lie, how the surfaces lie there, and the sun to them.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn geometry(l: &mut ShadingBatch, m: usize, camera: &ShadingCamera, sun: Vec3, variant: ShaderVariant) {
    let m = m.min(BATCH_SIZE);
    let mut depth = [0.0; BATCH_SIZE];
    for i in 0..m {
        depth[i] = 1.0 / l.inverse_depth[i];
    }
    for i in 0..m {
        let direction = camera.corner + camera.right * l.u[i] + camera.down * l.v[i];
        let length = direction.dot(direction).sqrt();
        let point = direction * depth[i];
        put(&mut l.view, i, direction * (1.0 / length));
        put(&mut l.point, i, point);
        l.distance_m[i] = depth[i] * length;
        l.cos_face[i] = get(&l.face_normal, i).dot(sun);
    }
    if variant.pattern != Pattern::Plain {
        for i in 0..m {
            let cos_view = get(&l.view, i).dot(get(&l.face_normal, i)).abs().max(0.02);
            l.pixel_m[i] = depth[i] * camera.pixel_per_m;
            l.footprint_m[i] = l.pixel_m[i] / cos_view.sqrt();
        }
    }
    if variant.is_flat() {
        l.normal = l.face_normal;
        l.cos_sun = l.cos_face;
        return;
    }
    if variant.is_smooth {
        for i in 0..m {
            let point = get(&l.point, i);
            let (least, most) = (l.least_weight[i], 1.0 - l.least_weight[i]);
            let wb = (point.dot(get(&l.to_b, i)) + l.weights_at_eye[0][i]).max(least).min(most);
            let wc = (point.dot(get(&l.to_c, i)) + l.weights_at_eye[1][i]).max(least).min(most - wb);
            let normal = get(&l.normal, i) + get(&l.normal_ab, i) * wb + get(&l.normal_ac, i) * wc;
            let scale = 1.0 / normal.dot(normal).max(1e-20).sqrt();
            put(&mut l.normal, i, normal * scale);
        }
    }
    for i in 0..m {
        l.cos_sun[i] = get(&l.normal, i).dot(sun);
    }
}

/// The coordinates of the texture in the left or the right pixels.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn place_texture(
    l: &mut ShadingBatch,
    m: usize,
    camera: &ShadingCamera,
    variant: ShaderVariant,
    pixel: usize,
) {
    let m = m.min(BATCH_SIZE);
    let side = if pixel == 0 { -1.0 } else { 1.0 };
    let mut points = [[0.0; BATCH_SIZE]; 3];
    for i in 0..m {
        let aside = l.aside[i] * side;
        let direction = camera.corner + camera.right * (l.u[i] + aside) + camera.down * l.v[i];
        // What is seen from its rim ends before the next pixel's middle.
        let middle = l.inverse_depth[i];
        let inverse_depth = (middle + l.inverse_depth_by_column[i] * aside).max(0.5 * middle).min(2.0 * middle);
        put(&mut points, i, direction * (1.0 / inverse_depth));
    }
    let [u, v] = &mut l.texture[pixel];
    if variant.pattern == Pattern::Leaves {
        let [across, down] = [camera.right.normalize(), camera.down.normalize()];
        for i in 0..m {
            let point = get(&points, i);
            let normal = get(&l.face_normal, i);
            // Along the leaf: leaves seen edge-on, and the sides of hedges, would be streaks.
            let [along, upwards] =
                [across, down].map(|axis| 1.0 / (1.0 - normal.dot(axis) * normal.dot(axis)).max(0.02).sqrt());
            u[i] = (point.dot(across) + l.at_eye[0][i]) * along;
            v[i] = (point.dot(down) + l.at_eye[1][i]) * upwards;
        }
    } else {
        for i in 0..m {
            let point = get(&points, i);
            u[i] = point.dot(get(&l.axis_u, i)) + l.at_eye[0][i];
            v[i] = point.dot(get(&l.axis_v, i)) + l.at_eye[1][i];
        }
    }
}

/// The albedo, by the variant's texture.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn texture(l: &mut ShadingBatch, m: usize, pattern: Pattern, pixel: usize) {
    let [u, v] = &l.texture[pixel];
    macro_rules! fill {
        ($($of:ident),*) => {
            match pattern {
                Pattern::Plain => (),
                $(Pattern::$of => {
                    for i in 0..m.min(BATCH_SIZE) {
                        let at = PatternPoint {
                            u: u[i],
                            v: v[i],
                            footprint_m: l.footprint_m[i],
                            pixel_m: l.pixel_m[i],
                            face_hash: l.face_hash[i],
                            place_hash: l.place_hash[i],
                        };
                        let albedo = textures::albedo(Pattern::$of, get(&l.material, i), &at);
                        put(&mut l.albedo[pixel], i, albedo);
                    }
                })*
            }
        };
    }
    fill!(Asphalt, Slabs, Blocks, Bricks, Render, Tiles, Grass, Leaves, Wood, Cloth);
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn snow(l: &mut ShadingBatch, m: usize, camera: &ShadingCamera, snow: f32, pixel: usize) {
    let side = if pixel == 0 { -1.0 } else { 1.0 };
    let (eye, right) = (camera.eye, camera.right);
    for i in 0..m.min(BATCH_SIZE) {
        // In the pixel itself: in the pair's middle, each pair would have its own drift.
        let aside = l.aside[i] * side / l.inverse_depth[i];
        let (x, y) = (l.point[0][i] + right.x * aside + eye.x, l.point[1][i] + right.y * aside + eye.y);
        let drift = value_noise(x * 0.6, y * 0.6, 0x5E0);
        let worn = if l.flags[i] & Flags::ROAD > 0 { 0.55 } else { 1.0 };
        let lies = if l.flags[i] & Flags::VEHICLE > 0 { 0.0 } else { 1.0 };
        let level = ((l.normal[2][i] - 0.4) * 2.0).clamp(0.0, 1.0);
        let cover = level * (snow * worn * (0.5 + drift)).min(1.0) * lies;
        let albedo = get(&l.albedo[pixel], i);
        put(&mut l.albedo[pixel], i, albedo + (Vec3::splat(0.8) - albedo) * cover);
    }
}

/// The light that a diffuse surface gets.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn diffuse(l: &mut ShadingBatch, m: usize, sky: &Sky, variant: ShaderVariant, wetness: f32) {
    let is_leaf = variant.pattern == Pattern::Leaves;
    if !variant.is_flat() {
        for i in 0..m.min(BATCH_SIZE) {
            let sky_visibility = std::array::from_fn(|k| l.sky_visibility[k][i]);
            let ambient = sky.ambient_with_bounce(get(&l.normal, i), &sky_visibility);
            (l.ambient[0][i], l.ambient[1][i], l.ambient[2][i]) = (ambient.x, ambient.y, ambient.z);
        }
    }
    for i in 0..m.min(BATCH_SIZE) {
        let normal = get(&l.normal, i);
        // Leaves get light through their neighbors, too.
        let ambient = get(&l.ambient, i) * (l.contact_occlusion[i] * if is_leaf { 1.3 } else { 1.0 });
        let cos_sun = l.cos_sun[i];
        let facing = cos_sun.max(0.0);
        let direct = if is_leaf {
            // Leaves turn to all sides and let through a third of the light, yellower.
            let through = Vec3::new(0.85, 1.0, 0.50) * (0.40 * (-cos_sun).max(0.0));
            (Vec3::splat(facing) + through) * 0.8 + Vec3::splat(0.12)
        } else {
            Vec3::splat(facing)
        };
        let wet = if normal.z > 0.5 { 1.0 - 0.45 * wetness } else { 1.0 };
        put(&mut l.diffuse, i, (sky.sun * direct * l.shadow_factor[i] + ambient) * wet);
    }
    l.specular = [[0.0; BATCH_STRIDE]; 3];
}

/// Of ground on which the film begins: stones stand out of it, and drops stir it, so that it is no mirror.
const WET_ROUGHNESS: f32 = 0.55;

/// Adds the specular reflection of a coat or a film of water.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn specular(l: &mut ShadingBatch, m: usize, sky: &Sky, eye: Vec3, wetness: f32) {
    for i in 0..m.min(BATCH_SIZE) {
        let (view, normal) = (get(&l.view, i), get(&l.normal, i));
        let (x, y) = (l.point[0][i] + eye.x, l.point[1][i] + eye.y);
        let puddle = value_noise(x * 0.35, y * 0.35, 0xF11);
        let is_wet = l.flags[i] & Flags::GROUND > 0 && normal.z > 0.5;
        let film = if is_wet { (wetness * 1.5 - 0.9 * puddle).clamp(0.0, 1.0) } else { 0.0 };
        let f0 = if film > 0.0 { 0.02 } else { l.f0[i] };
        let roughness = if film > 0.0 { WET_ROUGHNESS - 0.2 * film } else { l.roughness[i] };
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        let smooth = (1.0 - roughness) * (1.0 - roughness);
        let fresnel = f0 + (1.0 - f0) * fifth(1.0 - cos_view) * smooth;
        let fresnel = if f0 > 0.0 { fresnel } else { 0.0 };
        let mirrored = view + normal * (2.0 * cos_view);
        let sky_visibility =
            [l.sky_visibility[0][i], l.sky_visibility[1][i], l.sky_visibility[2][i], l.sky_visibility[3][i]];
        let shine = environment(sky, mirrored, &sky_visibility, roughness) * l.contact_occlusion[i].max(0.3)
            + highlight(sky, mirrored, roughness) * l.shadow_factor[i];
        // Metals color what they reflect.
        let is_metal = f0 > 0.5;
        let metal = get(&l.material, i);
        let tint = Vec3::new(
            if is_metal { metal.x } else { 1.0 },
            if is_metal { metal.y } else { 1.0 },
            if is_metal { metal.z } else { 1.0 },
        );
        let diffuse = get(&l.diffuse, i);
        put(&mut l.diffuse, i, diffuse * (1.0 - fresnel));
        put(&mut l.specular, i, shine * tint * fresnel);
    }
}

/// A transparent surface; what is seen through it takes the place of an albedo.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn transparent(l: &mut ShadingBatch, m: usize, sky: &Sky) {
    for i in 0..m.min(BATCH_SIZE) {
        let (view, normal) = (get(&l.view, i), get(&l.normal, i));
        let cos_view = (-view.dot(normal)).clamp(0.0, 1.0);
        // Both faces of a transparent surface of glass reflect.
        let f0 = l.f0[i].max(0.045) * 1.8;
        let fresnel = (f0 + (1.0 - f0) * fifth(1.0 - cos_view)).min(1.0);
        let mirrored = view + normal * (2.0 * cos_view);
        let glint = highlight(sky, mirrored, 0.15) * l.shadow_factor[i];
        let tint = Vec3::new(0.93, 1.0, 0.95) * l.transmission[i];
        let sky_visibility =
            [l.sky_visibility[0][i], l.sky_visibility[1][i], l.sky_visibility[2][i], l.sky_visibility[3][i]];
        let shine = environment(sky, mirrored, &sky_visibility, 0.0) + glint;
        put(&mut l.diffuse, i, tint * (1.0 - fresnel));
        put(&mut l.specular, i, shine * fresnel);
        // What is behind has come through the air already.
        l.distance_m[i] = 0.0;
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn through_air(l: &mut ShadingBatch, m: usize, light: &Light) {
    for i in 0..m.min(BATCH_SIZE) {
        let clear = transmittance(light.extinction_per_m, l.distance_m[i]);
        let (diffuse, specular) = (get(&l.diffuse, i), get(&l.specular, i));
        put(&mut l.diffuse, i, diffuse * clear);
        put(&mut l.specular, i, specular * clear + light.in_scattered(get(&l.view, i)) * (1.0 - clear));
    }
}

/// Resolves the pairs to pixels: light is known in the middles of pairs, and changes evenly from one to the next of a row, and so
/// beyond the first and the last: where blocks meet, it changes by as much as elsewhere.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn resolve(l: &mut ShadingBatch, m: usize) {
    let m = m.min(BATCH_SIZE);
    let [of_left, of_right] = &mut l.out;
    let goes_on = &l.goes_on;
    for axis in 0..3 {
        let (diffuse, specular) = (&l.diffuse[axis], &l.specular[axis]);
        // The first pair has none before it.
        let first = [diffuse, specular].map(|v| at_both_pixels(v[0], 0.0, v[1], 0, goes_on[0]));
        of_left[axis][0] = (l.albedo[0][axis][0] * first[0][0] + first[1][0]) * l.weights[0][0];
        of_right[axis][0] = (l.albedo[1][axis][0] * first[0][1] + first[1][1]) * l.weights[1][0];
        for i in 1..m {
            let [diffuse_left, diffuse_right] =
                at_both_pixels(diffuse[i], diffuse[i - 1], diffuse[i + 1], goes_on[i - 1], goes_on[i]);
            let [specular_left, specular_right] =
                at_both_pixels(specular[i], specular[i - 1], specular[i + 1], goes_on[i - 1], goes_on[i]);
            of_left[axis][i] = (l.albedo[0][axis][i] * diffuse_left + specular_left) * l.weights[0][i];
            of_right[axis][i] = (l.albedo[1][axis][i] * diffuse_right + specular_right) * l.weights[1][i];
        }
    }
}

/// Light in the left and the right pixel of a pair by that in its middle and in those of the pairs beside it, which are known
/// where bits are set.
#[inline(always)]
fn at_both_pixels(here: f32, before: f32, after: f32, has_before: u32, has_after: u32) -> [f32; 2] {
    let (fall, rise) = (where_set(has_before, here - before), where_set(has_after, after - here));
    let (at_left, at_right) = (fall + where_set(!has_before, rise), rise + where_set(!has_after, fall));
    [(here - 0.25 * at_left).max(0.0), (here + 0.25 * at_right).max(0.0)]
}

/// A number, or 0 where no bit is set: what is not asked for may be no number.
#[inline(always)]
fn where_set(mask: u32, v: f32) -> f32 {
    f32::from_bits(v.to_bits() & mask)
}

/// What a mirror shows: sky above the roofs and trees, a dark street below them, ground.
#[inline(always)]
fn environment(sky: &Sky, direction: Vec3, sky_visibility: &[f32; 4], roughness: f32) -> Vec3 {
    let d2 = direction * direction;
    let level = (d2.x + d2.y).max(1e-6);
    let toward_x = if direction.x < 0.0 { sky_visibility[1] } else { sky_visibility[0] };
    let toward_y = if direction.y < 0.0 { sky_visibility[3] } else { sky_visibility[2] };
    let free = (toward_x * d2.x + toward_y * d2.y) / level;
    // Sine of the skyline's elevation there, uneven as roofs and crowns are.
    let uneven = value_noise(direction.x * 7.0 + 31.0, direction.y * 7.0 + 31.0, 0xE17);
    let skyline = (0.10 + 0.85 * (1.0 - free).max(0.0).sqrt()) * (0.65 + 0.7 * uneven);
    let soft = 0.02 + 0.35 * roughness;
    let above = ((direction.z - skyline) / soft + 0.5).clamp(0.0, 1.0);
    let over_ground = ((direction.z + 0.01) / soft + 0.5).clamp(0.0, 1.0);
    let street = sky.sky_on_level * 0.16 + sky.sun * 0.030;
    let up = Vec3::new(direction.x, direction.y, direction.z.max(0.0));
    let low = sky.ground * 0.8 + (street - sky.ground * 0.8) * over_ground;
    low + (sky.radiance(up) - low) * above
}

/// The sun's own reflection, a GGX lobe about the mirrored direction.
#[inline(always)]
fn highlight(sky: &Sky, mirrored: Vec3, roughness: f32) -> Vec3 {
    let alpha2 = (roughness * roughness * roughness * roughness).max(0.002);
    let miss = 1.0 - mirrored.dot(sky.sun_world);
    let lobe = 1.0 + miss / (2.0 * alpha2);
    sky.sun * (1.0 / (4.0 * alpha2 * lobe * lobe))
}

#[inline(always)]
fn fifth(x: f32) -> f32 {
    let x2 = x * x;
    x2 * x2 * x
}
