//! What trucks carry: which body goes with which kind; tipping bodies and flatbeds.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface};
use super::bay::{Room, block};
use super::closed_load::{add_box, add_curtain};
use super::plan::{Plan, WorkKind};
use super::special_load::{add_fire, add_refuse, add_tank};
use cadet_base::math::{Vec3, sinf};
use std::f32::consts::TAU;

/// Adds the load behind the cab.
pub(super) fn add_load(surface: &mut Surface, p: &Plan, level: usize) {
    let room = Room {
        front_x: p.load_front(),
        rear_x: -p.length_m / 2.0,
        half_y: p.width_m / 2.0,
        floor_z: p.deck_z,
        top_z: p.height_m,
    };
    match p.kind {
        WorkKind::Box => add_box(surface, p, &room, level),
        WorkKind::Curtain => add_curtain(surface, p, &room, level),
        WorkKind::Semi if p.detail[7] > 0.45 => add_curtain(surface, p, &room, level),
        WorkKind::Semi => add_box(surface, p, &room, level),
        WorkKind::Tipper => add_tipper(surface, p, &room, level),
        WorkKind::Flatbed => add_flatbed(surface, p, &room, level),
        WorkKind::Tank => add_tank(surface, &room, level),
        WorkKind::Refuse => add_refuse(surface, &room, level),
        WorkKind::Fire => add_fire(surface, &room, level),
        WorkKind::Bus => {}
    }
}

fn add_tipper(surface: &mut Surface, p: &Plan, r: &Room, level: usize) {
    let is_small = p.wheel_radius_m < 0.43;
    let wall =
        (if is_small { 0.42 } else { 0.45 * (r.top_z - r.floor_z) + 0.4 * p.detail[7] }).min(r.top_z - r.floor_z - 0.3);
    let (low, high) = (r.floor_z + 0.12, r.floor_z + 0.12 + wall);
    let t = 0.05;
    block(surface, r, (r.rear_x + 0.02, r.front_x), 0.03, (r.floor_z + 0.02, low), work_slot::LOAD);
    surface.cuboid_pair(
        Vec3::new(r.rear_x, r.half_y - t - 0.05, low),
        Vec3::new(r.front_x, r.half_y - 0.05, high),
        work_slot::LOAD,
    );
    block(surface, r, (r.rear_x, r.rear_x + t), 0.0, (low, high - 0.04), work_slot::LOAD);
    block(surface, r, (r.front_x - t, r.front_x), 0.05, (low, r.top_z), work_slot::LOAD);
    if !is_small {
        // The shield over the cab.
        let z = r.top_z;
        surface.builder.cuboid(
            Vec3::new(r.front_x - t, -0.85 * r.half_y, z - 0.05),
            Vec3::new(r.front_x + 0.5, 0.85 * r.half_y, z),
            work_slot::LOAD,
        );
    }
    if level < 3 {
        let n = ((r.front_x - r.rear_x) / 0.62) as usize;
        for k in 0..=n {
            let x = r.rear_x + 0.03 + (r.front_x - r.rear_x - 0.12) * k as f32 / n as f32;
            surface.cuboid_pair(
                Vec3::new(x, r.half_y - 0.06, low - 0.08),
                Vec3::new(x + 0.07, r.half_y, high - 0.02),
                work_slot::LOAD,
            );
        }
        surface.cuboid_pair(
            Vec3::new(r.rear_x, r.half_y - 0.07, high - 0.09),
            Vec3::new(r.front_x, r.half_y, high),
            work_slot::LOAD,
        );
    }
    // A heap of earth or gravel, or none.
    let fill = 0.35 + 0.75 * p.detail[5];
    let (nx, ny) = if level < 2 { (9, 7) } else { (4, 3) };
    let heap: Vec<Vec<Vec3>> = (0..=nx)
        .map(|i| {
            let u = i as f32 / nx as f32;
            (0..=ny)
                .map(|j| {
                    let v = j as f32 / ny as f32;
                    let swell = sinf(u * 0.5 * TAU) * sinf(v * 0.5 * TAU)
                        + 0.10 * sinf(11.0 * u + 17.0 * v + 9.0 * p.detail[6]);
                    let x = r.rear_x + t + (r.front_x - r.rear_x - 2.0 * t) * u;
                    let y = (r.half_y - t - 0.05) * (2.0 * v - 1.0);
                    Vec3::new(x, y, (low + wall * fill * (0.55 + 0.6 * swell)).clamp(low, r.top_z - 0.1))
                })
                .collect()
        })
        .collect();
    surface.sheet(&heap, Outward::Along(Vec3::Z), |_, _| Some(work_slot::CARGO));
}

