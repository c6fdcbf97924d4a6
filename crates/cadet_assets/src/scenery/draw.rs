//! Small things that several models need.

use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

/// Crease for everything built of flat parts.
pub(super) const CREASE_RAD: f32 = 0.7;

/// A place or a size.
pub(super) fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A direction drawn evenly from the sphere.
pub(super) fn direction(stream: &mut Stream) -> Vec3 {
    let z = stream.range(-1.0, 1.0) as f32;
    let a = stream.range(0.0, std::f64::consts::TAU) as f32;
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cosf(a), r * sinf(a), z)
}

/// Uniform in [lo, hi), in single precision.
pub(super) fn range(stream: &mut Stream, lo: f32, hi: f32) -> f32 {
    stream.range(f64::from(lo), f64::from(hi)) as f32
}
