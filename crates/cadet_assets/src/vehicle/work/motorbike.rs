//! Motorbikes and scooters on their stands.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface, grid};
use super::super::wheels::{Rim, add_pair, wheel};
use super::cab::plate;
use super::plan::TowedPlan;
use cadet_base::math::{Mat3, Quat, Vec3};

/// How high the saddle is, by the height.
const SEAT: f32 = 0.62;

/// Adds a block in the middle that stands upright, at (x, z).
fn add_upright(surface: &mut Surface, [x, z]: [f32; 2], half: Vec3, sides: usize, slot: u8) {
    surface.block(Vec3::new(x, 0.0, z), half, Mat3::IDENTITY, sides, slot);
}

impl TowedPlan {
    /// Adds a motorbike or a scooter.
    pub(super) fn add_motorbike(&self, surface: &mut Surface, level: usize) {
        let (half, r) = (self.length_m / 2.0, self.wheel_radius());
        let (rear, front) = (-half + r, half - r);
        let high = self.height_m;
        let bar = high - 0.14;
        let n = [8, 6, 4, 4][level];
        let made = wheel(r, (0.14 * r / 0.3).max(0.09), Rim { spokes: 6, spoke_share: 0.35 }, level);
        for x in [rear, front] {
            add_pair(surface, &made, Vec3::new(x, 0.0, r));
        }
        let head = Vec3::new(front - 0.30 * (half - r), 0.0, bar - 0.06);
        for y in [0.07, -0.07] {
            limb(surface, Vec3::new(front, y, r), head + Vec3::Y * y, 0.022, 0.026, n, work_slot::ALU);
        }
        let seat_z = SEAT * high;
        let is_scooter = self.detail[0] > 0.55;
        if is_scooter {
            // Leg shield, foot board, body under the saddle.
            let lean = Mat3::from_quat(Quat::from_rotation_y(-0.35));
            let shield = Vec3::new(0.06, 0.19, 0.5 * (bar - 0.25));
            surface.block(Vec3::new(head.x - 0.02, 0.0, 0.5 * (bar + 0.25)), shield, lean, 2 * n, slot::PAINT);
            surface.cuboid([rear + 0.3, head.x + 0.05], [-0.15, 0.15], [0.24, 0.31], slot::PLASTIC);
            let body = Vec3::new(0.40, 0.16, 0.5 * (seat_z - 0.30));
            add_upright(surface, [rear + 0.08, 0.5 * (seat_z + 0.34)], body, 2 * n, slot::PAINT);
        } else {
            self.add_engine_and_frame(surface, [rear, front], head, n);
        }
        add_upright(surface, [rear + 0.16, seat_z], Vec3::new(0.34, 0.14, 0.06), 2 * n, slot::DARK);
        add_upright(surface, [-half + 0.12, seat_z - 0.05], Vec3::new(0.12, 0.09, 0.05), n, slot::PAINT);
        surface.cuboid([-half, -half + 0.03], [-0.05, 0.05], [seat_z - 0.10, seat_z - 0.04], slot::TAIL_LAMP);
        // Handlebar with grips, lamp, mirrors up to the box's edges.
        let w = self.width_m / 2.0;
        let [left, right] = [-w, w].map(|y| Vec3::new(head.x - 0.08, y, bar));
        limb(surface, left, right, 0.016, 0.016, n, slot::PLASTIC);
        add_upright(surface, [head.x + 0.10, head.z - 0.04], Vec3::new(0.07, 0.09, 0.09), 2 * n, slot::LAMP);
        for (x, y, z) in [(head.x + 0.08, 0.15, head.z - 0.06), (-half + 0.05, 0.13, seat_z - 0.07)] {
            let around = |at: f32, half: f32| [at - half, at + half];
            surface.cuboid_pair(around(x, 0.025), around(y, 0.035), around(z, 0.02), slot::LEFT_SIGNAL);
        }
        for side in [1.0, -1.0] {
            let a = Vec3::new(head.x - 0.05, side * 0.7 * w, bar);
            limb(surface, a, a + Vec3::new(-0.02, side * 0.05, high - bar - 0.05), 0.008, 0.008, 3, slot::PLASTIC);
            let glass_z = [a.z + (high - bar - 0.09), a.z + (high - bar)];
            surface.cuboid([a.x - 0.04, a.x], [a.y - 0.05, a.y + 0.05], glass_z, slot::PLASTIC);
        }
        if self.detail[3] > 0.5 && !is_scooter {
            // A screen.
            let edges = [(head.x + 0.16, 0.16, head.z + 0.02), (head.x, 0.13, high - 0.01)];
            let screen = grid(edges, [-1.0, 1.0], |(x, half_y, z), side| Vec3::new(x, side * half_y, z));
            surface.panel(&screen, Outward::Along(Vec3::X), slot::DARK_GLASS);
        }
        if self.detail[2] > 0.6 {
            // A top case.
            add_upright(surface, [-half + 0.20, seat_z + 0.20], Vec3::new(0.19, 0.21, 0.15), 2 * n, slot::PLASTIC);
        }
        // The stand, and the plate.
        limb(surface, Vec3::new(0.0, 0.05, 0.3), Vec3::new(0.06, 0.20, 0.0), 0.015, 0.015, 4, work_slot::FRAME);
        if level < 3 {
            plate(surface, -half + 0.03, seat_z - 0.22, 0.10, -1.0);
        }
    }

