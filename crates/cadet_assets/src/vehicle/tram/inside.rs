//! The inside of a tram's car, seen through its windows: floor, ceiling, seats, poles, the driver's desk, passengers.

use super::super::interior::{add_occupant, add_passengers, add_seat_pairs, limb};
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface, grid, level_sheet, upright};
use super::plan::{CarPlan, End};
use super::shell::{BELLOWS_M, roof};
use cadet_base::math::Vec3;

/// Distance between rows of seats.
const ROW_M: f32 = 0.86;
/// Height of a sitter's hip over the floor.
const HIP_M: f32 = 0.55;

/// Where the inside begins and ends.
fn reach(p: &CarPlan) -> [f32; 2] {
    let half = p.length_m / 2.0;
    let inner = |end: End, lean: f32| match end {
        End::Cab => half - 0.45 - lean * 0.5,
        End::Joint => half - BELLOWS_M - 0.04,
    };
    [inner(p.ends[0], p.lean_tangent), -inner(p.ends[1], 0.8 * p.lean_tangent)]
}

pub(super) fn add(surface: &mut Surface, p: &CarPlan, level: usize) {
    let ([a, b], w) = (reach(p), p.width_m / 2.0 - 0.08);
    let ceiling = roof(p) - 0.42;
    surface.panel_pair(&level_sheet([a, b], [0.0, w], p.floor_z + 0.02), Outward::Along(Vec3::Z), slot::DARK);
    surface.panel_pair(&level_sheet([a, b], [0.0, w], ceiling), Outward::Along(Vec3::NEG_Z), work_slot::LINING);
    let wall = |z0: f32, z1: f32| grid([z0, z1], [a, b], |z, x| Vec3::new(x, w, z));
    // Walls below the windows on sides without doors, and above them on both.
    if p.doors.is_empty() {
        surface.panel_pair(&wall(p.floor_z, p.sill_z - 0.02), Outward::Along(Vec3::NEG_Y), work_slot::LINING);
    } else if !p.has_left_doors {
        surface.panel(&wall(p.floor_z, p.sill_z - 0.02), Outward::Along(Vec3::NEG_Y), work_slot::LINING);
    }
    surface.panel_pair(&wall(p.header_z + 0.02, ceiling), Outward::Along(Vec3::NEG_Y), work_slot::LINING);
    add_seat_pairs(surface, seats(p), level);
    if level < 2 {
        for x in &p.doors {
            for (dx, y) in [(0.5, 0.3), (-0.5, 0.3), (0.5, -0.3), (-0.5, -0.3)] {
                let at = |z: f32| Vec3::new(x + dx * p.door_width_m, y, z);
                limb(surface, at(p.floor_z), at(ceiling), 0.018, 0.018, 4, work_slot::AMBER);
            }
        }
    }
    for (sign, end, x) in [(1.0, p.ends[0], a), (-1.0, p.ends[1], -b)] {
        if end != End::Cab {
            continue;
        }
        // The desk below the screen, and the wall behind the driver.
        let desk = [(x + 0.1, p.sill_z + 0.02), (x - 0.35, p.sill_z + 0.08), (x - 0.4, p.floor_z)];
        let desk = grid([0.0, 0.85 * w], desk, |y, (x, z)| Vec3::new(sign * x, y, z));
        surface.panel_pair(&desk, Outward::Along(Vec3::new(-0.6 * sign, 0.0, 1.0)), slot::DARK);
        let back = sign * (x - 1.55);
        let sheet = upright(back, [0.1 * w, w], [p.floor_z, p.sill_z + 0.35]);
        for outward in [Vec3::X, Vec3::NEG_X] {
            surface.panel_pair(&sheet, Outward::Along(outward), slot::DARK);
        }
    }
}

/// Hip points of the left seats, none beside doors; the right side has as many.
fn seats(p: &CarPlan) -> Vec<Vec3> {
    let [a, b] = reach(p);
    let front = a - if p.ends[0] == End::Cab { 2.2 } else { 0.6 };
    let rear = b + if p.ends[1] == End::Cab { 2.0 } else { 0.6 };
    let count = ((front - rear) / ROW_M).max(0.0) as usize;
    (0..count)
        .map(|k| front - ROW_M * (k as f32 + 0.5))
        .filter(|x| p.doors.iter().all(|door| (x - door).abs() > p.door_width_m / 2.0 + 0.25))
        .map(|x| Vec3::new(x, 0.60 * p.width_m / 2.0, p.floor_z + HIP_M))
        .collect()
}

/// The driver in the first cab, and passengers.
pub(super) fn occupants(p: &CarPlan, level: usize) -> Surface {
    let mut surface = Surface::default();
    if p.ends[0] == End::Cab {
        let hip = Vec3::new(p.length_m / 2.0 - 1.75, 0.15, p.floor_z.max(p.sill_z - 0.75) + 0.12);
        add_occupant(&mut surface, hip, 0.95, None, level.min(2));
    }
    add_passengers(&mut surface, seats(p), p.detail[0], p.taken_share);
    surface
}
