//! Small shapes that several models are made of.

use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, sinf};
use crate::rng::Stream;

/// Crease for everything built of flat parts.
pub(super) const CREASE_RAD: f32 = 0.7;

/// A tapered tube of `sides` faces from `from` to `to`, capped.
pub(super) fn tube(b: &mut MeshBuilder, from: (Vec3, f32), to: (Vec3, f32), sides: usize, slot: u8) {
    path_tube(b, &[from, to], sides, slot);
}

/// A tube through (center, radius) stations, capped at both ends.
pub(super) fn path_tube(b: &mut MeshBuilder, stations: &[(Vec3, f32)], sides: usize, slot: u8) {
    let (Some(first), Some(last)) = (stations.first(), stations.last()) else { return };
    let axis = (last.0 - first.0).normalize_or(Vec3::Z);
    let side = if axis.z.abs() < 0.9 { Vec3::Z } else { Vec3::X };
    let e1 = side.cross(axis).normalize();
    let e2 = axis.cross(e1);
    let rings: Vec<Vec<Vec3>> = stations
        .iter()
        .map(|(center, radius)| {
            (0..sides)
                .map(|i| std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32)
                .map(|a| *center + (e1 * cosf(a) + e2 * sinf(a)) * *radius)
                .collect()
        })
        .collect();
    b.loft(&rings, slot, true);
}

/// A box given by its middle and its edge lengths.
pub(super) fn block(b: &mut MeshBuilder, middle: Vec3, size: Vec3, slot: u8) {
    b.cuboid(middle - size * 0.5, middle + size * 0.5, slot);
}

/// A closed disc (a regular polygon of `sides` corners) that faces +x.
pub(super) fn disc(b: &mut MeshBuilder, middle: Vec3, radius: f32, sides: usize, turn_rad: f32, slot: u8) {
    let corner = |i: usize| {
        let a = turn_rad + std::f32::consts::TAU * i as f32 / sides as f32;
        middle + Vec3::new(0.0, cosf(a), sinf(a)) * radius
    };
    for i in 1..sides - 1 {
        b.triangle(corner(0), corner(i), corner(i + 1), slot);
    }
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
