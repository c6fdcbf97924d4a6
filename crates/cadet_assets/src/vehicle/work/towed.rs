//! What KITTI's annotators call Misc, as far as it is parked: the common parts of trailers, and their boards and covers.

use super::super::interior::limb;
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface};
use super::super::wheels::{Rim, wheel};
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
        if self.kind == Towed::Motorbike {
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

    /// Everything, wheels too.
    pub fn body(&self, level: usize) -> Surface {
        let mut surface = Surface::default();
        if self.kind == Towed::Motorbike {
            self.add_motorbike(&mut surface, level);
        } else {
            self.add_trailer(&mut surface, level);
        }
        surface
    }

    fn add_trailer(&self, surface: &mut Surface, level: usize) {
        let (half, r) = (self.length_m / 2.0, self.wheel_radius());
        let (rear, front) = (-half, half - self.drawbar());
        let stand = self.stand();
        // Small trailers carry their wheels beside the bed, large ones below it.
        let is_beside =
            !self.is_heavy() && self.kind != Towed::Platform && self.kind != Towed::Caravan && self.width_m < 2.0;
        let tyre = if self.is_heavy() { 0.30 } else { 0.165 };
        let bed_w = if is_beside { self.width_m / 2.0 - tyre - 0.03 } else { self.width_m / 2.0 };
        let floor = if self.is_heavy() {
            1.1
        } else if is_beside {
            0.36 + 0.25 * r
        } else {
            2.0 * r + 0.06
        };
        let floor = floor.min(0.62 * self.height_m);
        match self.kind {
            Towed::Open => self.add_open(surface, (rear, front), bed_w, floor, self.height_m, level),
            Towed::Covered => self.add_covered(surface, (rear, front), bed_w, floor, level),
            Towed::Caravan => self.add_caravan(surface, (rear, front), level),
            Towed::Platform => {
                self.add_open(surface, (rear, front), bed_w, floor, (floor + 0.35).min(self.height_m), level);
                // The winch's post fills the box.
                surface.builder.cuboid(
                    Vec3::new(front - 0.12, -0.35, floor),
                    Vec3::new(front - 0.04, 0.35, self.height_m),
                    work_slot::ALU,
                );
            }
            Towed::Container | Towed::Motorbike => {
                surface.builder.cuboid(
                    Vec3::new(rear + 0.01, -bed_w + 0.01, floor),
                    Vec3::new(front - 0.01, bed_w - 0.01, self.height_m - 0.01),
                    work_slot::LOAD,
                );
                for x in [rear, front - 0.05] {
                    surface.cuboid_pair(
                        Vec3::new(x, bed_w - 0.05, floor),
                        Vec3::new(x + 0.05, bed_w, self.height_m),
                        work_slot::ALU,
                    );
                }
                for z in [floor, self.height_m - 0.06] {
                    surface.cuboid_pair(
                        Vec3::new(rear, bed_w - 0.04, z),
                        Vec3::new(front, bed_w, z + 0.06),
                        work_slot::ALU,
                    );
                }
                surface.builder.cuboid(
                    Vec3::new(rear, -0.008, floor),
                    Vec3::new(rear + 0.02, 0.008, self.height_m - 0.05),
                    slot::LINER,
                );
                surface.cuboid_pair(
                    Vec3::new(rear - 0.0, 0.25, floor + 0.05),
                    Vec3::new(rear + 0.03, 0.28, self.height_m - 0.1),
                    work_slot::ALU,
                );
                if level < 3 && self.detail[3] > 0.5 && self.length_m > 3.0 {
                    let y = bed_w + 0.001;
                    let field = [floor + 0.35 * (self.height_m - floor), floor + 0.62 * (self.height_m - floor)]
                        .map(|z| vec![Vec3::new(rear + 0.4, y, z), Vec3::new(front - 0.5, y, z)]);
                    surface.pair(&field, Outward::Along(Vec3::Y), |_, _| Some(work_slot::STRIPE));
                }
            }
        }
        // Drawbar: two beams that meet at the coupling, jockey wheel, box.
        let hitch = Vec3::new(half - 0.02, 0.0, 0.42);
        for side in [1.0, -1.0] {
            let foot = Vec3::new(front - 0.3, side * 0.55 * bed_w, floor - 0.05);
            limb(surface, foot, hitch - Vec3::X * 0.14, 0.035, 0.03, 4, work_slot::FRAME);
        }
        surface.builder.cuboid(
            hitch - Vec3::new(0.22, 0.05, 0.05),
            hitch + Vec3::new(0.02, 0.05, 0.07),
            work_slot::FRAME,
        );
        let foot = Vec3::new(stand.leg_x, 0.10, 0.0);
        limb(
            surface,
            foot + Vec3::Z * 0.1,
            foot + Vec3::Z * 0.75_f32.min(self.height_m - 0.1),
            0.025,
            0.025,
            5,
            work_slot::ALU,
        );
        surface.block(foot + Vec3::Z * 0.1, Vec3::new(0.10, 0.03, 0.10), Mat3::IDENTITY, 6, slot::TYRE);
        surface.builder.cuboid(
            Vec3::new(rear + 0.05, -bed_w + 0.08, floor - 0.08),
            Vec3::new(front - 0.05, bed_w - 0.08, floor - 0.01),
            work_slot::FRAME,
        );
        self.add_wheels(surface, &stand, r, tyre, is_beside, level);
        self.add_lamps(surface, rear, bed_w, floor, level);
    }

    fn add_wheels(&self, surface: &mut Surface, stand: &Stand, r: f32, tyre: f32, is_beside: bool, level: usize) {
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
            surface.builder.append(&made.builder, Mat3::IDENTITY, Vec3::new(*x, y, r));
            surface.builder.append(
                &made.builder,
                Mat3::from_diagonal(Vec3::new(-1.0, -1.0, 1.0)),
                Vec3::new(*x, -y, r),
            );
            limb(surface, Vec3::new(*x, -y, r), Vec3::new(*x, y, r), 0.04, 0.04, 5, work_slot::FRAME);
        }
        if is_beside && level < 3 {
            let n = [8, 6, 4][level];
            let middle = 0.5 * (low + high);
            let (rx, rz) = (0.5 * (high - low) + r + 0.06, r + 0.06);
            let outer = self.width_m / 2.0;
            let arc: Vec<Vec<Vec3>> = (0..=n)
                .map(|k| PI * k as f32 / n as f32)
                .map(|a| (middle + rx * cosf(a), r + rz * sinf(a)))
                .map(|(x, z)| {
                    vec![
                        Vec3::new(x, outer - tyre - 0.03, z),
                        Vec3::new(x, outer - 0.02, z),
                        Vec3::new(x, outer, z - 0.03),
                    ]
                })
                .collect();
            surface.pair(&arc, Outward::From(Vec3::new(middle, outer - 0.1, r)), |_, _| Some(slot::PLASTIC));
        }
    }

    fn add_lamps(&self, surface: &mut Surface, rear: f32, bed_w: f32, floor: f32, level: usize) {
        let z = floor + 0.02;
        surface.builder.cuboid(
            Vec3::new(rear + 0.005, -bed_w + 0.02, z - 0.09),
            Vec3::new(rear + 0.06, bed_w - 0.02, z + 0.09),
            work_slot::ALU,
        );
        surface.cuboid_pair(
            Vec3::new(rear, bed_w - 0.26, z - 0.06),
            Vec3::new(rear + 0.03, bed_w - 0.03, z + 0.06),
            slot::TAIL_LAMP,
        );
        if level < 3 {
            plate(surface, rear + 0.002, z, 0.26_f32.min(bed_w - 0.28), -1.0);
        }
    }

    /// Boards round a bed.
    fn add_open(&self, surface: &mut Surface, (rear, front): (f32, f32), w: f32, floor: f32, top: f32, level: usize) {
        let side = if self.detail[0] > 0.45 { work_slot::ALU } else { work_slot::BOARD };
        let top = top.min(self.height_m);
        surface.builder.cuboid(
            Vec3::new(rear + 0.02, -w + 0.02, floor),
            Vec3::new(front - 0.02, w - 0.02, floor + 0.03),
            work_slot::BOARD,
        );
        let high = top.min(floor + 0.42);
        surface.cuboid_pair(Vec3::new(rear, w - 0.03, floor - 0.03), Vec3::new(front, w, high), side);
        for x in [rear, front - 0.03] {
            surface.builder.cuboid(Vec3::new(x, -w, floor - 0.03), Vec3::new(x + 0.03, w, high), side);
        }
        for x in [rear, 0.5 * (rear + front) - 0.02, front - 0.05] {
            surface.cuboid_pair(
                Vec3::new(x, w - 0.04, floor - 0.03),
                Vec3::new(x + 0.05, w + 0.004, high + 0.015),
                work_slot::FRAME,
            );
        }
        if level < 2 {
            surface.cuboid_pair(
                Vec3::new(rear, w - 0.01, 0.5 * (floor + high)),
                Vec3::new(front, w + 0.003, 0.5 * (floor + high) + 0.012),
                slot::LINER,
            );
        }
        if top > high + 0.05 {
            // A higher frame of tubes with mesh between them, or branches and earth over the boards.
            if self.detail[5] > 0.5 {
                for x in [rear + 0.02, 0.5 * (rear + front), front - 0.04] {
                    surface.cuboid_pair(
                        Vec3::new(x, w - 0.035, high),
                        Vec3::new(x + 0.03, w - 0.005, top),
                        work_slot::ALU,
                    );
                }
                let bars = 4;
                for k in 1..=bars {
                    let z = high + (top - high) * k as f32 / bars as f32 - 0.02;
                    surface.cuboid_pair(
                        Vec3::new(rear, w - 0.025, z),
                        Vec3::new(front, w - 0.01, z + 0.015),
                        work_slot::ALU,
                    );
                    for x in [rear + 0.01, front - 0.02] {
                        surface.builder.cuboid(Vec3::new(x, -w, z), Vec3::new(x + 0.015, w, z + 0.015), work_slot::ALU);
                    }
                }
            } else {
                let n = if level < 2 { 7 } else { 3 };
                let heap: Vec<Vec<Vec3>> = (0..=n)
                    .map(|i| {
                        (0..=n)
                            .map(|j| {
                                let (u, v) = (i as f32 / n as f32, j as f32 / n as f32);
                                let swell = sinf(u * PI) * sinf(v * PI);
                                let rough = 0.12 * sinf(9.0 * u + 4.0 * self.detail[6]) * sinf(13.0 * v);
                                let z = high - 0.05 + (top - high + 0.05) * (1.15 * swell + rough).clamp(0.0, 1.0);
                                Vec3::new(rear + 0.03 + (front - rear - 0.06) * u, (w - 0.03) * (2.0 * v - 1.0), z)
                            })
                            .collect()
                    })
                    .collect();
                surface.sheet(&heap, Outward::Along(Vec3::Z), |_, _| Some(work_slot::CARGO));
                surface.builder.cuboid(Vec3::new(front - 0.03, -w, high), Vec3::new(front, w, top), work_slot::ALU);
            }
        }
    }

    /// Boards below, a tarpaulin over hoops above, drawn in by its cord.
    fn add_covered(&self, surface: &mut Surface, (rear, front): (f32, f32), w: f32, floor: f32, level: usize) {
        let boards = (floor + 0.34).min(floor + 0.4 * (self.height_m - floor));
        self.add_open(surface, (rear, front), w, floor, boards, level);
        let top = self.height_m;
        let n = if level < 2 { 10 } else { 2 };
        let wave = |k: usize, m: f32| {
            if k % 2 == 1 && level < 2 { m * (0.5 + 0.5 * sinf(k as f32 * 2.1 + 9.0 * self.detail[2])) } else { 0.0 }
        };
        let sides: Vec<Vec<Vec3>> = (0..=n)
            .map(|k| {
                let x = rear + (front - rear) * k as f32 / n as f32;
                let y = w - wave(k, 0.025);
                vec![
                    Vec3::new(x, w + 0.005, boards - 0.08 - wave(k, 0.03)),
                    Vec3::new(x, y, boards + 0.3 * (top - boards)),
                    Vec3::new(x, y - 0.01, top - 0.06),
                    Vec3::new(x, w - 0.06, top - wave(k, 0.02)),
                    Vec3::new(x, 0.0, top),
                ]
            })
            .collect();
        surface
            .pair(&sides, Outward::From(Vec3::new(0.5 * (rear + front), 0.0, boards)), |_, _| Some(work_slot::CANVAS));
        for (x, out) in [(rear, -1.0), (front, 1.0)] {
            let end: Vec<Vec<Vec3>> = (0..=n)
                .map(|k| {
                    let y = w * (2.0 * k as f32 / n as f32 - 1.0);
                    let deep = x - out * wave(k, 0.02);
                    vec![
                        Vec3::new(x, y, boards - 0.08),
                        Vec3::new(deep, y, 0.5 * (boards + top)),
                        Vec3::new(x - out * 0.004, y, top - 0.05),
                        Vec3::new(x - out * 0.03, y * 0.97, top - 0.005),
                    ]
                })
                .collect();
            surface.sheet(&end, Outward::Along(Vec3::X * out), |_, _| Some(work_slot::CANVAS));
        }
    }
}
