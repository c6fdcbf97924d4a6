//! Closed bodies behind the cab: boxes and curtains, with doors, profiles and lettering.

use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface};
use super::bay::{Room, block};
use super::plan::Plan;
use cadet_base::math::Vec3;

/// Bars and hinges of doors in the rear wall.
fn add_rear_doors(surface: &mut Surface, r: &Room, level: usize) {
    let (x, w) = (r.rear_x, r.half_y - 0.05);
    surface.builder.cuboid(
        Vec3::new(x + 0.001, -0.008, r.floor_z),
        Vec3::new(x + 0.02, 0.008, r.top_z - 0.1),
        slot::LINER,
    );
    for y in [0.18, 0.62 * w] {
        surface.cuboid_pair(
            Vec3::new(x, y - 0.018, r.floor_z + 0.05),
            Vec3::new(x + 0.03, y + 0.018, r.top_z - 0.12),
            work_slot::ALU,
        );
    }
    if level < 2 {
        for k in 0..4 {
            let z = r.floor_z + (r.top_z - r.floor_z) * (0.12 + 0.24 * k as f32);
            surface.cuboid_pair(Vec3::new(x, w - 0.20, z), Vec3::new(x + 0.03, w, z + 0.06), work_slot::ALU);
        }
        surface.cuboid_pair(
            Vec3::new(x, 0.10, r.floor_z + 0.45),
            Vec3::new(x + 0.04, 0.40, r.floor_z + 0.49),
            slot::PLASTIC,
        );
    }
}

/// Profiles along the edges of a closed body.
fn add_edges(surface: &mut Surface, r: &Room, level: usize) {
    let e = if level < 2 { 0.06 } else { 0.09 };
    let side = |z0: f32, z1: f32| (Vec3::new(r.rear_x, r.half_y - 0.05, z0), Vec3::new(r.front_x, r.half_y, z1));
    for (low, high) in [side(r.floor_z - 0.12, r.floor_z + e), side(r.top_z - 1.6 * e, r.top_z)] {
        surface.cuboid_pair(low, high, work_slot::ALU);
    }
    for x in [r.rear_x, r.front_x - e] {
        surface.cuboid_pair(
            Vec3::new(x, r.half_y - 0.06, r.floor_z),
            Vec3::new(x + e, r.half_y, r.top_z),
            work_slot::ALU,
        );
        surface.builder.cuboid(
            Vec3::new(x, -r.half_y, r.top_z - 1.6 * e),
            Vec3::new(x + e, r.half_y, r.top_z),
            work_slot::ALU,
        );
    }
}

/// Colored fields on the flanks: who owns the truck.
fn add_lettering(surface: &mut Surface, p: &Plan, r: &Room) {
    let length = r.front_x - r.rear_x;
    let field = |surface: &mut Surface, x: (f32, f32), z: (f32, f32), slot: u8| {
        let y = r.half_y - 0.018;
        let sheet = [
            vec![Vec3::new(x.0, y, z.0), Vec3::new(x.1, y, z.0)],
            vec![Vec3::new(x.0, y, z.1), Vec3::new(x.1, y, z.1)],
        ];
        surface.pair(&sheet, Outward::Along(Vec3::Y), |_, _| Some(slot));
    };
    let high = r.top_z - r.floor_z;
    let z = |t: f32| r.floor_z + t * high;
    if p.detail[0] > 0.5 {
        field(surface, (r.rear_x + 0.1, r.front_x - 0.1), (z(0.16), z(0.24 + 0.1 * p.detail[1])), work_slot::STRIPE);
    }
    if p.detail[2] > 0.25 {
        // Words: a row of blocks.
        let (n, from) = (5 + (p.detail[3] * 6.0) as usize, r.front_x - (0.12 + 0.2 * p.detail[4]) * length);
        let (wide, tall) = (0.045 * length, (0.12 + 0.14 * p.detail[5]) * high);
        for k in 0..n {
            let x = from - 1.12 * wide * k as f32;
            let narrow = 0.55 + 0.45 * ((k * 7 + 3) % 5) as f32 / 4.0;
            if x - wide > r.rear_x + 0.2 {
                field(surface, (x - wide * narrow, x), (z(0.56), z(0.56) + tall), work_slot::STRIPE);
            }
        }
    }
}

