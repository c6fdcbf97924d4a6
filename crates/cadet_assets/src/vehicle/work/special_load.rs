//! Bodies for one purpose: tanks, refuse compactors, fire engines.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface};
use super::bay::{Room, block};
use cadet_base::math::{Mat3, Quat, Vec3, cosf, powf, sinf};
use std::f32::consts::TAU;

/// A tank with its ladder and cabinets.
pub(super) fn add_tank(surface: &mut Surface, r: &Room, level: usize) {
    let n = [24, 14, 10, 8][level];
    let low = r.floor_z + 0.08;
    let (middle, half_z) = (0.5 * (low + r.top_z), 0.5 * (r.top_z - low));
    let ring = |x: f32, k: f32| -> Vec<Vec3> {
        (0..n)
            .map(|i| TAU * i as f32 / n as f32)
            .map(|a| {
                let (c, s) = (cosf(a), sinf(a));
                // Between an ellipse and a box.
                let out = powf(powf(c.abs(), 3.0) + powf(s.abs(), 3.0), -1.0 / 3.0);
                Vec3::new(x, c * out * k * r.half_y, middle + s * out * k * half_z)
            })
            .collect()
    };
    let (a, b) = (r.rear_x + 0.12, r.front_x);
    let rings = [
        (a, 0.3),
        (a + 0.03, 0.7),
        (a + 0.14, 0.95),
        (a + 0.3, 1.0),
        (b - 0.3, 1.0),
        (b - 0.14, 0.95),
        (b - 0.03, 0.7),
        (b, 0.3),
    ];
    surface.builder.loft(&rings.map(|(x, k)| ring(x, k)), work_slot::LOAD, true);
    for k in 1..4 {
        let x = a + (b - a) * k as f32 / 4.0;
        if level < 3 {
            surface.builder.loft(&[ring(x - 0.03, 1.004), ring(x + 0.03, 1.004)], work_slot::ALU, true);
        }
    }
    block(surface, r, (r.rear_x + 0.3, r.front_x - 0.3), 0.75, (r.floor_z - 0.06, low + 0.25), work_slot::FRAME);
    block(surface, r, (r.rear_x, r.rear_x + 0.1), 0.05, (r.floor_z - 0.3, r.floor_z + 0.15), work_slot::FRAME);
    if level < 2 {
        for y in [0.35, 0.65] {
            limb(
                surface,
                Vec3::new(r.rear_x + 0.06, y, r.floor_z - 0.1),
                Vec3::new(r.rear_x + 0.20, y, r.top_z - 0.12),
                0.02,
                0.02,
                5,
                work_slot::ALU,
            );
        }
        for k in 0..7 {
            let z = r.floor_z + (r.top_z - r.floor_z) * k as f32 / 7.5;
            limb(
                surface,
                Vec3::new(r.rear_x + 0.09, 0.35, z),
                Vec3::new(r.rear_x + 0.09, 0.65, z),
                0.014,
                0.014,
                4,
                work_slot::ALU,
            );
        }
        // Cabinets with hoses along the sides.
        surface.cuboid_pair(
            Vec3::new(r.rear_x + 1.2, r.half_y - 0.25, r.floor_z - 0.55),
            Vec3::new(r.front_x - 1.0, r.half_y - 0.08, r.floor_z - 0.05),
            work_slot::ALU,
        );
    }
}

