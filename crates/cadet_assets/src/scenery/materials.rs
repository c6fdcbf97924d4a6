//! Colors and reflectances of the scenery, and the palettes that instances of one prototype may wear.

use std::sync::Arc;

use cadet_base::material::{LidarMaterial, Material, Palette, Pattern, Semantic};
use cadet_base::rng::Stream;

/// Slots of a house's or garage's palette.
pub mod house_slot {
    /// Rendered or brick walls.
    pub const WALL: u8 = 0;
    /// The darker foot of the walls.
    pub const PLINTH: u8 = 1;
    /// Tiles, or felt on flat roofs.
    pub const ROOF: u8 = 2;
    /// Window frames.
    pub const FRAME: u8 = 3;
    /// Panes that are looked through.
    pub const GLASS: u8 = 4;
    /// The dark room behind a pane.
    pub const ROOM: u8 = 5;
    /// Curtains behind a pane.
    pub const CURTAIN: u8 = 6;
    /// Doors and garage doors.
    pub const DOOR: u8 = 7;
    /// Gutters, downpipes, flashings.
    pub const METAL: u8 = 8;
    /// Chimneys.
    pub const CHIMNEY: u8 = 9;
    /// Roller shutters.
    pub const SHUTTER: u8 = 10;
    /// Steps, sills, balcony slabs.
    pub const STONE: u8 = 11;
    /// Soffits, verge boards, timbers.
    pub const WOOD: u8 = 12;
    /// Far panes: opaque, dark and shiny.
    pub const DARK_GLASS: u8 = 13;
    /// Far panes before net curtains.
    pub const NET_GLASS: u8 = 14;
    /// Number of slots.
    pub const COUNT: usize = 15;
}

/// Slots of a tree's, shrub's or hedge's palette.
pub mod plant_slot {
    /// Leaves of the common tint.
    pub const LEAF: u8 = 0;
    /// Lighter, yellower leaves.
    pub const LIGHT_LEAF: u8 = 1;
    /// Leaves of the crown's inside.
    pub const DARK_LEAF: u8 = 2;
    /// Trunk and limbs.
    pub const BARK: u8 = 3;
}

/// Slots of street furniture: poles, signs, bins.
pub mod furniture_slot {
    /// Main body: pole, bin, cabinet.
    pub const BODY: u8 = 0;
    /// Second tone: lid, lamp head, seat.
    pub const ACCENT: u8 = 1;
    /// White face of a sign.
    pub const WHITE: u8 = 2;
    /// Red face of a sign.
    pub const RED: u8 = 3;
    /// Blue or black face of a sign.
    pub const INK: u8 = 4;
    /// Wheels, dark parts.
    pub const DARK: u8 = 5;
    /// Backs and rims of plates: bare aluminum.
    pub const BACK: u8 = 6;
}

/// Scales a color by up to `value_share` around 1, and each of its three parts by up to `hue_share`.
pub(crate) fn jitter(stream: &mut Stream, rgb: [f32; 3], value_share: f64, hue_share: f64) -> [f32; 3] {
    let v = stream.range(1.0 - value_share, 1.0 + value_share) as f32;
    rgb.map(|c| (c * v * stream.range(1.0 - hue_share, 1.0 + hue_share) as f32).clamp(0.004, 0.92))
}

pub(super) fn building(albedo: [f32; 3], pattern: Pattern, reflectance: f32) -> Material {
    Material::matt(Semantic::Building, albedo, pattern, reflectance)
}

/// What double glazing mirrors at normal incidence, four faces of 4 %: of panes that are opaque, and of those that are
/// looked through, whose back is counted when they are drawn.
const DOUBLE_GLAZING: (f32, f32) = (0.14, 0.078);
/// Share of a net curtain's color that is left behind a pane, and the reflectance that the LIDAR sees of it there.
const BEHIND_PANE: (f32, f32) = (0.4, 0.28);

fn pane() -> Material {
    let coat_index = LidarMaterial::LACQUER_INDEX;
    let lidar = LidarMaterial { coat_index, transmission: 0.72, ..LidarMaterial::diffuse(0.03) };
    let pane = building([0.03, 0.035, 0.035], Pattern::Plain, 0.03).polished(0.03, DOUBLE_GLAZING.1);
    Material { transmission: 0.55, lidar, ..pane }
}

/// Panes of homes at night: share that is lit, radiance, whiteness; see [`Pattern::Window`].
const LIT_AT_HOME: [f32; 3] = [0.24, 0.10, 0.0];
pub(super) const LIT_PANES: [(u8, [f32; 3]); 3] =
    [(house_slot::GLASS, LIT_AT_HOME), (house_slot::DARK_GLASS, LIT_AT_HOME), (house_slot::NET_GLASS, LIT_AT_HOME)];

