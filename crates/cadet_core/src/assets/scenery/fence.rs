//! Fences and garden walls, in pieces along x.

use super::draw::{CREASE_RAD, block, tube};
use super::materials::fence_slot as slot;
use super::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::Vec3;

/// What kind of fence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FenceKind {
    /// Wooden pickets on two rails.
    Picket,
    /// Iron bars on a low wall.
    Railing,
    /// A solid wall with a coping.
    Wall,
    /// Wooden boards without gaps.
    Screen,
    /// Posts and wires.
    Wire,
    /// A steel beam on posts, beside a main road; it faces -y.
    GuardRail,
}

impl FenceKind {
    /// Every kind.
    pub const ALL: [Self; 6] = [Self::Picket, Self::Railing, Self::Wall, Self::Screen, Self::Wire, Self::GuardRail];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Picket => "picket",
            Self::Railing => "railing",
            Self::Wall => "wall",
            Self::Screen => "screen",
            Self::Wire => "wire",
            Self::GuardRail => "guard-rail",
        }
    }

    /// True where the body is metal.
    #[must_use]
    pub fn is_metal(self) -> bool {
        matches!(self, Self::Railing | Self::Wire | Self::GuardRail)
    }

    /// Height above the ground.
    #[must_use]
    pub fn height_m(self, variant: usize) -> f64 {
        let tall = variant % 2 == 1;
        match (self, tall) {
            (Self::Picket, false) => 0.95,
            (Self::Picket, true) | (Self::Railing, false) => 1.15,
            (Self::Railing, true) | (Self::Wall, false) => 1.35,
            (Self::Wall, true) | (Self::Screen, false) => 1.75,
            (Self::Screen, true) => 1.95,
            (Self::GuardRail, _) => 0.75,
            (Self::Wire, false) => 1.0,
            (Self::Wire, true) => 1.4,
        }
    }
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A flat upright: a thin box near, two-sided cards farther off.
fn slat(b: &mut MeshBuilder, [x0, x1, z0, z1]: [f32; 4], thickness: f32, detail: Detail) {
    if detail == Detail::Near {
        b.cuboid(v(x0, -thickness / 2.0, z0), v(x1, thickness / 2.0, z1), slot::BODY);
    } else {
        b.quad(v(x0, 0.0, z0), v(x1, 0.0, z0), v(x1, 0.0, z1), v(x0, 0.0, z1), slot::BODY);
    }
}

