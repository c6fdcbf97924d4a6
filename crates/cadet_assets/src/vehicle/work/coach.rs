//! A city bus: long windows, two or three doors on the right, a low floor with seats, and who sits on them.

use super::super::interior::{add_occupant, add_passengers, add_seat_pairs, add_wheel, limb, limb_pair};
use super::super::paint::{slot, work_slot};
use super::super::surface::{Outward, Surface, grid, level_sheet, upright};
use super::cab::plate;
use super::hull::{Arch, Cell, Hull, Part};
use super::plan::Plan;
use cadet_base::math::{Mat3, Quat, Vec3};

const FLOOR_M: f32 = 0.40;
const SILL_M: f32 = 0.98;

/// The shell of a bus.
pub(super) struct Coach {
    hull: Hull,
    arches: [Arch; 2],
    /// x of the pillars between the windows.
    pillars: Vec<f32>,
    /// x of the doors: front edge and rear edge.
    doors: Vec<(f32, f32)>,
    header: f32,
    skirt: f32,
    detail: [f32; 8],
}

impl Coach {
    pub fn new(p: &Plan) -> Self {
        let half = p.length_m / 2.0;
        let high = p.height_m - 0.03;
        let header = (high - 0.42).min(2.35);
        let skirt = 0.62;
        let radius_m = p.wheel_radius_m * 1.13;
        let arch_top = p.wheel_radius_m + radius_m + 0.04;
        let sill = SILL_M.max(arch_top + 0.02);
        let rows = vec![
            (0.26, 0.03),
            (skirt, 0.0),
            (arch_top, 0.0),
            (sill, 0.0),
            (header, 0.02),
            (high - 0.18, 0.04),
            (high - 0.06, 0.09),
            (high, 0.22),
        ];
        let hull = Hull {
            front_x: half,
            rear_x: -half,
            half_y: p.width_m / 2.0,
            front_radius_m: 0.28,
            rear_radius_m: 0.16,
            bow_m: 0.10,
            lean_from_z: 1.1,
            lean_tangent: 0.10,
            rear_lean_tangent: 0.03,
            rows,
        };
        let arch = |axle_x| Arch {
            axle_x,
            wheel_radius_m: p.wheel_radius_m,
            radius_m,
            y: p.width_m / 2.0,
            depth_m: 0.45,
            top_z: arch_top,
        };
        let (from, to) = hull.flank();
        let middle = 0.5 * (p.axles_x[0] + p.axles_x[1]);
        let mut doors = vec![(from - 0.06, from - 1.28), (middle + 0.65, middle - 0.65)];
        if p.detail[4] > 0.6 {
            doors.push((p.axles_x[1] - 1.0, p.axles_x[1] - 2.2));
        }
        let n = ((from - to) / 1.45).round();
        let pillars = (0..=n as usize).map(|k| from - (from - to) * k as f32 / n).collect();
        Self { hull, arches: [arch(p.axles_x[0]), arch(p.axles_x[1])], pillars, doors, header, skirt, detail: p.detail }
    }

    fn sill(&self) -> f32 {
        self.hull.rows[3].0
    }

    /// Adds what lies inside the label's box.
    pub fn add(&self, surface: &mut Surface, p: &Plan, level: usize) {
        let h = &self.hull;
        let ends: &[f32] =
            [&[0.0, 0.25, 0.5, 0.72, 0.88][..], &[0.0, 0.5, 0.72, 0.88], &[0.0, 0.72], &[0.0, 0.72]][level];
        let (from, to) = h.flank();
        let edge = 0.05;
        let mut xs: Vec<f32> = vec![from, to];
        if level < 3 {
            xs.extend(self.pillars.iter().flat_map(|x| [x + edge, x - edge]));
        }
        for (a, b) in &self.doors {
            xs.extend([*a, *b, a - 0.06, b + 0.06, 0.5 * (a + b) + 0.03, 0.5 * (a + b) - 0.03]);
        }
        xs.extend(self.arches.iter().flat_map(|a| [a.axle_x + a.radius_m, a.axle_x - a.radius_m]));
        xs.retain(|x| *x <= from && *x >= to);
        let columns = h.columns(ends, &xs, [5, 3, 2, 2][level]);
        h.add(surface, &columns, |c| self.slot(c, level), slot::PAINT);
        for arch in &self.arches {
            arch.add(surface, level, slot::PAINT);
        }
        if level < 3 {
            self.add_inside(surface, level);
        }
        self.add_trim(surface, p, level);
    }

