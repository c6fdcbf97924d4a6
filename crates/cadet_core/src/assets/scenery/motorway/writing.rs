//! Words and numbers on boards, in letters of five rows.

use super::super::city::letter_rows;
use super::slot;
use crate::geometry::MeshBuilder;
use crate::math::Vec3;

fn rows(letter: char) -> ([u8; 5], usize) {
    match letter {
        '0' => ([0b111, 0b101, 0b101, 0b101, 0b111], 3),
        '1' => ([0b01, 0b11, 0b01, 0b01, 0b01], 2),
        '2' => ([0b111, 0b001, 0b111, 0b100, 0b111], 3),
        '3' => ([0b111, 0b001, 0b111, 0b001, 0b111], 3),
        '4' => ([0b101, 0b101, 0b111, 0b001, 0b001], 3),
        '5' => ([0b111, 0b100, 0b111, 0b001, 0b111], 3),
        '6' => ([0b111, 0b100, 0b111, 0b101, 0b111], 3),
        '7' => ([0b111, 0b001, 0b010, 0b010, 0b010], 3),
        '8' => ([0b111, 0b101, 0b111, 0b101, 0b111], 3),
        '9' => ([0b111, 0b101, 0b111, 0b001, 0b111], 3),
        ' ' => ([0; 5], 2),
        ',' => ([0, 0, 0, 0b1, 0b1], 1),
        other => letter_rows(other),
    }
}

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
            let is_set = |k: usize| k < columns && bits >> (columns - 1 - k) & 1 == 1;
            let mut k = 0;
            while k < columns {
                let end = (k..=columns).find(|e| !is_set(*e)).unwrap_or(columns);
                if end > k {
                    let (left, right) = (at + dy * k as f32, at + dy * end as f32);
                    let corner = |y: f32, z: f32| Vec3::new(x, y, z);
                    b.quad(
                        corner(left, top - dz),
                        corner(right, top - dz),
                        corner(right, top),
                        corner(left, top),
                        slot,
                    );
                }
                k = end + 1;
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
