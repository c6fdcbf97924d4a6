//! A cab-over cab: rounded shell with a large screen, grille and lamps, steps, mirrors, visor, and who sits inside.

use super::super::interior::{add_occupant, add_wheel, limb, limb_pair};
use super::super::paint::slot;
use super::super::surface::{Outward, Surface, grid, upright};
use super::body::Roof;
use super::hull::{Arch, Cell, Hull, Part};
use super::plan::Plan;
use cadet_base::math::{Mat3, Quat, Vec3};

/// The cab of a truck.
pub(super) struct Cab {
    hull: Hull,
    arch: Arch,
    /// Side windows from the screen's pillar to the door's end.
    window_x: (f32, f32),
    bumper_top: f32,
    floor: f32,
    sill: f32,
    header: f32,
    is_small: bool,
    has_visor: bool,
    black_bumper: bool,
}

impl Cab {
    pub fn new(p: &Plan) -> Self {
        let is_small = p.wheel_radius_m < 0.43;
        let (front_x, rear_x) = (p.front_x(), p.front_x() - p.cab_length_m);
        let radius_m = p.wheel_radius_m * 1.14;
        let arch_top = p.wheel_radius_m + radius_m + 0.06;
        let floor = arch_top.max(if is_small { 0.85 } else { 1.16 });
        let head = (p.cab_top_z - floor).min(1.95);
        let sill = floor + 0.36 * head.min(1.6);
        let header = sill + (0.47 * head).min(0.80);
        let bumper_top = if is_small { 0.62 } else { 0.76 };
        let low = if is_small { 0.28 } else { 0.34 };
        let grille_mid = 0.5 * (bumper_top + floor);
        let rows = vec![
            (low, 0.02),
            (bumper_top, 0.0),
            (grille_mid, 0.0),
            (floor, 0.0),
            (sill - 0.12, 0.0),
            (sill, 0.005),
            (header, 0.03),
            (p.cab_top_z - 0.10, 0.06),
            (p.cab_top_z, 0.16),
        ];
        let hull = Hull {
            front_x,
            rear_x,
            half_y: p.cab_half_y,
            front_radius_m: 0.20,
            rear_radius_m: 0.04,
            bow_m: 0.06,
            lean_from_z: sill - 0.12,
            lean_tangent: 0.10 + 0.10 * p.detail[5],
            rear_lean_tangent: 0.0,
            rows,
        };
        let (flank, _) = hull.flank();
        let window_x = (flank - 0.10, (rear_x + if p.cab_length_m > 2.0 { 0.85 } else { 0.28 }).min(flank - 0.75));
        let arch = Arch {
            axle_x: p.axles_x[0],
            wheel_radius_m: p.wheel_radius_m,
            radius_m,
            y: p.cab_half_y,
            depth_m: 0.50,
            top_z: floor,
        };
        Self {
            hull,
            arch,
            window_x,
            bumper_top,
            floor,
            sill,
            header,
            is_small,
            has_visor: !is_small && p.detail[6] > 0.35,
            black_bumper: p.detail[7] > 0.6,
        }
    }

    /// Adds what lies inside the label's box.
    pub fn add(&self, surface: &mut Surface, p: &Plan, level: usize) {
        let h = &self.hull;
        let ends: &[f32] =
            [&[0.0, 0.2, 0.42, 0.62, 0.80][..], &[0.0, 0.42, 0.62, 0.80], &[0.0, 0.62, 0.8], &[0.0, 0.62]][level];
        let (flank, rear) = h.flank();
        let edges = [flank, self.window_x.0, self.window_x.1, rear];
        let arch_edges = [self.arch.axle_x + self.arch.radius_m, self.arch.axle_x - self.arch.radius_m];
        let side_x: Vec<f32> =
            edges.into_iter().chain(arch_edges.into_iter().filter(|x| *x < flank && *x > rear)).collect();
        let columns = h.columns(ends, &side_x, [4, 3, 2, 1][level]);
        let (screen, window) =
            if level < 3 { (slot::SCREEN, slot::SIDE_GLASS) } else { (slot::DARK_GLASS, slot::DARK_GLASS) };
        h.add(surface, &columns, |c| self.slot(c, screen, window), slot::PAINT);
        self.arch.add(surface, level, slot::PAINT);
        if level < 3 {
            self.add_inside(surface, level);
        }
        self.add_trim(surface, p, level);
    }

