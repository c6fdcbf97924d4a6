//! Roof, pillars and panes above the belt line.

use super::archetypes::Windows;
use super::outline::Outline;
use super::paint::slot;
use super::surface::{Outward, Surface, grid};
use cadet_base::math::{Vec3, lerp};

/// High vans have a panel above panes of the usual height: how far panes reach above the belt line at most, meters.
pub(super) const SCREEN_TO_M: f32 = 0.80;
pub(super) const SIDE_PANES_TO_M: f32 = 0.70;
/// How far panes lie inside the shell, meters.
const PANE_INSET: f32 = 0.006;

/// The rows with the panes' upper edge brought down to a fraction of the way to the roof.
fn capped(rows: &[f32], limit: f32) -> Vec<f32> {
    let (low, high) = (rows[1], rows[rows.len() - 2]);
    let scale = ((limit - low) / (high - low)).min(1.0);
    let inner = |r: &f32| if *r <= low || *r >= 1.0 { *r } else { low + (r - low) * scale };
    rows.iter().map(inner).collect()
}

/// The rows of panes, which reach a little below the lowest row of the frame and above the highest.
fn overlapping(rows: &[f32]) -> Vec<f32> {
    let last = rows.len() - 2;
    let mut rows = rows[1..=last].to_vec();
    rows[0] -= 0.015;
    if last > 1 {
        rows[last - 1] += 0.015;
    }
    rows
}

/// What follows a post: its own width, or a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Pillar(u8),
    Pane(u8),
}

/// Lines from the belt to the roof's edge: x at the foot, x at the top, what follows behind.
pub(super) type Post = (f32, f32, Cell);

/// The upper body's shape.
#[derive(Debug)]
pub(super) struct Glasshouse<'a> {
    o: &'a Outline,
    /// x of the roof's front and rear edge at the sides.
    pub header_x: f32,
    pub rear_header_x: f32,
    apex_x: f32,
    edge_drop: f32,
    bulge: f32,
    header_bow: f32,
    posts: Vec<Post>,
    /// x of the B-pillar's foot.
    pub b_pillar_x: f32,
}

impl<'a> Glasshouse<'a> {
    /// The upper body over an outline; `rear_glass` is the slot of the panes behind the front doors.
    pub fn new(o: &'a Outline, rear_glass: u8) -> Self {
        let d = &o.d;
        let header_bow = 0.04;
        let front_rise = d.height_m - d.roof_sag_m[0] - d.cowl_z;
        let header_x = d.cowl_x - front_rise / d.screen_slope - header_bow;
        let tail_z = o.deck_z(o.backlight_foot_x, 0.0);
        let backlight_x = o.backlight_foot_x - if d.is_van { 0.03 } else { 0.08 };
        let rear_rise = d.height_m - d.roof_sag_m[1] - tail_z;
        let rear_header_x = (backlight_x + rear_rise / d.backlight_slope + 0.03).min(header_x - 0.5);
        let middle = 0.5 * (header_x + rear_header_x);
        let apex_x = (0.02 * d.length_m).clamp(middle - 0.2, middle + 0.35 * (header_x - rear_header_x));
        let mut house = Self {
            o,
            header_x,
            rear_header_x,
            apex_x,
            edge_drop: if d.is_van { 0.055 } else { 0.07 },
            bulge: if d.is_van { 0.010 } else { 0.018 },
            header_bow,
            posts: Vec::new(),
            b_pillar_x: 0.0,
        };
        house.place_posts(rear_glass);
        house
    }

