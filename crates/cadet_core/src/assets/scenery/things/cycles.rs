//! Parked bicycles, and what they lean on.

use super::colors::slot;
use super::shapes::{hoop as ring_of, sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, path_tube, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, sinf};

/// A bicycle that leans a little on its stand; spokes are left out, since beam and eye pass between them.
pub(super) fn bicycle(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("bicycle", variant);
    let (wheel, wheelbase) = (within(s, (0.31, 0.35)), within(s, (1.02, 1.12)));
    let (bar, saddle) = (within(s, (1.0, 1.12)), within(s, (0.88, 1.0)));
    let is_low = s.chance(0.45);
    let (has_basket, has_rack, lean) = (s.chance(0.35), s.chance(0.75), within(s, (0.03, 0.13)));
    let (front, rear) = (v(wheelbase / 2.0, 0.0, wheel), v(-wheelbase / 2.0, 0.0, wheel));
    let pedals = v(-0.08, 0.0, 0.28);
    let (seat, head) = (v(-0.24, 0.0, saddle), v(wheelbase / 2.0 - 0.17, 0.0, 0.82));
    let mut b = MeshBuilder::new();
    let thick = detail.pick(0.018, 0.02, 0.028);
    let counts = detail.pick((22, 5), (12, 3), (8, 3));
    for hub in [front, rear] {
        ring_of(&mut b, hub, wheel - thick, thick, counts, slot::DARK);
        if detail != Detail::Far {
            tube(&mut b, (hub - Vec3::Y * 0.05, 0.03), (hub + Vec3::Y * 0.05, 0.03), 6, slot::METAL);
        }
    }
    let sides = detail.pick(6, 4, 3);
    let r = detail.pick(0.016, 0.018, 0.026);
    let mut strut = |from: Vec3, to: Vec3, slot: u8| tube(&mut b, (from, r), (to, r), sides, slot);
    strut(pedals, seat - (seat - pedals) * 0.08, slot::BODY);
    strut(pedals, head - v(0.02, 0.0, 0.12), slot::BODY);
    let top = if is_low { pedals.lerp(seat, 0.35) } else { pedals.lerp(seat, 0.72) };
    strut(top, head, slot::BODY);
    strut(front, head + v(-0.04, 0.0, 0.12), slot::BODY);
    strut(pedals, rear, slot::BODY);
    if detail != Detail::Far {
        strut(pedals.lerp(seat, 0.66), rear, slot::BODY);
    }
    let grip = v(head.x - 0.1, 0.0, bar);
    strut(head, grip, slot::METAL);
    strut(grip - Vec3::Y * 0.29, grip + Vec3::Y * 0.29, slot::DARK);
    block(&mut b, seat, v(0.26, 0.15, 0.06), slot::DARK);
    if detail != Detail::Far {
        // Chain guard, cranks, rack, mudguards.
        block(&mut b, v((pedals.x + rear.x) / 2.0, -0.05, (pedals.z + rear.z) / 2.0), v(0.5, 0.02, 0.09), slot::DARK);
        block(&mut b, pedals + v(0.09, -0.10, -0.08), v(0.2, 0.09, 0.025), slot::METAL);
        block(&mut b, pedals + v(-0.09, 0.10, 0.08), v(0.2, 0.09, 0.025), slot::METAL);
        if has_rack {
            block(&mut b, v(rear.x + 0.02, 0.0, 2.0 * wheel + 0.07), v(0.4, 0.13, 0.02), slot::METAL);
        }
        for (hub, from, to) in [(front, 0.6_f32, 2.3_f32), (rear, 0.9, 3.1)] {
            let arc = (0..5).map(|k| from + (to - from) * k as f32 / 4.0);
            let stations: Vec<_> = arc.map(|a| (hub + v(cosf(a), 0.0, sinf(a)) * (wheel + 0.03), 0.022)).collect();
            path_tube(&mut b, &stations, 4, slot::BODY);
        }
    }
    if has_basket {
        let at =
            if variant.is_multiple_of(2) { grip + v(0.22, 0.0, -0.14) } else { v(rear.x, 0.0, 2.0 * wheel + 0.22) };
        block(&mut b, at, v(0.32, 0.36, 0.26), slot::ACCENT);
    }
    // On its stand, about the line that the wheels touch.
    for p in b.positions_mut() {
        *p = v(
            p.x,
            p.y * cosf(lean) + p.z * sinf(lean) - 0.5 * sinf(lean),
            (p.z * cosf(lean) - p.y * sinf(lean)).max(0.0),
        );
    }
    b.build("bicycle", CREASE_RAD)
}

/// A bent tube, set into the ground.
pub(super) fn hoop(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("cycle hoop", variant);
    let (half, high) = (within(s, (0.28, 0.45)), within(s, (0.72, 0.9)));
    let mut b = MeshBuilder::new();
    let r = detail.pick(0.024, 0.026, 0.035);
    let bend = 0.12;
    let stations = [
        (-half, -0.2),
        (-half, high - bend),
        (-half + 0.3 * bend, high - 0.3 * bend),
        (-half + bend, high),
        (half - bend, high),
        (half - 0.3 * bend, high - 0.3 * bend),
        (half, high - bend),
        (half, -0.2),
    ];
    // Rings of one tube must not turn over where it comes down again: three straight pieces.
    let at = |k: usize| v(stations[k].0, 0.0, stations[k].1);
    for (from, to) in [(0, 1), (1, 3), (3, 4), (4, 6), (6, 7)] {
        tube(&mut b, (at(from), r), (at(to), r), detail.pick(8, 5, 3), slot::METAL);
    }
    b.build("cycle hoop", CREASE_RAD)
}
