//! The colors of houses in closed rows: render or stone, shop boards, awnings, goods.

use std::sync::Arc;

use super::super::materials::{LIT_PANES, building as paint, house_palette, house_slot as slot, jitter};
use super::city_slot;
use cadet_base::lamp::Lamp;
use cadet_base::material::{Material, Palette, Pattern};
use cadet_base::rng::Stream;

/// Radiances of lit shops: of panes that are looked through, of those of coarser levels of detail, and of white things inside.
const CLEAR_PANE: f32 = 0.008;
const FAR_PANE: f32 = 0.075;
const INSIDE: f32 = 0.32;

/// The palette of a house with the lamps of its shops, which are lit at night if there are any.
pub(super) fn light_shops(palette: Arc<Palette>, lamps: &[Lamp]) -> Arc<Palette> {
    let Some(at_night) = palette.at_night().filter(|_| !lamps.is_empty()) else { return palette };
    let mut materials = at_night.materials().to_vec();
    for (number, radiance) in [(slot::GLASS, CLEAR_PANE), (slot::DARK_GLASS, FAR_PANE)] {
        materials[usize::from(number)].albedo[2] = radiance;
    }
    for number in [city_slot::INSIDE, city_slot::GOODS, city_slot::LIGHT_GOODS] {
        materials[usize::from(number)].shine(INSIDE);
    }
    let at_night = Palette::new(materials).with_lamps(lamps.to_vec());
    Arc::new(Palette::clone(&palette).with_night(at_night))
}

/// The colors of one house of a closed row. Many in Karlsruhe are built of red sandstone, or trimmed with it.
#[must_use]
pub fn city_palette(stream: &mut Stream) -> Arc<Palette> {
    let mut materials = house_palette(stream, false).materials().to_vec();
    let red = jitter(stream, [0.30, 0.13, 0.09], 0.15, 0.05);
    let pale = jitter(stream, [0.42, 0.37, 0.29], 0.12, 0.04);
    let (wall, pattern, reflectance, stone) = match stream.weighted(&[0.2, 0.12, 0.2, 0.16, 0.12, 0.1, 0.1]) {
        0 => (red, Pattern::Blocks, 0.36, red.map(|c| c * 1.12)),
        1 => (jitter(stream, [0.27, 0.12, 0.08], 0.15, 0.05), Pattern::Bricks, 0.35, red),
        2 => (jitter(stream, [0.60, 0.55, 0.45], 0.12, 0.04), Pattern::Render, 0.64, red),
        3 => (jitter(stream, [0.56, 0.47, 0.30], 0.12, 0.05), Pattern::Render, 0.56, pale),
        4 => (jitter(stream, [0.50, 0.50, 0.47], 0.15, 0.03), Pattern::Render, 0.55, pale),
        5 => (pale, Pattern::Blocks, 0.42, pale.map(|c| c * 0.85)),
        _ => (jitter(stream, [0.50, 0.36, 0.29], 0.12, 0.05), Pattern::Render, 0.52, pale),
    };
    let mut set = |slot: u8, material: Material| materials[usize::from(slot)] = material;
    set(slot::WALL, paint(wall, pattern, reflectance));
    set(slot::STONE, paint(stone, Pattern::Plain, 0.38));
    set(slot::PLINTH, paint(stone.map(|c| c * 0.6), Pattern::Blocks, 0.33));
    let base = match stream.below(3) {
        0 => stone,
        1 => jitter(stream, [0.22, 0.21, 0.20], 0.3, 0.03),
        _ => wall.map(|c| c * 0.8),
    };
    let board = match stream.weighted(&[0.24, 0.2, 0.16, 0.14, 0.14, 0.12]) {
        0 => [0.55, 0.55, 0.52],
        1 => [0.05, 0.05, 0.055],
        2 => [0.36, 0.04, 0.04],
        3 => [0.03, 0.09, 0.26],
        4 => [0.04, 0.18, 0.09],
        _ => [0.50, 0.36, 0.05],
    };
    let is_light = board.iter().sum::<f32>() > 0.8;
    let letter = if is_light { [0.05, 0.05, 0.06] } else { [0.62, 0.60, 0.55] };
    let awning = [[0.42, 0.06, 0.05], [0.05, 0.17, 0.10], [0.05, 0.09, 0.24], [0.55, 0.40, 0.12]][stream.below(4)];
    let goods = [[0.30, 0.05, 0.06], [0.06, 0.12, 0.28], [0.32, 0.22, 0.05], [0.10, 0.10, 0.10]][stream.below(4)];
    let sign = paint(jitter(stream, board, 0.15, 0.05), Pattern::Plain, 0.45).polished(0.4, 0.04);
    materials.resize(city_slot::COUNT, sign);
    let mut set = |slot: u8, material: Material| materials[usize::from(slot)] = material;
    set(city_slot::BASE, paint(base, Pattern::Blocks, 0.38));
    set(city_slot::SIGN, sign);
    set(city_slot::LETTER, paint(letter, Pattern::Plain, 0.5));
    set(city_slot::AWNING, paint(jitter(stream, awning, 0.2, 0.05), Pattern::Cloth, 0.5));
    set(city_slot::INSIDE, paint(jitter(stream, [0.16, 0.15, 0.13], 0.3, 0.03), Pattern::Plain, 0.4));
    set(city_slot::GOODS, paint(jitter(stream, goods, 0.3, 0.1), Pattern::Plain, 0.4));
    set(city_slot::LIGHT_GOODS, paint([0.55, 0.54, 0.50], Pattern::Plain, 0.5));
    Arc::new(Palette::new(materials).with_lit_panes(&LIT_PANES))
}
