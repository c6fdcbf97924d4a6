//! Colors and materials of things: drawn for each that is placed.

use std::sync::Arc;

use super::ThingKind;
use crate::assets::scenery::materials::{jitter, pane, plant_palette};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::rng::Stream;

/// Slots of a thing's palette; what grows has a plant's instead.
pub(super) mod slot {
    /// What most of it is made of.
    pub const BODY: u8 = 0;
    /// Lids, hatches, doors.
    pub const ACCENT: u8 = 1;
    /// Rubber, plastic, openings.
    pub const DARK: u8 = 2;
    /// Frames, posts, fittings.
    pub const METAL: u8 = 3;
    /// Boards and pallets.
    pub const WOOD: u8 = 4;
    /// Panes.
    pub const GLASS: u8 = 5;
    /// Posters, in two colors.
    pub const POSTER: u8 = 6;
    /// The second one.
    pub const POSTER_TOO: u8 = 7;
    /// Rubble, earth, grass.
    pub const FILL: u8 = 8;
    /// Red of a barrier.
    pub const RED: u8 = 9;
    /// White of a barrier or a board.
    pub const WHITE: u8 = 10;
}

/// Paints of skips, containers, and the like.
const PAINTS: [[f32; 3]; 8] = [
    [0.03, 0.08, 0.22],
    [0.04, 0.13, 0.06],
    [0.42, 0.27, 0.02],
    [0.30, 0.05, 0.03],
    [0.22, 0.23, 0.24],
    [0.45, 0.44, 0.41],
    [0.20, 0.10, 0.05],
    [0.36, 0.13, 0.03],
];
const TARPAULINS: [[f32; 3]; 6] = [
    [0.33, 0.34, 0.35],
    [0.16, 0.17, 0.18],
    [0.04, 0.11, 0.06],
    [0.04, 0.09, 0.22],
    [0.30, 0.27, 0.20],
    [0.05, 0.05, 0.055],
];
const BINS: [[f32; 3]; 4] = [[0.045, 0.046, 0.05], [0.10, 0.11, 0.11], [0.03, 0.09, 0.05], [0.02, 0.04, 0.10]];
const LIDS: [[f32; 3]; 5] =
    [[0.045, 0.045, 0.05], [0.02, 0.05, 0.20], [0.42, 0.30, 0.02], [0.03, 0.10, 0.05], [0.12, 0.06, 0.03]];
const BANKS: [[f32; 3]; 5] =
    [[0.03, 0.11, 0.05], [0.50, 0.50, 0.48], [0.16, 0.08, 0.04], [0.03, 0.10, 0.26], [0.30, 0.31, 0.32]];

fn one_of<const N: usize>(s: &mut Stream, colors: &[[f32; 3]; N]) -> [f32; 3] {
    colors[s.below(N)]
}

fn any_color(s: &mut Stream) -> [f32; 3] {
    let (bright, dull) = (s.range(0.05, 0.6), s.range(0.02, 0.3));
    let main = s.below(3);
    std::array::from_fn(|k| if k == main { bright as f32 } else { (dull * s.range(0.3, 1.2)) as f32 })
}

/// Printed paper seen from a street: a tint of some gray.
fn print_color(s: &mut Stream) -> [f32; 3] {
    let gray = s.range(0.06, 0.45);
    std::array::from_fn(|_| (gray * s.range(0.55, 1.45)) as f32)
}