    fn slot(&self, c: &Cell, level: usize) -> Option<u8> {
        let is_glazed = level < 3;
        let pane = |slot: u8| if is_glazed { slot } else { slot::DARK_GLASS };
        let (sill, header) = (self.sill(), self.header);
        let is_window_high = c.z > sill && c.z < header;
        Some(match c.part {
            Part::Front if is_window_high && c.fraction < 0.85 => pane(slot::SCREEN),
            Part::Front if c.z > header && c.z < header + 0.30 && c.fraction < 0.8 => slot::DARK_GLASS,
            Part::FrontCorner if is_window_high => slot::DARK_GLASS,
            Part::Rear if is_window_high && c.z > sill + 0.2 && c.fraction < 0.85 => slot::DARK_GLASS,
            Part::Side => {
                if self.arches.iter().any(|a| a.covers(c.x, c.z)) {
                    return None;
                }
                let door = self.doors.iter().find(|(a, b)| c.side < 0.0 && c.x < *a && c.x > *b);
                if let Some((a, b)) = door {
                    let is_frame = a - c.x < 0.06 || c.x - b < 0.06 || (c.x - 0.5 * (a + b)).abs() < 0.03;
                    return Some(if c.z > header {
                        slot::PAINT
                    } else if is_frame {
                        slot::PLASTIC
                    } else {
                        pane(slot::SIDE_GLASS)
                    });
                }
                let is_pillar = is_glazed && self.pillars.iter().any(|x| (c.x - x).abs() < 0.05);
                let is_engine = c.x < self.hull.flank().1 + 1.1 * self.detail[5];
                match c.z {
                    _ if is_window_high && (is_pillar || is_engine) => slot::DARK_GLASS,
                    _ if is_window_high => pane(slot::REAR_SIDE_GLASS),
                    z if z < self.skirt && self.detail[6] > 0.5 => work_slot::STRIPE,
                    _ => slot::PAINT,
                }
            }
            _ if c.z < self.skirt => slot::PLASTIC,
            _ => slot::PAINT,
        })
    }

    fn add_inside(&self, surface: &mut Surface, level: usize) {
        let h = &self.hull;
        let (a, b, w) = (h.front_x - 0.35, h.rear_x + 0.35, h.half_y - 0.06);
        let ceiling = h.rows[5].0;
        surface.panel_pair(&level_sheet([a, b], [0.0, w], FLOOR_M), Outward::Along(Vec3::Z), slot::DARK);
        surface.panel_pair(&level_sheet([a, b], [0.0, w], ceiling), Outward::Along(Vec3::NEG_Z), work_slot::LINING);
        let wall = |z: [f32; 2]| grid(z, [a, b], |z, x| Vec3::new(x, w, z));
        // The doors on the right are glazed down to the floor.
        surface.panel(&wall([FLOOR_M, self.sill() - 0.02]), Outward::Along(Vec3::NEG_Y), slot::DARK);
        surface.panel_pair(&wall([self.header + 0.02, ceiling]), Outward::Along(Vec3::NEG_Y), work_slot::LINING);
        surface.panel_pair(&upright(b, [0.0, w], [FLOOR_M, ceiling]), Outward::Along(Vec3::X), slot::CLOTH);
        add_seat_pairs(surface, self.seats(), level);
        if level < 2 {
            for x in &self.pillars {
                for y in [-0.42, 0.42] {
                    let [foot, top] = [FLOOR_M, ceiling].map(|z| Vec3::new(*x, y, z));
                    limb(surface, foot, top, 0.018, 0.018, 4, work_slot::AMBER);
                }
            }
            let (center, axes) = self.steering();
            add_wheel(surface, center, axes, 0.22, level);
        }
        let dash = [(a + 0.10, self.sill() + 0.02), (a - 0.25, self.sill() + 0.10), (a - 0.30, FLOOR_M)];
        let dash = grid([0.0, 0.9 * w], dash, |y, (x, z)| Vec3::new(x, y, z));
        surface.panel_pair(&dash, Outward::Along(Vec3::new(-0.6, 0.0, 1.0)), slot::DARK);
    }

    /// Hip points of the left seats; there are as many on the right but beside the doors.
    fn seats(&self) -> Vec<Vec3> {
        let (from, to) = self.hull.flank();
        let n = ((from - to - 3.6) / 0.80) as usize;
        (0..n).map(|k| Vec3::new(from - 2.4 - 0.80 * k as f32, 0.62 * self.hull.half_y, FLOOR_M + 0.55)).collect()
    }

