//! Things that are smaller than a person and stand at walls.

use super::colors::slot;
use super::shapes::{sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;

/// A cabinet on its foot, one to three doors wide.
pub(super) fn cabinet(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("network cabinet", variant);
    let (d, w, h) = (within(s, (0.28, 0.48)), within(s, (0.6, 1.75)), within(s, (0.95, 1.5)));
    let doors = (w / 0.6).round().max(1.0);
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, 0.0), v(d - 0.06, w - 0.06, 0.3), slot::METAL);
    block(&mut b, v(0.0, 0.0, 0.1 + (h - 0.15) / 2.0), v(d - 0.04, w - 0.04, h - 0.15), slot::BODY);
    block(&mut b, v(0.0, 0.0, h - 0.035), v(d, w, 0.07), slot::ACCENT);
    if detail == Detail::Near {
        for k in 0..doors as usize {
            let y = w * ((k as f32 + 0.5) / doors - 0.5);
            block(&mut b, v(d / 2.0 - 0.02, y, h * 0.5), v(0.02, 0.86 * w / doors, h * 0.7), slot::BODY);
            block(&mut b, v(d / 2.0 - 0.008, y + 0.3 * w / doors, h * 0.52), v(0.016, 0.03, 0.12), slot::DARK);
            block(&mut b, v(d / 2.0 - 0.008, y, h * 0.78), v(0.012, 0.4 * w / doors, 0.05), slot::DARK);
        }
    }
    b.build("network cabinet", CREASE_RAD)
}