fn add_flatbed(surface: &mut Surface, p: &Plan, r: &Room, level: usize) {
    block(surface, r, (r.rear_x + 0.02, r.front_x), 0.02, (r.floor_z, r.floor_z + 0.09), work_slot::BOARD);
    let (low, high) = (r.floor_z + 0.06, r.floor_z + 0.48);
    surface.cuboid_pair(
        Vec3::new(r.rear_x, r.half_y - 0.035, low),
        Vec3::new(r.front_x, r.half_y - 0.005, high),
        work_slot::ALU,
    );
    block(surface, r, (r.rear_x, r.rear_x + 0.03), 0.0, (low, high), work_slot::ALU);
    let posts = 1 + ((r.front_x - r.rear_x) / 2.2) as usize;
    for k in 0..=posts {
        let x = r.rear_x + (r.front_x - r.rear_x - 0.08) * k as f32 / posts as f32;
        surface.cuboid_pair(
            Vec3::new(x, r.half_y - 0.05, r.floor_z - 0.06),
            Vec3::new(x + 0.08, r.half_y, high + 0.02),
            work_slot::FRAME,
        );
    }
    if level < 2 {
        for z in [low + 0.13, low + 0.27] {
            surface.cuboid_pair(
                Vec3::new(r.rear_x, r.half_y - 0.01, z),
                Vec3::new(r.front_x, r.half_y - 0.003, z + 0.012),
                slot::LINER,
            );
        }
    }
    // The rack behind the cab.
    let rack = r.top_z;
    surface.cuboid_pair(
        Vec3::new(r.front_x - 0.06, r.half_y - 0.12, high),
        Vec3::new(r.front_x, r.half_y - 0.06, rack),
        work_slot::FRAME,
    );
    for k in 0..4 {
        let z = high + (rack - high) * (k as f32 + 0.9) / 4.0;
        block(surface, r, (r.front_x - 0.05, r.front_x - 0.01), 0.07, (z - 0.05, z), work_slot::FRAME);
    }
    if p.wheel_radius_m > 0.43 && p.detail[7] > 0.35 {
        add_crane(surface, p, r, level);
    }
    // Pallets, crates, boards: what fits.
    let n = (p.detail[4] * 4.0) as usize;
    for k in 0..n {
        let random = |m: f32| {
            let t = p.detail[5] * 13.0 + m * 3.7 + k as f32 * 2.3;
            t - t.floor()
        };
        let x = r.rear_x + 0.5 + (r.front_x - r.rear_x - 1.8) * (k as f32 + 0.2 * random(1.0)) / n as f32;
        let (long, wide) = (0.8 + 0.5 * random(2.0), 0.35 + 0.55 * random(3.0));
        let top = (r.floor_z + 0.25 + 1.1 * random(4.0)).min(r.top_z - 0.1);
        let y = (r.half_y - 0.1 - wide) * (2.0 * random(5.0) - 1.0);
        let slot = if random(6.0) > 0.5 { work_slot::BOARD } else { work_slot::CARGO };
        surface.builder.cuboid(
            Vec3::new(x, y - wide, r.floor_z + 0.2),
            Vec3::new(x + long, y + wide, top.max(r.floor_z + 0.4)),
            slot,
        );
        surface.builder.cuboid(
            Vec3::new(x, y - wide, r.floor_z + 0.09),
            Vec3::new(x + long, y + wide, r.floor_z + 0.2),
            work_slot::BOARD,
        );
    }
}

/// A loading crane, folded behind the rack.
fn add_crane(surface: &mut Surface, p: &Plan, r: &Room, level: usize) {
    let n = [8, 6, 4, 4][level];
    let x = r.front_x - 0.45;
    let foot = Vec3::new(x, 0.1, r.floor_z);
    let head = Vec3::new(x, 0.1, r.top_z - 0.45);
    limb(surface, foot, head, 0.17, 0.13, n, work_slot::STRIPE);
    let elbow = Vec3::new(x - 0.05, -0.85 * r.half_y, r.top_z - 0.25);
    limb(surface, head, elbow, 0.11, 0.10, n, work_slot::STRIPE);
    limb(
        surface,
        elbow,
        Vec3::new(x - 0.15, 0.75 * r.half_y, r.top_z - 0.62 - 0.2 * p.detail[3]),
        0.09,
        0.07,
        n,
        work_slot::STRIPE,
    );
    surface.cuboid_pair(
        Vec3::new(x - 0.14, 0.5 * r.half_y, 0.42),
        Vec3::new(x + 0.14, r.half_y - 0.06, 0.62),
        work_slot::FRAME,
    );
    surface.cuboid_pair(
        Vec3::new(x - 0.08, r.half_y - 0.24, 0.3),
        Vec3::new(x + 0.08, r.half_y - 0.06, r.floor_z + 0.1),
        work_slot::FRAME,
    );
}
