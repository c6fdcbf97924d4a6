//! The colors of large buildings.

use std::sync::Arc;

use super::super::city::{city_palette, city_slot};
use super::super::materials::{building as paint, house_slot as slot, jitter};
use super::HallKind;
use cadet_base::material::{Material, Palette, Pattern};
use cadet_base::rng::Stream;

/// The colors of one large building: coated sheet, concrete, brick, or render.
#[must_use]
pub fn hall_palette(kind: HallKind, s: &mut Stream) -> Arc<Palette> {
    let mut materials = city_palette(s).materials().to_vec();
    let sheets = [
        ([0.50, 0.51, 0.51], 0.3),
        ([0.30, 0.32, 0.34], 0.2),
        ([0.16, 0.22, 0.32], 0.14),
        ([0.47, 0.44, 0.36], 0.16),
        ([0.20, 0.26, 0.21], 0.08),
        ([0.34, 0.10, 0.08], 0.06),
        ([0.10, 0.11, 0.12], 0.06),
    ];
    let walls = [
        ([0.46, 0.45, 0.42], Pattern::Plain, 0.34),
        ([0.54, 0.53, 0.49], Pattern::Render, 0.3),
        ([0.30, 0.15, 0.11], Pattern::Bricks, 0.2),
        ([0.36, 0.33, 0.28], Pattern::Slabs, 0.1),
        ([0.16, 0.30, 0.40], Pattern::Slabs, 0.06),
    ];
    let (wall, pattern) = if matches!(kind, HallKind::Market | HallKind::Works) {
        (s.pick(&sheets), Pattern::Plain)
    } else {
        let (wall, pattern, _) = walls[s.weighted(&walls.map(|c| c.2))];
        (wall, pattern)
    };
    let wall = jitter(s, wall, 0.12, 0.03);
    let face = paint(wall, pattern, 0.42);
    let face = if pattern == Pattern::Plain { face.polished(0.55, 0.04) } else { face };
    let seam = wall.map(|c| c * 0.62);
    let gate = [[0.40, 0.41, 0.42], [0.10, 0.14, 0.26], [0.50, 0.50, 0.48], [0.13, 0.14, 0.15]][s.below(4)];
    let mut set = |slot: u8, material: Material| materials[usize::from(slot)] = material;
    set(slot::WALL, face);
    set(slot::PLINTH, paint([0.25, 0.245, 0.23], Pattern::Plain, 0.32));
    set(slot::ROOF, paint([0.20, 0.20, 0.20], Pattern::Plain, 0.3));
    set(slot::STONE, paint(wall.map(|c| c * 0.8), Pattern::Plain, 0.36));
    set(slot::DOOR, paint(jitter(s, gate, 0.15, 0.04), Pattern::Plain, 0.4));
    set(slot::FRAME, paint(if s.chance(0.5) { [0.12, 0.125, 0.13] } else { [0.48, 0.48, 0.47] }, Pattern::Plain, 0.4));
    set(slot::WOOD, paint([0.30, 0.31, 0.31], Pattern::Plain, 0.36));
    set(city_slot::BASE, paint(seam, Pattern::Plain, 0.36));
    Arc::new(Palette::new(materials))
}
