//! The lower body as a surface over (place along the half ring, height): plan, section and belt line.

use super::dimensions::Dimensions;
use cadet_base::math::{Vec3, cosf, powf, sinf};

/// Height fractions at which the section bends, and how far the flank lies inside the widest line there, meters.
const SECTION: [(f32, f32); 11] = [
    (0.0, 0.075),
    (0.08, 0.042),
    (0.22, 0.024),
    (0.36, 0.017),
    (0.43, 0.013),
    (0.50, 0.009),
    (0.64, 0.0),
    (0.78, 0.006),
    (0.90, 0.020),
    (0.97, 0.035),
    (1.0, 0.050),
];
/// How far nose and tail lie behind their foremost line at the same height fractions, meters: the tail without the ledge of
/// its bumper, which is as deep at each height as its share says. `end_tests` compares them with real scans.
const NOSE_SETBACK: [f32; 11] = [0.07, 0.03, 0.005, 0.0, 0.0, 0.003, 0.015, 0.035, 0.07, 0.11, 0.16];
const TAIL_SETBACK: [f32; 11] = [0.075, 0.042, 0.016, 0.003, 0.0, 0.0, 0.003, 0.010, 0.022, 0.036, 0.052];
const TAIL_LEDGE: [f32; 11] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.05, 0.9, 1.0, 1.0, 1.0, 1.0];
/// Share of their tails' setback, above the ledge, that vans have: they end upright.
const VAN_TAIL: f32 = 0.4;

/// A place on the half ring around the body, from the middle of the nose over the left flank to the tail's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// x on the widest line.
    pub x: f32,
    /// Which face it is on.
    pub face: Face,
    /// Lower edge where a wheel arch is cut.
    pub arch_z: Option<f32>,
    /// The cells between this column and the one before are no surface: the two stand above each other.
    pub is_seam: bool,
}

impl Column {
    /// A column down to the sill.
    pub fn whole(x: f32, face: Face) -> Self {
        Self { x, face, arch_z: None, is_seam: false }
    }
}

/// The part of the half ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Face {
    /// The nose, with the lateral fraction 0 (middle) to 1.
    Nose(f32),
    /// The flank.
    Side,
    /// The tail, with the lateral fraction.
    Tail(f32),
}

impl Face {
    /// Lateral fraction: 1 on the flank.
    pub fn lateral(self) -> f32 {
        match self {
            Self::Nose(f) | Self::Tail(f) => f,
            Self::Side => 1.0,
        }
    }
}

/// The lower body's shape.
#[derive(Debug)]
pub(super) struct Outline {
    pub d: Dimensions,
    /// x where nose and tail begin.
    pub nose_x: f32,
    pub tail_x: f32,
    /// x of the windscreen's and the backlight's foot at the side.
    pub screen_foot_x: f32,
    pub backlight_foot_x: f32,
    lip: f32,
}

fn interpolate(table: impl Fn(usize) -> (f32, f32), n: usize, v: f32) -> f32 {
    let mut k = 0;
    while k + 2 < n && table(k + 1).0 < v {
        k += 1;
    }
    let ((v0, a), (v1, b)) = (table(k), table(k + 1));
    a + (b - a) * ((v - v0) / (v1 - v0)).clamp(0.0, 1.0)
}

/// How far the tail lies behind the bumper's foremost line at a row of [`SECTION`].
fn tail_setback(d: &Dimensions, row: usize) -> f32 {
    (if d.is_van { VAN_TAIL } else { 1.0 }) * TAIL_SETBACK[row] + d.tail_ledge_m * TAIL_LEDGE[row]
}

impl Outline {
    /// The outline of a vehicle.
    pub fn new(d: Dimensions) -> Self {
        let half = d.length_m / 2.0;
        let nose_x = d.axles_x[0] + d.arch_radius_m + 0.02;
        let tail_x = d.axles_x[1] - d.arch_radius_m - 0.02;
        let (screen_bow, backlight_bow) = if d.is_van { (0.10, 0.03) } else { (0.15, 0.08) };
        let backlight_x = -half + tail_setback(&d, TAIL_SETBACK.len() - 1) + 0.02 + d.boot_m;
        Self {
            nose_x,
            tail_x,
            screen_foot_x: d.cowl_x - screen_bow,
            backlight_foot_x: backlight_x + backlight_bow,
            lip: 0.018,
            d,
        }
    }

    /// Height of the shell's upper edge at the side: fender, belt line, tail.
    pub fn top_z(&self, x: f32) -> f32 {
        let d = &self.d;
        let half = d.length_m / 2.0;
        if x >= self.screen_foot_x {
            let t = ((half - x) / (half - self.screen_foot_x)).clamp(0.0, 1.0);
            d.bonnet_edge_z + (d.belt_z - d.bonnet_edge_z) * (1.0 - powf(1.0 - t, 1.5))
        } else {
            d.belt_z + d.belt_rise_m * (self.screen_foot_x - x) / (self.screen_foot_x + half)
        }
    }

