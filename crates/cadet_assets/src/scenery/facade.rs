//! Walls with real openings: reveals, frames, panes and the dark rooms behind them.

use super::Detail;
use super::city::{Shop, fill_gate};
use super::materials::house_slot as slot;
use super::wall_plane::WallPlane;
use cadet_base::geometry::MeshBuilder;
use cadet_base::rng::Stream;

/// What fills an opening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Filling {
    /// A window of one or two sashes; `shutter` of its height is closed.
    Window { sashes: u8, shutter: f32, curtain: Curtain },
    /// A door leaf with a small pane.
    Door,
    /// An up-and-over garage door.
    GarageDoor,
    /// A gate of slats that rolls up.
    RollerGate,
    /// A shop's glass front with its door.
    Shop(Shop),
    /// The gateway to a court.
    Gate,
}

impl Filling {
    /// Draws a window of a home, its shutter and curtain.
    pub fn draw_window(sashes: u8, s: &mut Stream) -> Self {
        let shutter = if s.chance(0.25) { [0.3, 0.5, 1.0][s.below(3)] } else { 0.0 };
        Self::Window { sashes, shutter, curtain: Curtain::draw(s, 0.55) }
    }
}

impl Opening {
    /// Where along the wall people or cars go in, if they do.
    pub fn doorway(&self) -> Option<[f32; 2]> {
        let [u0, u1, ..] = self.rect;
        match self.filling {
            Filling::Door | Filling::Gate => Some([u0, u1]),
            Filling::Shop(shop) => Some(shop.doorway([u0, u1])),
            Filling::Window { .. } | Filling::GarageDoor | Filling::RollerGate => None,
        }
    }
}

/// What hangs behind a pane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Curtain {
    None,
    /// At both sides.
    Sides,
    /// A net before the whole window.
    Net,
}

impl Curtain {
    /// Draws one; `share` of the windows have some.
    pub fn draw(s: &mut Stream, share: f64) -> Self {
        match (s.chance(share), s.chance(NET_SHARE)) {
            (false, _) => Self::None,
            (true, false) => Self::Sides,
            (true, true) => Self::Net,
        }
    }

    /// The pane before it, in levels of detail without rooms.
    fn pane(self) -> u8 {
        if self == Self::Net { slot::NET_GLASS } else { slot::DARK_GLASS }
    }
}

/// A hole in a wall: [u0, u1, v0, v1] in the wall's plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Opening {
    pub rect: [f32; 4],
    pub filling: Filling,
}

/// The outline of a wall from `bottom_m` up to `eaves_m`, and on to a gable's `apex_m` in the middle (equal: none).
#[derive(Debug, Clone, Copy)]
pub(super) struct WallShape {
    pub width_m: f32,
    pub bottom_m: f32,
    pub eaves_m: f32,
    pub apex_m: f32,
    /// What the wall is made of.
    pub face: u8,
}

impl WallShape {
    /// A wall without a gable.
    pub fn level(width_m: f32, bottom_m: f32, top_m: f32, face: u8) -> Self {
        Self { width_m, bottom_m, eaves_m: top_m, apex_m: top_m, face }
    }
}

/// How deep window frames lie behind the wall's face.
pub(super) const REVEAL_M: f32 = 0.16;
const FRAME_M: f32 = 0.08;
/// What a frame holds, a pane or a leaf, lies so far behind its front.
const BEHIND_FRAME_M: f32 = 0.03;
const SASH_BAR_M: f32 = 0.1;
const ROOM_M: f32 = 1.2;
/// Of the windows with curtains, those with nets.
const NET_SHARE: f64 = 0.45;
const CURTAIN_DEPTH_M: f32 = 0.1;

fn breaks(values: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut values: Vec<f32> = values.collect();
    values.sort_by(f32::total_cmp);
    values.dedup();
    values
}

