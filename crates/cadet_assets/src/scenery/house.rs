//! Houses of a South German suburb, from the terrace to the block of flats.

use strum::{AsRefStr, VariantArray};

use super::draw::{CREASE_RAD, range};
use super::facade::{Curtain, Filling, Opening, WallShape, wall};
use super::materials::house_slot as slot;
use super::roof::{Pitched, flat};
use super::wall_plane::WallPlane;
use super::{Detail, Mesh};
use cadet_base::geometry::MeshBuilder;
use cadet_base::math::{Mat3, Vec3};
use cadet_base::rng::Stream;

/// What kind of house.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum HouseKind {
    /// A family's own house in its garden.
    Detached,
    /// Two halves under one roof.
    Semi,
    /// Four or five narrow houses in a row.
    Terrace,
    /// An old house on the sidewalk's line, its gable often to the street.
    Village,
    /// A tall block of the closed kind, on the sidewalk's line.
    Block,
    /// Two to four stories of flats with balconies.
    Flats,
}

/// The drawn measures of one house: x is its depth, y its width along the street.
#[derive(Debug, Clone)]
pub(super) struct HouseDesign {
    pub kind: HouseKind,
    pub depth_m: f32,
    pub width_m: f32,
    pub units: usize,
    pub stories: usize,
    pub story_height_m: f32,
    pub plinth_m: f32,
    pub eaves_m: f32,
    pub slope: f32,
    pub overhang_m: f32,
    pub gable_to_street: bool,
    pub hipped: bool,
    pub flat_roof: bool,
    pub num_dormers: usize,
    pub balconies: bool,
    window: (f32, f32),
    sashes: u8,
    seed: u64,
}

impl HouseDesign {
    /// Draws the measures of a variant.
    pub fn new(kind: HouseKind, variant: usize) -> Self {
        let s = &mut Stream::from_seed(kind.as_ref(), variant as u64);
        let (units, width_m, depth_m) = match kind {
            HouseKind::Detached => (1, range(s, 9.0, 12.5), range(s, 9.0, 12.0)),
            HouseKind::Semi => (2, 2.0 * range(s, 6.5, 8.5), range(s, 10.0, 12.0)),
            HouseKind::Terrace => {
                let n = 3 + s.below(3);
                (n, n as f32 * range(s, 5.6, 6.8), range(s, 10.0, 11.0))
            }
            HouseKind::Village => (1, range(s, 8.0, 11.5), range(s, 8.5, 11.0)),
            HouseKind::Block => (1, range(s, 12.0, 19.0), range(s, 12.0, 13.5)),
            HouseKind::Flats => (2 + s.below(2), range(s, 18.0, 32.0), range(s, 10.0, 12.0)),
        };
        let stories = match kind {
            HouseKind::Detached | HouseKind::Village => 1 + s.weighted(&[0.35, 0.65]),
            HouseKind::Semi | HouseKind::Terrace => 2,
            HouseKind::Block => 3 + s.below(2),
            HouseKind::Flats => 2 + s.below(3),
        };
        let story_height_m = if kind == HouseKind::Block { range(s, 3.2, 3.7) } else { range(s, 2.65, 2.85) };
        let plinth_m = match kind {
            HouseKind::Flats => range(s, 0.5, 0.9),
            // On the sidewalk's line there is no room for steps.
            HouseKind::Village | HouseKind::Block => range(s, 0.14, 0.19),
            _ => range(s, 0.25, 0.7),
        };
        let degrees = match kind {
            HouseKind::Detached | HouseKind::Semi => range(s, 33.0, 46.0),
            HouseKind::Terrace => range(s, 30.0, 40.0),
            HouseKind::Village => range(s, 44.0, 51.0),
            HouseKind::Block => range(s, 32.0, 42.0),
            HouseKind::Flats => range(s, 22.0, 30.0),
        };
        let gable_to_street = match kind {
            HouseKind::Detached => s.chance(0.3),
            HouseKind::Village => s.chance(0.6),
            _ => false,
        };
        let hipped = match kind {
            HouseKind::Detached => s.chance(0.22) && !gable_to_street,
            HouseKind::Block => s.chance(0.7),
            _ => false,
        };
        let flat_roof = kind == HouseKind::Flats && s.chance(0.4);
        let loft = match kind {
            // One story under a steep roof has a knee wall.
            HouseKind::Detached | HouseKind::Village if stories == 1 => range(s, 0.5, 1.1),
            _ => range(s, 0.15, 0.35),
        };
        let dormers = !gable_to_street && !hipped && !flat_roof && s.chance(0.4);
        Self {
            kind,
            depth_m,
            width_m,
            units,
            stories,
            story_height_m,
            plinth_m,
            eaves_m: plinth_m + stories as f32 * story_height_m + loft,
            slope: cadet_base::math::tanf(degrees.to_radians()),
            overhang_m: range(s, 0.3, 0.6),
            gable_to_street,
            hipped,
            flat_roof,
            num_dormers: if dormers { units.max(1 + s.below(2)) } else { 0 },
            balconies: kind == HouseKind::Flats && s.chance(0.75),
            window: (range(s, 0.95, 1.35), range(s, 1.2, 1.5)),
            sashes: 1 + u8::from(s.chance(0.6)),
            seed: s.next_u64(),
        }
    }