    /// How much higher than its edges bonnet, boot lid and cowl are in the middle.
    pub fn crown(&self, x: f32) -> f32 {
        let half = self.d.length_m / 2.0;
        if x >= self.screen_foot_x {
            let t = ((half - x) / (half - self.screen_foot_x)).clamp(0.0, 1.0);
            0.035 + ((self.d.cowl_z - self.d.belt_z).max(0.025) - 0.035) * t
        } else {
            0.025
        }
    }

    fn taper(&self, x: f32) -> f32 {
        let half = self.d.length_m / 2.0;
        let nose = ((x - self.d.axles_x[0]) / (half - self.d.axles_x[0])).clamp(0.0, 1.0);
        let tail = ((self.d.axles_x[1] - x) / (half + self.d.axles_x[1])).clamp(0.0, 1.0);
        1.0 - 0.10 * nose * nose * nose - 0.07 * tail * tail * tail
    }

    /// Half width of the flank at x and a height fraction, without the arches' lips.
    pub fn half_width(&self, x: f32, v: f32) -> f32 {
        let tuck = interpolate(|k| SECTION[k], SECTION.len(), v);
        // Vans carry their full width up to the roof.
        let tuck = if self.d.is_van && v > 0.64 { 0.4 * tuck } else { tuck };
        (self.d.width_m / 2.0 - self.lip) * self.taper(x) - tuck
    }

    /// The height fraction of a height at a column's place.
    pub fn fraction(&self, x: f32, z: f32) -> f32 {
        (z - self.d.clearance_m) / (self.top_z(x) - self.d.clearance_m)
    }

    /// A point of the flank by x and z.
    pub fn flank(&self, x: f32, z: f32) -> Vec3 {
        let (d, mut y) = (&self.d, self.half_width(x, self.fraction(x, z)));
        for axle in d.axles_x {
            let dz = (z - d.wheel_radius_m).max(0.0);
            let gap = ((x - axle) * (x - axle) + dz * dz).sqrt() - d.arch_radius_m;
            let near = (1.0 - gap.abs() / 0.06).max(0.0);
            y += self.lip * near * near;
        }
        Vec3::new(x, y, z)
    }

    /// A point of the ring at a column and a height fraction.
    pub fn point(&self, column: &Column, v: f32) -> Vec3 {
        let d = &self.d;
        let f = column.face.lateral();
        let top = self.top_z(column.x) + self.crown(column.x) * (1.0 - f * f);
        let z = d.clearance_m + v * (top - d.clearance_m);
        match column.face {
            Face::Side => self.flank(column.x, column.arch_z.map_or(z, |low| z.max(low))),
            Face::Nose(f) | Face::Tail(f) => {
                let is_nose = matches!(column.face, Face::Nose(_));
                let (root, tip, n) = self.end(is_nose);
                let reach = (tip - root).abs();
                let setback = |k: usize| if is_nose { NOSE_SETBACK[k] } else { tail_setback(d, k) };
                let back = interpolate(|k| (SECTION[k].0, setback(k)), SECTION.len(), v).min(0.6 * reach);
                let scale = (tip - root).signum() * (reach - back);
                let x = root + scale * powf((1.0 - powf(f, n)).max(0.0), 1.0 / n);
                Vec3::new(x, f * self.half_width(column.x, v), z)
            }
        }
    }

    /// A point of bonnet or boot lid at a column, `t` from 0 in the middle to 1 at the ring's edge.
    pub fn deck(&self, column: &Column, t: f32) -> Vec3 {
        let edge = self.point(column, 1.0);
        let f = column.face.lateral();
        let z = self.top_z(column.x) + self.crown(column.x) * (1.0 - f * f * t * t);
        Vec3::new(edge.x, edge.y * t, z)
    }

    /// Half width of the shell's upper edge at x, rounded off toward nose and tail.
    pub fn edge_y(&self, x: f32) -> f32 {
        let lateral = |is_nose: bool, setback: f32| {
            let (root, tip, n) = self.end(is_nose);
            let back = setback.min(0.6 * (tip - root).abs());
            let along = ((x - root) / ((tip - root) * (1.0 - back / (tip - root).abs()))).clamp(0.0, 1.0);
            powf((1.0 - powf(along, n)).max(0.0), 1.0 / n)
        };
        let last = SECTION.len() - 1;
        let f = match x {
            _ if x > self.nose_x => lateral(true, NOSE_SETBACK[last]),
            _ if x < self.tail_x => lateral(false, tail_setback(&self.d, last)),
            _ => 1.0,
        };
        f * self.half_width(x, 1.0)
    }