    fn slot(&self, c: &Cell, screen: u8, window: u8) -> Option<u8> {
        let is_front = c.part == Part::Front;
        let has_lamp = is_front && c.fraction > 0.50;
        let is_window_high = c.z > self.sill && c.z < self.header;
        Some(match c.part {
            Part::Front | Part::FrontCorner => match c.z {
                // Small trucks have their lamps over the bumper.
                z if z < self.bumper_top && has_lamp && c.fraction < 0.82 && !self.is_small => slot::LAMP,
                z if z < self.bumper_top && self.black_bumper => slot::PLASTIC,
                z if z < self.bumper_top => slot::PAINT,
                z if z < 0.5 * (self.bumper_top + self.floor) && has_lamp && self.is_small => slot::LAMP,
                z if z < self.floor && is_front && c.fraction < 0.66 => slot::GRILLE,
                z if z < self.floor => slot::PAINT,
                _ if is_window_high && is_front => screen,
                z if z > self.sill - 0.12 && z < self.sill => slot::PLASTIC,
                _ => slot::PAINT,
            },
            Part::Side if self.arch.covers(c.x, c.z) => return None,
            Part::Side if is_window_high && c.x < self.window_x.0 && c.x > self.window_x.1 => window,
            Part::Side if c.z < self.bumper_top => slot::PLASTIC,
            Part::RearCorner | Part::Rear if c.z < self.floor => slot::PLASTIC,
            Part::Side | Part::RearCorner | Part::Rear => slot::PAINT,
        })
    }

    fn add_inside(&self, surface: &mut Surface, level: usize) {
        let h = &self.hull;
        let (front, rear) = (h.front_x - 0.30, h.rear_x + 0.08);
        let w = h.half_y - 0.07;
        let z = self.floor + 0.02;
        let ceiling = self.hull.rows[7].0 - 0.02;
        let sides = grid([z, self.sill - 0.02], [front, rear], |z, x| Vec3::new(x, w, z));
        surface.panel_pair(&sides, Outward::Along(Vec3::NEG_Y), slot::DARK);
        let level_at = |z: f32| grid([w, 0.0], [front, rear], |y, x| Vec3::new(x, y, z));
        surface.panel_pair(&level_at(z), Outward::Along(Vec3::Z), slot::DARK);
        surface.panel_pair(&level_at(ceiling), Outward::Along(Vec3::NEG_Z), slot::CLOTH);
        surface.panel_pair(&upright(rear, [w, 0.0], [z, ceiling]), Outward::Along(Vec3::X), slot::CLOTH);
        // The dashboard below the screen.
        let dash = [
            (front + 0.12, self.sill - 0.08),
            (front - 0.22, self.sill - 0.02),
            (front - 0.30, self.sill - 0.16),
            (front - 0.12, z),
        ];
        let dash = grid([0.0, w], dash, |y, (x, z)| Vec3::new(x, y, z));
        surface.panel_pair(&dash, Outward::Along(Vec3::new(-0.6, 0.0, 1.0)), slot::DARK);
        let hip = self.hip();
        let lean = Mat3::from_quat(Quat::from_rotation_y(-0.25));
        let sides = if level == 0 { 8 } else { 4 };
        surface.block_pair(hip + Vec3::new(-0.20, 0.0, 0.26), Vec3::new(0.06, 0.23, 0.32), lean, sides, slot::CLOTH);
        surface.block_pair(hip + Vec3::new(-0.28, 0.0, 0.66), Vec3::new(0.05, 0.13, 0.10), lean, sides, slot::CLOTH);
        if level < 2 {
            let cushion = hip + Vec3::new(0.06, 0.0, -0.10);
            surface.block_pair(cushion, Vec3::new(0.25, 0.24, 0.09), Mat3::IDENTITY, sides, slot::CLOTH);
            let (center, axes) = self.steering();
            add_wheel(surface, center, axes, 0.22, level);
        }
    }