/// The colors of one house: walls and roofs by the shares of a South German suburb.
#[must_use]
pub fn house_palette(stream: &mut Stream, flat_roof: bool) -> Arc<Palette> {
    let (wall, wall_pattern, wall_905) = match stream.weighted(&[0.38, 0.17, 0.10, 0.08, 0.07, 0.10, 0.06, 0.04]) {
        0 => ([0.57, 0.555, 0.515], Pattern::Render, 0.68),
        1 => ([0.55, 0.495, 0.40], Pattern::Render, 0.64),
        2 => ([0.53, 0.455, 0.27], Pattern::Render, 0.56),
        3 => ([0.50, 0.355, 0.295], Pattern::Render, 0.54),
        4 => ([0.48, 0.36, 0.19], Pattern::Render, 0.50),
        5 => ([0.38, 0.38, 0.38], Pattern::Render, 0.45),
        6 => ([0.31, 0.15, 0.11], Pattern::Bricks, 0.35),
        _ => ([0.33, 0.17, 0.13], Pattern::Blocks, 0.36),
    };
    let wall = jitter(stream, wall, 0.12, 0.04);
    let roof = if flat_roof {
        [0.12, 0.12, 0.12]
    } else {
        match stream.weighted(&[0.65, 0.25, 0.10]) {
            0 => [0.20, 0.075, 0.048],
            1 => [0.055, 0.055, 0.06],
            _ => [0.34, 0.13, 0.06],
        }
    };
    let roof = jitter(stream, roof, 0.25, 0.08);
    let frame = if stream.chance(0.72) { [0.70, 0.70, 0.68] } else { [0.11, 0.06, 0.035] };
    let doors = [[0.16, 0.08, 0.04], [0.55, 0.55, 0.53], [0.10, 0.12, 0.11], [0.22, 0.22, 0.23], [0.07, 0.10, 0.06]];
    let door = doors[stream.below(5)];
    let shutter = if stream.chance(0.6) { [0.52, 0.52, 0.50] } else { [0.20, 0.16, 0.12] };
    let metal = if stream.chance(0.7) { [0.30, 0.31, 0.32] } else { [0.17, 0.09, 0.06] };
    let curtain = if stream.chance(0.7) { [0.60, 0.59, 0.55] } else { [0.40, 0.33, 0.24] };
    let plain = |c: [f32; 3], r: f32| building(c, Pattern::Plain, r);
    let plinth = wall.map(|c| c * 0.5 + 0.03);
    let mut dark_glass = pane();
    (dark_glass.transmission, dark_glass.specular) = (0.0, DOUBLE_GLAZING.0);
    dark_glass.lidar = LidarMaterial { coat_index: LidarMaterial::LACQUER_INDEX, ..LidarMaterial::diffuse(0.05) };
    let mut net_glass = dark_glass;
    net_glass.albedo = curtain.map(|c| c * BEHIND_PANE.0);
    net_glass.lidar = LidarMaterial::diffuse(BEHIND_PANE.1);
    let house = Palette::new(vec![
        building(wall, wall_pattern, wall_905),
        building(plinth, Pattern::Render, 0.35),
        building(roof, if flat_roof { Pattern::Plain } else { Pattern::Tiles }, 0.30).polished(0.7, 0.04),
        plain(frame, 0.55).polished(0.4, 0.04),
        pane(),
        plain([0.045, 0.042, 0.038], 0.35),
        building(curtain, Pattern::Cloth, 0.55),
        plain(jitter(stream, door, 0.2, 0.05), 0.40).polished(0.5, 0.04),
        plain(metal, 0.35).polished(0.45, 0.04),
        building([0.24, 0.11, 0.08], Pattern::Bricks, 0.34),
        plain(jitter(stream, shutter, 0.1, 0.03), 0.45).polished(0.5, 0.04),
        plain([0.30, 0.29, 0.27], 0.36),
        building([0.15, 0.085, 0.05], Pattern::Wood, 0.45),
        dark_glass,
        net_glass,
    ]);
    Arc::new(house.with_lit_panes(&LIT_PANES))
}

/// What a leaf's skin reflects of all colors alike; leaves turn to all sides, so that it counts as diffuse.
const LEAF_SKIN: f32 = 0.02;

fn leaf(albedo: [f32; 3], reflectance: f32) -> Material {
    let albedo = albedo.map(|a| a + LEAF_SKIN);
    Material::matt(Semantic::Vegetation, albedo, Pattern::Leaves, reflectance).polished(0.45, 0.04)
}