    fn place_posts(&mut self, rear_glass: u8) {
        let (o, d) = (self.o, &self.o.d);
        let (foot, top) = (o.screen_foot_x, self.header_x);
        let (tail_foot, tail_top) = (o.backlight_foot_x, self.rear_header_x);
        let screen_sine = d.screen_slope / (1.0 + d.screen_slope * d.screen_slope).sqrt();
        let a_width = 0.055 / screen_sine;
        let wheelbase = d.axles_x[0] - d.axles_x[1];
        let paint = Cell::Pillar(slot::PAINT);
        let black = Cell::Pillar(slot::PLASTIC);
        let door_share = match d.windows {
            Windows::ThreeDoor => 0.62,
            _ if d.is_van => 0.42,
            _ => 0.56,
        };
        let b = d.axles_x[0] - wheelbase * door_share;
        // Behind the header, so that the lines up do not cross.
        let b = b.min(top - a_width - 0.10);
        self.b_pillar_x = b;
        let b_top = (b - 0.03).min(top - a_width - 0.05);
        let mut posts = vec![
            (foot, top, paint),
            (foot - a_width, top - a_width, Cell::Pane(slot::SIDE_GLASS)),
            (b + 0.05, b_top + 0.045, black),
            (b - 0.05, b_top - 0.045, Cell::Pane(rear_glass)),
        ];
        let slant = tail_foot - tail_top;
        if d.windows == Windows::PanelVan {
            posts[3].2 = paint;
        } else {
            let rear_width = if d.windows == Windows::Estate { 0.10 } else { 0.17 + 0.04 * d.backlight_slope };
            let steep = slant.abs() < 0.35;
            let (mut end, mut end_top) =
                (tail_foot + rear_width, tail_top + rear_width * if steep { 0.9 } else { 0.5 });
            if d.boot_m > 0.1 || d.backlight_slope < 0.6 {
                // A sloping C-pillar: the door's glass ends over the rear wheel.
                end = d.axles_x[1] + 0.10;
                end_top = (tail_top + 0.12).min(b_top - 0.25);
            }
            if d.windows == Windows::Estate && end < d.axles_x[1] - 0.05 {
                let c = d.axles_x[1] + 0.16;
                let c_top = (c - 0.06).max(end_top + 0.22);
                posts.push((c + 0.035, c_top + 0.03, black));
                posts.push((c - 0.035, c_top - 0.03, Cell::Pane(rear_glass)));
            }
            posts.push((end.min(b - 0.2), end_top.min(b_top - 0.2), paint));
        }
        posts.push((tail_foot, tail_top, paint));
        self.posts = posts;
    }

    /// The pane of the front door: x at foot and top, before and behind.
    pub fn front_pane(&self) -> [(f32, f32); 2] {
        [1, 2].map(|k| (self.posts[k].0, self.posts[k].1))
    }

    /// Height of the roof in the middle.
    pub fn roof_z(&self, x: f32) -> f32 {
        let d = &self.o.d;
        let (end, sag) = if x > self.apex_x {
            (self.header_x + self.header_bow, d.roof_sag_m[0])
        } else {
            (self.rear_header_x, d.roof_sag_m[1])
        };
        let t = (x - self.apex_x) / (end - self.apex_x);
        // Flat in the middle, as real roofs are for a meter.
        d.height_m - sag * t * t * t.abs()
    }

    fn drop(&self, t: f32) -> f32 {
        let t2 = t * t;
        let t8 = t2 * t2 * t2 * t2;
        self.edge_drop * (0.45 * t2 + 0.55 * t8)
    }

    /// The roof's edge at the side.
    pub fn cant(&self, x: f32) -> Vec3 {
        let d = &self.o.d;
        let z = self.roof_z(x) - self.edge_drop;
        let (end, narrowing) = if x > self.apex_x {
            (self.header_x, 0.035)
        } else {
            (self.rear_header_x, if d.is_van { 0.01 } else { 0.03 })
        };
        let t = ((x - self.apex_x) / (end - self.apex_x)).clamp(0.0, 1.2);
        // Over the foot line's own place: where the tail narrows, the roof does.
        let along = ((x - self.rear_header_x) / (self.header_x - self.rear_header_x)).clamp(0.0, 1.0);
        let (o, middle) = (self.o, 0.0);
        let foot_x = o.backlight_foot_x + (o.screen_foot_x - o.backlight_foot_x) * along;
        let foot = o.edge_y(foot_x).min(o.half_width(middle, 1.0)) - 0.018;
        Vec3::new(x, foot - (z - d.belt_z) * d.tumblehome_tangent - narrowing * t * t, z)
    }

    /// A point of the roof, lateral fraction.
    pub fn roof(&self, x: f32, t: f32) -> Vec3 {
        let edge = self.cant(x);
        // Headers bow outward in plan.
        let front = ((x - self.apex_x) / (self.header_x - self.apex_x)).max(0.0);
        let rear = ((self.apex_x - x) / (self.apex_x - self.rear_header_x)).max(0.0);
        let bow = self.header_bow * front * front - 0.03 * rear * rear;
        let bowed = x + bow * (1.0 - t * t);
        Vec3::new(bowed, edge.y * t, self.roof_z(x) - self.drop(t))
    }

    /// A point of the side above the belt line, by the ends of a line and a height fraction.
    pub fn side(&self, foot_x: f32, top_x: f32, v: f32) -> Vec3 {
        let p = self.o.glass_foot(foot_x).lerp(self.cant(top_x), v);
        p + Vec3::Y * (self.bulge * 4.0 * v * (1.0 - v))
    }