    fn hip(&self) -> Vec3 {
        Vec3::new(self.hull.front_x - 1.18, 0.48 * self.hull.half_y, self.sill - 0.24)
    }

    fn steering(&self) -> (Vec3, Mat3) {
        let hip = self.hip();
        (Vec3::new(hip.x + 0.50, hip.y, self.sill + 0.05), Mat3::from_quat(Quat::from_rotation_y(-0.6)))
    }

    /// The driver, with a mate if asked for.
    pub fn occupants(&self, has_passenger: bool, level: usize) -> Surface {
        let mut surface = Surface::default();
        let (center, axes) = self.steering();
        let hands = [0.19, -0.19].map(|y| center + axes * Vec3::new(0.05, y, 0.02));
        let hip = self.hip();
        add_occupant(&mut surface, hip, 0.95, Some(hands), level.min(2));
        if has_passenger {
            add_occupant(&mut surface, Vec3::new(hip.x, -hip.y, hip.z), 0.92, None, level.min(2));
        }
        surface
    }

    fn add_trim(&self, surface: &mut Surface, p: &Plan, level: usize) {
        let h = &self.hull;
        let (front, w) = (h.front_x, h.half_y);
        // Turn signals in the corners beside the lamps, and their repeaters behind the doors' hinges.
        let edge = h.half_y - h.front_radius_m;
        let (x, z) = ([front - 0.20, front - h.bow_m + 0.004], [self.bumper_top - 0.15, self.bumper_top - 0.03]);
        surface.cuboid_pair(x, [edge - 0.05, edge + 0.08], z, slot::LEFT_SIGNAL);
        if level < 2 {
            let (x, z) = (self.window_x.0 + 0.12, [self.floor - 0.04, self.floor]);
            surface.cuboid_pair([x - 0.05, x + 0.05], [w - 0.02, w + 0.004], z, slot::LEFT_SIGNAL);
        }
        if level < 3 {
            // Bars of the grille, the maker's badge, the plate.
            let n = if level == 0 { 4 } else { 2 };
            for k in 0..n {
                let z = self.bumper_top + (self.floor - self.bumper_top) * (k as f32 + 0.7) / (n as f32 + 0.4);
                let y = [-0.60 * w, 0.60 * w];
                surface.cuboid([front - 0.06, front - 0.003], y, [z - 0.016, z + 0.016], slot::PLASTIC);
            }
            let badge_z = [self.floor + 0.05, self.floor + 0.13];
            surface.cuboid([front - 0.02, front - 0.001], [-0.07, 0.07], badge_z, slot::CHROME);
            plate(surface, front - 0.001, 0.48, 0.26, 1.0);
        }
        if level < 2 {
            // Steps below the doors, door gaps, handles, wipers.
            let (flank, _) = h.flank();
            let ahead = self.arch.axle_x + self.arch.radius_m;
            if flank - ahead > 0.12 {
                for z in [0.46, 0.80] {
                    let step_x = [ahead + 0.03, flank - 0.02];
                    surface.cuboid_pair(step_x, [w - 0.02, w + 0.003], [z, z + 0.07], slot::GRILLE);
                }
            }
            let (y, door_x) = (w + 0.002, self.window_x.1);
            for x in [self.window_x.0 + 0.05, door_x - 0.05] {
                let gap_z = [self.floor + 0.02, self.sill - 0.02];
                surface.cuboid_pair([x - 0.006, x + 0.006], [y - 0.02, y], gap_z, slot::LINER);
            }
            let handle_z = [self.sill - 0.22, self.sill - 0.18];
            surface.cuboid_pair([door_x, door_x + 0.16], [y - 0.02, y + 0.012], handle_z, slot::PLASTIC);
            for y in [-0.62, 0.12] {
                let a = Vec3::new(front - 0.045, y, self.sill + 0.01);
                limb(surface, a, a + Vec3::new(-0.03, 0.52, 0.12), 0.012, 0.008, 3, slot::PLASTIC);
            }
        }
        if self.has_visor && level < 3 {
            let (x, z, w) = (front - 0.05 - h.lean_tangent * 0.7, self.header + 0.10, 0.90 * w);
            let visor = [
                [Vec3::new(x - 0.06, 0.0, z), Vec3::new(x - 0.10, w, z)],
                [Vec3::new(x + 0.04, 0.0, z - 0.20), Vec3::new(x, w, z - 0.20)],
            ];
            surface.panel_pair(&visor, Outward::Along(Vec3::X), slot::DARK_GLASS);
        }
        // The engine and the tunnel that it stands in.
        surface.cuboid([h.rear_x - 0.15, front - 0.35], [-0.42, 0.42], [0.42, self.floor - 0.05], slot::LINER);
        let leads_to_roof = p.body.is_some_and(|body| body.family.roof == Roof::Flat);
        if p.cab_top_z + 0.25 < p.height_m && leads_to_roof && p.detail[6] > 0.3 {
            self.add_deflector(surface, p);
        }
    }

