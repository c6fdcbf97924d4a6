//! Caravans: a rounded shell with dark windows, a door, and a gas box.

use super::super::paint::{slot, work_slot};
use super::super::surface::Surface;
use super::hull::{Cell, Hull, Part};
use super::plan::TowedPlan;

impl TowedPlan {
    /// Adds a caravan's shell.
    pub(super) fn add_caravan(&self, surface: &mut Surface, (rear_x, front_x): (f32, f32), level: usize) {
        let (low, top, side) = (0.40, self.height_m, self.width_m / 2.0);
        let high = top - low;
        let (sill, header) = (low + 0.42 * high, low + 0.74 * high);
        let hull = Hull {
            front_x,
            rear_x,
            half_y: side,
            front_radius_m: 0.14,
            rear_radius_m: 0.12,
            bow_m: 0.12,
            lean_from_z: low + 0.30 * high,
            lean_tangent: 0.22 + 0.15 * self.detail[4],
            rear_lean_tangent: 0.08,
            rows: vec![
                (low, 0.02),
                (low + 0.28 * high, 0.0),
                (sill, 0.0),
                (header, 0.01),
                (top - 0.14, 0.02),
                (top - 0.04, 0.07),
                (top, 0.20),
            ],
        };
        let (from, to) = hull.flank();
        let (from, to) = (from - 0.14 * high, to + 0.04 * high);
        let window = |t0: f32, t1: f32| (to + (from - to) * t1, to + (from - to) * t0);
        let windows = [window(0.04, 0.36), window(0.62, 0.97)];
        let xs: Vec<f32> = windows.iter().flat_map(|(a, b)| [*a, *b]).chain([from, to]).collect();
        let ends: &[f32] = if level < 2 { &[0.0, 0.4, 0.78] } else { &[0.0, 0.78] };
        let columns = hull.columns(ends, &xs, [4, 3, 2, 1][level]);
        let stripe = self.detail[5] > 0.4;
        let slot_of = |c: &Cell| {
            let is_window = c.z > sill && c.z < header;
            Some(match c.part {
                Part::Front | Part::Rear if is_window && c.fraction < 0.75 => slot::DARK_GLASS,
                Part::Side if is_window && windows.iter().any(|(a, b)| c.x < *a && c.x > *b) => slot::DARK_GLASS,
                _ if stripe && c.z > low + 0.28 * high && c.z < sill => work_slot::STRIPE,
                _ => slot::PAINT,
            })
        };
        hull.add(surface, &columns, slot_of, slot::PAINT);
        if level < 3 {
            // The door on the right, a skylight, the gas box on the drawbar.
            let (x, door_z) = (0.5 * (from + to), low + 0.86 * high);
            let y = [-side - 0.002, -side - 0.002 + 0.02];
            for (x0, x1) in [(x - 0.31, x - 0.295), (x + 0.295, x + 0.31)] {
                surface.cuboid([x0, x1], y, [low + 0.06, door_z], slot::LINER);
            }
            surface.cuboid([x - 0.31, x + 0.31], y, [door_z - 0.015, door_z], slot::LINER);
            let box_x = [front_x + 0.02, (front_x + 0.45).min(self.length_m / 2.0 - 0.2)];
            surface.cuboid(box_x, [-0.38, 0.38], [0.48, 0.95], slot::PAINT);
            let (lamp_x, lamp_z) = ([rear_x + 0.005, rear_x + 0.08], [low + 0.16, low + 0.42]);
            surface.cuboid_pair(lamp_x, [side - 0.30, side - 0.14], lamp_z, slot::TAIL_LAMP);
        }
        // The arch's dark over the wheel.
        let (x, r) = (self.stand().wheels_x, self.wheel_radius());
        let reach = if self.length_m > 4.6 && self.detail[1] > 0.4 { 2.2 * r } else { 1.15 * r };
        let (y, z) = ([side - 0.25, side + 0.002], [low - 0.01, 2.0 * r + 0.06]);
        surface.cuboid_pair([x - reach, x + reach], y, z, slot::LINER);
    }
}
