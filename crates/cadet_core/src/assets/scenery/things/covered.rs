//! Things under a tarpaulin.

use super::colors::slot;
use super::shapes::{sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, range, tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, powf, sinf};
use crate::rng::Stream;

/// Heights of a car's outline along it, from tail to nose, as shares of its height: a saloon's, an estate's, a van's.
const OUTLINES: [[(f32, f32); 9]; 3] = [
    [
        (0.0, 0.42),
        (0.03, 0.62),
        (0.16, 0.70),
        (0.32, 0.96),
        (0.5, 1.0),
        (0.62, 0.93),
        (0.76, 0.68),
        (0.97, 0.55),
        (1.0, 0.36),
    ],
    [
        (0.0, 0.50),
        (0.03, 0.74),
        (0.09, 0.93),
        (0.25, 1.0),
        (0.5, 0.99),
        (0.62, 0.92),
        (0.76, 0.67),
        (0.97, 0.54),
        (1.0, 0.36),
    ],
    [
        (0.0, 0.60),
        (0.02, 0.88),
        (0.06, 0.98),
        (0.3, 1.0),
        (0.6, 0.99),
        (0.74, 0.90),
        (0.86, 0.60),
        (0.98, 0.48),
        (1.0, 0.32),
    ],
];

/// A cloth over an outline along x: smooth on top, in folds toward its hem.
fn cloth(b: &mut MeshBuilder, s: &mut Stream, [l, w, h]: [f32; 3], outline: &[(f32, f32)], detail: Detail) {
    let (stations, around) = detail.pick((21, 15), (11, 9), (7, 7));
    let height = |t: f32| {
        let k = outline.partition_point(|p| p.0 < t).clamp(1, outline.len() - 1);
        let ((t0, z0), (t1, z1)) = (outline[k - 1], outline[k]);
        z0 + (z1 - z0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
    };
    let hem = within(s, (0.1, 0.28));
    let (waves, turn) = (within(s, (5.0, 9.0)), within(s, (0.0, 6.0)));
    let rings: Vec<Vec<Vec3>> = (0..stations)
        .map(|i| {
            let t = i as f32 / (stations - 1) as f32;
            // Ends are rounded seen from above.
            let end = (2.0 * t - 1.0).abs();
            let half = (w / 2.0) * (1.0 - 0.2 * powf(end, 6.0));
            let top = h * height(t);
            let fold = 0.02 * sinf(waves * std::f32::consts::TAU * t + turn);
            // Counter-clockwise seen against +x: from the left hem over the top to the right one, reversed.
            (0..around)
                .map(|k| {
                    let a = 2.0 * k as f32 / (around - 1) as f32 - 1.0;
                    let side = a.abs();
                    let low = powf(side, 3.5);
                    let z = top + (hem + 0.5 * fold - top) * low;
                    let wide = half * powf(side, 0.75).min(1.0) * (1.0 - 0.05 * (1.0 - low)) - (fold + 0.02) * low;
                    let rough = if detail == Detail::Far { 0.0 } else { range(s, -0.008, 0.008) };
                    v(l * (t - 0.5), wide * a.signum(), (z + rough * (1.0 - low)).min(h))
                })
                .rev()
                .collect()
        })
        .collect();
    b.loft(&rings, slot::BODY, true);
}

/// Of a small car's size to a van's.
pub(super) fn car(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("covered car", variant);
    let outline = OUTLINES[variant % OUTLINES.len()];
    let size =
        [within(s, (3.5, 4.7)), within(s, (1.62, 1.86)), within(s, (1.36, 1.62)) + [0.0, 0.02, 0.3][variant % 3]];
    let mut b = MeshBuilder::new();
    cloth(&mut b, s, size, &outline, detail);
    let [l, w, _] = size;
    for (x, y) in [(-0.3, -1.0), (-0.3, 1.0), (0.31, -1.0), (0.31, 1.0)] {
        let middle = v(x * l, y * (w / 2.0 - 0.27), 0.29);
        let half = Vec3::Y * 0.09;
        tube(&mut b, (middle - half, 0.29), (middle + half, 0.29), detail.pick(14, 8, 5), slot::DARK);
    }
    b.build("covered car", 1.1)
}

/// Of a motorcycle's size.
pub(super) fn cycle(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("covered cycle", variant);
    let size = [within(s, (1.8, 2.3)), within(s, (0.65, 0.95)), within(s, (1.0, 1.3))];
    let outline =
        [(0.0, 0.5), (0.08, 0.66), (0.3, 0.7), (0.55, 0.78), (0.72, 1.0), (0.8, 0.96), (0.93, 0.6), (1.0, 0.4)];
    let mut b = MeshBuilder::new();
    cloth(&mut b, s, size, &outline, detail);
    for x in [-0.34, 0.34] {
        let middle = v(x * size[0], 0.0, 0.3);
        let half = Vec3::Y * 0.06;
        tube(&mut b, (middle - half, 0.3), (middle + half, 0.3), detail.pick(14, 8, 5), slot::DARK);
    }
    b.build("covered cycle", 1.1)
}

/// Split logs under a sheet, or without one.
pub(super) fn wood_pile(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("wood pile", variant);
    let (d, w, h) = (within(s, (0.6, 1.1)), within(s, (1.6, 3.6)), within(s, (0.9, 1.6)));
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, h / 2.0 - 0.1), v(d - 0.1, w - 0.06, h - 0.1), slot::WOOD);
    if detail == Detail::Near {
        let (columns, rows) = ((w / 0.2) as usize, ((h - 0.3) / 0.17) as usize);
        for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
            let (y, z) = (-w / 2.0 + 0.13 + 0.2 * i as f32, 0.1 + 0.17 * j as f32);
            if y > w / 2.0 - 0.12 {
                continue;
            }
            let (r, turn) = (range(s, 0.06, 0.085), range(s, 0.0, 6.0));
            let outline: Vec<(f32, f32)> = (0..5)
                .map(|k| turn + std::f32::consts::TAU * k as f32 / 5.0)
                .map(|a| (y + r * cosf(a), z + r * sinf(a)))
                .collect();
            super::shapes::prism_x(&mut b, &outline, (d / 2.0 - 0.06, d / 2.0 - range(s, 0.0, 0.03)), slot::WOOD);
        }
    }
    // Its caps are fans about the ridge's inner side.
    let cover = [
        (0.0, h - 0.03),
        (d / 2.0 - 0.01, h - 0.28),
        (d / 2.0, h - 0.28),
        (d / 2.0 - 0.02, h - 0.1),
        (0.0, h),
        (-d / 2.0 + 0.02, h - 0.1),
        (-d / 2.0, h - 0.28),
        (-d / 2.0 + 0.01, h - 0.28),
    ];
    super::shapes::prism_y(&mut b, &cover, (-w / 2.0, w / 2.0), slot::BODY);
    b.build("wood pile", CREASE_RAD)
}