/// The materials of a plant in the order of [`plant_slot`]: of leaves the base, light and dark ones by their shares of
/// it, and the reflectance of each; then the bark's.
fn plant(
    base: [f32; 3],
    light: [f32; 3],
    dark: f32,
    [r0, r1, r2]: [f32; 3],
    (bark, r3): ([f32; 3], f32),
) -> Arc<Palette> {
    Arc::new(Palette::new(vec![
        leaf(base, r0),
        leaf(std::array::from_fn(|k| base[k] * light[k]), r1),
        leaf(base.map(|c| c * dark), r2),
        Material::matt(Semantic::Vegetation, bark, Pattern::Wood, r3),
    ]))
}

/// The colors of one plant: `evergreen` ones are darker and bluer; a few broad-leaved ones are copper or turning.
#[must_use]
pub fn plant_palette(stream: &mut Stream, evergreen: bool) -> Arc<Palette> {
    let base = if evergreen {
        [0.055, 0.088, 0.044]
    } else {
        match stream.weighted(&[0.50, 0.25, 0.13, 0.08, 0.04]) {
            0 => [0.091, 0.137, 0.050],
            1 => [0.072, 0.117, 0.055],
            2 => [0.137, 0.169, 0.058],
            3 => [0.180, 0.150, 0.048],
            _ => [0.100, 0.055, 0.046],
        }
    };
    let base = jitter(stream, base, 0.22, 0.07);
    let reflectance = stream.range(0.45, 0.55) as f32;
    let bark = jitter(stream, [0.125, 0.105, 0.085], 0.3, 0.06);
    let reflectances = [reflectance, reflectance + 0.02, reflectance - 0.05];
    plant(base, [1.55, 1.42, 1.25], 0.42, reflectances, (bark, 0.30))
}

/// Tall grass and herbs: from green to dry.
#[must_use]
pub fn herbs_palette(stream: &mut Stream) -> Arc<Palette> {
    let dry = stream.unit() as f32;
    let base = [0.062 + 0.085 * dry * dry, 0.098 + 0.030 * dry * dry, 0.034 + 0.030 * dry * dry];
    let base = jitter(stream, base, 0.12, 0.04);
    plant(base, [1.5, 1.3, 1.2], 0.6, [0.45, 0.47, 0.42], ([0.12, 0.11, 0.07], 0.40))
}

/// A field of maize in late summer: from green to straw.
#[must_use]
pub fn maize_palette(stream: &mut Stream) -> Arc<Palette> {
    let ripe = stream.unit() as f32;
    let base = [0.078 + 0.055 * ripe, 0.122 + 0.006 * ripe, 0.044 + 0.016 * ripe];
    let base = jitter(stream, base, 0.12, 0.04);
    plant(base, [1.45, 1.3, 1.2], 0.55, [0.50, 0.52, 0.45], ([0.16, 0.13, 0.07], 0.40))
}

/// A house as a barn: weathered boards or bricks, wide gates of wood.
#[must_use]
pub fn barn_palette(stream: &mut Stream) -> Arc<Palette> {
    let (wall, pattern) = match stream.below(3) {
        0 => ([0.135, 0.090, 0.058], Pattern::Wood),
        1 => ([0.28, 0.14, 0.10], Pattern::Bricks),
        _ => ([0.40, 0.37, 0.31], Pattern::Render),
    };
    let mut materials = house_palette(stream, false).materials().to_vec();
    materials[usize::from(house_slot::WALL)] = building(jitter(stream, wall, 0.15, 0.04), pattern, 0.42);
    for slot in [house_slot::FRAME, house_slot::DOOR, house_slot::SHUTTER] {
        materials[usize::from(slot)] = building([0.11, 0.075, 0.045], Pattern::Wood, 0.42);
    }
    Arc::new(Palette::new(materials))
}

fn plate(semantic: Semantic, albedo: [f32; 3]) -> Material {
    let mut plate = Material::matt(semantic, albedo, Pattern::Plain, 0.9).polished(0.5, 0.04);
    plate.lidar.retro = true;
    plate
}

/// The colors of poles, signs and other furniture; `semantic` is the class of the body, plates are signs.
#[must_use]
pub fn furniture_palette(stream: &mut Stream, semantic: Semantic, body: [f32; 3], accent: [f32; 3]) -> Arc<Palette> {
    let body = jitter(stream, body, 0.15, 0.03);
    let gloss = |albedo: [f32; 3], reflectance: f32| {
        Material::matt(semantic, albedo, Pattern::Plain, reflectance).polished(0.45, 0.04)
    };
    let sign = if semantic == Semantic::Furniture { Semantic::Furniture } else { Semantic::TrafficSign };
    Arc::new(Palette::new(vec![
        gloss(body, 0.30),
        gloss(accent, 0.30),
        plate(sign, [0.70, 0.70, 0.68]),
        plate(sign, [0.48, 0.03, 0.03]),
        plate(sign, [0.02, 0.03, 0.05]),
        gloss([0.06, 0.06, 0.065], 0.08),
        gloss([0.36, 0.37, 0.38], 0.30),
    ]))
}
