//! What KITTI's annotators call Misc, as far as it is parked: what trailers have besides their beds.

use super::super::interior::limb;
use super::super::levels::Blueprint;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface, grid};
use super::super::wheels::{Rim, add_pair, wheel};
use super::body::{Load, Room, Size};
use super::cab::plate;
use super::plan::{Towed, TowedPlan};
use cadet_base::math::{Mat3, Vec3, cosf, sinf};
use std::f32::consts::PI;

/// Where a trailer stands on the ground: x of the wheels and of the leg in front, half the track.
pub(super) struct Stand {
    pub wheels_x: f32,
    pub leg_x: f32,
    pub half_track_m: f32,
}

impl Blueprint for TowedPlan {
    /// Everything, wheels and load too.
    fn shell(&self, level: usize) -> Surface {
        let mut surface = Surface::default();
        if matches!(self.kind, Towed::Motorbike) {
            self.add_motorbike(&mut surface, level);
        } else {
            self.add_trailer(&mut surface, level);
        }
        surface
    }
}

impl TowedPlan {
    fn is_heavy(&self) -> bool {
        self.length_m > 7.5
    }

    fn drawbar(&self) -> f32 {
        match self.kind {
            Towed::Motorbike => 0.0,
            _ if self.is_heavy() => 0.3,
            _ => (0.34 * self.length_m).min(1.15),
        }
    }

    pub(super) fn wheel_radius(&self) -> f32 {
        match self.kind {
            Towed::Motorbike => (0.155 * self.length_m).clamp(0.2, 0.33),
            _ if self.is_heavy() => 0.5,
            _ if self.length_m > 4.0 => 0.33,
            _ => (0.12 * self.length_m).clamp(0.2, 0.29),
        }
    }

    pub fn stand(&self) -> Stand {
        let half = self.length_m / 2.0;
        if matches!(self.kind, Towed::Motorbike) {
            let r = self.wheel_radius();
            return Stand { wheels_x: -half + r, leg_x: half - r, half_track_m: 0.12 };
        }
        let bed = self.length_m - self.drawbar();
        Stand {
            wheels_x: -half + if self.is_heavy() { 2.4 } else { 0.46 * bed },
            leg_x: half - 0.45 * self.drawbar().max(0.6) - if self.is_heavy() { 2.0 } else { 0.0 },
            half_track_m: self.width_m / 2.0 - 0.10,
        }
    }

    /// Whether it carries its wheels beside the bed, as small trailers do, not below it.
    fn has_wheels_beside(&self) -> bool {
        !matches!(self.kind, Towed::Caravan | Towed::Trailer(Size::Flat | Size::Heavy, _)) && self.width_m < 2.0
    }

    fn tyre_width(&self) -> f32 {
        if self.is_heavy() { 0.30 } else { 0.165 }
    }

    /// What it carries.
    pub fn load(&self) -> Load {
        Load { body: self.bed(), room: self.room(), seed: self.body_seed }
    }

    /// The room on the frame.
    pub fn room(&self) -> Room {
        let half = self.length_m / 2.0;
        let is_beside = self.has_wheels_beside();
        let floor_z = if self.is_heavy() {
            1.1
        } else if is_beside {
            0.36 + 0.25 * self.wheel_radius()
        } else {
            2.0 * self.wheel_radius() + 0.06
        };
        Room {
            front_x: half - self.drawbar(),
            rear_x: -half,
            // Wider than nothing on the narrowest, too.
            half_y: (self.width_m / 2.0 - if is_beside { self.tyre_width() + 0.03 } else { 0.0 }).max(0.12),
            floor_z: floor_z.min(0.62 * self.height_m),
            top_z: self.height_m,
        }
    }

