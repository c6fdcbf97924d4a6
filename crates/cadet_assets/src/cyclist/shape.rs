//! The bicycle's shape: tubes, bars and arcs.

use super::bicycle::{Bicycle, FrameKind};
use super::paint::slot;
use super::rider::{PEDAL_HALF_M, SADDLE_BELOW_HIP_M, Seat};
use crate::person::tube::{Ring, Tubes};
use cadet_base::math::{Vec3, cosf, sinf};
use std::f32::consts::{PI, TAU};

/// Corners of a round tube at each level of detail.
const SIDES: [usize; 3] = [8, 5, 3];

/// A direction square to another.
fn square_to(along: Vec3) -> Vec3 {
    if along.y.abs() > 0.9 { Vec3::X } else { along.cross(Vec3::Y).normalize() }
}

/// A tube through points, with half axes up to down and side to side.
fn pipe(tubes: &mut Tubes, points: &[Vec3], half: [f32; 2], slot: u8, level: usize) {
    let last = points.len() - 1;
    let rings: Vec<Ring> = (0..=last)
        .map(|i| {
            let along = (points[(i + 1).min(last)] - points[i.max(1) - 1]).normalize();
            Ring::new(points[i], [along, square_to(along)], half, slot, 2)
        })
        .collect();
    tubes.tube(&rings, SIDES[level], level, -1.0);
}

fn bar(tubes: &mut Tubes, from: Vec3, to: Vec3, radius: f32, slot: u8, level: usize) {
    pipe(tubes, &[from, to], [radius; 2], slot, level);
}

/// An arc round an axle along y, from an angle to another (0 is up, forward positive), of a section `half`: outward, aside.
fn arc(tubes: &mut Tubes, center: Vec3, radius: f32, turn: [f32; 2], half: [f32; 2], slot: u8, level: usize) {
    let share = (turn[1] - turn[0]).abs() / TAU;
    let steps = (share * [40.0, 22.0, 12.0][level]).ceil().max(3.0) as usize;
    let rings: Vec<Ring> = (0..=steps)
        .map(|k| {
            let angle = turn[0] + (turn[1] - turn[0]) * k as f32 / steps as f32;
            let out = Vec3::new(sinf(angle), 0.0, cosf(angle));
            let along = Vec3::new(cosf(angle), 0.0, -sinf(angle));
            Ring::new(center + out * radius, [along, out], half, slot, 2)
        })
        .collect();
    tubes.tube(&rings, [8, 6, 4][level], level, -1.0);
}

/// A wheel about its own axle, which lies along y.
pub(super) fn wheel(bicycle: &Bicycle, level: usize) -> Tubes {
    let mut tubes = Tubes::default();
    let (r, tire) = (bicycle.wheel_radius_m, bicycle.tire_half_m);
    let whole = [0.0, TAU];
    // The corners of a coarse ring lie on the tire's circle, its edges inside.
    let out = [1.001, 1.004, 1.01][level];
    arc(&mut tubes, Vec3::ZERO, (r - tire) * out, whole, [tire, tire], slot::TIRE, level);
    arc(&mut tubes, Vec3::ZERO, r - 2.0 * tire - 0.006, whole, [0.011, 0.010], slot::METAL, level);
    bar(&mut tubes, Vec3::Y * 0.045, Vec3::Y * -0.045, 0.020, slot::METAL, level);
    if level == 0 {
        for k in 0..28 {
            let angle = k as f32 / 28.0 * TAU;
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let at = |angle: f32, radius: f32, y: f32| Vec3::new(radius * sinf(angle), y, radius * cosf(angle));
            let lead = if k % 4 < 2 { 0.9 } else { -0.9 };
            let ends = [at(angle + lead, 0.020, 0.032 * side), at(angle, r - 2.0 * tire - 0.01, 0.0)];
            let along = (ends[1] - ends[0]).normalize();
            let rings = ends.map(|end| Ring::new(end, [along, square_to(along)], [0.0011; 2], slot::METAL, 2));
            tubes.tube(&rings, 3, level, -1.0);
        }
    }
    tubes
}

