//! The base color of a batch's surfaces: texture, water, and snow.

use macro_rules_attribute::apply;

use super::super::face::ShaderVariant;
use super::super::shading_queue::{BATCH_SIZE, BatchScalar};
use super::batch::{BatchVector, OutgoingLight, ShadingCamera, SurfaceGeometry, SurfaceInputs, get, put};
use crate::camera::surfaces::{Flags, PatternPoint, textures, value_noise, windows};
use crate::surface_cover::{snow_share, under_film, wet_share};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// Leaves that are seen nearly edge-on are stretched no further, by the squared sine of their angle to the view.
const LEAST_SINE_SQUARED: f32 = 0.02;
/// Drifts of snow: cells of noise per meter.
const DRIFTS_PER_M: f32 = 0.6;
const DRIFT_SALT: u32 = 0x5E0;
const SNOW_ALBEDO: f32 = 0.8;
/// Light that goes through the face of a film of water, from most directions.
const ENTERS: f64 = 0.98;

/// Which of a pair's pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelOfPair {
    Left,
    Right,
    /// The middle of both.
    Middle,
}

impl PixelOfPair {
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// From the pair's middle, in half spacings.
    fn offset(self) -> f32 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
            Self::Middle => 0.0,
        }
    }
}

/// Where the left or the right pixel of a pair meets its surface, relative to the eye.
#[inline(always)]
fn point_in_pixel(inputs: &SurfaceInputs, camera: &ShadingCamera, side: f32, i: usize) -> Vec3 {
    let aside = inputs.half_spacing[i] * side;
    let direction = camera.corner + camera.right * (inputs.u[i] + aside) + camera.down * inputs.v[i];
    // What is seen from its rim ends before the next pixel's middle.
    let middle = inputs.inverse_depth_per_m[i];
    let inverse_depth = (middle + inputs.inverse_depth_by_column[i] * aside).max(0.5 * middle).min(2.0 * middle);
    direction * (1.0 / inverse_depth)
}

/// The coordinates of the texture in the left or the right pixels.
#[apply(for_wide_registers)]
pub fn place_texture(
    inputs: &SurfaceInputs,
    m: usize,
    camera: &ShadingCamera,
    variant: ShaderVariant,
    side: PixelOfPair,
    out: &mut [BatchScalar; 2],
) {
    let m = m.min(BATCH_SIZE);
    let side = side.offset();
    let mut points = [[0.0; BATCH_SIZE]; 3];
    for i in 0..m {
        put(&mut points, i, point_in_pixel(inputs, camera, side, i));
    }
    let [u, v] = out;
    if variant.pattern == Pattern::Leaves {
        let [across, down] = [camera.right.normalize(), camera.down.normalize()];
        for i in 0..m {
            let point = get(&points, i);
            let normal = get(&inputs.face_normal, i);
            // Along the leaf: leaves seen edge-on, and the sides of hedges, would be streaks.
            let [along, upwards] = [across, down]
                .map(|axis| 1.0 / (1.0 - normal.dot(axis) * normal.dot(axis)).max(LEAST_SINE_SQUARED).sqrt());
            u[i] = (point.dot(across) + inputs.at_eye_m[0][i]) * along;
            v[i] = (point.dot(down) + inputs.at_eye_m[1][i]) * upwards;
        }
    } else {
        for i in 0..m {
            let point = get(&points, i);
            u[i] = point.dot(get(&inputs.axis_u, i)) + inputs.at_eye_m[0][i];
            v[i] = point.dot(get(&inputs.axis_v, i)) + inputs.at_eye_m[1][i];
        }
    }
}

/// The material's albedo, by the variant's texture.
#[apply(for_wide_registers)]
pub fn texture(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    [u, v]: &[BatchScalar; 2],
    m: usize,
    pattern: Pattern,
    out: &mut BatchVector,
) {
    macro_rules! fill {
        ($($of:ident),*) => {
            match pattern {
                Pattern::Plain | Pattern::Lamp | Pattern::Reflector => (),
                Pattern::Window => fill_with!(windows::radiance),
                $(Pattern::$of => fill_with!(|base, at| textures::albedo(Pattern::$of, base, at)),)*
            }
        };
    }
    macro_rules! fill_with {
        ($color:expr) => {
            for i in 0..m.min(BATCH_SIZE) {
                let at = PatternPoint {
                    u: u[i],
                    v: v[i],
                    footprint_m: geometry.footprint_m[i],
                    pixel_m: geometry.pixel_m[i],
                    face_hash: inputs.face_hash[i],
                    place_hash: inputs.place_hash[i],
                };
                put(out, i, $color(get(&inputs.albedo, i), &at));
            }
        };
    }
    fill!(Asphalt, Slabs, Blocks, Bricks, Render, Tiles, Grass, Leaves, Wood, Cloth, Paint);
}

/// What snow covers of the surface in the left or the right pixel of a pair, or in its middle.
#[inline(always)]
fn covered_share(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    camera: &ShadingCamera,
    snow_cover: f32,
    side: PixelOfPair,
    i: usize,
) -> f32 {
    // In the pixel itself: in the pair's middle, each pair would have its own drift.
    let Vec3 { x, y, .. } = point_in_pixel(inputs, camera, side.offset(), i) + camera.eye;
    let drift = value_noise(x * DRIFTS_PER_M, y * DRIFTS_PER_M, DRIFT_SALT);
    let lies = if inputs.flags[i] & Flags::SHEDS_SNOW > 0 { 0.0 } else { 1.0 };
    snow_share(geometry.normal[2][i]) * (snow_cover * (0.5 + drift)).min(1.0) * lies
}

/// Darkens what water soaks into.
#[apply(for_wide_registers)]
pub fn soak(inputs: &SurfaceInputs, geometry: &SurfaceGeometry, m: usize, wetness: f32, out: &mut BatchVector) {
    for i in 0..m.min(BATCH_SIZE) {
        let absorbs = if inputs.flags[i] & Flags::ABSORBS > 0 { wetness } else { 0.0 };
        let wet = absorbs * wet_share(geometry.normal[2][i]);
        for channel in out.iter_mut() {
            let dark = under_film(f64::from(channel[i]), ENTERS) as f32;
            channel[i] *= 1.0 - wet * (1.0 - dark);
        }
    }
}

/// Lays snow on the left or the right pixels.
#[apply(for_wide_registers)]
pub fn lay_snow(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    m: usize,
    camera: &ShadingCamera,
    snow_cover: f32,
    side: PixelOfPair,
    out: &mut BatchVector,
) {
    for i in 0..m.min(BATCH_SIZE) {
        let cover = covered_share(inputs, geometry, camera, snow_cover, side, i);
        let albedo = get(out, i);
        put(out, i, albedo + (Vec3::splat(SNOW_ALBEDO) - albedo) * cover);
    }
}

/// Puts snow over what leaves transparent surfaces.
#[apply(for_wide_registers)]
pub fn snow_over(
    inputs: &SurfaceInputs,
    geometry: &SurfaceGeometry,
    m: usize,
    camera: &ShadingCamera,
    snow_cover: f32,
    irradiance: &BatchVector,
    out: &mut OutgoingLight,
) {
    for i in 0..m.min(BATCH_SIZE) {
        let cover = covered_share(inputs, geometry, camera, snow_cover, PixelOfPair::Middle, i);
        let (seen_through, mirrored) = (get(&out.diffuse, i), get(&out.specular, i));
        put(&mut out.diffuse, i, seen_through * (1.0 - cover));
        put(&mut out.specular, i, mirrored * (1.0 - cover) + get(irradiance, i) * (SNOW_ALBEDO * cover));
    }
}