    /// Adds the deflector on the roof.
    fn add_deflector(&self, surface: &mut Surface, p: &Plan) {
        let h = &self.hull;
        let (x0, x1, w) = (h.front_x - 0.55 - h.lean_tangent, h.rear_x + 0.05, h.half_y - 0.16);
        let (z0, z1) = (p.cab_top_z - 0.02, p.cab_top_z + 0.85 * (p.height_m - p.cab_top_z));
        let ramp = [(x0, z0, 0.8), (0.6 * x0 + 0.4 * x1, 0.35 * z0 + 0.65 * z1, 0.93), (x1, z1, 1.0)];
        let ramp = ramp.map(|(x, z, k)| [(0.0, z), (k * w, z), (k * w, z0)].map(|(y, z)| Vec3::new(x, y, z)));
        surface.panel_pair(&ramp, Outward::Along(Vec3::new(0.3, 1.0, 1.0)), slot::PAINT);
        surface.panel_pair(&upright(x1, [0.0, w], [z0, z1]), Outward::Along(Vec3::NEG_X), slot::PLASTIC);
    }

    /// Adds what sticks out of the label's box: mirrors on their arms.
    pub fn add_mirrors(&self, surface: &mut Surface, level: usize) {
        let h = &self.hull;
        let scale = if self.is_small { 0.75 } else { 1.0 };
        let at = Vec3::new(h.front_x - 0.16, h.half_y + 0.14 * scale, self.sill + 0.30 * scale);
        let half = Vec3::new(0.06, 0.10, 0.24) * scale;
        surface.block_pair(at, half, Mat3::IDENTITY, [10, 6, 4, 4][level], slot::PLASTIC);
        if level < 2 {
            let (w, h_m) = (0.8 * half.y, 0.8 * half.z);
            let glass = upright(at.x - half.x - 0.001, [at.y - w, at.y + w], [at.z - h_m, at.z + h_m]);
            surface.panel_pair(&glass, Outward::Along(Vec3::NEG_X), slot::CHROME);
            for z in [-0.7, 0.7] {
                let out = at + Vec3::new(0.0, 0.0, z * half.z);
                let foot = Vec3::new(at.x - 0.12, h.half_y - 0.04, out.z);
                limb_pair(surface, foot, out, 0.015, 4, slot::PLASTIC);
            }
        }
    }
}

/// A number plate on an upright face that looks along `direction` times x.
pub(super) fn plate(surface: &mut Surface, x: f32, z: f32, half_y: f32, direction: f32) {
    let half_h = if half_y < 0.2 { 0.09 } else { 0.055 };
    let facing = Outward::Along(Vec3::X * direction);
    surface.panel(&upright(x, [-half_y, half_y], [z - half_h, z + half_h]), facing, slot::PLATE);
    let (x, letter_z) = (x + 0.0006 * direction, [z - 0.55 * half_h, z + 0.55 * half_h]);
    for k in 0..7 {
        let y = half_y * (0.72 - 0.24 * k as f32);
        surface.panel(&upright(x, [y - 0.013, y + 0.013], letter_z), facing, slot::LETTERS);
    }
}
