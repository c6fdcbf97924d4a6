//! The materials of vehicles: a palette with fixed slots, and the colors of the stock around 2011.

use cadet_base::actor::ObjectClass;
use cadet_base::material::{LidarMaterial, Material, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Slots of every vehicle's palette.
pub(super) mod slot {
    pub const PAINT: u8 = 0;
    /// Windscreen: heat-absorbing.
    pub const SCREEN: u8 = 1;
    pub const SIDE_GLASS: u8 = 2;
    /// Side panes behind the front doors.
    pub const REAR_SIDE_GLASS: u8 = 3;
    pub const REAR_GLASS: u8 = 4;
    /// Glass over nothing to see: sunroofs.
    pub const DARK_GLASS: u8 = 5;
    pub const TYRE: u8 = 6;
    pub const RIM: u8 = 7;
    /// Bare black plastic: bumper lips, seals, mirrors' feet.
    pub const PLASTIC: u8 = 8;
    pub const GRILLE: u8 = 9;
    pub const LAMP: u8 = 10;
    pub const TAIL_LAMP: u8 = 11;
    pub const PLATE: u8 = 12;
    pub const CLOTH: u8 = 13;
    /// Dashboard, steering wheel, door cards.
    pub const DARK: u8 = 14;
    /// Wheel wells, underbody, shut lines.
    pub const LINER: u8 = 15;
    pub const SKIN: u8 = 16;
    pub const HAIR: u8 = 17;
    pub const SHIRT: u8 = 18;
    pub const CHROME: u8 = 19;
    /// Plates' letters.
    pub const LETTERS: u8 = 20;
    /// Turn signals of the left side and of the right.
    pub const LEFT_SIGNAL: u8 = 21;
    pub const RIGHT_SIGNAL: u8 = 22;
}

/// A color of the stock: share, albedo, spread, LIDAR reflectance below the coat, and what is on top.
type Color = (f64, [f32; 3], f32, (f64, f64), Coat);

/// What lies over a paint's pigments: clear coat alone, or metal flakes below it.
#[derive(Debug, Clone, Copy)]
enum Coat {
    Clear,
    /// Few flakes among dark pigment.
    DarkFlakes,
    Flakes,
}

impl Coat {
    /// (Fresnel reflectance, Beckmann roughness) at 905 nm.
    fn gloss(self) -> (f32, f32) {
        match self {
            Self::Clear => (0.04, 0.18),
            Self::DarkFlakes => (0.08, 0.45),
            Self::Flakes => (0.4, 0.32),
        }
    }
}

/// Shares and colors of the stock. The order of the reflectances is that measured at 905 nm (black least, dark metallic,
/// gray, blue, silver, red, white); their size, and that of the coats' lobes, is fitted to KITTI's cars: which share of the
/// beams they return at each range and height, and which share of those reads 0.
const COLOURS: [Color; 14] = [
    (18.0, [0.42, 0.43, 0.44], 0.06, (0.08, 0.17), Coat::Flakes),
    (18.0, [0.16, 0.165, 0.17], 0.06, (0.004, 0.011), Coat::DarkFlakes),
    (23.0, [0.016, 0.016, 0.018], 0.01, (0.001, 0.006), Coat::Clear),
    (10.0, [0.020, 0.032, 0.095], 0.015, (0.004, 0.014), Coat::DarkFlakes),
    (5.0, [0.06, 0.15, 0.36], 0.05, (0.022, 0.063), Coat::DarkFlakes),
    (6.0, [0.36, 0.025, 0.025], 0.06, (0.21, 0.36), Coat::Clear),
    (3.0, [0.16, 0.015, 0.022], 0.03, (0.045, 0.08), Coat::DarkFlakes),
    (7.0, [0.72, 0.72, 0.70], 0.05, (0.39, 0.45), Coat::Clear),
    (3.5, [0.02, 0.07, 0.045], 0.02, (0.018, 0.04), Coat::DarkFlakes),
    (1.5, [0.12, 0.20, 0.12], 0.05, (0.065, 0.13), Coat::Flakes),
    (2.0, [0.34, 0.28, 0.19], 0.05, (0.085, 0.15), Coat::Flakes),
    (1.0, [0.10, 0.06, 0.035], 0.02, (0.014, 0.04), Coat::DarkFlakes),
    (1.5, [0.75, 0.50, 0.03], 0.06, (0.27, 0.39), Coat::Clear),
    (0.5, [0.62, 0.20, 0.02], 0.05, (0.24, 0.36), Coat::Clear),
];

/// Lenses of turn signals: of most they are amber, of others clear over an amber bulb.
const CLEAR_SIGNALS: f64 = 0.35;
const CLEAR_SIGNAL: [f32; 3] = [0.50, 0.44, 0.36];
pub(super) const AMBER: [f32; 3] = [0.60, 0.24, 0.02];

/// Further slots of what works: trucks, buses, trailers.
pub(super) mod work_slot {
    /// Panels of the body behind the cab.
    pub const LOAD: u8 = 23;
    /// Rails, axles, racks.
    pub const FRAME: u8 = 24;
    pub const ALU: u8 = 25;
    pub const CANVAS: u8 = 26;
    /// Wood.
    pub const BOARD: u8 = 27;
    pub const AMBER: u8 = 28;
    /// Bands and letters.
    pub const STRIPE: u8 = 29;
    /// Earth, gravel, goods.
    pub const CARGO: u8 = 30;
    pub const BEACON: u8 = 31;
    /// Ceilings and linings of buses.
    pub const LINING: u8 = 32;
}

/// What the colors of a vehicle are drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Livery {
    /// Cars and vans, in the colors of the stock.
    Private,
    /// Trucks that carry goods.
    Freight,
    /// Refuse trucks and others of a town.
    Municipal,
    /// Fire engines.
    Fire,
    /// Buses of a line.
    Bus,
    /// Car trailers.
    Trailer,
    /// Caravans and motor homes.
    Caravan,
    /// Motorbikes.
    Motorbike,
    /// Trams.
    Tram,
}