    /// Houses that open onto the sidewalk.
    fn on_sidewalk(&self) -> bool {
        matches!(self.kind, HouseKind::Village | HouseKind::Block)
    }

    /// The roof, its ridge along its own y.
    fn roof(&self) -> Pitched {
        let (length_m, span_m) =
            if self.gable_to_street { (self.depth_m, self.width_m) } else { (self.width_m, self.depth_m) };
        let Self { eaves_m, slope, overhang_m, hipped, .. } = *self;
        // Hips need the ridge along the longer side.
        Pitched { length_m, span_m, eaves_m, slope, overhang_m, hipped: hipped && length_m >= span_m }
    }

    /// The highest point of the walls and the roof.
    pub fn height(&self) -> f32 {
        if self.flat_roof { self.eaves_m + 0.3 } else { self.roof().ridge() + 0.3 }
    }

    /// Length of a side's wall; sides go round counter-clockwise from the front.
    fn side_width(&self, side: usize) -> f32 {
        if side.is_multiple_of(2) { self.width_m } else { self.depth_m }
    }

    /// Whether the roof's end is over a side.
    fn has_gable(&self, side: usize) -> bool {
        side.is_multiple_of(2) == self.gable_to_street
    }

    /// Height of the gables.
    fn rise(&self) -> f32 {
        let roof = self.roof();
        if self.flat_roof || roof.hipped { 0.0 } else { roof.ridge() - self.eaves_m }
    }

    /// The ways in at the front: from where to where along y.
    pub fn doorways(&self) -> Vec<[f32; 2]> {
        let along = |[u0, u1]: [f32; 2]| [u0 - self.width_m / 2.0, u1 - self.width_m / 2.0];
        self.openings(0).iter().filter_map(Opening::doorway).map(along).collect()
    }

    /// The openings of a side, the same for every level of detail: doors at the front, one a unit.
    fn openings(&self, side: usize) -> Vec<Opening> {
        let s = &mut Stream::from_seed("facade", self.seed ^ side as u64);
        let (width, doors) = (self.side_width(side), if side == 0 { self.units } else { 0 });
        let gable = self.has_gable(side).then(|| self.rise());
        let density = [0.95, 0.55, 0.85, 0.55][side];
        let (w, h) = self.window;
        let mut openings = Vec::new();
        let pitch = if self.kind == HouseKind::Block { 2.3 } else { 2.7 };
        let parts = doors.max(1);
        let part = width / parts as f32;
        let columns = ((part / pitch).round() as usize).max(1);
        let cell = part / columns as f32;
        let w = w.min(cell - 0.5);
        for unit in 0..parts {
            let door_column = if unit % 2 == 0 { columns - 1 } else { 0 };
            for column in 0..columns {
                let u = part * unit as f32 + cell * (column as f32 + 0.5);
                for story in 0..self.stories {
                    let floor = self.plinth_m + self.story_height_m * story as f32;
                    if doors > 0 && column == door_column && story == 0 {
                        let rect = [u - 0.55, u + 0.55, floor + 0.02, floor + 2.12];
                        openings.push(Opening { rect, filling: Filling::Door });
                    } else if s.chance(density) {
                        let rect = [u - w / 2.0, u + w / 2.0, floor + 0.9, floor + 0.9 + h];
                        openings.push(Opening { rect, filling: Filling::draw_window(self.sashes, s) });
                    }
                }
            }
        }
        if let Some(rise) = gable.filter(|r| *r > 2.6) {
            let u = width / 2.0;
            let half = (w / 2.0).min(0.55);
            let v = self.eaves_m + 0.25_f32.max(rise * 0.1);
            openings.push(Opening {
                rect: [u - half, u + half, v, v + 1.15],
                filling: Filling::draw_window(self.sashes, s),
            });
        }
        openings
    }

