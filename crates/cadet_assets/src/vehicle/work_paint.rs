//! The colors of what works: hauliers' boxes and tarpaulins, refuse and fire engines, buses, trailers, motorbikes.

use super::paint::{AMBER, Livery, coated, of_every_vehicle, slot, work_slot};
use cadet_base::actor::ObjectClass;
use cadet_base::material::{LidarMaterial, Material, Palette, Pattern};
use cadet_base::rng::Stream;

/// Albedo and LIDAR reflectance of enamels and tarpaulins, without their spread.
type Tone = ([f32; 3], f32);

const WHITE: Tone = ([0.70, 0.70, 0.68], 0.70);
const CREAM: Tone = ([0.62, 0.57, 0.44], 0.60);
const SILVER: Tone = ([0.40, 0.41, 0.42], 0.30);
const GRAY: Tone = ([0.17, 0.175, 0.18], 0.14);
const BLACK: Tone = ([0.02, 0.02, 0.022], 0.03);
const RED: Tone = ([0.38, 0.022, 0.02], 0.50);
const DARK_RED: Tone = ([0.16, 0.02, 0.025], 0.35);
const ORANGE: Tone = ([0.62, 0.17, 0.015], 0.55);
const YELLOW: Tone = ([0.66, 0.42, 0.03], 0.55);
const GREEN: Tone = ([0.03, 0.13, 0.06], 0.25);
const LIGHT_GREEN: Tone = ([0.14, 0.30, 0.10], 0.35);
const BLUE: Tone = ([0.02, 0.06, 0.22], 0.20);
const LIGHT_BLUE: Tone = ([0.08, 0.22, 0.45], 0.35);
const DARK_BLUE: Tone = ([0.012, 0.022, 0.075], 0.10);

const CABS: [(Tone, f64); 9] = [
    (WHITE, 0.46),
    (RED, 0.10),
    (BLUE, 0.11),
    (LIGHT_BLUE, 0.06),
    (SILVER, 0.07),
    (YELLOW, 0.07),
    (ORANGE, 0.05),
    (GREEN, 0.05),
    (DARK_BLUE, 0.03),
];
const BODIES: [(Tone, f64); 8] = [
    (WHITE, 0.58),
    (SILVER, 0.08),
    (CREAM, 0.07),
    (BLUE, 0.06),
    (RED, 0.06),
    (YELLOW, 0.05),
    (GRAY, 0.06),
    (GREEN, 0.04),
];
const TARPAULINS: [(Tone, f64); 9] = [
    (BLUE, 0.22),
    (DARK_BLUE, 0.12),
    (GRAY, 0.17),
    (WHITE, 0.14),
    (GREEN, 0.12),
    (RED, 0.08),
    (DARK_RED, 0.04),
    (BLACK, 0.05),
    (CREAM, 0.06),
];
const BUSES: [(Tone, f64); 7] =
    [(DARK_BLUE, 0.16), (WHITE, 0.30), (CREAM, 0.10), (YELLOW, 0.16), (RED, 0.14), (SILVER, 0.08), (LIGHT_BLUE, 0.06)];
const BANDS: [(Tone, f64); 8] = [
    (RED, 0.22),
    (BLUE, 0.24),
    (GREEN, 0.10),
    (LIGHT_GREEN, 0.08),
    (ORANGE, 0.09),
    (YELLOW, 0.09),
    (BLACK, 0.10),
    (DARK_BLUE, 0.08),
];
/// Colors of a tram's body, with those of its band and doors.
const TRAMS: [((Tone, Tone), f64); 6] = [
    ((YELLOW, RED), 0.46),
    ((YELLOW, GRAY), 0.14),
    ((CREAM, RED), 0.12),
    ((WHITE, YELLOW), 0.14),
    ((BLUE, WHITE), 0.07),
    ((RED, WHITE), 0.07),
];
const BIKES: [(Tone, f64); 6] =
    [(BLACK, 0.35), (RED, 0.18), (SILVER, 0.20), (DARK_BLUE, 0.10), (GREEN, 0.05), (CREAM, 0.12)];