    /// Adds all between the axles `[rear, front]` and the steering `head` of a motorbike.
    fn add_engine_and_frame(&self, surface: &mut Surface, [rear, front]: [f32; 2], head: Vec3, n: usize) {
        let (r, seat_z, middle) = (self.wheel_radius(), SEAT * self.height_m, 0.5 * (rear + front));
        // Crank case, cylinders that lean forward, tank, panels below the saddle, front fender.
        add_upright(surface, [middle, 0.40], Vec3::new(0.27, 0.17, 0.15), 2 * n, work_slot::FRAME);
        let lean = Mat3::from_quat(Quat::from_rotation_y(0.35));
        let cylinders = Vec3::new(0.13, 0.14, 0.5 * (seat_z - 0.40));
        surface.block(Vec3::new(middle + 0.13, 0.0, 0.5 * (seat_z + 0.45)), cylinders, lean, 2 * n, work_slot::ALU);
        let (at, lean) = (Vec3::new(middle + 0.10, 0.0, seat_z + 0.07), Mat3::from_quat(Quat::from_rotation_y(0.12)));
        surface.block(at, Vec3::new(0.31, 0.15, 0.13), lean, 2 * n, slot::PAINT);
        let panels = Vec3::new(0.22, 0.12, 0.5 * (seat_z - 0.40));
        add_upright(surface, [middle - 0.27, 0.5 * (seat_z + 0.46)], panels, 2 * n, slot::PAINT);
        add_upright(surface, [front - 0.05, 2.0 * r + 0.02], Vec3::new(0.24, 0.07, 0.03), n, slot::PAINT);
        // Tubes: over the engine, down before it, and below it on both sides; the swing arm and its springs.
        let down = Vec3::new(middle + 0.30, 0.0, 0.30);
        limb(surface, head, Vec3::new(middle - 0.30, 0.0, seat_z - 0.06), 0.045, 0.04, n, work_slot::FRAME);
        limb(surface, head, down, 0.03, 0.03, n, work_slot::FRAME);
        for side in [1.0, -1.0] {
            let at = |x: f32, y: f32, z: f32| Vec3::new(x, side * y, z);
            limb(surface, down, at(middle - 0.25, 0.12, 0.28), 0.022, 0.022, n, work_slot::FRAME);
            limb(surface, at(middle - 0.20, 0.10, 0.38), at(rear, 0.10, r), 0.035, 0.028, n, work_slot::ALU);
            let [foot, top] = [at(rear + 0.05, 0.12, r + 0.04), at(rear + 0.20, 0.12, seat_z - 0.05)];
            limb(surface, foot, top, 0.03, 0.03, n, slot::DARK);
        }
        // The exhaust goes down before the engine and back along its right side.
        let bend = Vec3::new(middle + 0.24, -0.15, 0.30);
        limb(surface, Vec3::new(middle + 0.22, -0.05, seat_z - 0.18), bend, 0.025, 0.025, n, slot::CHROME);
        limb(surface, bend, Vec3::new(middle - 0.20, -0.17, 0.28), 0.025, 0.03, n, slot::CHROME);
        let end = Vec3::new(rear - 0.1, -0.20, 0.40);
        limb(surface, Vec3::new(middle - 0.20, -0.17, 0.28), end, 0.045, 0.06, n, slot::CHROME);
    }
}
