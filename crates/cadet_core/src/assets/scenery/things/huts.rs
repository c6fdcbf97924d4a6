//! Small buildings: a transformer's house, a bus shelter, a shed, a carport.

use super::colors::slot;
use super::shapes::{prism_x, prism_y, sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;

/// Walls, a slab for a roof, steel doors with louvers.
pub(super) fn transformer(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("transformer", variant);
    let (d, w, h) = (within(s, (1.4, 2.8)), within(s, (1.9, 3.8)), within(s, (1.6, 2.7)));
    let doors = if w > 2.8 { 2 } else { 1 };
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, (h - 0.5) / 2.0), v(d - 0.16, w - 0.16, h + 0.3), slot::BODY);
    block(&mut b, v(0.0, 0.0, 0.0), v(d - 0.12, w - 0.12, 0.5), slot::METAL);
    let (x, t) = (d / 2.0, h - 0.2);
    prism_y(&mut b, &[(-x, t), (x, t), (x, t + 0.1), (0.0, h), (-x, t + 0.1)], (-w / 2.0, w / 2.0), slot::METAL);
    if detail == Detail::Far {
        return b.build("transformer", CREASE_RAD);
    }
    for k in 0..doors {
        let y = w * ((k as f32 + 0.5) / doors as f32 - 0.5);
        let (wide, high) = ((0.7 * w / doors as f32).min(1.5), h * 0.72);
        block(&mut b, v(x - 0.08, y, 0.25 + high / 2.0), v(0.06, wide, high), slot::ACCENT);
        let louvers = detail.pick(6, 2, 0);
        for i in 0..louvers {
            let z = 0.45 + 0.3 * high * (i as f32 / louvers as f32);
            block(&mut b, v(x - 0.05, y, z), v(0.025, 0.7 * wide, 0.02 + 0.06 / louvers as f32), slot::DARK);
        }
        block(&mut b, v(x - 0.045, y - 0.4 * wide, 0.25 + high * 0.5), v(0.02, 0.04, 0.15), slot::DARK);
        block(&mut b, v(x - 0.045, y + 0.2 * wide, 0.25 + high * 0.75), v(0.012, 0.2, 0.18), slot::POSTER);
    }
    b.build("transformer", CREASE_RAD)
}

/// A roof over a bench, glass behind and at the ends.
pub(super) fn bus_shelter(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("bus shelter", variant);
    let (d, w, h) = (within(s, (1.4, 1.8)), within(s, (3.0, 4.6)), within(s, (2.35, 2.6)));
    let has_poster = s.chance(0.7);
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0 - 0.1, w / 2.0 - 0.1);
    prism_y(
        &mut b,
        &[(-d / 2.0, h - 0.14), (d / 2.0, h - 0.1), (d / 2.0, h - 0.02), (-d / 2.0, h)],
        (-w / 2.0, w / 2.0),
        slot::BODY,
    );
    let bays = (w / 1.5).round();
    let sides = detail.pick(8, 5, 3);
    for k in 0..=bays as usize {
        let at = -y + 2.0 * y * k as f32 / bays;
        tube(&mut b, (v(-x, at, -0.2), 0.04), (v(-x, at, h - 0.1), 0.04), sides, slot::METAL);
    }
    for side in [-1.0_f32, 1.0] {
        tube(&mut b, (v(x, side * y, -0.2), 0.04), (v(x, side * y, h - 0.06), 0.04), sides, slot::METAL);
    }
    let (low, high) = (0.22, h - 0.3);
    for k in 0..bays as usize {
        let at = |k: usize| -y + 2.0 * y * k as f32 / bays;
        let (p, q) = (at(k) + 0.05, at(k + 1) - 0.05);
        b.quad(v(-x, p, low), v(-x, q, low), v(-x, q, high), v(-x, p, high), slot::GLASS);
    }
    for side in [-1.0_f32, 1.0] {
        if side > 0.0 && has_poster {
            block(&mut b, v(0.0, y, 1.12), v(1.16, 0.14, 1.86), slot::METAL);
            for face in [-0.065_f32, 0.065] {
                block(&mut b, v(0.0, y + face, 1.14), v(1.04, 0.02, 1.68), slot::POSTER);
                for (x, z, wide, high, paper) in [
                    (0.05, 0.72, 0.8, 0.4, slot::POSTER_TOO),
                    (-0.1, 1.35, 0.6, 0.62, slot::WHITE),
                    (0.2, 1.42, 0.34, 0.8, slot::ACCENT),
                    (0.0, 0.42, 0.9, 0.1, slot::DARK),
                ] {
                    block(&mut b, v(x, y + face * 1.08, z), v(wide, 0.02, high), paper);
                }
            }
        } else {
            let p = side * y;
            b.quad(v(-x + 0.05, p, low), v(x - 0.25, p, low), v(x - 0.25, p, high), v(-x + 0.05, p, high), slot::GLASS);
        }
    }
    let rails = [low - 0.02, high + 0.02];
    for z in rails {
        block(&mut b, v(-x, 0.0, z), v(0.04, 2.0 * y, 0.04), slot::METAL);
    }
    block(&mut b, v(-x + 0.28, -0.1 * w, 0.45), v(0.36, 0.55 * w, 0.05), slot::WOOD);
    if detail != Detail::Far {
        for k in [-0.3, 0.1] {
            block(&mut b, v(-x + 0.2, k * w, 0.2), v(0.3, 0.05, 0.46), slot::METAL);
        }
        block(&mut b, v(-x + 0.03, 0.3 * w, 1.4), v(0.03, 0.4, 0.7), slot::WHITE);
    }
    b.build("bus shelter", CREASE_RAD)
}