    /// Draws the house.
    pub fn mesh(&self, detail: Detail) -> Mesh {
        let mut b = MeshBuilder::new();
        let (x, y) = (self.depth_m / 2.0, self.width_m / 2.0);
        let roof = self.roof();
        for (i, (plane, width_m)) in WallPlane::around(self.depth_m, self.width_m).into_iter().enumerate() {
            let openings = self.openings(i);
            let mut shape = WallShape::level(width_m, self.plinth_m - 0.05, self.eaves_m, slot::WALL);
            shape.apex_m += if self.has_gable(i) { self.rise() } else { 0.0 };
            wall(&mut b, &plane, &shape, &openings, detail);
            if detail != Detail::Far {
                self.attach(&mut b, &plane, &openings, i == 0);
            }
        }
        let (foot_x, foot_y) = (x + 0.03, y + 0.03);
        b.cuboid(Vec3::new(-foot_x, -foot_y, -1.5), Vec3::new(foot_x, foot_y, self.plinth_m), slot::PLINTH);
        if self.flat_roof {
            flat(&mut b, x, y, self.eaves_m);
        } else {
            let mut top = MeshBuilder::new();
            roof.draw(&mut top, detail);
            let turned = Mat3::from_cols(-Vec3::Y, Vec3::X, Vec3::Z);
            b.append(&top, if self.gable_to_street { turned } else { Mat3::IDENTITY }, Vec3::ZERO);
            self.on_the_roof(&mut b, &roof, detail);
        }
        if detail != Detail::Far {
            self.downpipes(&mut b, &roof);
        }
        b.build(self.kind.as_ref(), CREASE_RAD)
    }

    /// Steps and canopies at doors, balconies.
    fn attach(&self, b: &mut MeshBuilder, plane: &WallPlane, openings: &[Opening], front: bool) {
        for o in openings.iter().filter(|o| o.filling == Filling::Door) {
            let u = (o.rect[0] + o.rect[1]) / 2.0;
            let steps = ((self.plinth_m / 0.17).ceil() as usize).max(1);
            for k in 0..steps {
                let out = 0.28 * (steps - k) as f32 + if self.on_sidewalk() { 0.0 } else { 0.35 };
                let top = self.plinth_m * (k + 1) as f32 / steps as f32;
                plane.block(b, [u - 0.8, u + 0.8, -0.6, top], -out, 0.0, slot::STONE);
            }
            if !self.on_sidewalk() {
                plane.block(b, [u - 0.9, u + 0.9, o.rect[3] + 0.18, o.rect[3] + 0.28], -0.9, 0.0, slot::METAL);
            }
        }
        if self.balconies && front {
            let pitch = self.width_m / self.units as f32;
            for unit in 0..self.units {
                for story in 1..self.stories {
                    let (u, v) = (pitch * (unit as f32 + 0.45), self.plinth_m + self.story_height_m * story as f32);
                    let (u0, u1) = (u - 1.6, u + 1.6);
                    plane.block(b, [u0, u1, v - 0.18, v], -1.3, 0.0, slot::STONE);
                    plane.block(b, [u0, u1, v + 0.08, v + 0.95], -1.3, -1.25, slot::SHUTTER);
                    for side in [[u0, u0 + 0.05], [u1 - 0.05, u1]] {
                        plane.block(b, [side[0], side[1], v + 0.08, v + 0.95], -1.25, 0.0, slot::SHUTTER);
                    }
                }
            }
        }
    }

