//! What a truck stands on: ladder frame, axles, tanks, guards, mudguards, lamps, and the wheels that do not turn.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface, grid};
use super::super::wheels::{Rim, add_pair, wheel};
use super::cab::plate;
use super::plan::{Chassis, Plan};
use cadet_base::math::{Mat3, Vec3, cosf, sinf};
use std::f32::consts::PI;

pub(super) const RIM: Rim = Rim { spokes: 10, spoke_share: 0.72 };

/// Adds the frame behind the cab and what hangs on it.
pub(super) fn add_frame(surface: &mut Surface, p: &Plan, level: usize) {
    let (rear, ahead) = (-p.length_m / 2.0 + 0.04, p.front_x() - 0.5);
    let rail_top = p.deck_z - 0.04;
    surface.cuboid_pair([rear, ahead], [0.36, 0.44], [rail_top - 0.26, rail_top], work_slot::FRAME);
    if level < 2 {
        let n = ((ahead - rear) / 1.25) as usize;
        for k in 0..=n {
            let x = rear + 0.05 + (p.load_front() - rear - 0.1) * k as f32 / n as f32;
            let z = [rail_top - 0.22, rail_top - 0.06];
            surface.cuboid([x - 0.04, x + 0.04], [-0.37, 0.37], z, work_slot::FRAME);
        }
    }
    for x in &p.axles_x[1..] {
        let [right, middle, left] = [-p.hub_y(), 0.0, p.hub_y()].map(|y| Vec3::new(*x, y, p.wheel_radius_m));
        limb(surface, right, left, 0.08, 0.08, [8, 6, 4, 4][level], work_slot::FRAME);
        if level < 2 {
            surface.block(middle, Vec3::new(0.22, 0.2, 0.18), Mat3::IDENTITY, 8, work_slot::FRAME);
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
        let (tank_front, tank_rear) = (from - 0.15, (from - 1.3).max(to + 0.1));
        let z = p.deck_z - 0.12 - r;
        let axis = |x: f32| Vec3::new(x, side - r - 0.04, z);
        limb(surface, axis(tank_front), axis(tank_rear), r, r, [12, 8, 6, 5][level], work_slot::ALU);
        surface.cuboid([tank_rear + 0.2, tank_front], [-side + 0.05, -0.48], [z - r, z + r], slot::PLASTIC);
        if level < 2 {
            // Straps of the tank, the air vessels behind the box.
            for x in [tank_front - 0.2, tank_rear + 0.2] {
                limb(surface, axis(x), axis(x - 0.05), r + 0.012, r + 0.012, 10, slot::PLASTIC);
            }
        }
        let from = tank_rear - 0.1;
        if p.length_m > 6.9 && level < 3 && from - to > 0.5 {
            for z in [0.50, 0.82] {
                surface.cuboid_pair([to, from], [side - 0.03, side], [z, z + 0.10], work_slot::ALU);
            }
            if level < 2 {
                for x in [from - 0.2, 0.5 * (from + to), to + 0.2] {
                    let y = [side - 0.07, side - 0.03];
                    surface.cuboid_pair([x - 0.03, x + 0.03], y, [0.5, p.deck_z], work_slot::FRAME);
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
    surface.cuboid([rear + 0.10, rear + 0.18], [-side, side], [bar_z - 0.06, bar_z + 0.06], work_slot::FRAME);
    if level < 3 {
        surface.cuboid_pair([rear + 0.10, rear + 0.16], [0.36, 0.44], [bar_z, p.deck_z - 0.1], work_slot::FRAME);
    }
    let lamp_z = bar_z + 0.18;
    let (x, y) = ([rear + 0.03, rear + 0.12], [side - 0.42, side - 0.02]);
    surface.cuboid_pair(x, y, [lamp_z - 0.07, lamp_z + 0.07], slot::TAIL_LAMP);
    if level < 3 {
        let (x, y) = ([rear + 0.028, rear + 0.10], [side - 0.16, side - 0.08]);
        surface.cuboid_pair(x, y, [lamp_z - 0.06, lamp_z + 0.06], slot::LEFT_SIGNAL);
        plate(surface, rear + 0.029, lamp_z, 0.26, -1.0);
    }
    if level < 2 && p.length_m > 6.9 {
        // Amber reflectors along the sides.
        let (n, half_y) = ((p.length_m / 2.6) as usize, p.width_m / 2.0);
        for k in 0..n {
            let x = rear + 1.0 + (p.load_front() - rear - 1.6) * k as f32 / n.max(2) as f32;
            let (y, z) = ([half_y - 0.05, half_y - 0.025], [p.deck_z - 0.03, p.deck_z + 0.02]);
            surface.cuboid_pair([x - 0.05, x + 0.05], y, z, work_slot::AMBER);
        }
    }
}

fn add_mudguards(surface: &mut Surface, p: &Plan, level: usize) {
    let n = [8, 5, 3][level];
    let outer = p.hub_y() + p.tyre_width_m / 2.0 + 0.01;
    for x in &p.axles_x[1..] {
        let r = p.wheel_radius_m + 0.09;
        let arc = grid(0..=n, [outer - 0.55, outer], |k, y| {
            let a = PI * (0.06 + 0.88 * k as f32 / n as f32);
            Vec3::new(x + r * cosf(a), y, (p.wheel_radius_m + r * sinf(a)).min(p.deck_z - 0.03))
        });
        surface.panel_pair(&arc, Outward::From(Vec3::new(*x, outer - 0.3, p.wheel_radius_m)), slot::PLASTIC);
    }
    let last = p.axles_x.iter().copied().fold(f32::INFINITY, f32::min) - p.wheel_radius_m - 0.14;
    if last > -p.length_m / 2.0 + 0.25 {
        surface.cuboid_pair([last - 0.01, last], [outer - 0.5, outer], [0.22, 0.75], slot::PLASTIC);
    }
}

/// Adds the inner tires of twins and the wheels of the axles that the springs do not carry.
pub(super) fn add_fixed_wheels(surface: &mut Surface, p: &Plan, level: usize) {
    let [outer, inner] = [level, (level + 2).min(3)].map(|level| wheel(p.wheel_radius_m, p.tyre_width_m, RIM, level));
    for (k, x) in p.axles_x.iter().enumerate() {
        let center = Vec3::new(*x, p.hub_y(), p.wheel_radius_m);
        if k > 1 {
            add_pair(surface, &outer, center);
        }
        if p.twin[k] {
            add_pair(surface, &inner, center.with_y(p.hub_y() - p.tyre_width_m - 0.05));
        }
    }
}

/// The landing legs and the gap of a semi-trailer: its frame stands on the tractor's.
pub(super) fn add_coupling(surface: &mut Surface, p: &Plan, level: usize) {
    if p.chassis != Chassis::Semi {
        return;
    }
    let x = p.axles_x[4] - 1.9;
    surface.cuboid_pair([x - 0.06, x + 0.06], [0.62, 0.74], [0.35, p.deck_z], work_slot::FRAME);
    if level < 2 {
        surface.cuboid_pair([x - 0.14, x + 0.14], [0.55, 0.80], [0.33, 0.36], work_slot::FRAME);
        // Air lines between cab and trailer.
        let (a, b) = (p.front_x() - p.cab_length_m, p.load_front());
        for y in [-0.3, 0.0, 0.3] {
            limb(surface, Vec3::new(a, y, 1.5), Vec3::new(b, y * 0.6, 1.35), 0.02, 0.02, 4, slot::LAMP);
        }
    }
}
