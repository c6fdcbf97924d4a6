//! Heaps of earth, and mounds with grass on them.

use super::colors::slot;
use super::shapes::{sizes, v, within};
use crate::assets::scenery::draw::range;
use crate::assets::scenery::{Detail, Mesh};
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, powf, sinf};

/// A rough cushion of a car's size; `name` is "heap" for a steep one, "mound" for a flat one.
pub(super) fn heap(name: &'static str, variant: usize, detail: Detail) -> Mesh {
    let s = &mut sizes(name, variant);
    let is_mound = name == "mound";
    let (d, w, h) = if is_mound {
        (within(s, (2.4, 4.0)), within(s, (3.2, 6.5)), within(s, (0.5, 1.2)))
    } else {
        (within(s, (1.6, 2.6)), within(s, (2.0, 4.2)), within(s, (0.7, 1.5)))
    };
    let steepness = if is_mound { 1.7 } else { 1.15 };
    let (sides, rings) = detail.pick((26, 8), (16, 5), (9, 3));
    // The same bumps at every level: a few waves about it.
    let waves: Vec<[f32; 3]> =
        (0..4).map(|k| [2.0 + k as f32, range(s, 0.0, 6.3), range(s, 0.02, 0.10) / (1.0 + k as f32 * 0.4)]).collect();
    let (ox, oy) = (range(s, -0.08, 0.08) * d, range(s, -0.12, 0.12) * w);
    let level = |t: f32| -> Vec<Vec3> {
        // t: 0 at the foot, near 1 at the top.
        let out = 1.0 - t;
        let z = h * (1.0 - powf(out, steepness));
        (0..sides)
            .map(|i| std::f32::consts::TAU * i as f32 / sides as f32)
            .map(|a| {
                let bump: f32 = waves.iter().map(|[n, turn, size]| size * sinf(n * a + turn)).sum();
                let r = out * (0.84 + 0.8 * bump * (0.4 + 0.6 * out)).min(1.0);
                let p = v(d / 2.0 * r * cosf(a) + ox * t, w / 2.0 * r * sinf(a) + oy * t, z + 0.5 * h * bump * t * out);
                p.max(v(-d / 2.0, -w / 2.0, -0.3)).min(v(d / 2.0, w / 2.0, h))
            })
            .collect()
    };
    let mut all: Vec<Vec<Vec3>> = vec![level(0.0).into_iter().map(|p| v(p.x, p.y, -0.25)).collect()];
    all.extend((0..=rings).map(|k| level(0.97 * k as f32 / rings as f32)));
    let mut b = MeshBuilder::new();
    b.loft(&all, slot::FILL, true);
    b.build(name, 1.3)
}