/// Draws a wall with its openings. Openings above the eaves lie in the gable.
pub(super) fn wall(b: &mut MeshBuilder, plane: &WallPlane, shape: &WallShape, openings: &[Opening], detail: Detail) {
    let cut: &[Opening] = if detail == Detail::Far { &[] } else { openings };
    let half = shape.width_m / 2.0;
    let gabled = shape.apex_m > shape.eaves_m;
    let across = cut.iter().flat_map(|o| [o.rect[0], o.rect[1]]);
    let us = breaks([0.0, shape.width_m].into_iter().chain(gabled.then_some(half)).chain(across));
    let low = |o: &&Opening| o.rect[3] <= shape.eaves_m;
    let up = cut.iter().filter(low).flat_map(|o| [o.rect[2], o.rect[3]]);
    let vs = breaks([shape.bottom_m, shape.eaves_m].into_iter().chain(up));
    let roofline = |u: f32| shape.eaves_m + (shape.apex_m - shape.eaves_m) * (1.0 - (u - half).abs() / half);
    for strip in us.windows(2) {
        let (u0, u1) = (strip[0], strip[1]);
        let inside = |o: &&Opening| o.rect[0] <= u0 && o.rect[1] >= u1;
        for row in vs.windows(2) {
            if !cut.iter().filter(inside).any(|o| o.rect[2] <= row[0] && o.rect[3] >= row[1]) {
                plane.rect(b, [u0, u1, row[0], row[1]], 0.0, shape.face);
            }
        }
        if gabled {
            let mut from = shape.eaves_m;
            if let Some(o) = cut.iter().filter(inside).find(|o| !low(o)) {
                plane.rect(b, [u0, u1, from, o.rect[2]], 0.0, shape.face);
                from = o.rect[3];
            }
            let top = [plane.at(u1, roofline(u1).max(from), 0.0), plane.at(u0, roofline(u0).max(from), 0.0)];
            b.quad(plane.at(u0, from, 0.0), plane.at(u1, from, 0.0), top[0], top[1], shape.face);
        }
    }
    for opening in openings {
        fill(b, plane, opening, shape.face, detail);
    }
}

fn fill(b: &mut MeshBuilder, plane: &WallPlane, opening: &Opening, face: u8, detail: Detail) {
    let [u0, u1, v0, v1] = opening.rect;
    if detail == Detail::Far {
        return fill_far(b, plane, opening);
    }
    match &opening.filling {
        Filling::Shop(shop) => return shop.fill(b, plane, opening.rect, detail),
        Filling::Gate => return fill_gate(b, plane, opening.rect, detail),
        _ => {}
    }
    let back = REVEAL_M + BEHIND_FRAME_M;
    let sides = match opening.filling {
        Filling::GarageDoor | Filling::RollerGate => 0.22,
        // Without inner edges a frame lies in the plane of what it holds, so that nothing shows between the two.
        _ if detail == Detail::Mid => back,
        _ => REVEAL_M,
    };
    plane.sides(b, opening.rect, 0.0, sides, face);
    match opening.filling {
        Filling::Shop(_) | Filling::Gate => {}
        Filling::GarageDoor => {
            let ribs = detail.pick(12, 1, 1);
            for i in 0..ribs {
                let edge = |k: usize| u0 + (u1 - u0) * k as f32 / ribs as f32;
                let depth = sides + if i % 2 == 0 { 0.0 } else { 0.02 };
                plane.rect(b, [edge(i), edge(i + 1), v0, v1], depth, slot::DOOR);
                if i > 0 {
                    let (front, back) = (sides, sides + 0.02);
                    // The step between two ribs, facing the recessed one.
                    let (a, z) = if i % 2 == 1 { (back, front) } else { (front, back) };
                    let e = edge(i);
                    let (p, q) = (plane.at(e, v0, a), plane.at(e, v0, z));
                    b.quad(p, q, plane.at(e, v1, z), plane.at(e, v1, a), slot::DOOR);
                }
            }
            if detail == Detail::Near {
                let (u, v) = ((u0 + u1) / 2.0, v0 + 1.0);
                plane.block(b, [u - 0.08, u + 0.08, v, v + 0.04], sides - 0.04, sides, slot::METAL);
            }
        }
        Filling::RollerGate => {
            plane.rect(b, opening.rect, sides, slot::DOOR);
            let slats = if detail == Detail::Near { ((v1 - v0) / 0.5) as usize } else { 0 };
            for k in 1..slats {
                let v = v0 + (v1 - v0) * k as f32 / slats as f32;
                plane.rect(b, [u0, u1, v - 0.02, v + 0.02], sides - 0.004, slot::METAL);
            }
        }
        Filling::Door => {
            frame(b, plane, opening.rect, sides, detail);
            plane.rect(b, [u0 + FRAME_M, u1 - FRAME_M, v0 + FRAME_M, v1 - FRAME_M], back, slot::DOOR);
            if detail == Detail::Near {
                let (u, v) = ((u0 + u1) / 2.0, v0 + 1.45);
                plane.block(b, [u - 0.16, u + 0.16, v, v + 0.38], back - 0.01, back, slot::FRAME);
                plane.rect(b, [u - 0.12, u + 0.12, v + 0.04, v + 0.34], sides + 0.015, slot::DARK_GLASS);
                let (hu, hv) = (u1 - FRAME_M - 0.12, v0 + 1.0);
                plane.block(b, [hu - 0.07, hu + 0.03, hv, hv + 0.03], sides - 0.04, back, slot::METAL);
            }
        }
        Filling::Window { sashes, shutter, curtain } => {
            frame(b, plane, opening.rect, sides, detail);
            let inner = [u0 + FRAME_M, u1 - FRAME_M, v0 + FRAME_M, v1 - FRAME_M];
            let glass = if detail == Detail::Near { slot::GLASS } else { curtain.pane() };
            plane.rect(b, inner, back, glass);
            if sashes > 1 {
                let (u, bar) = ((u0 + u1) / 2.0, SASH_BAR_M / 2.0);
                plane.rect(b, [u - bar, u + bar, inner[2], inner[3]], REVEAL_M, slot::FRAME);
            }
            let closed = v1 - (v1 - v0) * shutter;
            if shutter > 0.0 {
                plane.rect(b, [u0, u1, closed, v1], sides - 0.05, slot::SHUTTER);
            }
            if detail == Detail::Near {
                room(b, plane, inner, sides + 0.05, curtain);
                plane.block(b, [u0 - 0.04, u1 + 0.04, v0 - 0.04, v0], -0.06, sides, slot::STONE);
            }
        }
    }
}

