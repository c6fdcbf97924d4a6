//! The materials of belongings: a palette with fixed slots.

use super::thing::Thing;
use crate::person::clothes::pick;
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Slots of every belonging's palette.
pub(super) mod slot {
    /// Of umbrellas, hoods, cases.
    pub const CLOTH: u8 = 0;
    pub const CLOTH_INSIDE: u8 = 1;
    pub const METAL: u8 = 2;
    pub const PLASTIC: u8 = 3;
    pub const TIRE: u8 = 4;
    /// Of a child in a pram, and of its clothes.
    pub const SKIN: u8 = 5;
    pub const CLOTHES: u8 = 6;
    /// Of dogs: back, and muzzle with ears.
    pub const COAT: u8 = 7;
    pub const MUZZLE: u8 = 8;
    pub const NOSE: u8 = 9;
    pub const TROUSERS: u8 = 10;
}

const UMBRELLAS: [(f64, [f32; 3]); 7] = [
    (45.0, [0.018, 0.018, 0.020]),
    (14.0, [0.020, 0.030, 0.080]),
    (10.0, [0.30, 0.02, 0.03]),
    (8.0, [0.10, 0.02, 0.04]),
    (7.0, [0.03, 0.10, 0.06]),
    (8.0, [0.30, 0.28, 0.24]),
    (8.0, [0.05, 0.16, 0.34]),
];
const HOODS: [(f64, [f32; 3]); 6] = [
    (34.0, [0.030, 0.030, 0.033]),
    (20.0, [0.030, 0.045, 0.11]),
    (12.0, [0.30, 0.03, 0.03]),
    (12.0, [0.26, 0.22, 0.17]),
    (10.0, [0.12, 0.13, 0.13]),
    (12.0, [0.06, 0.13, 0.06]),
];
const COATS: [(f64, [f32; 3]); 7] = [
    (24.0, [0.018, 0.016, 0.015]),
    (20.0, [0.10, 0.055, 0.026]),
    (18.0, [0.26, 0.16, 0.075]),
    (10.0, [0.40, 0.29, 0.16]),
    (12.0, [0.52, 0.49, 0.43]),
    (8.0, [0.16, 0.15, 0.145]),
    (8.0, [0.06, 0.032, 0.018]),
];

/// The materials of a thing. What is carried is of the person's class in the semantic image, as in Cityscapes; what stands on
/// the ground of its own is a thing.
pub(super) fn palette(thing: Thing, s: &mut Stream) -> Palette {
    let semantic = if thing.is_carried() { Semantic::Person } else { Semantic::Furniture };
    let cloth =
        |albedo: [f32; 3], reflectance: f64| Material::matt(semantic, albedo, Pattern::Cloth, reflectance as f32);
    let plain =
        |albedo: [f32; 3], reflectance: f64| Material::matt(semantic, albedo, Pattern::Plain, reflectance as f32);
    let color = pick(if thing == Thing::Umbrella { &UMBRELLAS } else { &HOODS }, s);
    // Dyes are clear at 905 nm: the laser sees bright cloth whatever the eye sees.
    let bright = s.range(0.30, 0.60);
    let metal = if s.chance(0.6) { [0.42; 3] } else { [0.03; 3] };
    let tone = s.range(0.8, 1.1) as f32;
    let clothes = [s.range(0.1, 0.6) as f32, s.range(0.08, 0.5) as f32, s.range(0.1, 0.6) as f32];
    let trousers = [[0.06, 0.085, 0.155], [0.05, 0.05, 0.055], [0.28, 0.24, 0.18]][s.below(3)];
    let coat = pick(&COATS, s);
    let muzzle = if s.chance(0.4) { coat.map(|c| 0.35 * c) } else { coat.map(|c| (1.25 * c + 0.02).min(0.7)) };
    let fur = s.range(0.35, 0.65);

    Palette::new(vec![
        cloth(color, bright),
        cloth(color.map(|c| 0.7 * c), bright),
        plain(metal, 0.45).polished(0.35, 0.25),
        plain([0.03; 3], 0.08).polished(0.5, 0.04),
        plain([0.03; 3], 0.06),
        plain([0.46 * tone, 0.29 * tone, 0.21 * tone], 0.55).polished(0.55, 0.04),
        cloth(clothes, s.range(0.3, 0.7)),
        cloth(coat, fur),
        cloth(muzzle, fur),
        plain([0.012; 3], 0.1).polished(0.4, 0.04),
        cloth(trousers, 0.45),
    ])
}