/// What does not move: frame, fork, handlebar, saddle, and what is mounted on them.
pub(super) fn add_bicycle(tubes: &mut Tubes, b: &Bicycle, seat: &Seat, level: usize) {
    let [rear, front] = b.axles();
    let crank = b.crank_axle();
    let saddle_z = seat.hip.z - SADDLE_BELOW_HIP_M;
    let (head_top, head_low) = (b.steerer((b.grip.z - 0.10).max(0.72)), b.steerer(2.0 * b.wheel_radius_m + 0.07));
    let cluster = b.seat_tube((saddle_z - 0.14).min(head_top.z));
    let mut tube = |from: Vec3, to: Vec3, radius: f32, slot: u8| bar(tubes, from, to, radius, slot, level);
    tube(crank, cluster, 0.016, slot::FRAME);
    tube(cluster, b.seat_tube(saddle_z - 0.03), 0.013, slot::METAL);
    tube(head_low, head_top, 0.019, slot::FRAME);
    match b.frame {
        FrameKind::Diamond => {
            tube(cluster - Vec3::Z * 0.02, head_top - Vec3::Z * 0.03, 0.015, slot::FRAME);
            tube(crank, head_low + Vec3::Z * 0.02, 0.018, slot::FRAME);
        }
        FrameKind::StepThrough => {
            tube(b.seat_tube(crank.z + 0.20), head_top - Vec3::Z * 0.05, 0.014, slot::FRAME);
            tube(crank, head_low + Vec3::Z * 0.01, 0.019, slot::FRAME);
        }
    }
    for side in [1.0, -1.0] {
        let aside = |y: f32| Vec3::Y * (y * side);
        tube(crank + aside(0.03), rear + aside(0.062), 0.010, slot::FRAME);
        tube(cluster + aside(0.02), rear + aside(0.062), 0.009, slot::FRAME);
        tube(head_low + aside(0.045), front + aside(0.055), 0.012, slot::FRAME);
    }
    tube(head_low + Vec3::Y * 0.05, head_low - Vec3::Y * 0.05, 0.014, slot::FRAME);
    add_handlebar(tubes, b, head_top, level);
    add_saddle(tubes, b.seat_tube(saddle_z), level);
    add_fittings(tubes, b, level);
    bar(tubes, crank + Vec3::Y * 0.06, crank - Vec3::Y * 0.06, 0.020, slot::METAL, level);
    if b.fittings.chain_guard {
        let y = Vec3::Y * -0.055;
        pipe(tubes, &[rear + y, crank + y + Vec3::X * 0.08], [0.045, 0.008], slot::PLASTIC, level);
    } else {
        arc(tubes, crank - Vec3::Y * 0.05, 0.065, [0.0, TAU], [0.022, 0.003], slot::METAL, level);
    }
    let tail = if b.fittings.rack {
        Vec3::new(rear.x - 0.20, 0.0, 2.0 * b.wheel_radius_m + 0.04)
    } else {
        b.seat_tube(saddle_z - 0.09) - Vec3::X * 0.02
    };
    bar(tubes, tail, tail - Vec3::X * 0.02, 0.024, slot::TAIL_LAMP, level);
    let lamp = b.steerer(head_low.z + 0.05) + Vec3::X * 0.02;
    bar(tubes, lamp, lamp + Vec3::X * 0.05, 0.030, slot::LAMP, level);
}

fn add_handlebar(tubes: &mut Tubes, b: &Bicycle, head_top: Vec3, level: usize) {
    let stem = b.steerer(b.grip.z - 0.02) + Vec3::X * 0.05;
    bar(tubes, head_top, stem, 0.014, slot::METAL, level);
    let end = |side: f32, y: f32, x: f32| Vec3::new(b.grip.x + x, side * y, b.grip.z);
    let half = b.bar_half_m;
    // Bars of upright bicycles sweep back to the grips.
    let bend = stem.lerp(b.grip, 0.35);
    let points = [
        end(1.0, half, -0.02),
        end(1.0, half - 0.12, 0.015),
        Vec3::new(bend.x, 0.5 * b.grip.y, b.grip.z),
        stem,
        Vec3::new(bend.x, -0.5 * b.grip.y, b.grip.z),
        end(-1.0, half - 0.12, 0.015),
        end(-1.0, half, -0.02),
    ];
    pipe(tubes, &points, [0.012; 2], slot::METAL, level);
    for side in [1.0, -1.0] {
        bar(tubes, end(side, half, -0.02), end(side, half - 0.12, 0.015), 0.017, slot::PLASTIC, level);
    }
    bar(tubes, stem, stem + Vec3::new(0.03, 0.0, 0.02), 0.02, slot::PLASTIC, level);
}