/// Without a hole: what fills it lies just proud of the wall, panes before their frame.
fn fill_far(b: &mut MeshBuilder, plane: &WallPlane, opening: &Opening) {
    let [u0, u1, v0, v1] = opening.rect;
    match opening.filling {
        Filling::Window { sashes, shutter, curtain } => {
            plane.rect(b, opening.rect, -0.02, slot::FRAME);
            let (low, high) = (v0 + FRAME_M, v1 - FRAME_M);
            plane.rect(b, [u0 + FRAME_M, u1 - FRAME_M, low, high], -0.03, curtain.pane());
            if sashes > 1 {
                let (u, bar) = ((u0 + u1) / 2.0, SASH_BAR_M / 2.0);
                plane.rect(b, [u - bar, u + bar, low, high], -0.035, slot::FRAME);
            }
            if shutter > 0.0 {
                plane.rect(b, [u0, u1, v1 - (v1 - v0) * shutter, v1], -0.04, slot::SHUTTER);
            }
        }
        Filling::Shop(_) => plane.rect(b, opening.rect, -0.02, slot::DARK_GLASS),
        _ => plane.rect(b, opening.rect, -0.02, slot::DOOR),
    }
}

/// The frame: four bars with their inner edges.
fn frame(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1, v0, v1]: [f32; 4], depth: f32, detail: Detail) {
    let f = FRAME_M;
    for bar in [[u0, u1, v0, v0 + f], [u0, u1, v1 - f, v1], [u0, u0 + f, v0 + f, v1 - f], [u1 - f, u1, v0 + f, v1 - f]]
    {
        plane.rect(b, bar, depth, slot::FRAME);
    }
    if detail == Detail::Near {
        plane.sides(b, [u0 + f, u1 - f, v0 + f, v1 - f], depth, depth + BEHIND_FRAME_M, slot::FRAME);
    }
}

/// A shallow dark room behind a pane, and what hangs before it.
fn room(b: &mut MeshBuilder, plane: &WallPlane, [u0, u1, v0, v1]: [f32; 4], front: f32, curtain: Curtain) {
    if curtain == Curtain::Net {
        return plane.rect(b, [u0, u1, v0, v1], front + CURTAIN_DEPTH_M, slot::CURTAIN);
    }
    plane.sides(b, [u0, u1, v0, v1], front, front + ROOM_M, slot::ROOM);
    plane.rect(b, [u0, u1, v0, v1], front + ROOM_M, slot::ROOM);
    if curtain == Curtain::Sides {
        let w = (u1 - u0) * 0.3;
        plane.rect(b, [u0, u0 + w, v0, v1], front + CURTAIN_DEPTH_M, slot::CURTAIN);
        plane.rect(b, [u1 - w, u1, v0, v1], front + CURTAIN_DEPTH_M, slot::CURTAIN);
    }
}
