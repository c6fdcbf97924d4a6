//! The materials of cyclists: the person's slots, then the bicycle's.

use crate::person::clothes;
use crate::person::proportions::Proportions;
use cadet_base::material::{LidarMaterial, Material, Palette, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Slots of every cyclist's palette behind those of [`clothes::slot`].
pub(super) mod slot {
    pub const FRAME: u8 = 6;
    pub const TIRE: u8 = 7;
    pub const METAL: u8 = 8;
    pub const PLASTIC: u8 = 9;
    pub const SADDLE: u8 = 10;
    pub const MUDGUARD: u8 = 11;
    pub const LUGGAGE: u8 = 12;
    pub const BASKET: u8 = 13;
    pub const LAMP: u8 = 14;
    pub const TAIL_LAMP: u8 = 15;
}

/// Frames: share, albedo, reflectance at 905 nm.
const FRAMES: [(f64, [f32; 3], f64); 9] = [
    (30.0, [0.02, 0.02, 0.022], 0.06),
    (22.0, [0.40, 0.41, 0.42], 0.25),
    (12.0, [0.12, 0.12, 0.13], 0.12),
    (10.0, [0.03, 0.06, 0.20], 0.15),
    (8.0, [0.35, 0.03, 0.03], 0.45),
    (6.0, [0.65, 0.65, 0.63], 0.65),
    (5.0, [0.03, 0.12, 0.06], 0.2),
    (4.0, [0.08, 0.22, 0.42], 0.3),
    (3.0, [0.60, 0.42, 0.05], 0.5),
];

/// The materials of a cyclist.
pub(super) fn palette(p: &Proportions, s: &mut Stream) -> Palette {
    let person = clothes::palette(p.kind, p.headwear, s);
    let rider = person.materials().iter().map(|m| Material { semantic: Semantic::Cyclist, ..*m });
    let plain = |albedo: [f32; 3], roughness: f32, specular: f32, reflectance: f32| {
        Material::matt(Semantic::Cyclist, albedo, Pattern::Plain, reflectance).polished(roughness, specular)
    };
    let (_, albedo, reflectance) = FRAMES[s.weighted(&FRAMES.map(|f| f.0))];
    let light = s.range(0.8, 1.25) as f32;
    let mut frame = plain(albedo.map(|a| (a * light).min(0.8)), 0.35, 0.045, reflectance as f32);
    frame.lidar.coat_index = LidarMaterial::LACQUER_INDEX;
    let metal = plain([0.36; 3], 0.55, 0.12, 0.2);
    let black = plain([0.02; 3], 0.6, 0.03, 0.06);
    let mudguard = if s.chance(0.65) { black } else { plain([0.40; 3], 0.5, 0.06, 0.2) };
    let cloth =
        |albedo: [f32; 3], reflectance: f32| Material::matt(Semantic::Cyclist, albedo, Pattern::Cloth, reflectance);
    let luggage = [[0.02, 0.02, 0.022], [0.25, 0.03, 0.03], [0.03, 0.05, 0.16], [0.35, 0.27, 0.04]][s.below(4)];
    let basket = [[0.03; 3], [0.24, 0.15, 0.07]][s.below(2)];
    let saddle = if s.chance(0.15) { [0.10, 0.05, 0.025] } else { [0.018; 3] };
    let mut tail_lamp = plain([0.35, 0.012, 0.015], 0.15, 0.05, 0.9);
    tail_lamp.lidar.retro = true;
    let mut materials: Vec<Material> = rider.collect();
    materials.extend([
        frame,
        plain([0.022; 3], 0.85, 0.02, 0.05),
        metal,
        black,
        cloth(saddle, 0.10),
        mudguard,
        cloth(luggage, s.range(0.15, 0.5) as f32),
        cloth(basket, s.range(0.2, 0.4) as f32),
        plain([0.5; 3], 0.1, 0.08, 0.3),
        tail_lamp,
    ]);
    Palette::new(materials)
}
