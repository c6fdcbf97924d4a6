//! Transcendental functions that give the same bits on every machine (`libm`), and small helpers.
//!
//! The standard library's `sin`, `exp`, ... call the platform's, whose last bit differs between machines; clippy
//! refuses them in this workspace (`clippy.toml`). `sqrt`, `floor` and `abs` are exact everywhere.

pub use glamx::{DMat3, DPose3, DQuat, DVec2, DVec3, Mat3, Quat, Vec2, Vec3};
pub use std::f64::consts::{PI, TAU};

macro_rules! from_libm {
    ($($name:ident, $f64:path, $f32_name:ident, $f32:path;)*) => {$(
        #[doc = concat!("`", stringify!($name), "` in double precision, the same bits everywhere.")]
        #[inline]
        #[must_use]
        pub fn $name(x: f64) -> f64 { $f64(x) }
        #[doc = concat!("`", stringify!($name), "` in single precision, the same bits everywhere.")]
        #[inline]
        #[must_use]
        pub fn $f32_name(x: f32) -> f32 { $f32(x) }
    )*};
}
from_libm! {
    sin, libm::sin, sinf, libm::sinf;
    cos, libm::cos, cosf, libm::cosf;
    tan, libm::tan, tanf, libm::tanf;
    asin, libm::asin, asinf, libm::asinf;
    acos, libm::acos, acosf, libm::acosf;
    atan, libm::atan, atanf, libm::atanf;
    exp, libm::exp, expf, libm::expf;
    ln, libm::log, lnf, libm::logf;
}

/// The cube root of `x`, the same bits everywhere.
#[inline]
#[must_use]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// `atan2(y, x)` in double precision, in [-pi, pi].
#[inline]
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// `atan2(y, x)` in single precision, in [-pi, pi].
#[inline]
#[must_use]
pub fn atan2f(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// `base` to the power `exponent`, in double precision.
#[inline]
#[must_use]
pub fn pow(base: f64, exponent: f64) -> f64 {
    libm::pow(base, exponent)
}

/// `base` to the power `exponent`, in single precision.
#[inline]
#[must_use]
pub fn powf(base: f32, exponent: f32) -> f32 {
    libm::powf(base, exponent)
}

/// The length of (x, y), without `hypot`'s platform dependence.
#[inline]
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The smaller of two numbers as vector registers compare them: `b` where one of them is NaN.
#[inline(always)]
#[must_use]
pub fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The larger of two numbers, as [`lesser`].
#[inline(always)]
#[must_use]
pub fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The whole number below, of numbers that have one: without SSE 4.1 `f64::floor` is a call.
#[inline(always)]
#[must_use]
pub fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    toward_zero - i64::from((toward_zero as f64) > x)
}

/// Wraps an angle to [-pi, pi).
#[inline]
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let wrapped = angle_rad - TAU * ((angle_rad + PI) / TAU).floor();
    if wrapped >= PI { wrapped - TAU } else { wrapped }
}

/// The angle by which one turns from a direction to another, in [-pi, pi]: above 0 to the left.
#[inline]
#[must_use]
pub fn turn_rad(from: DVec2, to: DVec2) -> f64 {
    atan2(from.perp_dot(to), from.dot(to))
}

/// `0` below `lo`, `1` above `hi`, a smooth cubic between.
#[inline]
#[must_use]
pub fn smoothstep(lo: f64, hi: f64, x: f64) -> f64 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear blend from `a` (t = 0) to `b` (t = 1).
#[inline]
#[must_use]
pub fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The natural logarithm of a positive, normal number within 2e-9, in a few multiplications and one division: for what
/// a scan computes a hundred thousand times and rounds to hundredths.
#[inline(always)]
#[must_use]
pub fn quick_ln(x: f64) -> f64 {
    // x = m * 2^e with m from 1 / sqrt 2 to sqrt 2, and ln m = 2 artanh((m - 1) / (m + 1)).
    const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let exponent = (shifted as i64) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub((exponent as u64) << 52));
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (1.0 / 5.0 + q * (1.0 / 7.0 + q * (1.0 / 9.0))));
    exponent as f64 * std::f64::consts::LN_2 + 2.0 * s * series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_wrap_into_the_half_open_interval() {
        for k in -20..20 {
            let a = wrap_angle(0.3 + f64::from(k) * TAU);
            assert!((a - 0.3).abs() < 1e-12, "{a}");
        }
        assert_eq!(wrap_angle(PI), -PI);
        assert_eq!(wrap_angle(-PI), -PI);
    }

    #[test]
    fn the_quick_logarithm_is_near_enough() {
        for i in 0..20_000 {
            let x = exp(f64::from(i) * 0.005 - 50.0);
            assert!((quick_ln(x) - ln(x)).abs() < 2e-9, "{x}");
        }
        assert_eq!(quick_ln(1.0), 0.0);
    }
}
