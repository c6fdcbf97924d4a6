//! Ground floors with shops: glass fronts with goods behind them, doors, signs, awnings, and gateways to the court.

use super::super::Detail;
use super::super::draw::range;
use super::super::materials::house_slot as slot;
use super::super::wall_plane::WallPlane;
use super::{city_slot, lettering};
use cadet_base::geometry::MeshBuilder;
use cadet_base::rng::Stream;

/// Width of a shop's door, and how far it lies behind the front.
const DOOR_M: f32 = 1.05;
const DOOR_DEPTH_M: f32 = 0.4;
const BAR_M: f32 = 0.07;
/// Panes lie so deep, and the rooms behind them reach so far.
const PANE_DEPTH_M: f32 = 0.14;
const ROOM_DEPTH_M: f32 = 2.6;
const DOOR_HEIGHT_M: f32 = 2.25;

/// One shop: the hole in the wall, and what belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct Shop {
    /// Height of the wall below the panes.
    pub sill_m: f32,
    /// Where its door begins, from 0 at the left to 1 at the right end of what is left beside it.
    pub door_share: f32,
    pub has_awning: bool,
    pub has_hanging_sign: bool,
    pub seed: u64,
}

impl Shop {
    /// Draws a shop.
    pub fn draw(s: &mut Stream) -> Self {
        Self {
            sill_m: [0.35, 0.5, 0.7][s.below(3)],
            door_share: [0.0, 1.0, 0.5][s.weighted(&[0.4, 0.4, 0.2])],
            has_awning: s.chance(0.4),
            has_hanging_sign: s.chance(0.4),
            seed: s.next_u64(),
        }
    }

    /// Where its door is in the hole from `u0` to `u1`.
    pub fn doorway(&self, [u0, u1]: [f32; 2]) -> [f32; 2] {
        let door_u = u0 + (u1 - u0 - DOOR_M) * self.door_share;
        [door_u, door_u + DOOR_M]
    }

    /// Fills the hole [u0, u1, v0, v1].
    pub fn fill(&self, b: &mut MeshBuilder, plane: &WallPlane, rect: [f32; 4], detail: Detail) {
        let [u0, u1, v0, v1] = rect;
        let s = &mut Stream::from_seed("shop", self.seed);
        let (door, mut panes) = (self.doorway([u0, u1]), Vec::new());
        for [a, z] in [[u0, door[0]], [door[1], u1]] {
            if z - a > 0.3 {
                panes.push([a, z]);
            }
        }
        for pane in &panes {
            self.window(b, plane, [pane[0], pane[1], v0, v1], detail, s);
        }
        door_leaf(b, plane, [door[0], door[1], v0, v1], detail);
        if detail == Detail::Near {
            plane.sides(b, [u0 + 0.02, u1 - 0.02, v0, v1], DOOR_DEPTH_M + 0.04, ROOM_DEPTH_M, city_slot::INSIDE);
            plane.rect(b, [u0, u1, v0, v1], ROOM_DEPTH_M, city_slot::INSIDE);
            // Shelves along the back wall.
            let mut u = u0 + 0.3;
            while u + 1.3 < u1 {
                if s.chance(0.7) {
                    let goods = [city_slot::GOODS, city_slot::LIGHT_GOODS, slot::CURTAIN][s.below(3)];
                    let top = v0 + range(s, 1.1, 2.1);
                    plane.block(b, [u, u + 1.15, v0, top], ROOM_DEPTH_M - 0.4, ROOM_DEPTH_M, goods);
                }
                u += 1.4;
            }
        }
        self.signs(b, plane, rect, detail, s);
    }