    /// A point of windscreen or backlight, lateral fraction and height fraction.
    pub fn screen(&self, is_front: bool, t: f32, v: f32) -> Vec3 {
        let o = self.o;
        let (foot_x, bow, top_x) = if is_front {
            (o.screen_foot_x, o.d.cowl_x - o.screen_foot_x, self.header_x)
        } else {
            (o.backlight_foot_x, if o.d.is_van { -0.03 } else { -0.08 }, self.rear_header_x)
        };
        let corner = o.glass_foot(foot_x);
        let (x, y) = (foot_x + bow * (1.0 - t * t), corner.y * t);
        let foot_z = if t == 1.0 { corner.z } else { o.deck_z(x, y).min(corner.z + 0.12) - 0.004 };
        let (foot, top) = (Vec3::new(x, y, foot_z), self.roof(top_x, t));
        let arc = 4.0 * v * (1.0 - v);
        let along = (top - foot).normalize();
        let normal = Vec3::new(along.z, 0.0, -along.x) * if is_front { 1.0 } else { -1.0 };
        let normal = if normal.z < 0.0 { -normal } else { normal };
        foot.lerp(top, v) + Vec3::Y * (t * self.bulge * arc) + normal * (0.02 * arc * (1.0 - t * t))
    }

    /// Adds roof, pillars and panes.
    pub fn add(&self, surface: &mut Surface, level: usize, has_sunroof: bool) {
        let rows: &[f32] =
            [&[0.0, 0.05, 0.22, 0.45, 0.70, 0.91, 1.0][..], &[0.0, 0.05, 0.5, 0.91, 1.0], &[0.0, 0.05, 0.91, 1.0]]
                [level];
        let lateral: &[f32] = [&[0.0, 0.3, 0.6, 0.8, 0.93, 1.0][..], &[0.0, 0.45, 0.93, 1.0], &[0.0, 0.93, 1.0]][level];
        let rise = self.o.d.height_m - self.edge_drop - self.o.d.belt_z;
        self.add_sides(surface, &capped(rows, SIDE_PANES_TO_M / rise), level);
        self.add_roof(surface, lateral, level, has_sunroof);
        self.add_screen(surface, &capped(rows, SCREEN_TO_M / rise), lateral, true);
        self.add_screen(surface, &capped(rows, SIDE_PANES_TO_M / rise), lateral, false);
    }

    fn add_sides(&self, surface: &mut Surface, rows: &[f32], level: usize) {
        let middle = Vec3::new(0.0, 0.0, self.o.d.belt_z);
        let outward = Outward::From(middle);
        let splits = [3, 2, 1][level];
        let last = rows.len() - 2;
        let lines = self.lines(splits);
        let frame = grid(&lines, rows, |(foot, top, _), v| self.side(*foot, *top, *v));
        surface.pair(&frame, outward, |i, j| match lines[i].2 {
            Cell::Pillar(s) => Some(s),
            Cell::Pane(_) if j == 0 => Some(slot::PLASTIC),
            Cell::Pane(_) if j == last => Some(slot::PAINT),
            Cell::Pane(_) => None,
        });
        for pair in self.posts.windows(2) {
            let Cell::Pane(glass) = pair[0].2 else { continue };
            let pane = grid(0..=splits, &overlapping(rows), |k, v| {
                let t = lerp(-0.02, 1.02, k as f64 / splits as f64) as f32;
                let (f, top) = (pair[0].0 + (pair[1].0 - pair[0].0) * t, pair[0].1 + (pair[1].1 - pair[0].1) * t);
                self.side(f, top, *v) - Vec3::Y * PANE_INSET
            });
            surface.panel_pair(&pane, outward, glass);
        }
        // The ledge from the shell's edge to the glass foot.
        let shell_edge = |x: f32| Vec3::new(x, self.o.edge_y(x) - 0.001, self.o.top_z(x) - 0.001);
        let ledge: Vec<_> = lines.iter().map(|(x, ..)| [self.o.glass_foot(*x), shell_edge(*x)]).collect();
        surface.panel_pair(&ledge, Outward::Along(Vec3::Z), slot::PAINT);
    }

