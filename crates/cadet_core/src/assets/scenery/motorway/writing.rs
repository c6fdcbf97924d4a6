//! Words and numbers on boards.

use super::super::letters::{rows, strokes};
use super::slot;
use crate::geometry::MeshBuilder;
use crate::math::Vec3;

/// Width of a word over its height.
pub(super) fn width(word: &str) -> f32 {
    let columns: usize = word.chars().map(|c| rows(c).1 + 1).sum();
    columns.saturating_sub(1) as f32 * 0.17
}

/// Writes a word on the plane x = `x`, facing +x: from `y` to the right as who looks at it sees it, its middle at `z`.
pub(super) fn write(b: &mut MeshBuilder, word: &str, (x, y, z): (f32, f32, f32), height: f32, slot: u8) {
    let (dy, dz) = (0.17 * height, height / 5.0);
    let mut at = y;
    for letter in word.chars() {
        let (rows, columns) = rows(letter);
        for (row, bits) in rows.into_iter().enumerate() {
            let top = z + height / 2.0 - dz * row as f32;
            for [from, to] in strokes(bits, columns) {
                let (left, right) = (at + dy * from as f32, at + dy * to as f32);
                let corner = |y: f32, z: f32| Vec3::new(x, y, z);
                b.quad(corner(left, top - dz), corner(right, top - dz), corner(right, top), corner(left, top), slot);
            }
        }
        at += dy * (columns + 1) as f32;
    }
}

/// An arrow that points down at the plane x = `x`, its middle at (y, z).
pub(super) fn arrow(b: &mut MeshBuilder, (x, y, z): (f32, f32, f32), height: f32) {
    let p = |dy: f32, dz: f32| Vec3::new(x, y + dy * height, z + dz * height);
    b.quad(p(-0.09, -0.1), p(0.09, -0.1), p(0.09, 0.5), p(-0.09, 0.5), slot::WHITE);
    b.triangle(p(0.0, -0.5), p(0.3, -0.1), p(-0.3, -0.1), slot::WHITE);
}
