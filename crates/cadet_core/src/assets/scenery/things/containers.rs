//! Containers for waste, bottles, clothes, rubble, and a site's tools.

use super::colors::slot;
use super::shapes::{prism_y, ring, sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{cosf, sinf};

/// On four casters, its lid rounded.
pub(super) fn large(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("large container", variant);
    let (w, d, h) = (within(s, (1.2, 1.38)), within(s, (0.75, 1.07)), within(s, (1.15, 1.42)));
    let is_round = s.chance(0.6);
    let mut b = MeshBuilder::new();
    let body_top = h * if is_round { 0.72 } else { 0.9 };
    let rim = |k: f32, z: f32| {
        let (x, y) = (d / 2.0 * k, w / 2.0 * k);
        vec![v(-x, -y, z), v(x, -y, z), v(x, y, z), v(-x, y, z)]
    };
    let foot = if detail == Detail::Far { 0.03 } else { 0.2 };
    b.loft(&[rim(0.84, foot), rim(0.88, 0.3), rim(1.0, body_top)], slot::BODY, true);
    let steps = if is_round { detail.pick(9, 5, 3) } else { 2 };
    let mut lid: Vec<(f32, f32)> = vec![(-d / 2.0, body_top), (d / 2.0, body_top)];
    if is_round {
        lid.extend((0..steps).map(|k| {
            let a = std::f32::consts::PI * (k as f32 + 0.5) / steps as f32;
            (d / 2.0 * cosf(a), body_top + 0.02 + (h - body_top - 0.02) * sinf(a))
        }));
    } else {
        lid.extend([(d / 2.0, h - 0.06), (-d / 2.0, h)]);
    }
    prism_y(&mut b, &lid, (-w / 2.0, w / 2.0), slot::ACCENT);
    if detail == Detail::Far {
        return b.build("large container", CREASE_RAD);
    }
    for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let (x, y) = (x * d * 0.34, y * w * 0.36);
        tube(&mut b, (v(x, y - 0.025, 0.1), 0.1), (v(x, y + 0.025, 0.1), 0.1), detail.pick(10, 6, 4), slot::DARK);
        block(&mut b, v(x, y, 0.19), v(0.1, 0.08, 0.06), slot::METAL);
    }
    for y in [-w / 2.0 + 0.012, w / 2.0 - 0.012] {
        block(&mut b, v(0.0, y, body_top - 0.1), v(d * 0.5, 0.02, 0.05), slot::DARK);
    }
    b.build("large container", CREASE_RAD)
}

/// A dome or a box with holes.
pub(super) fn glass_bank(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("glass bank", variant);
    let (d, w, h) = (within(s, (1.1, 1.5)), within(s, (1.2, 1.7)), within(s, (1.4, 1.75)));
    let is_dome = s.chance(0.5);
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0, w / 2.0);
    if is_dome {
        let sides = detail.pick(18, 10, 6);
        let parts = [(0.82, 0.0), (0.97, 0.18), (1.0, 0.35), (0.96, 0.6), (0.82, 0.8), (0.55, 0.94), (0.2, 1.0)];
        let rings: Vec<_> = parts.iter().map(|(k, z)| ring((x * k, y * k), h * z, sides, 2.6)).collect();
        b.loft(&rings, slot::BODY, true);
        for side in [-1.0, 1.0] {
            let (from, to) = (v(side * x * 0.90, 0.0, h * 0.66), v(side * x * 0.995, 0.0, h * 0.66));
            let (low, high) = if side > 0.0 { (from, to) } else { (to, from) };
            tube(&mut b, (low, 0.11), (high, 0.11), detail.pick(12, 8, 5), slot::DARK);
        }
    } else {
        let rings =
            [(0.97, 0.03), (1.0, 0.1), (1.0, h - 0.12), (0.93, h)].map(|(k, z)| ring((x * k, y * k), z, 12, 9.0));
        b.loft(&rings, slot::BODY, true);
        for k in 0..3 {
            let at = v(x - 0.03, y * (k as f32 - 1.0) * 0.55, h * 0.72);
            tube(&mut b, (at, 0.10), (at + v(0.03, 0.0, 0.0), 0.10), detail.pick(12, 8, 5), slot::DARK);
        }
    }
    if detail != Detail::Far {
        // What it is lifted by, and its label.
        block(&mut b, v(0.0, 0.0, h - 0.02), v(0.12, 0.3, 0.04), slot::METAL);
        if !is_dome {
            block(&mut b, v(x - 0.012, 0.0, h * 0.38), v(0.024, w * 0.5, h * 0.3), slot::WHITE);
        }
    }
    b.build("glass bank", CREASE_RAD)
}

/// A box with a slanted roof and a flap.
pub(super) fn clothes_bank(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("clothes bank", variant);
    let (d, w, h) = (within(s, (1.0, 1.2)), within(s, (1.05, 1.2)), within(s, (1.75, 2.2)));
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0, w / 2.0);
    prism_y(&mut b, &[(-x, 0.0), (x - 0.03, 0.0), (x - 0.03, h * 0.86), (-x, h)], (-y, y), slot::BODY);
    if detail != Detail::Far {
        block(&mut b, v(x - 0.02, 0.0, h * 0.72), v(0.04, w * 0.72, h * 0.16), slot::DARK);
        block(&mut b, v(x - 0.02, 0.0, h * 0.40), v(0.03, w * 0.7, h * 0.3), slot::POSTER);
        block(&mut b, v(x - 0.025, 0.0, h * 0.60), v(0.05, w * 0.5, 0.03), slot::METAL);
    }
    b.build("clothes bank", CREASE_RAD)
}

