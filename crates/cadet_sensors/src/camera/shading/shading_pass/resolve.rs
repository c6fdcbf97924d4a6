//! From the light of pairs to the radiance of pixels.

use macro_rules_attribute::apply;

use super::super::face::ShaderVariant;
use super::super::shading_queue::BATCH_SIZE;
use super::batch::{BatchVector, OutgoingLight, SurfaceGeometry, SurfaceInputs, get, put};
use crate::camera::light::{Light, transmittance};
use cadet_base::math::Vec3;

/// From the middle of a pair to its pixels, in pairs.
const PIXEL_OFFSET: f32 = 0.25;

/// What the air leaves of the light on its way to the camera, and what it adds. What is behind transparent surfaces has come
/// through the air of the whole way already; but the light that the air adds in front of them is not dimmed by them: they take
/// their share of it with what is behind.
#[apply(for_wide_registers)]
pub fn through_air(
    geometry: &SurfaceGeometry,
    outgoing: &OutgoingLight,
    m: usize,
    light: &Light,
    variant: ShaderVariant,
    out: &mut OutgoingLight,
) {
    for i in 0..m.min(BATCH_SIZE) {
        let clear = transmittance(light.extinction_per_m, geometry.distance_m[i]);
        let diffuse = get(&outgoing.diffuse, i);
        let air = light.in_scattered(get(&geometry.view, i)) * (1.0 - clear);
        let (diffuse, air) =
            if variant.is_transparent { (diffuse, air * (Vec3::ONE - diffuse)) } else { (diffuse * clear, air) };
        put(&mut out.diffuse, i, diffuse);
        put(&mut out.specular, i, get(&outgoing.specular, i) * clear + air);
    }
}

/// Light is known in the middles of pairs, and changes evenly from one to the next of a row, and so beyond the first and the
/// last: where blocks meet, it changes by as much as elsewhere.
#[apply(for_wide_registers)]
pub fn resolve(
    inputs: &SurfaceInputs,
    base_color: &[BatchVector; 2],
    arriving: &OutgoingLight,
    m: usize,
    [of_left, of_right]: &mut [BatchVector; 2],
) {
    let m = m.min(BATCH_SIZE);
    let ([base_left, base_right], [weight_left, weight_right]) = (base_color, &inputs.weights);
    let continues = &inputs.continues;
    for axis in 0..3 {
        let (diffuse, specular) = (&arriving.diffuse[axis], &arriving.specular[axis]);
        // The first pair has none before it.
        let first = [diffuse, specular].map(|v| at_both_pixels(v[0], 0.0, v[1], 0, continues[0]));
        of_left[axis][0] = (base_left[axis][0] * first[0][0] + first[1][0]) * weight_left[0];
        of_right[axis][0] = (base_right[axis][0] * first[0][1] + first[1][1]) * weight_right[0];
        for i in 1..m {
            let [diffuse_left, diffuse_right] =
                at_both_pixels(diffuse[i], diffuse[i - 1], diffuse[i + 1], continues[i - 1], continues[i]);
            let [specular_left, specular_right] =
                at_both_pixels(specular[i], specular[i - 1], specular[i + 1], continues[i - 1], continues[i]);
            of_left[axis][i] = (base_left[axis][i] * diffuse_left + specular_left) * weight_left[i];
            of_right[axis][i] = (base_right[axis][i] * diffuse_right + specular_right) * weight_right[i];
        }
    }
}

/// Light in the left and the right pixel of a pair by that in its middle and in those of the pairs beside it, which are known
/// where bits are set.
#[inline(always)]
fn at_both_pixels(here: f32, before: f32, after: f32, has_before: u32, has_after: u32) -> [f32; 2] {
    let (fall, rise) = (where_set(has_before, here - before), where_set(has_after, after - here));
    let (at_left, at_right) = (fall + where_set(!has_before, rise), rise + where_set(!has_after, fall));
    [(here - PIXEL_OFFSET * at_left).max(0.0), (here + PIXEL_OFFSET * at_right).max(0.0)]
}

/// A number, or 0 where no bit is set: what is masked out may be no number.
#[inline(always)]
fn where_set(mask: u32, v: f32) -> f32 {
    f32::from_bits(v.to_bits() & mask)
}
