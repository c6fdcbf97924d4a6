//! What carries posters.

use super::colors::slot;
use super::shapes::{prism_y, sizes, v, within};
use crate::assets::scenery::draw::{CREASE_RAD, block, path_tube};
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, sinf};
use crate::rng::Stream;

/// A slot of a poster, or of bare paper between them.
fn paper(s: &mut Stream) -> u8 {
    let papers = [slot::POSTER, slot::POSTER_TOO, slot::WHITE, slot::ACCENT, slot::BODY, slot::DARK];
    papers[s.weighted(&[0.25, 0.2, 0.2, 0.15, 0.1, 0.1])]
}

/// Round, its posters in rows.
pub(super) fn column(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("advert column", variant);
    let (radius, h) = (within(s, (0.52, 0.62)), within(s, (2.7, 3.5)));
    let sides = detail.pick(24, 12, 8);
    let mut b = MeshBuilder::new();
    let rows = [-0.2, 0.35, 1.15, 1.95, h - 0.25];
    let corner = |i: usize, z: f32| {
        let a = std::f32::consts::TAU * i as f32 / sides as f32;
        v(radius * cosf(a), radius * sinf(a), z)
    };
    let thirds: Vec<[u8; 8]> = (0..4).map(|_| std::array::from_fn(|_| paper(s))).collect();
    for (row, pair) in rows.windows(2).enumerate() {
        for i in 0..sides {
            let j = (i + 1) % sides;
            let paper = if row == 0 { slot::BODY } else { thirds[row][i * 8 / sides] };
            b.quad(corner(i, pair[0]), corner(j, pair[0]), corner(j, pair[1]), corner(i, pair[1]), paper);
        }
    }
    for i in 1..sides - 1 {
        b.triangle(corner(0, rows[0]), corner(i + 1, rows[0]), corner(i, rows[0]), slot::BODY);
        b.triangle(corner(0, rows[4]), corner(i, rows[4]), corner(i + 1, rows[4]), slot::BODY);
    }
    let roof = [(h - 0.25, radius + 0.05), (h - 0.18, radius + 0.06), (h, 0.12)].map(|(z, r)| (v(0.0, 0.0, z), r));
    path_tube(&mut b, &roof, sides, slot::ACCENT);
    b.build("advert column", CREASE_RAD)
}

/// A poster of 3.6 m on two posts.
pub(super) fn billboard(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("billboard", variant);
    let (w, h, low) = (within(s, (2.6, 3.9)), within(s, (1.8, 2.8)), within(s, (0.5, 1.3)));
    let mut b = MeshBuilder::new();
    block(&mut b, v(0.0, 0.0, low + h / 2.0), v(0.14, w, h), slot::METAL);
    for y in [-0.36, 0.36] {
        block(&mut b, v(-0.06, y * w, (low + h) / 2.0 - 0.3), v(0.14, 0.14, low + h - 0.2), slot::METAL);
    }
    block(&mut b, v(0.07, 0.0, low + h / 2.0), v(0.04, w - 0.16, h - 0.16), slot::POSTER);
    let parts = detail.pick(5, 4, 2);
    for k in 0..parts {
        let (y, z) = (within(s, (-0.3, 0.3)) * w, low + h * within(s, (0.25, 0.75)));
        let size = Vec3::new(0.04 + 0.004 * (k + 1) as f32, w * within(s, (0.12, 0.35)), h * within(s, (0.1, 0.4)));
        block(&mut b, v(0.07, y, z), size, paper(s));
    }
    b.build("billboard", CREASE_RAD)
}

/// Two boards that lean on each other.
pub(super) fn stand(variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes("advert stand", variant);
    let (w, h, d) = (within(s, (0.5, 0.7)), within(s, (0.8, 1.25)), within(s, (0.4, 0.6)));
    let mut b = MeshBuilder::new();
    for side in [-1.0_f32, 1.0] {
        let x = side * d / 2.0;
        let mut outline = [(x, 0.0), (x, 0.03), (side * 0.02, h), (side * 0.005, h), (x - side * 0.04, 0.0)];
        if side < 0.0 {
            outline.reverse();
        }
        prism_y(&mut b, &outline, (-w / 2.0, w / 2.0), slot::DARK);
        if detail != Detail::Far {
            let k = |t: f32| x + (side * 0.02 - x) * t;
            let mut outline = [
                (k(0.12), 0.12 * h),
                (k(0.12) + side * 0.01, 0.12 * h),
                (k(0.92) + side * 0.01, 0.92 * h),
                (k(0.92), 0.92 * h),
            ];
            if side < 0.0 {
                outline.reverse();
            }
            prism_y(&mut b, &outline, (-0.44 * w, 0.44 * w), paper(s));
        }
    }
    b.build("advert stand", CREASE_RAD)
}