/// Colors of a body and of its accents, as the kind has them.
fn paints(kind: ThingKind, s: &mut Stream) -> [[f32; 3]; 2] {
    match kind {
        ThingKind::LargeContainer => [one_of(s, &BINS), one_of(s, &LIDS)],
        ThingKind::GlassBank => [one_of(s, &BANKS); 2],
        ThingKind::ClothesBank => [if s.chance(0.5) { one_of(s, &BANKS) } else { any_color(s) }, one_of(s, &BANKS)],
        ThingKind::CoveredCar | ThingKind::CoveredCycle | ThingKind::WoodPile => {
            [one_of(s, &TARPAULINS), [0.10, 0.07, 0.045]]
        }
        ThingKind::Cabinet => [if s.chance(0.8) { [0.36, 0.37, 0.35] } else { [0.14, 0.18, 0.13] }; 2],
        ThingKind::Transformer => {
            let walls = [[0.50, 0.48, 0.43], [0.30, 0.31, 0.30], [0.20, 0.26, 0.18], [0.40, 0.30, 0.24]];
            [one_of(s, &walls), if s.chance(0.6) { [0.12, 0.16, 0.13] } else { [0.26, 0.27, 0.28] }]
        }
        ThingKind::Bicycle => {
            let frames = [[0.03, 0.03, 0.035], [0.40, 0.41, 0.42], [0.05, 0.07, 0.20]];
            [if s.chance(0.55) { one_of(s, &frames) } else { any_color(s) }, [0.20, 0.14, 0.09]]
        }
        ThingKind::BusShelter | ThingKind::Carport if s.chance(0.5) => [[0.10, 0.11, 0.12], [0.22, 0.13, 0.07]],
        ThingKind::Shed if s.chance(0.4) => [any_color(s).map(|c| 0.5 * c + 0.05), [0.10, 0.09, 0.085]],
        ThingKind::Shed => [[0.20, 0.125, 0.075], [0.07, 0.06, 0.055]],
        ThingKind::Parasol => [if s.chance(0.5) { [0.62, 0.58, 0.48] } else { any_color(s) }, any_color(s)],
        ThingKind::CafeChair | ThingKind::CafeTable => {
            let seats = [[0.25, 0.15, 0.08], [0.07, 0.07, 0.075], [0.48, 0.47, 0.45], [0.22, 0.04, 0.03]];
            [one_of(s, &seats); 2]
        }
        ThingKind::AdvertColumn | ThingKind::AdvertStand | ThingKind::Billboard => [[0.30, 0.30, 0.29], print_color(s)],
        _ => [one_of(s, &PAINTS), one_of(s, &PAINTS)],
    }
}

/// The colors of one thing.
#[must_use]
pub fn thing_palette(kind: ThingKind, s: &mut Stream) -> Arc<Palette> {
    if matches!(kind, ThingKind::ClippedBush | ThingKind::ShrubBed | ThingKind::Tub | ThingKind::TallPlant) {
        let is_evergreen = s.chance(0.55);
        return plant_palette(s, is_evergreen);
    }
    let semantic = match kind {
        ThingKind::Transformer | ThingKind::Shed | ThingKind::Carport => Semantic::Building,
        ThingKind::Bicycle => Semantic::OtherVehicle,
        ThingKind::Heap | ThingKind::Mound => Semantic::Terrain,
        _ => Semantic::Furniture,
    };
    let [body, accent] = paints(kind, s);
    let (pattern, body_905) = match kind {
        ThingKind::CoveredCar | ThingKind::CoveredCycle | ThingKind::WoodPile => (Pattern::Cloth, 0.35),
        ThingKind::Parasol => (Pattern::Cloth, 0.5),
        ThingKind::Transformer => (Pattern::Render, 0.4),
        ThingKind::Shed => (Pattern::Wood, 0.45),
        _ => (Pattern::Plain, 0.3),
    };
    let matt = |albedo: [f32; 3], pattern: Pattern, at_905: f32| Material::matt(semantic, albedo, pattern, at_905);
    let gloss = |albedo: [f32; 3], at_905: f32| {
        let mut m = matt(albedo, Pattern::Plain, at_905);
        m.roughness = 0.45;
        m.specular = 0.04;
        m
    };
    let body = jitter(s, body, 0.25, 0.08);
    let body = if pattern == Pattern::Plain { gloss(body, body_905) } else { matt(body, pattern, body_905) };
    let accent = jitter(s, accent, 0.2, 0.06);
    let fill = match (kind, s.below(3)) {
        (ThingKind::Mound, _) => matt(jitter(s, [0.10, 0.125, 0.045], 0.25, 0.1), Pattern::Grass, 0.42),
        (_, 0) => matt(jitter(s, [0.16, 0.12, 0.085], 0.2, 0.05), Pattern::Asphalt, 0.3),
        (_, 1) => matt(jitter(s, [0.34, 0.31, 0.27], 0.2, 0.05), Pattern::Asphalt, 0.38),
        _ => matt(jitter(s, [0.26, 0.16, 0.12], 0.2, 0.05), Pattern::Blocks, 0.33),
    };
    let mut glass = pane();
    glass.semantic = semantic;
    let mut film = |albedo: [f32; 3]| {
        let mut m = gloss(albedo, 0.4);
        m.lidar.retro = matches!(kind, ThingKind::Barrier) && s.chance(0.7);
        m
    };
    let (red, white) = (film([0.42, 0.03, 0.025]), film([0.66, 0.66, 0.63]));
    Arc::new(Palette::new(vec![
        body,
        gloss(accent, 0.3),
        gloss([0.045, 0.045, 0.05], 0.08),
        gloss([0.30, 0.31, 0.32], 0.35),
        matt(jitter(s, [0.23, 0.16, 0.10], 0.25, 0.06), Pattern::Wood, 0.45),
        glass,
        gloss(print_color(s), 0.35),
        gloss(print_color(s), 0.35),
        fill,
        red,
        white,
    ]))
}
