//! Where a batch's surfaces lie, and how they stand to eye and sun.

use macro_rules_attribute::apply;

use super::super::face::ShaderVariant;
use super::super::shading_queue::BATCH_SIZE;
use super::batch::{ShadingCamera, SurfaceGeometry, SurfaceInputs, get, put};
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// The least cosine between view and normal for which the size of a pixel on the surface is found.
const LEAST_COS_VIEW: f32 = 0.02;
/// The least square of a normal's length by which is divided.
const LEAST_SQUARE: f32 = 1e-20;

#[apply(for_wide_registers)]
pub fn place_surfaces(
    inputs: &SurfaceInputs,
    m: usize,
    camera: &ShadingCamera,
    sun: Vec3,
    variant: ShaderVariant,
    out: &mut SurfaceGeometry,
) {
    let m = m.min(BATCH_SIZE);
    let mut depth = [0.0; BATCH_SIZE];
    for i in 0..m {
        depth[i] = 1.0 / inputs.inverse_depth_per_m[i];
    }
    for i in 0..m {
        let direction = camera.corner + camera.right * inputs.u[i] + camera.down * inputs.v[i];
        let length = direction.dot(direction).sqrt();
        let point = direction * depth[i];
        put(&mut out.view, i, direction * (1.0 / length));
        put(&mut out.point, i, point);
        out.distance_m[i] = depth[i] * length;
        out.cos_face[i] = get(&inputs.face_normal, i).dot(sun);
    }
    if variant.pattern != Pattern::Plain {
        for i in 0..m {
            let cos_view = get(&out.view, i).dot(get(&inputs.face_normal, i)).abs().max(LEAST_COS_VIEW);
            out.pixel_m[i] = depth[i] * camera.pixel_per_m;
            out.footprint_m[i] = out.pixel_m[i] / cos_view.sqrt();
        }
    }
    if variant.is_flat() {
        out.normal = inputs.face_normal;
        out.cos_sun = out.cos_face;
        return;
    }
    if variant.is_smooth {
        for i in 0..m {
            let point = get(&out.point, i);
            let (least, most) = (inputs.least_weight[i], 1.0 - inputs.least_weight[i]);
            let wb = (point.dot(get(&inputs.to_b, i)) + inputs.weights_at_eye[0][i]).max(least).min(most);
            let wc = (point.dot(get(&inputs.to_c, i)) + inputs.weights_at_eye[1][i]).max(least).min(most - wb);
            let normal =
                get(&inputs.corner_normal, i) + get(&inputs.normal_ab, i) * wb + get(&inputs.normal_ac, i) * wc;
            let scale = 1.0 / normal.dot(normal).max(LEAST_SQUARE).sqrt();
            put(&mut out.normal, i, normal * scale);
        }
    } else {
        out.normal = inputs.corner_normal;
    }
    for i in 0..m {
        out.cos_sun[i] = get(&out.normal, i).dot(sun);
    }
}
