//! What a truck stands on: ladder frame, axles, tanks, guards, mudguards, lamps, and the wheels that do not turn.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface};
use super::super::wheels::{Rim, wheel};
use super::cab::plate;
use super::plan::{Chassis, Plan};
use cadet_base::math::{Mat3, Vec3, cosf, sinf};
use std::f32::consts::PI;

pub(super) const RIM: Rim = Rim { spokes: 10, spoke_share: 0.72 };

/// Adds the frame behind the cab and what hangs on it.
pub(super) fn add_frame(surface: &mut Surface, p: &Plan, level: usize) {
    let (rear, ahead) = (-p.length_m / 2.0 + 0.04, p.front_x() - 0.5);
    let rail_top = p.deck_z - 0.04;
    surface.cuboid_pair(Vec3::new(rear, 0.36, rail_top - 0.26), Vec3::new(ahead, 0.44, rail_top), work_slot::FRAME);
    if level < 2 {
        let n = ((ahead - rear) / 1.25) as usize;
        for k in 0..=n {
            let x = rear + 0.05 + (p.load_front() - rear - 0.1) * k as f32 / n as f32;
            surface.builder.cuboid(
                Vec3::new(x - 0.04, -0.37, rail_top - 0.22),
                Vec3::new(x + 0.04, 0.37, rail_top - 0.06),
                work_slot::FRAME,
            );
        }
    }
    for x in &p.axles_x[1..] {
        let y = p.hub_y();
        limb(
            surface,
            Vec3::new(*x, -y, p.wheel_radius_m),
            Vec3::new(*x, y, p.wheel_radius_m),
            0.08,
            0.08,
            [8, 6, 4, 4][level],
            work_slot::FRAME,
        );
        if level < 2 {
            surface.block(
                Vec3::new(*x, 0.0, p.wheel_radius_m),
                Vec3::new(0.22, 0.2, 0.18),
                Mat3::IDENTITY,
                8,
                work_slot::FRAME,
            );
        }
    }
    add_sides(surface, p, level);
    add_rear(surface, p, level);
    if level < 3 {
        add_mudguards(surface, p, level);
    }
}

/// Tanks, boxes and side guards between the axles.
fn add_sides(surface: &mut Surface, p: &Plan, level: usize) {
    let side = p.width_m.min(2.5) / 2.0 - 0.05;
    let gap = 1.15 * p.wheel_radius_m;
    let mut xs = p.axles_x.clone();
    xs.sort_by(|a, b| b.total_cmp(a));
    for pair in xs.windows(2) {
        let (from, to) = ((pair[0] - gap).min(p.front_x() - p.cab_length_m - 0.1), pair[1] + gap);
        if from - to < 0.7 {
            continue;
        }
        let r = if p.wheel_radius_m < 0.43 { 0.2 } else { 0.29 };
        let tank = (from - 0.15, (from - 1.3).max(to + 0.1));
        let z = p.deck_z - 0.12 - r;
        limb(
            surface,
            Vec3::new(tank.0, side - r - 0.04, z),
            Vec3::new(tank.1, side - r - 0.04, z),
            r,
            r,
            [12, 8, 6, 5][level],
            work_slot::ALU,
        );
        surface.builder.cuboid(
            Vec3::new(tank.1 + 0.2, -side + 0.05, z - r),
            Vec3::new(tank.0, -0.48, z + r),
            slot::PLASTIC,
        );
        if level < 2 {
            // Straps of the tank, the air vessels behind the box.
            for x in [tank.0 - 0.2, tank.1 + 0.2] {
                limb(
                    surface,
                    Vec3::new(x, side - r - 0.04, z),
                    Vec3::new(x - 0.05, side - r - 0.04, z),
                    r + 0.012,
                    r + 0.012,
                    10,
                    slot::PLASTIC,
                );
            }
        }
        if p.length_m > 6.9 && level < 3 {
            let from = tank.1 - 0.1;
            for z in [0.50, 0.82] {
                if from - to > 0.5 {
                    surface.cuboid_pair(Vec3::new(to, side - 0.03, z), Vec3::new(from, side, z + 0.10), work_slot::ALU);
                }
            }
            if level < 2 && from - to > 0.5 {
                for x in [from - 0.2, 0.5 * (from + to), to + 0.2] {
                    surface.cuboid_pair(
                        Vec3::new(x - 0.03, side - 0.07, 0.5),
                        Vec3::new(x + 0.03, side - 0.03, p.deck_z),
                        work_slot::FRAME,
                    );
                }
            }
        }
    }
}