/// Open, its ends sloping, half full.
pub(super) fn skip(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("skip", variant);
    let (d, w, h) = (within(s, (1.55, 1.85)), within(s, (2.8, 4.2)), within(s, (1.05, 1.6)));
    let full = within(s, (0.55, 1.05));
    let (x, y) = (d / 2.0 - 0.06, w / 2.0);
    let mut b = MeshBuilder::new();
    let lean = within(s, (0.3, 0.65));
    let edge = |z: f32| y - lean * (1.0 - z / h);
    let frustum = |b: &mut MeshBuilder, (z0, z1): (f32, f32), (x0, x1): (f32, f32), slot: u8| {
        super::shapes::prism_x(b, &[(-edge(z0), z0), (edge(z0), z0), (edge(z1), z1), (-edge(z1), z1)], (x0, x1), slot);
    };
    // A solid foot up to half the height, and four walls on it.
    let floor = h * 0.5;
    frustum(&mut b, (0.0, floor), (-x, x), slot::BODY);
    for side in [-1.0_f32, 1.0] {
        frustum(&mut b, (floor, h), (side * x - 0.03, side * x + 0.03), slot::BODY);
        let outline = [(edge(floor) - 0.06, floor), (edge(floor), floor), (edge(h), h), (edge(h) - 0.06, h)];
        let mut outline = outline.map(|(a, z)| (side * a, z));
        if side < 0.0 {
            outline.reverse();
        }
        super::shapes::prism_x(&mut b, &outline, (-x, x), slot::BODY);
    }
    // What lies in it.
    let top = floor + (h - floor) * full;
    let inner = (x - 0.03, edge(floor) - 0.03);
    let sides = detail.pick(14, 10, 6);
    let rings = [
        ring(inner, floor - 0.05, sides, 6.0),
        ring((inner.0, inner.1 + 0.5 * (edge(top) - edge(floor))), (floor + top) / 2.0, sides, 5.0),
        ring((inner.0 * 0.55, inner.1 * 0.5), top, sides, 2.2),
    ];
    b.loft(&rings, slot::FILL, true);
    if detail != Detail::Far {
        for side in [-1.0_f32, 1.0] {
            block(&mut b, v(side * (x + 0.03), 0.0, h - 0.05), v(0.06, 2.0 * edge(h) - 0.1, 0.1), slot::BODY);
            for k in [-0.55_f32, -0.18, 0.18, 0.55] {
                block(&mut b, v(side * (x + 0.02), k * w * 0.8, h * 0.52), v(0.05, 0.08, h * 0.8), slot::BODY);
            }
            block(&mut b, v(side * (x + 0.03), edge(h) * 0.6, h * 0.62), v(0.06, 0.14, 0.14), slot::METAL);
        }
    }
    b.build("skip", CREASE_RAD)
}

/// Of corrugated sheet, with a door; some have a window.
pub(super) fn site_container(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("site container", variant);
    let (d, w, h) = (within(s, (2.1, 2.44)), within(s, (2.9, 6.05)), within(s, (2.25, 2.6)));
    let has_window = s.chance(0.45);
    let mut b = MeshBuilder::new();
    let (x, y) = (d / 2.0 - 0.03, w / 2.0 - 0.03);
    block(&mut b, v(0.0, 0.0, 0.0), v(d - 0.3, w - 0.3, 0.3), slot::DARK);
    block(&mut b, v(0.0, 0.0, h / 2.0), v(2.0 * x - 0.06, 2.0 * y - 0.06, h - 0.24), slot::BODY);
    if detail == Detail::Near {
        // Corrugated: ribs all round.
        for (length, across, is_long) in [(2.0 * y, x, true), (2.0 * x, y, false)] {
            let count = (length / 0.28).floor().max(2.0);
            for k in 0..count as usize {
                let at = length * ((k as f32 + 0.5) / count - 0.5);
                for side in [-1.0_f32, 1.0] {
                    let out = side * (across - 0.02);
                    let wide = 0.55 * length / count;
                    let (middle, size) = if is_long {
                        (v(out, at, h / 2.0), v(0.04, wide, h - 0.24))
                    } else {
                        (v(at, out, h / 2.0), v(wide, 0.04, h - 0.24))
                    };
                    block(&mut b, middle, size, slot::BODY);
                }
            }
        }
    }
    block(&mut b, v(0.0, 0.0, 0.13), v(d, w, 0.14), slot::BODY);
    block(&mut b, v(0.0, 0.0, h - 0.07), v(d, w, 0.14), slot::BODY);
    if detail != Detail::Far {
        for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            block(&mut b, v(sx * (d / 2.0 - 0.06), sy * (w / 2.0 - 0.06), h / 2.0), v(0.12, 0.12, h), slot::BODY);
        }
        let at = if has_window { -w * 0.22 } else { 0.0 };
        block(&mut b, v(x - 0.01, at, h * 0.47), v(0.06, 0.95, h * 0.8), slot::ACCENT);
        block(&mut b, v(x + 0.02, at + 0.3, h * 0.45), v(0.02, 0.05, 0.14), slot::METAL);
        if has_window {
            block(&mut b, v(x - 0.01, w * 0.2, h * 0.6), v(0.06, 1.0, 0.85), slot::WHITE);
            block(&mut b, v(x - 0.002, w * 0.2, h * 0.6), v(0.06, 0.86, 0.71), slot::DARK);
        }
    }
    b.build("site container", CREASE_RAD)
}
