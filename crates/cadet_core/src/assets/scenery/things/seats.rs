//! A cafe's tables, chairs, and parasols.

use super::colors::slot;
use super::shapes::{ring, sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;

/// Height of a chair's seat.
pub const CHAIR_SEAT_M: f64 = 0.46;
/// Height of a bench's seat.
pub const BENCH_SEAT_M: f64 = 0.4575;
/// Height of the seat in a bus shelter.
pub const SHELTER_SEAT_M: f64 = 0.475;

/// Round or square, on one foot.
pub(super) fn table(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("cafe table", variant);
    let (half, high) = (within(s, (0.3, 0.4)), within(s, (0.71, 0.76)));
    let power = if s.chance(0.6) { 2.0 } else { 9.0 };
    let sides = detail.pick(16, 10, 6);
    let mut b = MeshBuilder::new();
    b.loft(&[ring((half, half), high - 0.03, sides, power), ring((half, half), high, sides, power)], slot::BODY, true);
    tube(&mut b, (v(0.0, 0.0, 0.0), 0.03), (v(0.0, 0.0, high - 0.02), 0.03), detail.pick(8, 5, 3), slot::METAL);
    b.loft(&[ring((0.2, 0.2), 0.0, 8, 2.0), ring((0.17, 0.17), 0.03, 8, 2.0)], slot::METAL, true);
    b.build("cafe table", CREASE_RAD)
}

/// Four legs, a seat, and a back at -x.
pub(super) fn chair(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("cafe chair", variant);
    let (half, back) = (within(s, (0.2, 0.225)), within(s, (0.78, 0.9)));
    let seat = CHAIR_SEAT_M as f32;
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, seat - 0.02), v(2.0 * half, 2.0 * half, 0.04), slot::BODY);
    let inset = half - 0.02;
    for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let top = if x < 0.0 { back } else { seat - 0.03 };
        block(&mut b, v(x * inset, y * inset, top / 2.0), v(0.028, 0.028, top), slot::METAL);
    }
    let slats = detail.pick(3, 2, 1);
    for k in 0..slats {
        let z = seat + 0.15 + (back - seat - 0.2) * (k as f32 + 0.5) / slats as f32;
        block(&mut b, v(-inset - 0.005, 0.0, z), v(0.02, 2.0 * half, (back - seat - 0.22) / slats as f32), slot::BODY);
    }
    b.build("cafe chair", CREASE_RAD)
}

/// Open, over a table.
pub(super) fn parasol(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("parasol", variant);
    let (half, high, low) = (within(s, (1.1, 1.5)), within(s, (2.4, 2.65)), within(s, (2.08, 2.2)));
    let sides = detail.pick(8, 8, 6);
    let power = 2.0;
    let mut b = MeshBuilder::new();
    let rings = [
        ring((half, half), low - 0.14, sides, power),
        ring((half * 0.995, half * 0.995), low, sides, power),
        ring((0.05, 0.05), high, sides, power),
        ring((0.05, 0.05), high - 0.04, sides, power),
        ring((half * 0.98, half * 0.98), low - 0.04, sides, power),
        ring((half * 0.985, half * 0.985), low - 0.14, sides, power),
        ring((half, half), low - 0.14, sides, power),
    ];
    b.loft(&rings, slot::BODY, false);
    tube(&mut b, (v(0.0, 0.0, 0.0), 0.025), (v(0.0, 0.0, high), 0.025), detail.pick(8, 5, 3), slot::METAL);
    b.loft(&[ring((0.28, 0.28), 0.0, 8, 2.0), ring((0.24, 0.24), 0.1, 8, 2.0)], slot::DARK, true);
    b.build("parasol", CREASE_RAD)
}
