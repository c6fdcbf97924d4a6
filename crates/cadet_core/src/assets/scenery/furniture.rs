//! Bins, cabinets, benches and the like.

use super::draw::{CREASE_RAD, block, path_tube, tube};
use super::materials::furniture_slot as slot;
use super::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::Vec3;

/// What kind of furniture; its front faces +x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum FurnitureKind {
    /// A two-wheeled 120 l bin.
    SmallBin,
    /// A two-wheeled 240 l bin.
    LargeBin,
    /// A gray distribution cabinet.
    Cabinet,
    /// A yellow post box on a foot.
    PostBox,
    /// A bench.
    Bench,
    /// Gate posts with a letter box.
    GatePost,
    /// A round planter or stone.
    Planter,
}

impl FurnitureKind {
    /// Every kind.
    pub const ALL: [Self; 7] =
        [Self::SmallBin, Self::LargeBin, Self::Cabinet, Self::PostBox, Self::Bench, Self::GatePost, Self::Planter];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SmallBin => "small-bin",
            Self::LargeBin => "large-bin",
            Self::Cabinet => "cabinet",
            Self::PostBox => "post-box",
            Self::Bench => "bench",
            Self::GatePost => "gate-post",
            Self::Planter => "planter",
        }
    }
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A wheeled bin of width, depth and height to the lid's hinge.
fn bin(b: &mut MeshBuilder, [w, d, h]: [f32; 3], detail: Detail) {
    let body_top = h - 0.09;
    let ring = |z: f32, k: f32| -> Vec<Vec3> {
        let (x, y) = (d / 2.0 * k, w / 2.0 * k);
        vec![v(-x, -y, z), v(x, -y, z), v(x, y, z), v(-x, y, z)]
    };
    b.loft(&[ring(0.08, 0.78), ring(body_top - 0.08, 0.92), ring(body_top, 1.0)], slot::BODY, true);
    // The lid slopes to the front; the handle sits at the back.
    let lid = |x0: f32, x1: f32, z0: f32, z1: f32| -> [Vec<Vec3>; 2] {
        let y = w / 2.0 + 0.01;
        [y, -y].map(|y| vec![v(x0, y, z0), v(x0, y, body_top), v(x1, y, body_top), v(x1, y, z1)])
    };
    b.loft(&lid(-d / 2.0 - 0.01, d / 2.0 + 0.02, h, h - 0.04), slot::ACCENT, true);
    if detail != Detail::Far {
        let x = -d / 2.0 - 0.06;
        tube(b, (v(x, -w * 0.4, h - 0.06), 0.015), (v(x, w * 0.4, h - 0.06), 0.015), 6, slot::DARK);
        for s in [-1.0, 1.0] {
            let y = s * w * 0.36;
            tube(b, (v(-d * 0.36, y - 0.025, 0.1), 0.1), (v(-d * 0.36, y + 0.025, 0.1), 0.1), 12, slot::DARK);
        }
    }
}

/// Draws one; variants differ in size where there is a range.
pub(super) fn mesh(kind: FurnitureKind, variant: usize, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::new();
    match kind {
        FurnitureKind::SmallBin => bin(&mut b, [0.48, 0.55, 0.94], detail),
        FurnitureKind::LargeBin => bin(&mut b, [0.58, 0.73, 1.07], detail),
        FurnitureKind::Cabinet => {
            let w = [0.6, 0.85, 1.25][variant % 3];
            block(&mut b, v(0.0, 0.0, 0.0), v(0.3, w - 0.06, 0.3), slot::DARK);
            block(&mut b, v(0.0, 0.0, 0.6), v(0.35, w, 0.94), slot::BODY);
            block(&mut b, v(0.0, 0.0, 1.09), v(0.41, w + 0.06, 0.05), slot::ACCENT);
            if detail == Detail::Near {
                for y in [-0.02, 0.02] {
                    block(&mut b, v(0.178, y * 1.5, 0.6), v(0.006, 0.02, 0.86), slot::DARK);
                }
            }
        }
        FurnitureKind::PostBox => {
            tube(&mut b, (v(0.0, 0.0, -0.3), 0.04), (v(0.0, 0.0, 0.9), 0.04), detail.pick(10, 6, 4), slot::DARK);
            block(&mut b, v(0.0, 0.0, 1.2), v(0.32, 0.42, 0.6), slot::ACCENT);
            block(&mut b, v(0.165, 0.0, 1.4), v(0.01, 0.3, 0.04), slot::DARK);
        }
        FurnitureKind::Bench => {
            for y in [-0.65, 0.65] {
                block(&mut b, v(0.0, y, 0.1), v(0.45, 0.07, 0.64), slot::DARK);
                block(&mut b, v(-0.22, y, 0.6), v(0.05, 0.07, 0.45), slot::DARK);
            }
            for k in 0..4 {
                block(&mut b, v(-0.16 + 0.12 * k as f32, 0.0, 0.44), v(0.1, 1.7, 0.035), slot::ACCENT);
            }
            for z in [0.6, 0.75] {
                block(&mut b, v(-0.185, 0.0, z), v(0.03, 1.7, 0.1), slot::ACCENT);
            }
        }
        FurnitureKind::GatePost => {
            block(&mut b, v(0.0, 0.0, 0.45), v(0.34, 0.34, 1.7), slot::BODY);
            block(&mut b, v(0.0, 0.0, 1.33), v(0.4, 0.4, 0.06), slot::ACCENT);
            if detail == Detail::Near {
                block(&mut b, v(0.18, 0.0, 1.0), v(0.04, 0.28, 0.2), slot::DARK);
            }
        }
        FurnitureKind::Planter => {
            let stations = [(-0.1, 0.28), (0.1, 0.32), (0.42, 0.38), (0.45, 0.34)].map(|(z, r)| (v(0.0, 0.0, z), r));
            path_tube(&mut b, &stations, detail.pick(14, 8, 5), slot::BODY);
            let stations = [(0.44, 0.33), (0.62, 0.3), (0.75, 0.12)].map(|(z, r)| (v(0.0, 0.0, z), r));
            path_tube(&mut b, &stations, detail.pick(10, 7, 5), slot::ACCENT);
        }
    }
    b.build(kind.name(), CREASE_RAD)
}
