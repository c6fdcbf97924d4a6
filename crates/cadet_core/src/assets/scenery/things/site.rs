//! What lies and stands about where something is built.

use super::colors::slot;
use super::shapes::{sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, range, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;

fn pallet(b: &mut MeshBuilder, y: f32, z: f32, detail: Detail) {
    if detail != Detail::Near {
        block(b, v(0.0, y, z + 0.072), v(0.8, 1.2, 0.12), slot::WOOD);
        return;
    }
    for k in 0..5 {
        block(b, v(-0.34 + 0.17 * k as f32, y, z + 0.133), v(0.12, 1.2, 0.022), slot::WOOD);
    }
    for k in [-0.53, 0.0, 0.53] {
        block(b, v(0.0, y + k, z + 0.072), v(0.8, 0.1, 0.1), slot::WOOD);
        block(b, v(0.0, y + k, z + 0.011), v(0.8, 0.1, 0.022), slot::WOOD);
    }
}

/// One to three pallets beside each other: empty ones, bricks, something in foil, sacks, pipes.
pub(super) fn pallets(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("pallets", variant);
    let count = 1 + variant % 3;
    let mut b = MeshBuilder::new();
    for k in 0..count {
        let y = 1.26 * (k as f32 - (count - 1) as f32 / 2.0);
        match s.below(5) {
            0 => (0..3 + s.below(6)).for_each(|i| pallet(&mut b, y, 0.144 * i as f32, detail)),
            1 => {
                pallet(&mut b, y, 0.0, detail);
                let h = within(s, (0.5, 1.1));
                block(&mut b, v(0.0, y, 0.144 + h / 2.0), v(0.76, 1.14, h), slot::FILL);
            }
            2 => {
                pallet(&mut b, y, 0.0, detail);
                let h = within(s, (0.6, 1.3));
                block(&mut b, v(0.0, y, 0.144 + h / 2.0), v(0.78, 1.16, h), slot::WHITE);
                block(&mut b, v(0.0, y, 0.144 + h * 0.6), v(0.79, 0.5, h * 0.3), slot::POSTER);
            }
            3 => {
                pallet(&mut b, y, 0.0, detail);
                for layer in 0..3 + s.below(3) {
                    for half in [-0.29_f32, 0.29] {
                        let z = 0.144 + 0.13 * (layer as f32 + 0.5);
                        let (dx, dy) = (range(s, -0.02, 0.02), range(s, -0.02, 0.02));
                        block(&mut b, v(dx, y + half + dy, z), v(0.72, 0.54, 0.125), slot::ACCENT);
                    }
                }
            }
            _ => {
                pallet(&mut b, y, 0.0, detail);
                let sides = detail.pick(10, 6, 4);
                for (i, j) in (0..4).flat_map(|i| (0..3).map(move |j| (i, j))) {
                    let (x, z) = (-0.29 + 0.19 * i as f32, 0.25 + 0.19 * j as f32);
                    tube(&mut b, (v(x, y - 0.57, z), 0.09), (v(x, y + 0.57, z), 0.09), sides, slot::BODY);
                }
            }
        }
    }
    b.build("pallets", CREASE_RAD)
}

/// Striped boards on feet, a lamp at an end of some.
pub(super) fn barrier(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("barrier", variant);
    let (w, h) = (within(s, (1.4, 2.3)), within(s, (0.95, 1.1)));
    let mut b = MeshBuilder::new();
    let stripes = (w / 0.25).round();
    for k in 0..stripes as usize {
        let y = w * ((k as f32 + 0.5) / stripes - 0.5);
        let color = if k % 2 == 0 { slot::RED } else { slot::WHITE };
        for (z, high) in [(h - 0.125, 0.25), (0.35, 0.15)] {
            block(&mut b, v(0.0, y, z), v(0.03, w / stripes, high), color);
        }
    }
    for side in [-1.0_f32, 1.0] {
        let y = side * (w / 2.0 - 0.12);
        block(&mut b, v(-0.03, y, h / 2.0), v(0.04, 0.05, h), slot::METAL);
        block(&mut b, v(0.0, y, 0.05), v(0.5, 0.2, 0.1), slot::DARK);
    }
    if detail != Detail::Far && s.chance(0.6) {
        let y = w / 2.0 - 0.12;
        block(&mut b, v(-0.02, y, h + 0.1), v(0.1, 0.18, 0.22), slot::POSTER);
    }
    b.build("barrier", CREASE_RAD)
}