/// A box of panels.
pub(super) fn add_box(surface: &mut Surface, p: &Plan, r: &Room, level: usize) {
    block(surface, r, (r.rear_x + 0.02, r.front_x - 0.01), 0.02, (r.floor_z - 0.08, r.top_z - 0.012), work_slot::LOAD);
    add_edges(surface, r, level);
    add_rear_doors(surface, r, level);
    if level < 3 {
        add_lettering(surface, p, r);
    }
    if p.detail[6] < 0.3 && r.top_z - r.floor_z > 1.6 {
        // A cooler on the front wall.
        let (w, z) = (0.7 * r.half_y, r.top_z - 0.25);
        surface.builder.cuboid(Vec3::new(r.front_x, -w, z - 0.75), Vec3::new(r.front_x + 0.34, w, z), work_slot::LOAD);
        surface.builder.cuboid(
            Vec3::new(r.front_x + 0.33, -0.8 * w, z - 0.6),
            Vec3::new(r.front_x + 0.35, 0.8 * w, z - 0.15),
            slot::GRILLE,
        );
    }
    if p.detail[5] > 0.55 {
        // The tail lift, folded up.
        block(
            surface,
            r,
            (r.rear_x, r.rear_x + 0.05),
            0.12,
            (r.floor_z - 0.1, r.floor_z + 0.45 * (r.top_z - r.floor_z)),
            work_slot::ALU,
        );
    }
}

/// A frame with curtains at its sides.
pub(super) fn add_curtain(surface: &mut Surface, p: &Plan, r: &Room, level: usize) {
    let x = (r.rear_x + 0.03, r.front_x - 0.03);
    block(surface, r, x, 0.06, (r.floor_z - 0.1, r.floor_z), work_slot::FRAME);
    // Front wall, roof, and the fabric of the flanks in soft folds.
    block(surface, r, (r.front_x - 0.06, r.front_x - 0.01), 0.02, (r.floor_z, r.top_z - 0.02), work_slot::LOAD);
    block(surface, r, x, 0.03, (r.top_z - 0.06, r.top_z - 0.01), work_slot::CANVAS);
    let rear = [
        vec![
            Vec3::new(r.rear_x + 0.02, -r.half_y + 0.03, r.floor_z),
            Vec3::new(r.rear_x + 0.02, r.half_y - 0.03, r.floor_z),
        ],
        vec![
            Vec3::new(r.rear_x + 0.02, -r.half_y + 0.03, r.top_z),
            Vec3::new(r.rear_x + 0.02, r.half_y - 0.03, r.top_z - 0.02),
        ],
    ];
    surface.sheet(&rear, Outward::Along(Vec3::NEG_X), |_, _| Some(work_slot::LOAD));
    let pitch = 0.62;
    let n = if level < 2 { ((x.1 - x.0) / pitch * 2.0) as usize } else { 1 };
    let folds: Vec<Vec<Vec3>> = (0..=n)
        .map(|k| {
            let at = x.0 + (x.1 - x.0) * k as f32 / n as f32;
            let y = r.half_y - 0.03 + if n > 1 && k % 2 == 1 { 0.018 } else { 0.0 };
            vec![
                Vec3::new(at, y - 0.01, r.floor_z - 0.12),
                Vec3::new(at, y, r.floor_z + 0.1),
                Vec3::new(at, y, r.top_z - 0.06),
            ]
        })
        .collect();
    surface.pair(&folds, Outward::Along(Vec3::Y), |_, _| Some(work_slot::CANVAS));
    add_edges(surface, &Room { floor_z: r.floor_z - 0.1, ..*r }, level);
    add_rear_doors(surface, r, level);
    if level == 0 {
        let straps = ((x.1 - x.0) / pitch) as usize;
        for k in 1..straps {
            let at = x.0 + pitch * k as f32;
            surface.cuboid_pair(
                Vec3::new(at - 0.022, r.half_y - 0.03, r.floor_z - 0.16),
                Vec3::new(at + 0.022, r.half_y - 0.006, r.floor_z + 0.22),
                slot::DARK,
            );
        }
    }
    if level < 3 {
        add_lettering(surface, p, r);
    }
}