    /// A glass front over its sill, goods behind it.
    fn window(&self, b: &mut MeshBuilder, plane: &WallPlane, rect: [f32; 4], detail: Detail, s: &mut Stream) {
        let [u0, u1, v0, v1] = rect;
        let sill = v0 + self.sill_m;
        plane.block(b, [u0, u1, v0, sill], 0.02, PANE_DEPTH_M + 0.3, city_slot::BASE);
        let count = ((u1 - u0) / 1.7).ceil().max(1.0) as usize;
        let step = (u1 - u0) / count as f32;
        let glass = if detail == Detail::Near { slot::GLASS } else { slot::DARK_GLASS };
        plane.rect(b, [u0, u1, sill, v1], PANE_DEPTH_M, glass);
        let (front, back) = (PANE_DEPTH_M - 0.05, PANE_DEPTH_M);
        for bar in [[u0, u1, sill, sill + BAR_M], [u0, u1, v1 - BAR_M, v1]] {
            plane.block(b, bar, front, back, slot::FRAME);
        }
        for k in 0..=count {
            let u = (u0 + step * k as f32 - BAR_M / 2.0).clamp(u0, u1 - BAR_M);
            plane.block(b, [u, u + BAR_M, sill, v1], front, back, slot::FRAME);
        }
        if detail != Detail::Near {
            return;
        }
        // The stage behind the glass, and what stands on it.
        let depth = PANE_DEPTH_M + 0.3;
        plane.rect(b, [u0, u1, v0, sill], depth + 0.5, city_slot::INSIDE);
        shelf(b, plane, [u0, u1], sill, [PANE_DEPTH_M + 0.02, depth + 0.5]);
        let mut u = u0 + 0.2;
        while u + 0.5 < u1 {
            let (width, height) = (range(s, 0.18, 0.5), range(s, 0.12, 0.75).min(v1 - sill - 0.4));
            if s.chance(0.75) {
                let goods = [city_slot::GOODS, city_slot::LIGHT_GOODS, city_slot::SIGN, city_slot::AWNING][s.below(4)];
                let near = depth - 0.15 + range(s, 0.0, 0.3);
                plane.block(b, [u, u + width, sill, sill + height], near, near + 0.25, goods);
            }
            u += width + range(s, 0.05, 0.35);
        }
        if s.chance(0.3) {
            let (u, v) = (u0 + (u1 - u0 - 0.5).max(0.0) * s.unit() as f32, sill + range(s, 0.3, 0.7));
            plane.rect(b, [u, u + 0.42_f32.min(u1 - u0), v, v + 0.6], PANE_DEPTH_M - 0.01, city_slot::LIGHT_GOODS);
        }
    }

    /// The board over it, a sign that stands out, an awning.
    fn signs(&self, b: &mut MeshBuilder, plane: &WallPlane, rect: [f32; 4], detail: Detail, s: &mut Stream) {
        let [u0, u1, _, v1] = rect;
        let board = [u0 - 0.1, u1 + 0.1, v1 + 0.06, v1 + 0.56];
        plane.block(b, board, -0.1, 0.0, city_slot::SIGN);
        let name = lettering::NAMES[s.below(lettering::NAMES.len())];
        let (is_striped, reach) = (s.chance(0.5), range(s, 0.9, 1.2));
        if detail == Detail::Near {
            lettering::write(b, plane, name, [u0 + 0.2, u1 - 0.2], [board[2] + 0.1, board[3] - 0.1], -0.1);
        }
        if self.has_hanging_sign {
            plane.block(b, [u0 - 0.1, u0, v1 + 0.7, v1 + 1.3], -0.85, 0.0, city_slot::SIGN);
            if detail == Detail::Near {
                let side = WallPlane { origin: plane.at(u0 - 0.1, 0.0, 0.0), u: plane.out() };
                lettering::write(b, &side, &name[..2], [0.15, 0.8], [v1 + 0.8, v1 + 1.2], 0.0);
                let side = WallPlane { origin: plane.at(u0, 0.0, -0.85), u: -plane.out() };
                lettering::write(b, &side, &name[..2], [0.1, 0.75], [v1 + 0.8, v1 + 1.2], 0.0);
            }
        }
        if self.has_awning {
            awning(b, plane, [u0, u1], v1 + 0.04, reach, is_striped && detail == Detail::Near);
        }
    }
}

