//! The shell of a tram's car: skirt, flanks with windows and doors, cabs with a leaning screen, the curve of the roof.

use super::super::paint::{slot, work_slot};
use super::super::surface::Surface;
use super::super::work::{Cell, Hull, Part};
use super::plan::{CarPlan, End};

/// Height of the skirt's lower edge over the rails.
const SKIRT_M: f32 = 0.30;
/// How far the shell ends before the middle of a joint: half of the bellows.
pub(super) const BELLOWS_M: f32 = 0.28;
/// How high roof boxes stand over the roof.
pub(super) const ROOF_BOX_M: f32 = 0.24;
/// Distance between the pillars of windows, and half their width.
const PANE_M: f32 = 1.5;
const PILLAR_M: f32 = 0.055;
/// Door leaves have frames this wide.
const FRAME_M: f32 = 0.07;

/// A car's shell.
pub(super) struct Shell<'a> {
    p: &'a CarPlan,
    hull: Hull,
    pillars: Vec<f32>,
}

/// Upper edge of the roof.
pub(super) fn roof(p: &CarPlan) -> f32 {
    p.height_m - ROOF_BOX_M
}

impl<'a> Shell<'a> {
    pub fn new(p: &'a CarPlan) -> Self {
        let half = p.length_m / 2.0;
        let is_cab = p.ends.map(|e| e == End::Cab);
        let end_x = is_cab.map(|cab| if cab { half } else { half - BELLOWS_M });
        let top = roof(p);
        let rows = vec![
            (SKIRT_M, 0.05),
            (SKIRT_M + 0.12, 0.0),
            (p.floor_z.max(0.62), 0.0),
            (p.sill_z - 0.30, 0.0),
            (p.sill_z, 0.0),
            (p.header_z, 0.03),
            (p.header_z + 0.28, 0.06),
            (top - 0.10, 0.14),
            (top - 0.02, 0.34),
            (top, 0.62),
        ];
        let hull = Hull {
            front_x: end_x[0],
            rear_x: -end_x[1],
            half_y: p.width_m / 2.0,
            front_radius_m: if is_cab[0] { p.nose_radius_m } else { 0.06 },
            rear_radius_m: if is_cab[1] { p.nose_radius_m } else { 0.06 },
            bow_m: if is_cab[0] { 0.16 } else { 0.0 },
            lean_from_z: p.sill_z - 0.25,
            lean_tangent: if is_cab[0] { p.lean_tangent } else { 0.0 },
            rear_lean_tangent: if is_cab[1] { 0.8 * p.lean_tangent } else { 0.0 },
            rows,
        };
        let (from, to) = hull.flank();
        let panes = ((from - to) / PANE_M).round().max(1.0);
        let pillars = (0..=panes as usize).map(|k| from - (from - to) * k as f32 / panes).collect();
        Self { p, hull, pillars }
    }

    pub fn add(&self, surface: &mut Surface, level: usize) {
        let h = &self.hull;
        let ends: &[f32] =
            [&[0.0, 0.3, 0.55, 0.75, 0.9][..], &[0.0, 0.55, 0.75, 0.9], &[0.0, 0.75], &[0.0, 0.75]][level];
        let (from, to) = h.flank();
        let mut xs = vec![from, to];
        if level < 3 {
            xs.extend(self.pillars.iter().flat_map(|x| [x + PILLAR_M, x - PILLAR_M]));
        }
        for x in &self.p.doors {
            let half = self.p.door_width_m / 2.0;
            xs.extend([x + half, x - half]);
            if level < 3 {
                xs.extend([x + half - FRAME_M, x - half + FRAME_M, x + FRAME_M / 2.0, x - FRAME_M / 2.0]);
            }
        }
        xs.retain(|x| *x <= from && *x >= to);
        let columns = h.columns(ends, &xs, [6, 4, 2, 2][level]);
        h.add(surface, &columns, |c| Some(self.slot(c, level)), work_slot::LOAD);
    }

    fn slot(&self, c: &Cell, level: usize) -> u8 {
        let p = self.p;
        let pane = |clear: u8| if level < 3 { clear } else { slot::DARK_GLASS };
        let is_window_high = c.z > p.sill_z && c.z < p.header_z;
        if c.z > p.header_z + 0.28 {
            return work_slot::LOAD;
        }
        let (is_front, is_rear) =
            (matches!(c.part, Part::Front | Part::FrontCorner), matches!(c.part, Part::Rear | Part::RearCorner));
        if is_front || is_rear {
            let is_cab = p.ends[usize::from(is_rear)] == End::Cab;
            let is_middle = matches!(c.part, Part::Front | Part::Rear) && c.fraction < 0.9;
            return match (is_cab, is_window_high) {
                (false, _) => slot::PLASTIC,
                (true, true) if is_middle => pane(slot::SCREEN),
                (true, true) => slot::DARK_GLASS,
                // The destination over the screen.
                (true, false) if c.z > p.header_z => slot::DARK_GLASS,
                (true, false) if c.z < SKIRT_M + 0.12 => slot::PLASTIC,
                (true, false) if c.z > p.sill_z - 0.30 => work_slot::STRIPE,
                (true, false) => slot::PAINT,
            };
        }
        let half = p.door_width_m / 2.0;
        let door = p.doors.iter().find(|x| (c.x - **x).abs() < half && (c.side < 0.0 || p.has_left_doors));
        if let Some(x) = door.filter(|_| c.z < p.header_z) {
            let off = (c.x - x).abs();
            return match c.z {
                z if z < SKIRT_M + 0.12 => slot::PLASTIC,
                _ if off > half - FRAME_M || off < FRAME_M / 2.0 => work_slot::STRIPE,
                // Leaves of low floors are glazed to the steps, others above a panel.
                z if z > p.sill_z || (p.floor_z < 0.5 && z > p.sill_z - 0.30) => pane(slot::SIDE_GLASS),
                _ => work_slot::STRIPE,
            };
        }
        match c.z {
            _ if is_window_high => {
                let is_pillar = self.pillars.iter().any(|x| (c.x - x).abs() < PILLAR_M);
                if is_pillar && level < 3 { slot::PLASTIC } else { pane(slot::REAR_SIDE_GLASS) }
            }
            z if z < SKIRT_M + 0.12 => slot::PLASTIC,
            z if z > p.header_z || z > p.sill_z - 0.30 => work_slot::STRIPE,
            _ => slot::PAINT,
        }
    }
}