/// The materials that every vehicle has.
pub(super) fn of_every_vehicle(class: ObjectClass, s: &mut Stream) -> Vec<Material> {
    let semantic = class.semantic();
    let mut materials = vec![Material::matt(semantic, [0.03; 3], Pattern::Plain, 0.012); 23];
    let mut set = |slot: u8, m: Material| materials[usize::from(slot)] = m;
    set(slot::PAINT, paint(class, semantic, s));

    let is_private = s.chance(0.30);
    let green = s.range(0.0, 1.0) as f32;
    let tint = [0.86 - 0.06 * green, 0.90, 0.88 - 0.05 * green];
    let clear = s.range(0.75, 0.85) as f32;
    let rear = if is_private { s.range(0.10, 0.20) as f32 } else { clear };
    let rear_eye = if is_private { 0.22 } else { 0.78 };
    set(slot::SCREEN, glass(semantic, tint, 0.74, s.range(0.45, 0.65) as f32));
    set(slot::SIDE_GLASS, glass(semantic, tint, 0.78, clear));
    set(slot::REAR_SIDE_GLASS, glass(semantic, tint, rear_eye, rear));
    set(slot::REAR_GLASS, glass(semantic, tint, rear_eye * 0.92, rear * 0.9));
    set(slot::DARK_GLASS, coated(semantic, [0.01; 3], 0.04, 0.03, 0.01));

    set(slot::TYRE, coated(semantic, [0.04; 3], 0.8, 0.02, 0.010));
    let rim = s.range(0.28, 0.5) as f32;
    set(slot::RIM, coated(semantic, [rim; 3], 0.35, 0.10, s.range(0.2, 0.4) as f32));
    set(slot::PLASTIC, coated(semantic, [0.042; 3], 0.45, 0.04, 0.018));
    set(slot::GRILLE, coated(semantic, [0.015; 3], 0.5, 0.03, 0.012));
    set(slot::LAMP, coated(semantic, [0.55, 0.56, 0.58], 0.08, 0.08, 0.30));
    set(slot::TAIL_LAMP, coated(semantic, [0.38, 0.012, 0.015], 0.10, 0.05, 0.55));
    let mut plate = coated(semantic, [0.72, 0.72, 0.70], 0.5, 0.03, 0.9);
    plate.lidar.retro = true;
    set(slot::PLATE, plate);
    set(slot::LETTERS, coated(semantic, [0.02; 3], 0.5, 0.03, 0.2));
    let cloth = s.range(0.025, 0.14) as f32;
    let fabric = |albedo: [f32; 3], reflectance: f32| Material::matt(semantic, albedo, Pattern::Cloth, reflectance);
    let plain = |albedo: [f32; 3], reflectance: f32| Material::matt(semantic, albedo, Pattern::Plain, reflectance);
    set(slot::CLOTH, fabric([cloth, cloth, cloth * 1.05], s.range(0.012, 0.12) as f32));
    set(slot::DARK, plain([0.025; 3], s.range(0.010, 0.025) as f32));
    set(slot::LINER, plain([0.008; 3], 0.01));
    let skin = s.range(0.75, 1.1) as f32;
    set(slot::SKIN, plain([0.45 * skin, 0.28 * skin, 0.20 * skin], 0.55));
    let hair = s.range(0.3, 2.5) as f32;
    set(slot::HAIR, fabric([0.05 * hair, 0.035 * hair, 0.022 * hair], 0.4));
    let shirt = [s.range(0.03, 0.55) as f32, s.range(0.03, 0.5) as f32, s.range(0.03, 0.55) as f32];
    set(slot::SHIRT, fabric(shirt, s.range(0.3, 0.7) as f32));
    set(slot::CHROME, coated(semantic, [0.55; 3], 0.1, 0.5, 0.01));
    // Later draws from the stream give shapes: this one looks ahead and takes nothing.
    let is_clear = Stream::from_seed("signal lenses", s.clone().next_u64()).chance(CLEAR_SIGNALS);
    let signal = coated(semantic, if is_clear { CLEAR_SIGNAL } else { AMBER }, 0.12, 0.05, 0.5);
    set(slot::LEFT_SIGNAL, signal);
    set(slot::RIGHT_SIGNAL, signal);
    materials
}