/// A board at height `v`, seen from above and from below.
fn shelf(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1]: [f32; 2], v: f32, [front, back]: [f32; 2]) {
    let p = |u: f32, d: f32, v: f32| plane.at(u, v, d);
    b.quad(p(u0, front, v), p(u1, front, v), p(u1, back, v), p(u0, back, v), city_slot::LIGHT_GOODS);
    let low = v - 0.02;
    b.quad(p(u0, back, low), p(u1, back, low), p(u1, front, low), p(u0, front, low), city_slot::INSIDE);
}

/// A leaf of glass in a frame under a pane, in a niche.
fn door_leaf(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1, v0, v1]: [f32; 4], detail: Detail) {
    let top = (v0 + DOOR_HEIGHT_M).min(v1 - 0.15);
    let d = DOOR_DEPTH_M;
    plane.sides(b, [u0, u1, v0, v1], 0.0, d, slot::FRAME);
    let glass = if detail == Detail::Near { slot::GLASS } else { slot::DARK_GLASS };
    plane.rect(b, [u0, u1, top, v1], d, glass);
    let stile = 0.11;
    plane.rect(b, [u0 + stile, u1 - stile, v0 + 0.25, top - stile], d + 0.02, glass);
    for bar in [
        [u0, u0 + stile, v0, top],
        [u1 - stile, u1, v0, top],
        [u0 + stile, u1 - stile, v0, v0 + 0.25],
        [u0 + stile, u1 - stile, top - stile, top],
    ] {
        plane.block(b, bar, d - 0.03, d + 0.02, slot::DOOR);
    }
    if detail == Detail::Near {
        plane.block(b, [u1 - 0.15, u1 - 0.11, v0 + 0.8, v0 + 1.4], d - 0.09, d - 0.03, slot::METAL);
    }
}

/// Cloth on arms, `reach` over the sidewalk, with a valance.
fn awning(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1]: [f32; 2], v: f32, reach: f32, is_striped: bool) {
    let low = v - 0.42 * reach;
    let count = if is_striped { ((u1 - u0) / 0.35).round().max(1.0) as usize } else { 1 };
    for k in 0..count {
        let at = |k: usize| u0 + (u1 - u0) * k as f32 / count as f32;
        let (a, z) = (at(k), at(k + 1));
        let cloth = if k % 2 == 0 { city_slot::AWNING } else { city_slot::LIGHT_GOODS };
        // A strip between two edges, each by its height and how far it is out.
        let mut strip = |a: f32, z: f32, (v0, out0): (f32, f32), (v1, out1): (f32, f32)| {
            let p = |u: f32, v: f32, out: f32| plane.at(u, v, -out);
            b.quad(p(a, v0, out0), p(z, v0, out0), p(z, v1, out1), p(a, v1, out1), cloth);
        };
        strip(a, z, (low, reach), (v, 0.0));
        strip(a, z, (v - 0.02, 0.0), (low - 0.02, reach));
        strip(a, z, (low - 0.2, reach), (low, reach));
        strip(z, a, (low - 0.2, reach - 0.01), (low, reach - 0.01));
    }
}

/// Two wooden leaves of a gateway under a lintel.
pub(in super::super) fn gate(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1, v0, v1]: [f32; 4], detail: Detail) {
    let d = 0.55;
    plane.sides(b, [u0, u1, v0, v1], 0.0, d, city_slot::BASE);
    plane.rect(b, [u0, u1, v0, v1], d, slot::DOOR);
    if detail == Detail::Near {
        let half = (u1 - u0) / 2.0;
        for leaf in 0..2 {
            let a = u0 + half * leaf as f32;
            for (low, high) in [(0.12, 0.42), (0.46, 0.95)] {
                let (bottom, top) = (v0 + (v1 - v0) * low, v0 + (v1 - v0) * high);
                plane.block(b, [a + 0.15, a + half - 0.15, bottom, top], d - 0.05, d, slot::DOOR);
            }
        }
        plane.block(b, [u0 + half - 0.04, u0 + half + 0.04, v0, v1], d - 0.07, d, slot::DOOR);
    }
}
