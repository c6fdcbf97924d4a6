//! Roofs: gables and hips in courses of tiles, and flat roofs with a parapet.

use super::Detail;

use super::materials::house_slot as slot;
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;

/// A pitched roof; its ridge runs along y.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pitched {
    /// Extent of the walls along the ridge.
    pub length_m: f32,
    /// Extent of the walls across it.
    pub span_m: f32,
    /// Height of the walls.
    pub eaves_m: f32,
    /// Rise over run.
    pub slope: f32,
    /// How far the roof goes beyond the walls at the eaves and, on gables, at the verges.
    pub overhang_m: f32,
    /// Hips instead of gables.
    pub hipped: bool,
}

const THICKNESS_M: f32 = 0.16;
const COURSE_M: f32 = 0.36;
const LIFT_M: f32 = 0.03;

impl Pitched {
    /// Height of the ridge.
    pub fn ridge(&self) -> f32 {
        self.eaves_m + self.slope * self.span_m / 2.0
    }

    /// Height of the upper surface at a distance from the ridge's plane.
    pub fn top_at(&self, x: f32) -> f32 {
        self.ridge() + THICKNESS_M - self.slope * x.abs()
    }

    /// Draws the roof, its soffit, its verges or hips, and gutters along the eaves.
    pub fn draw(&self, b: &mut MeshBuilder, detail: Detail) {
        let (reach_x, reach_y) = (self.span_m / 2.0 + self.overhang_m, self.length_m / 2.0 + self.overhang_m);
        let run = (1.0 + self.slope * self.slope).sqrt() * reach_x;
        let courses = match detail {
            Detail::Near => (run / COURSE_M).ceil() as usize,
            Detail::Mid | Detail::Far => 1,
        };
        let lift = if courses > 1 { LIFT_M } else { 0.0 };
        // Half extents of the surface at a horizontal inset from the eaves.
        let half = |inset: f32| {
            let y = if self.hipped { (reach_y - inset).max(0.0) } else { reach_y };
            (reach_x - inset, y)
        };
        for k in 0..courses {
            let inset = |k: usize| reach_x * k as f32 / courses as f32;
            let ((x0, y0), (x1, y1)) = (half(inset(k)), half(inset(k + 1)));
            let (z0, z1) = (self.top_at(x0) + lift, self.top_at(x1));
            self.band(b, (x0, y0, z0), (x1, y1, z1));
            if lift > 0.0 && k + 1 < courses {
                self.band(b, (x1, y1, z1), (x1, y1, z1 + lift));
            }
        }
        self.edges(b, reach_x, reach_y, lift);
        if detail == Detail::Far {
            return;
        }
        let ridge_y = if self.hipped { (reach_y - reach_x).max(0.0) } else { reach_y };
        let top = self.top_at(0.0) + 0.02;
        if ridge_y > 0.0 {
            let end = |y: f32| (Vec3::new(0.0, y, top), 0.11);
            b.tube(&[end(-ridge_y), end(ridge_y)], 6, slot::ROOF);
        }
        let gutter_z = self.top_at(reach_x) - 0.12;
        let (gx, gy) = (reach_x + 0.05, if self.hipped { reach_y + 0.05 } else { reach_y });
        let run = |b: &mut MeshBuilder, p: Vec3, q: Vec3| {
            b.tube(&[(p, 0.065), (q, 0.065)], detail.pick(6, 4, 4), slot::METAL)
        };
        for s in [-1.0, 1.0] {
            run(b, Vec3::new(s * gx, -gy, gutter_z), Vec3::new(s * gx, gy, gutter_z));
            if self.hipped {
                run(b, Vec3::new(-gx, s * gy, gutter_z), Vec3::new(gx, s * gy, gutter_z));
            }
        }
    }

    /// One belt of the roof between two outlines (half extents and height): both slopes, and the hips.
    fn band(&self, b: &mut MeshBuilder, (x0, y0, z0): (f32, f32, f32), (x1, y1, z1): (f32, f32, f32)) {
        let mut belt = |p: Vec3, q: Vec3, r: Vec3, s: Vec3| b.quad(p, q, r, s, slot::ROOF);
        let v = Vec3::new;
        belt(v(x0, -y0, z0), v(x0, y0, z0), v(x1, y1, z1), v(x1, -y1, z1));
        belt(v(-x0, y0, z0), v(-x0, -y0, z0), v(-x1, -y1, z1), v(-x1, y1, z1));
        if self.hipped {
            belt(v(x0, y0, z0), v(-x0, y0, z0), v(-x1, y1, z1), v(x1, y1, z1));
            belt(v(-x0, -y0, z0), v(x0, -y0, z0), v(x1, -y1, z1), v(-x1, -y1, z1));
        }
    }

    /// Fascias, verges and the soffit.
    fn edges(&self, b: &mut MeshBuilder, x: f32, y: f32, lift: f32) {
        let v = Vec3::new;
        let (up, low) = (self.top_at(x) + lift, self.top_at(x) - THICKNESS_M);
        for s in [-1.0, 1.0] {
            let (x, y) = (s * x, s * y);
            b.quad(v(x, -y, low), v(x, y, low), v(x, y, up), v(x, -y, up), slot::WOOD);
        }
        if self.hipped {
            for s in [-1.0, 1.0] {
                let (x, y) = (s * x, s * y);
                b.quad(v(x, y, low), v(-x, y, low), v(-x, y, up), v(x, y, up), slot::WOOD);
            }
            b.quad(v(-x, -y, low), v(-x, y, low), v(x, y, low), v(x, -y, low), slot::WOOD);
            return;
        }
        let (ridge_up, ridge_low) = (self.top_at(0.0) + lift, self.ridge());
        for s in [-1.0, 1.0] {
            // Verge boards: at the end y = s * y both slopes show their thickness.
            let w = s * y;
            for t in [-1.0, 1.0] {
                let (a, c) = (v(t * x, w, low), v(t * x, w, up));
                let (d, e) = (v(0.0, w, ridge_low), v(0.0, w, ridge_up));
                if s * t > 0.0 { b.quad(a, d, e, c, slot::WOOD) } else { b.quad(a, c, e, d, slot::WOOD) }
            }
            // The soffit below this slope.
            let (o, i) = (v(s * x, -s * y, low), v(s * x, s * y, low));
            b.quad(i, o, v(0.0, -s * y, ridge_low), v(0.0, s * y, ridge_low), slot::WOOD);
        }
    }
}

/// A flat roof over walls of the given half extents: a slab with an edge trim, sunk behind it.
pub(super) fn flat(b: &mut MeshBuilder, half_x: f32, half_y: f32, height_m: f32) {
    let (x, y) = (half_x + 0.12, half_y + 0.12);
    b.cuboid(Vec3::new(-x, -y, height_m), Vec3::new(x, y, height_m + 0.28), slot::METAL);
    let (x, y, z) = (half_x - 0.1, half_y - 0.1, height_m + 0.285);
    b.quad(Vec3::new(-x, -y, z), Vec3::new(x, -y, z), Vec3::new(x, y, z), Vec3::new(-x, y, z), slot::ROOF);
}