/// Of boards, with a gabled or a flat roof.
pub(super) fn shed(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("shed", variant);
    let (d, w, h) = (within(s, (1.6, 2.5)), within(s, (1.8, 3.1)), within(s, (1.95, 2.5)));
    let is_gabled = s.chance(0.6);
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0 - 0.12, w / 2.0 - 0.12);
    let eaves = if is_gabled { h - 0.45 } else { h - 0.2 };
    let top = if is_gabled { h - 0.06 } else { h - 0.08 };
    let walls = if is_gabled {
        vec![(-y, -0.2), (y, -0.2), (y, eaves), (0.0, top), (-y, eaves)]
    } else {
        vec![(-y, -0.2), (y, -0.2), (y, eaves), (-y, top)]
    };
    prism_x(&mut b, &walls, (-x, x), slot::BODY);
    let (out, x1) = (y + 0.12, d / 2.0);
    if is_gabled {
        let rise = (top - eaves) / y;
        let low = eaves - 0.12 * rise;
        let roof = [(-out, low), (0.0, top), (out, low), (out, low + 0.06), (0.0, h), (-out, low + 0.06)];
        prism_x(&mut b, &roof, (-x1, x1), slot::ACCENT);
    } else {
        let rise = (top - eaves) / (2.0 * y) * 0.12;
        let roof = [(-out, top + rise), (out, eaves - rise), (out, eaves - rise + 0.07), (-out, top + rise + 0.07)];
        prism_x(&mut b, &roof, (-x1, x1), slot::ACCENT);
    }
    if detail != Detail::Far {
        let wide = (1.5 * y).min(1.3);
        block(&mut b, v(x, 0.0, 0.05 + 0.43 * eaves), v(0.05, wide, 0.86 * eaves), slot::WOOD);
        block(&mut b, v(x + 0.02, 0.0, 0.05 + 0.43 * eaves), v(0.02, 0.03, 0.86 * eaves), slot::DARK);
        block(&mut b, v(0.0, y, 0.62 * eaves), v(0.6, 0.04, 0.45), slot::WHITE);
        block(&mut b, v(0.0, y + 0.005, 0.62 * eaves), v(0.52, 0.04, 0.37), slot::DARK);
    }
    b.build("shed", CREASE_RAD)
}

/// Six posts and a flat roof.
pub(super) fn carport(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("carport", variant);
    let (d, w, h) = (within(s, (4.7, 5.3)), within(s, (2.86, 2.98)), within(s, (2.3, 2.6)));
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0 - 0.3, w / 2.0 - 0.07);
    block(&mut b, v(0.0, 0.0, h - 0.08), v(d, w, 0.16), slot::ACCENT);
    for side in [-1.0_f32, 1.0] {
        block(&mut b, v(0.0, side * y, h - 0.24), v(d - 0.2, 0.1, 0.18), slot::WOOD);
        let posts = detail.pick(3, 3, 2);
        for k in 0..posts {
            let at = -x + 2.0 * x * k as f32 / (posts - 1) as f32;
            block(&mut b, v(at, side * y, (h - 0.5) / 2.0), v(0.11, 0.11, h), slot::WOOD);
        }
    }
    b.build("carport", CREASE_RAD)
}