    fn hip(&self) -> Vec3 {
        Vec3::new(self.hull.front_x - 1.35, 0.46 * self.hull.half_y, 1.02)
    }

    fn steering(&self) -> (Vec3, Mat3) {
        let hip = self.hip();
        (Vec3::new(hip.x + 0.52, hip.y, hip.z + 0.22), Mat3::from_quat(Quat::from_rotation_y(-0.5)))
    }

    /// The driver and the passengers.
    pub fn occupants(&self, level: usize) -> Surface {
        let mut surface = Surface::default();
        let (center, axes) = self.steering();
        let hands = [0.19, -0.19].map(|y| center + axes * Vec3::new(0.05, y, 0.02));
        add_occupant(&mut surface, self.hip(), 0.95, Some(hands), level.min(2));
        add_passengers(&mut surface, self.seats(), self.detail[3], 0.15 + 0.5 * self.detail[7]);
        surface
    }

    fn add_trim(&self, surface: &mut Surface, p: &Plan, level: usize) {
        let h = &self.hull;
        let (front, rear) = (h.front_x, h.rear_x);
        // Lamps in the corners of nose and tail, the destination, the air conditioner on the roof.
        let w = h.half_y;
        surface.cuboid_pair([front - 0.36, front - 0.075], [0.56 * w, 0.80 * w], [0.66, 0.86], slot::LAMP);
        surface.cuboid_pair([front - 0.40, front - 0.11], [0.815 * w, 0.90 * w], [0.68, 0.84], slot::LEFT_SIGNAL);
        let (from, to) = h.flank();
        if level < 2 {
            surface.cuboid_pair([from - 0.30, from - 0.20], [w - 0.02, w + 0.004], [0.92, 0.97], slot::LEFT_SIGNAL);
        }
        for (z0, z1, s) in [
            (0.95, 1.30, slot::TAIL_LAMP),
            (1.32, 1.44, slot::LEFT_SIGNAL),
            (h.rows[5].0 - 0.12, h.rows[5].0 - 0.04, slot::TAIL_LAMP),
        ] {
            let x0 = rear + 0.005 + 0.03 * (z0 - 1.1_f32).max(0.0);
            surface.cuboid_pair([x0, rear + 0.2], [0.74 * w, 0.86 * w], [z0, z1], s);
        }
        let roof = h.rows[7].0;
        let (ac_rear, ac_front) = (p.axles_x[1] + 1.5 + self.detail[0], -0.5 + self.detail[0]);
        let ac_half = Vec3::new(0.5 * (ac_front - ac_rear).abs(), 0.7, 0.05);
        surface.block(Vec3::new(0.5 * (ac_rear + ac_front), 0.0, roof - 0.02), ac_half, Mat3::IDENTITY, 4, slot::PAINT);
        if level < 3 {
            plate(surface, front - 0.002, 0.45, 0.26, 1.0);
            plate(surface, rear + 0.004, 0.75, 0.26, -1.0);
            surface.cuboid([rear + 0.002, rear + 0.05], [-0.62 * w, 0.62 * w], [0.52, 0.66], slot::GRILLE);
            if self.detail[2] > 0.4 {
                // A band of color below the windows.
                let band = grid([0.05, 0.13], [to, from], |down, x| Vec3::new(x, w + 0.003, self.sill() - down));
                surface.panel_pair(&band, Outward::Along(Vec3::Y), work_slot::STRIPE);
            }
        }
        surface.cuboid([rear + 0.4, front - 0.5], [-0.8 * w, 0.8 * w], [0.24, 0.38], slot::LINER);
    }

    /// Adds what sticks out of the label's box: mirrors like ears.
    pub fn add_mirrors(&self, surface: &mut Surface, level: usize) {
        let h = &self.hull;
        let at = Vec3::new(h.front_x - 0.09, h.half_y + 0.06, self.header - 0.30);
        let half = Vec3::new(0.06, 0.10, 0.20);
        surface.block_pair(at, half, Mat3::IDENTITY, [8, 6, 4, 4][level], slot::PLASTIC);
        if level < 2 {
            let foot = Vec3::new(h.front_x - 0.25, h.half_y - 0.12, self.header + 0.08);
            limb_pair(surface, foot, at + Vec3::Z * 0.18, 0.03, 5, slot::PLASTIC);
        }
    }
}