    /// Height of bonnet, cowl or boot lid at a place.
    pub fn deck_z(&self, x: f32, y: f32) -> f32 {
        let t = y / self.edge_y(x).max(0.05);
        self.top_z(x) + self.crown(x) * (1.0 - t * t)
    }

    /// The glass foot line: the ledge inside the belt line.
    pub fn glass_foot(&self, x: f32) -> Vec3 {
        Vec3::new(x, self.edge_y(x) - 0.018, self.top_z(x) + 0.006)
    }

    /// The column of nose or tail at a lateral fraction.
    pub fn end_column(&self, fraction: f32, is_nose: bool) -> Column {
        let (root, tip, n) = self.end(is_nose);
        let x = root + (tip - root) * powf((1.0 - powf(fraction, n)).max(0.0), 1.0 / n);
        Column::whole(x, if is_nose { Face::Nose(fraction) } else { Face::Tail(fraction) })
    }

    /// x of nose or tail where it begins and where it ends, and its plan's exponent.
    fn end(&self, is_nose: bool) -> (f32, f32, f32) {
        let d = &self.d;
        if is_nose {
            (self.nose_x, d.length_m / 2.0, d.corner_exponent[0])
        } else {
            (self.tail_x, -d.length_m / 2.0, d.corner_exponent[1])
        }
    }

    /// The columns of the half ring for a level of detail, 0 the finest.
    pub fn columns(&self, level: usize) -> Vec<Column> {
        const ENDS: [&[f32]; 3] = [
            &[0.0, 0.14, 0.28, 0.42, 0.55, 0.68, 0.79, 0.88, 0.94, 0.98],
            &[0.0, 0.28, 0.55, 0.79, 0.94],
            &[0.0, 0.58, 0.90],
        ];
        let d = &self.d;
        let flank = |x| Column::whole(x, Face::Side);
        let mut columns: Vec<Column> = ENDS[level].iter().map(|f| self.end_column(*f, true)).collect();
        let mut side: Vec<Column> = vec![flank(self.nose_x), flank(self.tail_x)];
        let segments = [14, 8, 4][level];
        for axle in d.axles_x {
            for k in 0..=segments {
                let angle = (0.5 - k as f32 / segments as f32) * std::f32::consts::PI;
                let x = axle + d.arch_radius_m * sinf(angle);
                let low = d.wheel_radius_m + d.arch_radius_m * cosf(angle).max(0.0);
                let is_first = k == 0;
                if is_first || k == segments {
                    // The arch's upright edge: one column down to the sill, one from the axle's height.
                    side.push(flank(x + if is_first { 1e-4 } else { -1e-4 }));
                }
                side.push(Column { arch_z: Some(low), is_seam: is_first, ..flank(x) });
            }
        }
        let covered = |x: f32| d.axles_x.iter().any(|a| (x - a).abs() < d.arch_radius_m + 0.02);
        for x in [self.screen_foot_x, self.backlight_foot_x] {
            if !covered(x) && x >= self.tail_x {
                side.push(flank(x));
            } else if x > self.tail_x {
                // On an arch the column takes the arch's height.
                let square = |a: &f32| d.arch_radius_m * d.arch_radius_m - (x - a) * (x - a);
                let low = d.axles_x.iter().map(square).filter(|s| *s > 0.0).map(|s| d.wheel_radius_m + s.sqrt());
                side.push(Column { arch_z: low.reduce(f32::max), ..flank(x) });
            }
        }
        let doors = [7, 3, 2][level];
        let (from, to) = (d.axles_x[0] - d.arch_radius_m, d.axles_x[1] + d.arch_radius_m);
        for k in 1..doors {
            let x = from + (to - from) * k as f32 / doors as f32;
            if (x - self.screen_foot_x).abs() > 0.06 {
                side.push(flank(x));
            }
        }
        side.sort_by(|a, b| b.x.total_cmp(&a.x));
        // Behind an arch the column that goes down to the sill comes second: its cells to the arch are the seam.
        for k in 1..side.len() {
            if side[k].arch_z.is_none() && side[k - 1].arch_z.is_some() {
                side[k].is_seam = true;
            }
        }
        columns.extend(side);
        columns.extend(ENDS[level].iter().rev().map(|f| self.end_column(*f, false)));
        columns
    }

    /// The height fractions of the section for a level of detail.
    pub fn fractions(level: usize) -> &'static [f32] {
        match level {
            0 => &[0.0, 0.08, 0.22, 0.36, 0.43, 0.50, 0.64, 0.78, 0.90, 0.97, 1.0],
            1 => &[0.0, 0.08, 0.43, 0.50, 0.64, 0.90, 1.0],
            _ => &[0.0, 0.43, 0.52, 1.0],
        }
    }
}