    fn add_trailer(&self, surface: &mut Surface, level: usize) {
        let (half, stand) = (self.length_m / 2.0, self.stand());
        let Room { front_x: front, rear_x: rear, half_y: bed_w, floor_z: floor, .. } = self.room();
        if matches!(self.kind, Towed::Caravan) {
            self.add_caravan(surface, (rear, front), level);
        }
        self.load().add(surface, level);
        // Drawbar: two beams that meet at the coupling, jockey wheel, box.
        let hitch = Vec3::new(half - 0.02, 0.0, 0.42);
        for side in [1.0, -1.0] {
            let foot = Vec3::new(front - 0.3, side * 0.55 * bed_w, floor - 0.05);
            limb(surface, foot, hitch - Vec3::X * 0.14, 0.035, 0.03, 4, work_slot::FRAME);
        }
        let coupling_z = [hitch.z - 0.05, hitch.z + 0.07];
        surface.cuboid([hitch.x - 0.22, hitch.x + 0.02], [-0.05, 0.05], coupling_z, work_slot::FRAME);
        let foot = Vec3::new(stand.leg_x, 0.10, 0.1);
        let leg_top = foot.with_z(0.75_f32.min(self.height_m - 0.1));
        limb(surface, foot, leg_top, 0.025, 0.025, 5, work_slot::ALU);
        surface.block(foot, Vec3::new(0.10, 0.03, 0.10), Mat3::IDENTITY, 6, slot::TYRE);
        let (bed_x, bed_y) = ([rear + 0.05, front - 0.05], [-bed_w + 0.08, bed_w - 0.08]);
        surface.cuboid(bed_x, bed_y, [floor - 0.08, floor - 0.01], work_slot::FRAME);
        self.add_wheels(surface, level);
        self.add_lamps(surface, level);
    }

    fn add_wheels(&self, surface: &mut Surface, level: usize) {
        let (stand, is_beside) = (self.stand(), self.has_wheels_beside());
        let (r, tyre) = (self.wheel_radius(), self.tyre_width());
        let y = self.width_m / 2.0 - tyre / 2.0 - if is_beside { 0.012 } else { 0.05 };
        let made = wheel(r, tyre, Rim { spokes: 8, spoke_share: 0.6 }, level);
        let mut axles = vec![stand.wheels_x];
        if self.is_heavy() {
            axles.extend([stand.wheels_x + 1.3, stand.wheels_x - 1.3]);
        } else if self.length_m > 4.6 && self.detail[1] > 0.4 {
            axles = vec![stand.wheels_x + 1.06 * r, stand.wheels_x - 1.06 * r];
        }
        let low = axles.iter().copied().fold(f32::INFINITY, f32::min);
        let high = axles.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        for x in &axles {
            add_pair(surface, &made, Vec3::new(*x, y, r));
            limb(surface, Vec3::new(*x, -y, r), Vec3::new(*x, y, r), 0.04, 0.04, 5, work_slot::FRAME);
        }
        if is_beside && level < 3 {
            let n = [8, 6, 4][level];
            let middle = 0.5 * (low + high);
            let (rx, rz) = (0.5 * (high - low) + r + 0.06, r + 0.06);
            let outer = self.width_m / 2.0;
            let section = [(outer - tyre - 0.03, 0.0), (outer - 0.02, 0.0), (outer, 0.03)];
            let arc = grid(0..=n, section, |k, (y, down)| {
                let a = PI * k as f32 / n as f32;
                Vec3::new(middle + rx * cosf(a), y, r + rz * sinf(a) - down)
            });
            surface.panel_pair(&arc, Outward::From(Vec3::new(middle, outer - 0.1, r)), slot::PLASTIC);
        }
    }

    fn add_lamps(&self, surface: &mut Surface, level: usize) {
        let Room { rear_x: rear, half_y: bed_w, floor_z: floor, .. } = self.room();
        let z = floor + 0.02;
        let beam_y = [-bed_w + 0.02, bed_w - 0.02];
        surface.cuboid([rear + 0.005, rear + 0.06], beam_y, [z - 0.09, z + 0.09], work_slot::ALU);
        let lamp_y = [bed_w - 0.26, bed_w - 0.03];
        surface.cuboid_pair([rear, rear + 0.03], lamp_y, [z - 0.06, z + 0.06], slot::TAIL_LAMP);
        if level < 3 {
            plate(surface, rear + 0.002, z, 0.26_f32.min(bed_w - 0.28), -1.0);
        }
    }
}