fn paint(class: ObjectClass, semantic: Semantic, s: &mut Stream) -> Material {
    let mut shares = COLOURS.map(|c| c.0);
    if class != ObjectClass::Car {
        shares[7] = 60.0;
    }
    let (_, albedo, spread, reflectance, coat) = COLOURS[s.weighted(&shares)];
    let (gloss, roughness) = coat.gloss();
    let light = s.range(-1.0, 1.0) as f32 * spread;
    let is_dull = s.chance(0.2);
    let albedo = albedo.map(|a| (a + light * (0.3 + a)).clamp(0.008, 0.85));
    let eye_roughness = if is_dull { s.range(0.15, 0.35) } else { s.range(0.03, 0.08) } as f32;
    let specular = if is_dull { 0.04 } else { s.range(0.04, 0.08) as f32 };
    let m = coated(semantic, albedo, eye_roughness, specular, s.range(reflectance.0, reflectance.1) as f32);
    let coat_index = LidarMaterial::LACQUER_INDEX;
    Material { lidar: LidarMaterial { coat_index, gloss, roughness, ..m.lidar }, ..m }
}

pub(crate) fn coated(
    semantic: Semantic,
    albedo: [f32; 3],
    roughness: f32,
    specular: f32,
    reflectance: f32,
) -> Material {
    Material::matt(semantic, albedo, Pattern::Plain, reflectance).polished(roughness, specular)
}

pub(crate) fn glass(semantic: Semantic, tint: [f32; 3], eye_transmission: f32, laser_transmission: f32) -> Material {
    let mut pane = coated(semantic, tint, 0.02, 0.04, 0.005);
    (pane.transmission, pane.lidar.transmission) = (eye_transmission, laser_transmission);
    pane
}