    /// The posts without the black ones between panes.
    pub fn outer_posts(&self) -> Vec<Post> {
        let black = Cell::Pillar(slot::PLASTIC);
        let is_between = |i: usize| {
            let is_pane = |i: usize| self.posts.get(i).is_some_and(|post| matches!(post.2, Cell::Pane(_)));
            (self.posts[i].2 == black && is_pane(i + 1)) || (i > 0 && self.posts[i - 1].2 == black && is_pane(i))
        };
        (0..self.posts.len()).filter(|i| !is_between(*i)).map(|i| self.posts[i]).collect()
    }

    /// The posts with the panes' inner lines between them.
    fn lines(&self, splits: usize) -> Vec<Post> {
        let mut lines = Vec::new();
        for pair in self.posts.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let is_wide = (a.0 - b.0).abs() > 0.3 || (a.1 - b.1).abs() > 0.3;
            let n = if is_wide { splits } else { 1 };
            for k in 0..n {
                let t = k as f32 / n as f32;
                lines.push((a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t, a.2));
            }
        }
        lines.extend(self.posts.last());
        lines
    }

    /// x of the roof's rows over some posts, from the front.
    pub fn roof_stations(&self, posts: &[Post]) -> Vec<f32> {
        let mut xs: Vec<f32> = posts.iter().map(|post| post.1).chain([self.apex_x]).collect();
        xs.sort_by(|a, b| b.total_cmp(a));
        xs.dedup();
        xs
    }

    fn add_roof(&self, surface: &mut Surface, lateral: &[f32], level: usize, has_sunroof: bool) {
        let xs = self.roof_stations(&self.lines([3, 2, 1][level]));
        let roof = grid(&xs, lateral, |x, t| self.roof(*x, *t));
        let front_of = self.header_x - 0.12;
        surface.pair(&roof, Outward::Along(Vec3::Z), |i, j| {
            let is_open = has_sunroof && xs[i] < front_of && xs[i + 1] > self.b_pillar_x - 0.15 && lateral[j + 1] < 0.7;
            Some(if is_open { slot::DARK_GLASS } else { slot::PAINT })
        });
        if level < 2 {
            let stations = [self.header_x - 0.05, self.apex_x, self.rear_header_x + 0.05];
            let lining = grid(stations, [0.0, 0.85], |x, t| self.roof(x, t) - Vec3::Z * 0.035);
            surface.panel_pair(&lining, Outward::Along(Vec3::NEG_Z), slot::CLOTH);
        }
    }

    fn add_screen(&self, surface: &mut Surface, rows: &[f32], lateral: &[f32], is_front: bool) {
        let mut s_rows = rows.to_vec();
        if !is_front {
            let n = s_rows.len();
            // Steep backlights end above the belt line, and under a spoiler.
            let (from, to) = if self.o.d.backlight_slope > 1.0 { (0.18, 0.84) } else { (0.11, 0.92) };
            (s_rows[1], s_rows[n - 2]) = (from, s_rows[n - 2].min(to));
        }
        let (border, last) = (lateral.len() - 2, rows.len() - 2);
        let frame = grid(lateral, &s_rows, |t, s| self.screen(is_front, *t, *s));
        let outward = Outward::Along(Vec3::new(if is_front { 1.0 } else { -1.0 }, 0.0, 0.3));
        let is_blind = !is_front && self.o.d.windows == Windows::PanelVan;
        surface.pair(&frame, outward, |i, j| match (i, j) {
            _ if is_blind => Some(slot::PAINT),
            (i, _) if i == border => Some(slot::PAINT),
            (_, 0) => Some(if is_front { slot::PLASTIC } else { slot::PAINT }),
            (_, j) if j == last => Some(if is_front && s_rows[last] > 0.85 { slot::PLASTIC } else { slot::PAINT }),
            _ => None,
        });
        if is_blind {
            return;
        }
        let inset = Vec3::new(if is_front { -0.7 } else { 0.7 }, 0.0, -0.7) * PANE_INSET;
        let pane = grid(&lateral[..=border], &overlapping(&s_rows), |t, s| {
            let t = if *t == lateral[border] { t + 0.015 } else { *t };
            self.screen(is_front, t, *s) + inset
        });
        let glass = if is_front { slot::SCREEN } else { slot::REAR_GLASS };
        surface.panel_pair(&pane, outward, glass);
    }

    /// A point of the backlight, lateral fraction and height fraction.
    pub fn on_backlight(&self, t: f32, v: f32) -> Vec3 {
        self.screen(false, t, v)
    }

    /// A point of the windscreen, lateral fraction and height fraction.
    pub fn on_screen(&self, t: f32, v: f32) -> Vec3 {
        self.screen(true, t, v)
    }
}
