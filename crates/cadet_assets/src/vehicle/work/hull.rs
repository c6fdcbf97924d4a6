//! Shells with a rounded plan: cabs, buses, caravans. A ring of columns round the shell, rows above each other.

use super::super::paint::slot;
use super::super::surface::{Outward, Surface, grid, mirror_image};
use cadet_base::math::{Vec3, cosf, sinf};
use std::f32::consts::{FRAC_PI_2, PI};

/// Which face of the shell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Part {
    Front,
    FrontCorner,
    Side,
    RearCorner,
    Rear,
}

/// The shape of a shell.
#[derive(Debug, Clone)]
pub(in super::super) struct Hull {
    pub front_x: f32,
    pub rear_x: f32,
    pub half_y: f32,
    /// Radii of the corners in the plan.
    pub front_radius_m: f32,
    pub rear_radius_m: f32,
    /// How far the front's middle stands before its corners.
    pub bow_m: f32,
    /// Above this height the front leans back by this tangent.
    pub lean_from_z: f32,
    pub lean_tangent: f32,
    /// Above `lean_from_z` the rear leans forward by this tangent.
    pub rear_lean_tangent: f32,
    /// Heights, and how far the shell draws in there.
    pub rows: Vec<(f32, f32)>,
}

/// A column of the left half ring.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Column {
    pub x: f32,
    pub y: f32,
    part: Part,
}

/// A cell between two columns and two rows, by its middle.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Cell {
    pub part: Part,
    pub x: f32,
    /// Lateral fraction, 0 in the middle of front or rear.
    pub fraction: f32,
    pub z: f32,
    /// +1 left, -1 right.
    pub side: f32,
}

impl Hull {
    /// The half ring from the front's middle to the rear's: lateral fractions of the ends' columns, x of the side's, and
    /// segments of a corner.
    pub fn columns(&self, ends: &[f32], side_x: &[f32], arc: usize) -> Vec<Column> {
        let end = |tip: f32, radius: f32, inwards: f32, bow: f32, [part, corner]: [Part; 2]| -> Vec<Column> {
            let edge = self.half_y - radius;
            let x_at = |y: f32| tip + inwards * bow * (y / edge) * (y / edge);
            let face = ends.iter().map(|f| f * edge).chain([edge]).map(|y| Column { x: x_at(y), y, part });
            let round = (1..=arc).map(|k| FRAC_PI_2 * k as f32 / arc as f32).map(|a| {
                let x = x_at(edge) + inwards * radius * (1.0 - cosf(a));
                Column { x, y: edge + radius * sinf(a), part: corner }
            });
            face.chain(round).collect()
        };
        let front = end(self.front_x, self.front_radius_m, -1.0, self.bow_m, [Part::Front, Part::FrontCorner]);
        let rear = end(self.rear_x, self.rear_radius_m, 1.0, 0.4 * self.bow_m, [Part::Rear, Part::RearCorner]);
        let mut xs = side_x.to_vec();
        xs.sort_by(|a, b| b.total_cmp(a));
        let side = xs.into_iter().map(|x| Column { x, y: self.half_y, part: Part::Side });
        front.into_iter().chain(side).chain(rear.into_iter().rev()).collect()
    }

    /// Where the flank begins behind the front corner, and ends before the rear one.
    pub fn flank(&self) -> (f32, f32) {
        (self.front_x - self.bow_m - self.front_radius_m, self.rear_x + 0.4 * self.bow_m + self.rear_radius_m)
    }

    pub fn point(&self, column: &Column, (z, inset): (f32, f32)) -> Vec3 {
        let up = (z - self.lean_from_z).max(0.0);
        let middle = 0.5 * (self.front_x + self.rear_x);
        let lean = match column.part {
            Part::Front | Part::FrontCorner => {
                let (from, _) = self.flank();
                let reach = ((column.x - from) / (self.front_x - from)).clamp(0.0, 1.0);
                -self.lean_tangent * up * reach.max(0.35)
            }
            Part::Rear | Part::RearCorner => self.rear_lean_tangent * up,
            Part::Side => 0.0,
        };
        let inwards = match column.part {
            Part::Side => 0.0,
            _ => inset * (middle - column.x).signum(),
        };
        let y = column.y * (1.0 - inset / self.half_y);
        Vec3::new(column.x + lean + inwards, y, z)
    }