/// The materials of a vehicle.
pub(super) fn palette(class: ObjectClass, livery: Livery, s: &mut Stream) -> Palette {
    let mut materials = of_every_vehicle(class, s);
    if livery != Livery::Private {
        add(&mut materials, livery, s);
    }
    Palette::new(materials)
}

/// Appends the slots of [`work_slot`], and repaints what such a vehicle has in a color of its own.
fn add(materials: &mut Vec<Material>, livery: Livery, s: &mut Stream) {
    let semantic = materials[0].semantic;
    let (cab, load, band) = match livery {
        Livery::Municipal => {
            let tone = if s.chance(0.65) { ORANGE } else { WHITE };
            (
                tone,
                if s.chance(0.5) { tone } else { s.pick(&[(WHITE, 0.5), (GREEN, 0.2), (ORANGE, 0.3)]) },
                if s.chance(0.5) { GRAY } else { ORANGE },
            )
        }
        Livery::Fire => (RED, RED, if s.chance(0.5) { WHITE } else { YELLOW }),
        Livery::Bus => (s.pick(&BUSES), WHITE, s.pick(&BANDS)),
        Livery::Caravan => (
            if s.chance(0.8) { WHITE } else { CREAM },
            WHITE,
            s.pick(&[(GRAY, 0.4), (BLUE, 0.2), (CREAM, 0.3), (RED, 0.1)]),
        ),
        Livery::Tram => {
            let (body, band) = TRAMS[s.weighted(&TRAMS.map(|t| t.1))].0;
            (body, GRAY, band)
        }
        Livery::Motorbike => (s.pick(&BIKES), GRAY, BLACK),
        Livery::Freight | Livery::Trailer | Livery::Private => (s.pick(&CABS), s.pick(&BODIES), s.pick(&BANDS)),
    };
    let dirt = s.range(0.82, 1.0) as f32;
    let mut worn = |(albedo, reflectance): Tone, roughness: f32| {
        let light = s.range(0.85, 1.12) as f32 * dirt;
        coated(semantic, albedo.map(|a| (a * light).clamp(0.008, 0.8)), roughness, 0.04, reflectance * dirt)
    };
    let enamel = |m: Material, gloss: f32| Material {
        lidar: LidarMaterial { coat_index: LidarMaterial::LACQUER_INDEX, gloss, roughness: 0.2, ..m.lidar },
        ..m
    };
    let paint = enamel(worn(cab, 0.12), 0.04);
    let load = enamel(worn(load, 0.28), 0.03);
    let stripe = worn(band, 0.3);
    let frame = worn(GRAY, 0.7);
    let alu = worn(SILVER, 0.4);
    materials[usize::from(slot::PAINT)] = paint;
    // Work's wheels are of steel, gray or silver.
    materials[usize::from(slot::RIM)] = worn(SILVER, 0.5);
    let tarpaulin = s.pick(&TARPAULINS);
    let canvas = Material::matt(semantic, tarpaulin.0, Pattern::Cloth, tarpaulin.1 * 0.9);
    let wood = s.range(0.7, 1.2) as f32;
    let earth = s.range(0.6, 1.3) as f32;
    let matt = |albedo: [f32; 3], reflectance: f32| Material::matt(semantic, albedo, Pattern::Plain, reflectance);
    let further: [(u8, Material); 10] = [
        (work_slot::LOAD, load),
        (work_slot::FRAME, Material { albedo: frame.albedo.map(|a| 0.25 * a), ..frame }),
        (work_slot::ALU, alu),
        (work_slot::CANVAS, canvas),
        (work_slot::BOARD, matt([0.26 * wood, 0.17 * wood, 0.09 * wood], 0.45)),
        (work_slot::AMBER, coated(semantic, AMBER, 0.15, 0.05, 0.5)),
        (work_slot::STRIPE, stripe),
        (work_slot::CARGO, matt([0.16 * earth, 0.12 * earth, 0.08 * earth], 0.25)),
        (work_slot::BEACON, coated(semantic, [0.02, 0.06, 0.5], 0.1, 0.06, 0.3)),
        (work_slot::LINING, matt([0.45, 0.45, 0.43], 0.45)),
    ];
    for (number, material) in further {
        debug_assert_eq!(materials.len(), usize::from(number));
        materials.push(material);
    }
}
