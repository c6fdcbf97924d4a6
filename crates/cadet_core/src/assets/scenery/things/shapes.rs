//! Solids that things are made of, all closed and turned outwards.

use crate::assets::scenery::draw::range;
use crate::geometry::MeshBuilder;
use crate::math::{Vec3, cosf, powf, sinf};
use crate::rng::Stream;

pub(super) fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// The sizes of a variant: one stream each, the same at every level of detail.
pub(super) fn sizes(name: &str, variant: usize) -> Stream {
    Stream::from_seed(name, variant as u64)
}

/// One of a range, given as a pair.
pub(super) fn within(s: &mut Stream, (least, most): (f32, f32)) -> f32 {
    range(s, least, most)
}

/// A solid between y0 and y1 whose outline in the plane of x and z runs counter-clockwise, x to the right, z up.
pub(super) fn prism_y(b: &mut MeshBuilder, outline: &[(f32, f32)], (y0, y1): (f32, f32), slot: u8) {
    let rings = [y1, y0].map(|y| outline.iter().map(|(x, z)| v(*x, y, *z)).collect::<Vec<_>>());
    b.loft(&rings, slot, true);
}

/// A solid between x0 and x1 whose outline in the plane of y and z runs counter-clockwise, y to the right, z up.
pub(super) fn prism_x(b: &mut MeshBuilder, outline: &[(f32, f32)], (x0, x1): (f32, f32), slot: u8) {
    let rings = [x0, x1].map(|x| outline.iter().map(|(y, z)| v(x, *y, *z)).collect::<Vec<_>>());
    b.loft(&rings, slot, true);
}

/// A level ring of `sides` corners about (0, 0, z): an ellipse at `power` 2, nearly a rectangle at 6.
pub(super) fn ring(half: (f32, f32), z: f32, sides: usize, power: f32) -> Vec<Vec3> {
    (0..sides)
        .map(|i| std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32)
        .map(|a| {
            let bent = |c: f32| powf(c.abs(), 2.0 / power) * c.signum();
            v(half.0 * bent(cosf(a)), half.1 * bent(sinf(a)), z)
        })
        .collect()
}

/// A closed tube through points that lead back to the first, all in the plane of x and z.
pub(super) fn hoop(b: &mut MeshBuilder, center: Vec3, radius: f32, thick: f32, counts: (usize, usize), slot: u8) {
    let (around, sides) = counts;
    let rings: Vec<Vec<Vec3>> = (0..=around)
        .map(|k| std::f32::consts::TAU * (k % around) as f32 / around as f32)
        .map(|a| {
            let out = v(cosf(a), 0.0, sinf(a));
            (0..sides)
                .map(|i| std::f32::consts::TAU * i as f32 / sides as f32)
                .map(|t| center + out * (radius + thick * cosf(t)) + Vec3::Y * (thick * sinf(t)))
                .collect()
        })
        .collect();
    b.loft(&rings, slot, false);
}