    /// Adds both halves; `slot` names each cell's material or leaves it open. The last row is roofed.
    pub fn add(&self, surface: &mut Surface, columns: &[Column], slot: impl Fn(&Cell) -> Option<u8>, roof: u8) {
        let left = grid(columns, &self.rows, |c, row| self.point(c, *row));
        let middle_z = 0.5 * (self.rows[0].0 + self.rows[self.rows.len() - 1].0);
        let inside = Vec3::new(0.5 * (self.front_x + self.rear_x), 0.0, middle_z);
        for (side, half) in [(1.0, &left), (-1.0, &mirror_image(&left))] {
            surface.sheet(half, Outward::From(inside), |i, j| {
                let (a, b) = (&columns[i], &columns[i + 1]);
                let part = match (a.part, b.part) {
                    (Part::Front, Part::FrontCorner) | (Part::FrontCorner, Part::Side) => b.part,
                    _ => a.part,
                };
                slot(&Cell {
                    part,
                    x: 0.5 * (a.x + b.x),
                    fraction: 0.5 * (a.y + b.y) / self.half_y,
                    z: 0.5 * (self.rows[j].0 + self.rows[j + 1].0),
                    side,
                })
            });
        }
        let edge = left.iter().map(|column| column[column.len() - 1]);
        let lid: Vec<[Vec3; 2]> = edge.map(|p| [p, p.with_y(0.0)]).collect();
        surface.panel_pair(&lid, Outward::Along(Vec3::Z), roof);
    }
}

/// A wheel arch in a flat flank.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arch {
    pub axle_x: f32,
    pub wheel_radius_m: f32,
    pub radius_m: f32,
    /// y of the flank, and how deep the arch is.
    pub y: f32,
    pub depth_m: f32,
    /// Upper edge of the panel that the arch is cut from, above the arch's crown.
    pub top_z: f32,
}

impl Arch {
    /// Whether a cell of the flank belongs to the arch's panel.
    pub fn covers(&self, x: f32, z: f32) -> bool {
        (x - self.axle_x).abs() < self.radius_m && z < self.top_z
    }

    /// Adds panel and lining on both sides.
    pub fn add(&self, surface: &mut Surface, level: usize, panel: u8) {
        let n = [12, 8, 6, 4][level];
        let crown = (0..=n).map(|k| PI * k as f32 / n as f32).map(|a| {
            Vec3::new(self.axle_x + self.radius_m * cosf(a), self.y, self.wheel_radius_m + self.radius_m * sinf(a))
        });
        let strip: Vec<[Vec3; 2]> = crown.clone().map(|p| [p, p.with_z(self.top_z)]).collect();
        surface.panel_pair(&strip, Outward::Along(Vec3::Y), panel);
        let inner_y = self.y - self.depth_m;
        let low = 0.45 * self.wheel_radius_m;
        let foot = |x: f32| Vec3::new(x, self.y, low);
        let [front, rear] = [foot(self.axle_x + self.radius_m), foot(self.axle_x - self.radius_m)];
        let lining: Vec<[Vec3; 2]> =
            [front].into_iter().chain(crown).chain([rear]).map(|p| [p, p.with_y(inner_y)]).collect();
        let hub = Vec3::new(self.axle_x, self.y - 0.5 * self.depth_m, self.wheel_radius_m);
        surface.panel_pair(&lining, Outward::Towards(hub), slot::LINER);
        let wall: Vec<[Vec3; 2]> = lining.iter().map(|[_, p]| [*p, p.with_z(low)]).collect();
        surface.panel_pair(&wall, Outward::Along(Vec3::Y), slot::LINER);
    }
}
