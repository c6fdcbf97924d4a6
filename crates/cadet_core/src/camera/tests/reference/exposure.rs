//! The exposure, by bisection.

use crate::math::Vec3;

const WHITE_BALANCE: Vec3 = Vec3::new(0.97, 1.0, 1.05);

/// What lens and housing scatter over the image: a twentieth of the mean, to which no pixel gives more than `ceiling`.
pub fn veil(pixels: &[Vec3], ceiling: f32) -> Vec3 {
    pixels.iter().map(|p| p.min(Vec3::splat(ceiling))).sum::<Vec3>() * (0.05 / pixels.len() as f32)
}

/// The gains of R, G, B to 8-bit values at which the clipped image has a mean luma of `target`.
pub fn gain(pixels: &[Vec3], veil: Vec3, target: f32) -> Vec3 {
    let luma = |gain: f32| {
        let value = |p: &Vec3| ((*p + veil) * WHITE_BALANCE * gain).min(Vec3::splat(255.0));
        let sum: Vec3 = pixels.iter().map(value).sum();
        sum.dot(Vec3::new(0.2126, 0.7152, 0.0722)) / pixels.len() as f32
    };
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        (low, high) = if luma(middle) < target { (middle, high) } else { (low, middle) };
    }
    WHITE_BALANCE * low
}
