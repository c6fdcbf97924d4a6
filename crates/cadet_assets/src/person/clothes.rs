//! The materials of people: a palette with fixed slots.

use super::proportions::{Headwear, PersonKind};
use cadet_base::material::{Material, Palette, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Slots of every person's palette.
pub(crate) mod slot {
    pub const SKIN: u8 = 0;
    pub const HAIR: u8 = 1;
    pub const TOP: u8 = 2;
    pub const LEGS: u8 = 3;
    pub const SHOES: u8 = 4;
    pub const BAG: u8 = 5;
}

const TOPS: [(f64, [f32; 3]); 12] = [
    (20.0, [0.62, 0.62, 0.60]),
    (22.0, [0.042, 0.041, 0.045]),
    (12.0, [0.042, 0.06, 0.14]),
    (10.0, [0.13, 0.13, 0.14]),
    (8.0, [0.10, 0.20, 0.38]),
    (7.0, [0.42, 0.05, 0.05]),
    (5.0, [0.30, 0.25, 0.17]),
    (4.0, [0.10, 0.17, 0.08]),
    (4.0, [0.48, 0.20, 0.26]),
    (3.0, [0.16, 0.05, 0.12]),
    (3.0, [0.60, 0.45, 0.08]),
    (2.0, [0.55, 0.16, 0.03]),
];
const LEGS: [(f64, [f32; 3]); 6] = [
    (38.0, [0.06, 0.085, 0.155]),
    (28.0, [0.040, 0.039, 0.043]),
    (12.0, [0.11, 0.16, 0.24]),
    (10.0, [0.28, 0.24, 0.18]),
    (8.0, [0.12, 0.12, 0.12]),
    (4.0, [0.55, 0.54, 0.50]),
];
const HAIR: [(f64, [f32; 3]); 5] = [
    (35.0, [0.045, 0.028, 0.018]),
    (20.0, [0.015, 0.012, 0.011]),
    (20.0, [0.13, 0.085, 0.045]),
    (13.0, [0.26, 0.19, 0.10]),
    (12.0, [0.34, 0.34, 0.33]),
];

/// A color of a stock of them, each with its weight, a little darker or lighter.
pub(crate) fn pick(stock: &[(f64, [f32; 3])], s: &mut Stream) -> [f32; 3] {
    let weights: Vec<f64> = stock.iter().map(|c| c.0).collect();
    let light = s.range(0.75, 1.3) as f32;
    stock[s.weighted(&weights)].1.map(|c| (c * light).min(0.8))
}

/// The materials of a person. Dyes are clear at 905 nm: the laser sees 0.3-0.7 whatever the eye sees.
pub(crate) fn palette(kind: PersonKind, headwear: Headwear, s: &mut Stream) -> Palette {
    let cloth = |albedo: [f32; 3], reflectance: f64| {
        Material::matt(Semantic::Person, albedo, Pattern::Cloth, reflectance as f32)
    };
    let tone = if s.chance(0.9) { s.range(0.8, 1.1) } else { s.range(0.15, 0.6) } as f32;
    let complexion = [0.46 * tone, 0.29 * tone, 0.21 * tone];
    let skin = Material::matt(Semantic::Person, complexion, Pattern::Plain, s.range(0.50, 0.60) as f32);

    let hair = match headwear {
        Headwear::Hat | Headwear::Helmet => pick(&TOPS, s),
        _ => pick(&HAIR[..if kind == PersonKind::Child { 4 } else { 5 }], s),
    };
    let is_leather = s.chance(0.5);
    let shoe = if is_leather { [0.03, 0.024, 0.02] } else { [s.range(0.03, 0.6) as f32; 3] };
    let bag_is_leather = s.chance(0.35);
    let bag = pick(&TOPS[1..], s);
    Palette::new(vec![
        skin.polished(0.55, 0.03),
        cloth(hair, s.range(0.30, 0.55)),
        cloth(pick(&TOPS, s), s.range(0.30, 0.70)),
        cloth(pick(&LEGS, s), s.range(0.30, 0.70)),
        cloth(shoe, if is_leather { s.range(0.05, 0.15) } else { s.range(0.2, 0.5) }),
        cloth(bag, if bag_is_leather { s.range(0.05, 0.15) } else { s.range(0.3, 0.6) }),
    ])
}