fn add_saddle(tubes: &mut Tubes, top: Vec3, level: usize) {
    let ring = |x: f32, y: f32, z: f32, level: usize| {
        Ring::new(top + Vec3::new(x, 0.0, -z), [Vec3::X, Vec3::Z], [z, y], slot::SADDLE, level)
    };
    let rings = [
        ring(-0.13, 0.055, 0.020, 2),
        ring(-0.10, 0.085, 0.032, 2),
        ring(-0.04, 0.080, 0.034, 1),
        ring(0.02, 0.042, 0.028, 0),
        ring(0.13, 0.020, 0.020, 2),
    ];
    tubes.tube(&rings, SIDES[level].max(4), level, -1.0);
}

fn add_fittings(tubes: &mut Tubes, b: &Bicycle, level: usize) {
    let [rear, front] = b.axles();
    let over = b.wheel_radius_m + 0.022;
    if b.fittings.mudguards {
        let half = [0.005, 0.027];
        arc(tubes, rear, over, [-0.62 * PI, 0.30 * PI], half, slot::MUDGUARD, level);
        arc(tubes, front, over, [-0.62 * PI, 0.17 * PI], half, slot::MUDGUARD, level);
    }
    if b.fittings.rack {
        let z = rear.z + b.wheel_radius_m + 0.06;
        let ends = [Vec3::new(rear.x - 0.20, 0.0, z), Vec3::new(rear.x + 0.17, 0.0, z)];
        pipe(tubes, &ends, [0.006, 0.065], slot::PLASTIC, level);
        for side in [1.0, -1.0] {
            let aside = Vec3::Y * (0.06 * side);
            bar(tubes, rear + aside, ends[0].lerp(ends[1], 0.3) + aside, 0.006, slot::PLASTIC, level);
        }
    }
    if b.fittings.panniers {
        for side in [1.0, -1.0] {
            let center = rear + Vec3::new(-0.04, 0.135 * side, 0.16);
            block(tubes, center, Vec3::new(0.16, 0.065, 0.17), slot::LUGGAGE, level);
        }
    }
    if b.fittings.basket {
        let center = b.steerer(b.grip.z - 0.12) + Vec3::X * 0.20;
        block(tubes, center, Vec3::new(0.13, 0.17, 0.11), slot::BASKET, level);
    }
}

/// A box with round edges.
fn block(tubes: &mut Tubes, center: Vec3, half: Vec3, slot: u8, level: usize) {
    let ring = |z: f32, s: f32, level: usize| {
        let half_xy = [half.x * s * 1.15, half.y * s * 1.15];
        Ring::new(center + Vec3::Z * (z * half.z), [Vec3::Z, Vec3::X], half_xy, slot, level)
    };
    let rings = [ring(-1.0, 0.8, 2), ring(-0.9, 0.92, 0), ring(0.85, 1.0, 2), ring(1.0, 0.93, 1)];
    tubes.tube(&rings, [12, 8, 4][level], level, -1.0);
}

/// Cranks and pedals at a phase.
pub(super) fn add_cranks(tubes: &mut Tubes, b: &Bicycle, phase: f32, level: usize) {
    for side in [1.0, -1.0] {
        let pedal = b.pedal(side, phase);
        let foot = Vec3::new(pedal.x, side * 0.065, pedal.z);
        bar(tubes, b.crank_axle() + Vec3::Y * (0.055 * side), foot, 0.011, slot::METAL, level);
        let ends = [foot, Vec3::new(pedal.x, side * (b.pedal_y + 0.045), pedal.z)];
        let rings = ends.map(|end| Ring::new(end, [Vec3::Y * side, Vec3::Z], [PEDAL_HALF_M, 0.035], slot::PLASTIC, 2));
        tubes.tube(&rings, SIDES[level].max(4), level, -1.0);
    }
}