    /// Chimneys and dormers.
    fn on_the_roof(&self, b: &mut MeshBuilder, roof: &Pitched, detail: Detail) {
        let mut s = Stream::from_seed("roof", self.seed);
        let chimneys = match self.kind {
            HouseKind::Terrace => self.units,
            HouseKind::Block | HouseKind::Flats | HouseKind::Semi => 2,
            _ => 1,
        };
        for k in 0..chimneys {
            let along = roof.length_m * ((k as f32 + range(&mut s, 0.3, 0.7)) / chimneys as f32 - 0.5);
            let along =
                if roof.hipped { along.clamp(-0.5, 0.5) * (roof.length_m - roof.span_m).max(0.1) } else { along };
            let across = range(&mut s, -0.8, 0.8);
            let at = if self.gable_to_street { Vec3::new(along, -across, 0.0) } else { Vec3::new(across, along, 0.0) };
            let (low, high) = (roof.ridge() - 1.2, roof.ridge() + 0.75);
            let middle = at + Vec3::Z * (low + high) / 2.0;
            b.block(middle, Vec3::new(0.5, 0.62, high - low), slot::CHIMNEY);
            if detail != Detail::Far {
                b.block(at + Vec3::Z * (high + 0.04), Vec3::new(0.6, 0.72, 0.08), slot::STONE);
                b.tube(&[(at + Vec3::Z * high, 0.1), (at + Vec3::Z * (high + 0.3), 0.1)], 6, slot::METAL);
            }
        }
        for k in 0..self.num_dormers {
            let y = self.width_m * ((k as f32 + 0.5) / self.num_dormers as f32 - 0.5);
            let x = roof.span_m / 2.0 * 0.62;
            let foot = roof.top_at(x) - 0.1;
            let top = (foot + 1.55).min(roof.ridge() - 0.2);
            if top - foot < 1.2 {
                continue;
            }
            let back = ((roof.ridge() + 0.16 - top) / roof.slope - 0.3).max(0.0);
            let half = 0.95;
            let plane = WallPlane { origin: Vec3::new(x, y - half, 0.0), u: Vec3::Y };
            let shape = WallShape::level(2.0 * half, foot - 0.4, top, slot::WALL);
            let rect = [half - 0.6, half + 0.6, foot + 0.15, top - 0.12];
            let filling = Filling::Window { sashes: 2, shutter: 0.0, curtain: Curtain::None };
            // Without a room behind its pane.
            let detail = if detail == Detail::Near { Detail::Mid } else { detail };
            wall(b, &plane, &shape, &[Opening { rect, filling }], detail);
            for s in [-1.0, 1.0] {
                let w = y + s * half;
                let [p, q, r] = [Vec3::new(x, w, foot - 0.4), Vec3::new(x, w, top), Vec3::new(back, w, top)];
                if s > 0.0 { b.triangle(p, r, q, slot::WOOD) } else { b.triangle(p, q, r, slot::WOOD) }
            }
            let low = Vec3::new(back - 0.3, y - half - 0.2, top);
            b.cuboid(low, Vec3::new(x + 0.25, y + half + 0.2, top + 0.13), slot::ROOF);
        }
    }

    fn downpipes(&self, b: &mut MeshBuilder, roof: &Pitched) {
        // Under the eaves, beside the corners.
        let (dx, dy) = if self.gable_to_street { (-0.25, 0.07) } else { (0.07, -0.25) };
        let (x, y) = (self.depth_m / 2.0 + dx, self.width_m / 2.0 + dy);
        let top = if self.flat_roof { self.eaves_m } else { roof.top_at(roof.span_m / 2.0 + roof.overhang_m) - 0.1 };
        for (px, py) in [(x, y), (x, -y), (-x, y), (-x, -y)] {
            b.tube(&[(Vec3::new(px, py, -0.3), 0.05), (Vec3::new(px, py, top), 0.05)], 5, slot::METAL);
        }
    }
}
