//! Names over shops, in letters of five rows.

use super::super::wall_plane::WallPlane;
use super::city_slot;
use crate::geometry::MeshBuilder;

/// What the shops sell.
pub(super) const NAMES: [&str; 14] = [
    "BLUMEN", "MODE", "OPTIK", "RADIO", "SCHUHE", "BUCH", "UHREN", "CAFE", "METZGER", "FOTO", "REISEN", "FRISEUR",
    "WEINE", "DROGERIE",
];

/// Rows of a letter from the top, the leftmost of three to five columns in the highest used bit.
pub(in crate::assets::scenery) fn rows(letter: char) -> ([u8; 5], usize) {
    match letter {
        'A' => ([0b0110, 0b1001, 0b1111, 0b1001, 0b1001], 4),
        'B' => ([0b1110, 0b1001, 0b1110, 0b1001, 0b1110], 4),
        'C' => ([0b0111, 0b1000, 0b1000, 0b1000, 0b0111], 4),
        'D' => ([0b1110, 0b1001, 0b1001, 0b1001, 0b1110], 4),
        'E' => ([0b111, 0b100, 0b110, 0b100, 0b111], 3),
        'F' => ([0b111, 0b100, 0b110, 0b100, 0b100], 3),
        'G' => ([0b0111, 0b1000, 0b1011, 0b1001, 0b0111], 4),
        'H' => ([0b1001, 0b1001, 0b1111, 0b1001, 0b1001], 4),
        'I' => ([0b1, 0b1, 0b1, 0b1, 0b1], 1),
        'K' => ([0b1001, 0b1010, 0b1100, 0b1010, 0b1001], 4),
        'L' => ([0b100, 0b100, 0b100, 0b100, 0b111], 3),
        'M' => ([0b10001, 0b11011, 0b10101, 0b10001, 0b10001], 5),
        'N' => ([0b1001, 0b1101, 0b1011, 0b1001, 0b1001], 4),
        'O' => ([0b0110, 0b1001, 0b1001, 0b1001, 0b0110], 4),
        'P' => ([0b1110, 0b1001, 0b1110, 0b1000, 0b1000], 4),
        'R' => ([0b1110, 0b1001, 0b1110, 0b1010, 0b1001], 4),
        'S' => ([0b0111, 0b1000, 0b0110, 0b0001, 0b1110], 4),
        'T' => ([0b111, 0b010, 0b010, 0b010, 0b010], 3),
        'U' => ([0b1001, 0b1001, 0b1001, 0b1001, 0b0110], 4),
        'W' => ([0b10001, 0b10001, 0b10101, 0b11011, 0b10001], 5),
        _ => ([0b1111, 0b0001, 0b0110, 0b1000, 0b1111], 4),
    }
}

/// Writes a name in the middle of [u0, u1], as high as `height` and no wider than there is room; `depth` is that of the
/// board's face.
pub(in super::super) fn write(
    b: &mut MeshBuilder,
    plane: &WallPlane,
    name: &str,
    [u0, u1]: [f32; 2],
    v: [f32; 2],
    depth: f32,
) {
    let letters: Vec<([u8; 5], usize)> = name.chars().map(rows).collect();
    let columns = letters.iter().map(|(_, n)| n + 1).sum::<usize>() - 1;
    let (dv, room) = ((v[1] - v[0]) / 5.0, u1 - u0);
    let du = (dv * 0.85).min(room / columns as f32);
    let mut u = (u0 + u1 - du * columns as f32) / 2.0;
    for (rows, width) in letters {
        for (row, bits) in rows.into_iter().enumerate() {
            let (top, low) = (v[1] - dv * row as f32, v[1] - dv * (row + 1) as f32);
            let is_set = |k: usize| k < width && bits >> (width - 1 - k) & 1 == 1;
            let mut k = 0;
            while k < width {
                let end = (k..=width).find(|e| !is_set(*e)).unwrap_or(width);
                if end > k {
                    let (a, z) = (u + du * k as f32, u + du * end as f32);
                    plane.rect(b, [a, z, low, top], depth - 0.006, city_slot::LETTER);
                }
                k = end + 1;
            }
        }
        u += du * (width + 1) as f32;
    }
}