fn add_rear(surface: &mut Surface, p: &Plan, level: usize) {
    let rear = -p.length_m / 2.0;
    let side = p.width_m.min(2.5) / 2.0 - 0.06;
    let bar_z = if p.wheel_radius_m < 0.43 { 0.42 } else { 0.50 };
    // The bar that keeps cars from running under, with the lamps above it.
    surface.builder.cuboid(
        Vec3::new(rear + 0.10, -side, bar_z - 0.06),
        Vec3::new(rear + 0.18, side, bar_z + 0.06),
        work_slot::FRAME,
    );
    if level < 3 {
        surface.cuboid_pair(
            Vec3::new(rear + 0.10, 0.36, bar_z),
            Vec3::new(rear + 0.16, 0.44, p.deck_z - 0.1),
            work_slot::FRAME,
        );
    }
    let lamp_z = bar_z + 0.18;
    surface.cuboid_pair(
        Vec3::new(rear + 0.03, side - 0.42, lamp_z - 0.07),
        Vec3::new(rear + 0.12, side - 0.02, lamp_z + 0.07),
        slot::TAIL_LAMP,
    );
    if level < 3 {
        surface.cuboid_pair(
            Vec3::new(rear + 0.028, side - 0.16, lamp_z - 0.06),
            Vec3::new(rear + 0.10, side - 0.08, lamp_z + 0.06),
            slot::LEFT_SIGNAL,
        );
        plate(surface, rear + 0.029, lamp_z, 0.26, -1.0);
    }
    if level < 2 && p.length_m > 6.9 {
        // Amber reflectors along the sides.
        let n = (p.length_m / 2.6) as usize;
        for k in 0..n {
            let x = rear + 1.0 + (p.load_front() - rear - 1.6) * k as f32 / n.max(2) as f32;
            surface.cuboid_pair(
                Vec3::new(x - 0.05, p.width_m / 2.0 - 0.05, p.deck_z - 0.03),
                Vec3::new(x + 0.05, p.width_m / 2.0 - 0.025, p.deck_z + 0.02),
                work_slot::AMBER,
            );
        }
    }
}

fn add_mudguards(surface: &mut Surface, p: &Plan, level: usize) {
    let n = [8, 5, 3][level];
    let outer = p.hub_y() + p.tyre_width_m / 2.0 + 0.01;
    for x in &p.axles_x[1..] {
        let r = p.wheel_radius_m + 0.09;
        let arc: Vec<Vec<Vec3>> = (0..=n)
            .map(|k| PI * (0.06 + 0.88 * k as f32 / n as f32))
            .map(|a| (x + r * cosf(a), (p.wheel_radius_m + r * sinf(a)).min(p.deck_z - 0.03)))
            .map(|(x, z)| vec![Vec3::new(x, outer - 0.55, z), Vec3::new(x, outer, z)])
            .collect();
        surface.pair(&arc, Outward::From(Vec3::new(*x, outer - 0.3, p.wheel_radius_m)), |_, _| Some(slot::PLASTIC));
    }
    let last = p.axles_x.iter().copied().fold(f32::INFINITY, f32::min) - p.wheel_radius_m - 0.14;
    if last > -p.length_m / 2.0 + 0.25 {
        surface.cuboid_pair(Vec3::new(last - 0.01, outer - 0.5, 0.22), Vec3::new(last, outer, 0.75), slot::PLASTIC);
    }
}

/// Adds the inner tires of twins and the wheels of the axles that the springs do not carry.
pub(super) fn add_fixed_wheels(surface: &mut Surface, p: &Plan, level: usize) {
    let mut put = |x: f32, y: f32, made: &Surface| {
        let turn = Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0));
        surface.builder.append(&made.builder, Mat3::IDENTITY, Vec3::new(x, y, p.wheel_radius_m));
        surface.builder.append(&made.builder, turn, Vec3::new(x, -y, p.wheel_radius_m));
    };
    let (outer, inner) = (
        wheel(p.wheel_radius_m, p.tyre_width_m, RIM, level),
        wheel(p.wheel_radius_m, p.tyre_width_m, RIM, (level + 2).min(3)),
    );
    for (k, x) in p.axles_x.iter().enumerate() {
        if k > 1 {
            put(*x, p.hub_y(), &outer);
        }
        if p.twin[k] {
            put(*x, p.hub_y() - p.tyre_width_m - 0.05, &inner);
        }
    }
}

/// The landing legs and the gap of a semi-trailer: its frame stands on the tractor's.
pub(super) fn add_coupling(surface: &mut Surface, p: &Plan, level: usize) {
    if p.chassis != Chassis::Semi {
        return;
    }
    let x = p.axles_x[4] - 1.9;
    surface.cuboid_pair(Vec3::new(x - 0.06, 0.62, 0.35), Vec3::new(x + 0.06, 0.74, p.deck_z), work_slot::FRAME);
    if level < 2 {
        surface.cuboid_pair(Vec3::new(x - 0.14, 0.55, 0.33), Vec3::new(x + 0.14, 0.80, 0.36), work_slot::FRAME);
        // Air lines between cab and trailer.
        let (a, b) = (p.front_x() - p.cab_length_m, p.load_front());
        for y in [-0.3, 0.0, 0.3] {
            limb(surface, Vec3::new(a, y, 1.5), Vec3::new(b, y * 0.6, 1.35), 0.02, 0.02, 4, slot::LAMP);
        }
    }
}