/// A compactor with its loader.
pub(super) fn add_refuse(surface: &mut Surface, r: &Room, level: usize) {
    let tail = r.rear_x + 0.24 * (r.front_x - r.rear_x).min(7.0);
    block(surface, r, (tail, r.front_x), 0.06, (r.floor_z, r.top_z - 0.03), work_slot::LOAD);
    if level < 3 {
        let n = ((r.front_x - tail) / 0.8) as usize;
        for k in 0..=n {
            let x = tail + (r.front_x - tail - 0.08) * k as f32 / n as f32;
            surface.cuboid_pair(
                Vec3::new(x, r.half_y - 0.08, r.floor_z),
                Vec3::new(x + 0.08, r.half_y, r.top_z - 0.06),
                work_slot::LOAD,
            );
        }
        surface.cuboid_pair(
            Vec3::new(tail, r.half_y - 0.08, r.top_z - 0.10),
            Vec3::new(r.front_x, r.half_y, r.top_z),
            work_slot::LOAD,
        );
    }
    // The loader: a hollow with a hopper and the lifter's arms.
    let profile = [
        (tail, r.floor_z - 0.25),
        (r.rear_x + 0.15, r.floor_z - 0.30),
        (r.rear_x, r.floor_z + 0.35),
        (r.rear_x + 0.10, r.top_z - 0.75),
        (tail - 0.25, r.top_z - 0.03),
        (tail, r.top_z - 0.03),
    ];
    let w = r.half_y - 0.02;
    let ring = |y: f32| -> Vec<Vec3> { profile.iter().map(|(x, z)| Vec3::new(*x, y, *z)).collect() };
    for (y0, y1) in [(w - 0.12, w), (-w, -w + 0.12)] {
        surface.builder.loft(&[ring(y1), ring(y0)], work_slot::STRIPE, true);
    }
    let inner = [
        (r.rear_x + 0.02, r.floor_z + 0.40),
        (r.rear_x + 0.75, r.floor_z + 0.20),
        (r.rear_x + 0.55, r.floor_z + 1.25),
        (r.rear_x + 0.11, r.floor_z + 1.30),
        (r.rear_x + 0.12, r.top_z - 0.75),
        (tail - 0.25, r.top_z - 0.04),
        (tail, r.top_z - 0.04),
    ]
    .map(|(x, z)| vec![Vec3::new(x, -w + 0.1, z), Vec3::new(x, w - 0.1, z)]);
    surface.sheet(&inner, Outward::Along(Vec3::new(-1.0, 0.0, 0.4)), |i, _| {
        Some(if i < 3 { slot::LINER } else { work_slot::STRIPE })
    });
    block(surface, r, (r.rear_x + 0.03, r.rear_x + 0.2), 0.1, (r.floor_z - 0.28, r.floor_z + 0.38), work_slot::STRIPE);
    if level < 2 {
        for y in [-0.72, 0.10] {
            surface.builder.cuboid(
                Vec3::new(r.rear_x, y, r.floor_z - 0.1),
                Vec3::new(r.rear_x + 0.08, y + 0.62, r.floor_z + 0.45),
                work_slot::FRAME,
            );
        }
        surface.cuboid_pair(
            Vec3::new(r.rear_x, w - 0.45, 0.42),
            Vec3::new(r.rear_x + 0.3, w - 0.02, 0.47),
            work_slot::ALU,
        );
        surface.block_pair(
            Vec3::new(r.rear_x + 0.25, w - 0.2, r.top_z - 0.62),
            Vec3::new(0.07, 0.07, 0.09),
            Mat3::IDENTITY,
            6,
            work_slot::AMBER,
        );
    }
}

/// Shutters, a ladder and beacons.
pub(super) fn add_fire(surface: &mut Surface, r: &Room, level: usize) {
    let top = r.top_z - 0.30;
    let low = r.floor_z - 0.30;
    block(surface, r, (r.rear_x + 0.02, r.front_x), 0.03, (low, top), work_slot::LOAD);
    let length = r.front_x - r.rear_x;
    let n = if length > 4.0 { 3 } else { 2 };
    for k in 0..n {
        // Roller shutters with their slats.
        let x0 = r.rear_x + 0.15 + (length - 0.3) * k as f32 / n as f32;
        let x1 = x0 + (length - 0.3) / n as f32 - 0.14;
        let slats = if level < 2 { 14 } else { 1 };
        let rows: Vec<Vec<Vec3>> = (0..=2 * slats)
            .map(|i| {
                let z = low + 0.08 + (top - low - 0.25) * i as f32 / (2 * slats) as f32;
                let y = r.half_y - 0.02 - if i % 2 == 1 { 0.008 } else { 0.0 };
                vec![Vec3::new(x0, y, z), Vec3::new(x1, y, z)]
            })
            .collect();
        surface.pair(&rows, Outward::Along(Vec3::Y), |_, _| Some(work_slot::ALU));
    }
    surface.cuboid_pair(
        Vec3::new(r.rear_x, r.half_y - 0.04, top - 0.14),
        Vec3::new(r.front_x, r.half_y, top - 0.02),
        work_slot::STRIPE,
    );
    surface.builder.cuboid(
        Vec3::new(r.rear_x, -0.55, low + 0.3),
        Vec3::new(r.rear_x + 0.04, 0.55, top - 0.3),
        work_slot::ALU,
    );
    // The ladder on the roof, the rail round it.
    for y in [-0.55, -0.15] {
        surface.builder.cuboid(
            Vec3::new(r.rear_x + 0.1, y - 0.03, top + 0.16),
            Vec3::new(r.front_x - 0.1, y + 0.03, r.top_z),
            work_slot::ALU,
        );
    }
    if level < 2 {
        let rungs = (length / 0.35) as usize;
        for k in 0..rungs {
            let x = r.rear_x + 0.2 + 0.35 * k as f32;
            surface.builder.cuboid(
                Vec3::new(x, -0.53, top + 0.2),
                Vec3::new(x + 0.03, -0.17, top + 0.24),
                work_slot::ALU,
            );
        }
    }
    surface.builder.cuboid(
        Vec3::new(r.rear_x + 0.2, 0.1, top),
        Vec3::new(r.front_x - 0.4, 0.7, top + 0.22),
        work_slot::ALU,
    );
    let lean = Mat3::from_quat(Quat::IDENTITY);
    surface.block_pair(
        Vec3::new(r.rear_x + 0.14, r.half_y - 0.16, top + 0.10),
        Vec3::new(0.10, 0.10, 0.10),
        lean,
        8,
        work_slot::BEACON,
    );
}
