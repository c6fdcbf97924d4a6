//! Slots of the palette after those of [`house_slot`].

use super::super::materials::house_slot;

/// The wall of the ground floor.
pub const BASE: u8 = house_slot::COUNT as u8;
/// Boards and signs of shops.
pub const SIGN: u8 = BASE + 1;
/// Lettering on the boards and signs of shops.
pub const LETTER: u8 = BASE + 2;
/// Awnings.
pub const AWNING: u8 = BASE + 3;
/// Walls and floors of shops.
pub const INSIDE: u8 = BASE + 4;
/// Goods behind the glass.
pub const GOODS: u8 = BASE + 5;
/// Light goods, stages, posters, and the light stripes of awnings.
pub const LIGHT_GOODS: u8 = BASE + 6;
/// Number of slots.
pub const COUNT: usize = BASE as usize + 7;
