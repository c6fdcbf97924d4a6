//! Names over shops.

use super::super::letters::{rows, strokes};
use super::super::wall_plane::WallPlane;
use super::city_slot;
use cadet_base::geometry::MeshBuilder;

/// What the shops sell.
pub(super) const NAMES: [&str; 14] = [
    "BLUMEN", "MODE", "OPTIK", "RADIO", "SCHUHE", "BUCH", "UHREN", "CAFE", "METZGER", "FOTO", "REISEN", "FRISEUR",
    "WEINE", "DROGERIE",
];

/// Writes a name in the middle of [u0, u1], as high as `v` and no wider than there is room; `depth_m` is that of the
/// board's face.
pub(in super::super) fn write(
    b: &mut MeshBuilder,
    plane: &WallPlane,
    name: &str,
    [u0, u1]: [f32; 2],
    v: [f32; 2],
    depth_m: f32,
) {
    let letters: Vec<([u8; 5], usize)> = name.chars().map(rows).collect();
    let columns = letters.iter().map(|(_, n)| n + 1).sum::<usize>() - 1;
    let (dv, room) = ((v[1] - v[0]) / 5.0, u1 - u0);
    let du = (dv * 0.85).min(room / columns as f32);
    let mut u = (u0 + u1 - du * columns as f32) / 2.0;
    for (rows, width) in letters {
        for (row, bits) in rows.into_iter().enumerate() {
            let (top, low) = (v[1] - dv * row as f32, v[1] - dv * (row + 1) as f32);
            for [from, to] in strokes(bits, width) {
                let (a, z) = (u + du * from as f32, u + du * to as f32);
                plane.rect(b, [a, z, low, top], depth_m - 0.006, city_slot::LETTER);
            }
        }
        u += du * (width + 1) as f32;
    }
}