/// Draws a piece from x = 0 to `length`; the middle of the fence is y = 0.
pub(super) fn mesh(kind: FenceKind, variant: usize, length: f32, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    let top = kind.height_m(variant) as f32;
    let posts = ((length / 2.4).ceil() as usize).max(1);
    let posts_seen = detail.pick(posts, posts, 1);
    let post_at = |i: usize| length * i as f32 / posts as f32;
    match kind {
        FenceKind::Picket => {
            // Far away fewer and wider ones, their share of gaps kept.
            let pitch = detail.pick(0.14, 0.14, 0.56);
            let count = (length / pitch).round().max(1.0);
            for i in 0..count as usize {
                let x = length * i as f32 / count;
                slat(&mut b, [x + pitch * 0.14, x + pitch * 0.78, 0.06, top], 0.02, detail);
            }
            for z in [0.25, top - 0.2] {
                b.cuboid(v(0.0, -0.05, z), v(length, -0.01, z + 0.08), slot::POST);
            }
            for i in 0..posts_seen {
                b.cuboid(v(post_at(i), -0.13, -0.4), v(post_at(i) + 0.09, -0.05, top - 0.05), slot::POST);
            }
        }
        FenceKind::Railing => {
            let plinth: f32 = if variant % 2 == 1 { 0.55 } else { 0.3 };
            b.cuboid(v(0.0, -0.12, -0.5), v(length, 0.12, plinth), slot::MASONRY);
            // Fewer and wider ones where a bar is thinner than half a pixel, so that it does not break into dashes; they
            // hide as much.
            let spacing = detail.pick(0.12, 0.24, 0.6);
            let half = 0.055 * spacing;
            let count = (length / spacing).round().max(1.0);
            for i in 0..count as usize {
                let x = length * (i as f32 + 0.5) / count;
                if detail == Detail::Near {
                    tube(&mut b, (v(x, 0.0, plinth), 0.009), (v(x, 0.0, top), 0.009), 4, slot::BODY);
                } else {
                    slat(&mut b, [x - half, x + half, plinth, top], 0.0, detail);
                }
            }
            let rail = detail.pick(0.03, 0.03, 0.04);
            for z in [plinth + 0.1, top - 0.05 - rail] {
                b.cuboid(v(0.0, -0.02, z), v(length, 0.02, z + rail), slot::POST);
            }
            b.cuboid(v(0.0, -0.03, plinth), v(0.06, 0.03, top + 0.04), slot::POST);
        }
        FenceKind::Wall => {
            b.cuboid(v(0.0, -0.12, -0.5), v(length, 0.12, top - 0.08), slot::MASONRY);
            b.cuboid(v(0.0, -0.17, top - 0.08), v(length, 0.17, top), slot::MASONRY);
            block(&mut b, v(0.17, 0.0, top / 2.0), v(0.34, 0.4, top + 0.12), slot::MASONRY);
        }
        FenceKind::Screen => {
            let spacing = detail.pick(0.15, 0.15, length);
            let count = (length / spacing).round().max(1.0);
            for i in 0..count as usize {
                let (x0, x1) = (length * i as f32 / count, length * (i + 1) as f32 / count);
                let y = if i % 2 == 0 { 0.0 } else { 0.02 };
                b.cuboid(v(x0, y - 0.01, 0.03), v(x1, y + 0.01, top), slot::BODY);
            }
            for i in 0..posts_seen {
                b.cuboid(v(post_at(i), -0.1, -0.4), v(post_at(i) + 0.09, -0.01, top + 0.03), slot::POST);
            }
        }
        FenceKind::GuardRail => {
            // Two waves, the sheet as thick as what it hides.
            let sheet =
                [(0.0, 0.0), (-0.08, 0.04), (-0.08, 0.12), (-0.01, 0.155), (-0.08, 0.19), (-0.08, 0.27), (0.0, 0.31)];
            let outline: Vec<Vec3> = match detail {
                Detail::Far => {
                    [(-0.06, 0.0), (0.01, 0.0), (0.01, 0.31), (-0.06, 0.31)].map(|(y, z)| v(0.0, y, z)).to_vec()
                }
                _ => sheet.iter().chain(&[(0.012, 0.31), (0.012, 0.0)]).map(|(y, z)| v(0.0, *y, *z)).rev().collect(),
            };
            let low = top - 0.31;
            let rings = [0.0, length].map(|x| outline.iter().map(|p| v(x, p.y, low + p.z)).collect::<Vec<_>>());
            b.loft(&rings, slot::BODY, true);
            for i in 0..posts_seen {
                let x = post_at(i) + 0.4;
                b.cuboid(v(x, 0.012, -0.4), v(x + 0.1, 0.09, top - 0.04), slot::POST);
            }
        }
        FenceKind::Wire => {
            for i in 0..posts {
                tube(
                    &mut b,
                    (v(post_at(i), 0.0, -0.4), 0.025),
                    (v(post_at(i), 0.0, top), 0.025),
                    detail.pick(6, 4, 3),
                    slot::POST,
                );
            }
            // Of the near mesh's wires so many are left as are half a pixel wide, and they hide as much as all did.
            let (wires, radius) = detail.pick((7, 0.002), (3, 0.007), (1, 0.021));
            for k in 0..wires {
                let z = top - 0.04 - (top - 0.12) * k as f32 / wires as f32;
                tube(&mut b, (v(0.0, 0.0, z), radius), (v(length, 0.0, z), radius), 3, slot::BODY);
            }
            if detail == Detail::Near {
                let count = (length / 0.25).round().max(1.0);
                for i in 0..count as usize {
                    let x = length * (i as f32 + 0.5) / count;
                    tube(&mut b, (v(x, 0.0, 0.05), 0.002), (v(x, 0.0, top), 0.002), 3, slot::BODY);
                }
            }
        }
    }
    b.build(kind.name(), CREASE_RAD)
}
