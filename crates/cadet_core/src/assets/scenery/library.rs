//! The prototypes: each is made once a process, when it is first asked for, and depends on its kind and variant only.

use std::sync::{Arc, OnceLock};

use super::building::{Design, House};
use super::city::CityDesign;
use super::hall::HallDesign;
use super::house::HouseDesign;
use super::materials::{fence_palette, furniture_palette, house_palette, plant_palette};
use super::tree::TreeDesign;
use super::{
    CityKind, Detail, FenceKind, FurnitureKind, HALL_VARIANTS, HallKind, HouseKind, LotFurniture, NUM_CITY_HOUSES,
    PoleKind, SceneryModel, THING_VARIANTS, ThingKind, TreeKind, city_palette, fence as fences, furniture as bins,
    garage as garages, hall_palette, hedge as hedges, lot_furniture_palette, pole as poles, thing_palette, things,
};
use crate::geometry::{Bounds, LodSet, MeshBuilder};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::{DVec2, Vec3};
use crate::rng::Stream;

/// Lengths that hedges and fences come in, the longest first.
pub const PIECE_LENGTHS_M: [f64; 5] = [9.6, 4.8, 2.4, 1.2, 0.6];

/// People pass below what is higher.
pub const OVERHEAD_M: f64 = 1.9;
const HOUSES: usize = 5;
const TREES: usize = 6;
const FENCES: usize = 2;
const POLES: usize = 6;
const FURNITURE: usize = 3;
const HEDGES: usize = hedges::SECTIONS_M.len();

/// How many variants [`house`], [`tree`], [`fence`], [`hedge`], [`pole`] and [`furniture`] have; a larger number wraps.
#[must_use]
pub fn num_variants() -> [usize; 6] {
    [HOUSES, TREES, FENCES, HEDGES, POLES, FURNITURE]
}

type Cell = OnceLock<SceneryModel>;

macro_rules! cells {
    ($n:expr) => {
        [const { Cell::new() }; $n]
    };
}

fn model(name: String, shape: Arc<LodSet>, palette: Arc<Palette>, half: DVec2, height_m: f64) -> SceneryModel {
    SceneryModel { name, shape, palette, footprint_min: -half, footprint_max: half, height_m }
}

/// A house; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn house(kind: HouseKind, variant: usize) -> House {
    static CELLS: [Cell; HOUSES * HouseKind::ALL.len()] = cells!(HOUSES * HouseKind::ALL.len());
    let variant = variant % HOUSES;
    let design = HouseDesign::new(kind, variant);
    let model = CELLS[kind as usize * HOUSES + variant]
        .get_or_init(|| {
            let design = design.clone();
            let name = format!("{}/{variant}", kind.name());
            let palette = house_palette(&mut Stream::from_seed(&name, 0), design.flat_roof);
            let half = DVec2::new(f64::from(design.depth), f64::from(design.width)) / 2.0;
            let height_m = f64::from(design.height());
            let shape = Detail::levels([42.0, 88.0, f32::INFINITY], move |d| design.mesh(d));
            model(name, shape, palette, half, height_m)
        })
        .clone();
    House { model, design: Design::Garden(design) }
}

/// A house of a closed row; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn city_house(kind: CityKind, variant: usize) -> House {
    const MOST: usize = 12;
    static CELLS: [Cell; 3 * MOST] = cells!(3 * MOST);
    let variant = variant % NUM_CITY_HOUSES[kind as usize];
    let design = CityDesign::new(kind, variant);
    let model = CELLS[kind as usize * MOST + variant]
        .get_or_init(|| {
            let design = design.clone();
            let name = format!("{}/{variant}", kind.name());
            let palette = design.lit_shops(city_palette(&mut Stream::from_seed(&name, 0)));
            let half = DVec2::new(f64::from(design.depth), f64::from(design.width)) / 2.0;
            let height_m = f64::from(design.height());
            let shape = Detail::levels([42.0, 88.0, f32::INFINITY], move |d| design.mesh(d));
            model(name, shape, palette, half, height_m)
        })
        .clone();
    House { model, design: Design::Row(design) }
}

/// A large building; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn hall(kind: HallKind, variant: usize) -> SceneryModel {
    static CELLS: [Cell; HALL_VARIANTS * HallKind::ALL.len()] = cells!(HALL_VARIANTS * HallKind::ALL.len());
    let variant = variant % HALL_VARIANTS;
    CELLS[kind as usize * HALL_VARIANTS + variant]
        .get_or_init(|| {
            let design = HallDesign::new(kind, variant);
            let name = format!("{}/{variant}", kind.name());
            let palette = hall_palette(kind, &mut Stream::from_seed(&name, 0));
            let half = DVec2::new(f64::from(design.depth), f64::from(design.width)) / 2.0;
            let height_m = f64::from(design.height());
            let shape = Detail::levels([50.0, 100.0, f32::INFINITY], move |d| design.mesh(d));
            model(name, shape, palette, half, height_m)
        })
        .clone()
}

/// A piece of what stands on lots: it looks along +x.
#[must_use]
pub fn lot_furniture(kind: LotFurniture) -> SceneryModel {
    static CELLS: [Cell; LotFurniture::ALL.len()] = cells!(LotFurniture::ALL.len());
    CELLS[kind as usize]
        .get_or_init(|| {
            let palette = lot_furniture_palette(kind, &mut Stream::from_seed(kind.name(), 0));
            let shape = Detail::levels(kind.limits_m(), move |d| kind.mesh(d));
            let below = Bounds::of(shape.levels[0].1.vertices.iter().copied().filter(|p| f64::from(p.z) < OVERHEAD_M));
            SceneryModel {
                name: kind.name().to_owned(),
                palette,
                footprint_min: below.min.truncate().as_dvec2(),
                footprint_max: below.max.truncate().as_dvec2(),
                height_m: f64::from(shape.bounds.max.z),
                shape,
            }
        })
        .clone()
}

/// A garage of one or two bays; the doors face +x.
#[must_use]
pub fn garage(bays: usize) -> SceneryModel {
    static CELLS: [Cell; 2] = cells!(2);
    let bays = bays.clamp(1, 2);
    CELLS[bays - 1]
        .get_or_init(|| {
            let name = format!("garage/{bays}");
            let palette = house_palette(&mut Stream::from_seed(&name, 0), true);
            let half = DVec2::new(f64::from(garages::DEPTH_M), f64::from(garages::BAY_M) * bays as f64) / 2.0;
            let shape = Detail::levels([38.0, 88.0, f32::INFINITY], move |d| garages::mesh(bays, d));
            model(name, shape, palette, half, f64::from(garages::HEIGHT_M) + 0.2)
        })
        .clone()
}

/// A tree; the trunk stands at the origin. The footprint is the crown's.
#[must_use]
pub fn tree(kind: TreeKind, variant: usize) -> SceneryModel {
    static CELLS: [Cell; TREES * TreeKind::ALL.len()] = cells!(TREES * TreeKind::ALL.len());
    let variant = variant % TREES;
    CELLS[kind as usize * TREES + variant]
        .get_or_init(|| {
            let design = TreeDesign::new(kind, variant);
            let name = format!("{}/{variant}", kind.name());
            let palette = plant_palette(&mut Stream::from_seed(&name, 0), kind.is_evergreen());
            let half = DVec2::splat(f64::from(design.crown_radius));
            let height_m = f64::from(design.height);
            model(name, Arc::new(design.shape()), palette, half, height_m)
        })
        .clone()
}

/// A piece of hedge along +x, of length [`PIECE_LENGTHS_M`]`[piece]`.
#[must_use]
pub fn hedge(variant: usize, piece: usize) -> SceneryModel {
    const PIECES: usize = PIECE_LENGTHS_M.len();
    static CELLS: [Cell; HEDGES * PIECES] = cells!(HEDGES * PIECES);
    let (variant, piece) = (variant % HEDGES, piece % PIECES);
    CELLS[variant * PIECES + piece]
        .get_or_init(|| {
            let length_m = PIECE_LENGTHS_M[piece];
            let (height, depth) = hedges::SECTIONS_M[variant];
            let name = format!("hedge/{variant}/{length_m}");
            let palette = plant_palette(&mut Stream::from_seed("hedge", variant as u64), variant % 2 == 0);
            let shape = Detail::levels([18.0, 40.0, 180.0], move |d| hedges::mesh(variant, length_m as f32, d));
            SceneryModel {
                name,
                shape,
                palette,
                footprint_min: DVec2::new(0.0, -f64::from(depth) / 2.0),
                footprint_max: DVec2::new(length_m, f64::from(depth) / 2.0),
                height_m: f64::from(height),
            }
        })
        .clone()
}

/// A piece of fence along +x, of length [`PIECE_LENGTHS_M`]`[piece]`.
#[must_use]
pub fn fence(kind: FenceKind, variant: usize, piece: usize) -> SceneryModel {
    const PIECES: usize = PIECE_LENGTHS_M.len();
    const COUNT: usize = FENCES * PIECES * FenceKind::ALL.len();
    static CELLS: [Cell; COUNT] = cells!(COUNT);
    let (variant, piece) = (variant % FENCES, piece % PIECES);
    CELLS[(kind as usize * FENCES + variant) * PIECES + piece]
        .get_or_init(|| {
            let length_m = PIECE_LENGTHS_M[piece];
            let name = format!("{}/{variant}/{length_m}", kind.name());
            let palette = fence_palette(&mut Stream::from_seed(kind.name(), variant as u64), kind.is_metal());
            let limits_m = if kind == FenceKind::Wire { [8.0, 22.0, 100.0] } else { [25.0, 60.0, 160.0] };
            SceneryModel {
                name,
                shape: Detail::levels(limits_m, move |d| fences::mesh(kind, variant, length_m as f32, d)),
                palette,
                footprint_min: DVec2::new(0.0, -0.2),
                footprint_max: DVec2::new(length_m, 0.2),
                height_m: kind.height_m(variant),
            }
        })
        .clone()
}

/// A lamp, sign or bollard.
#[must_use]
pub fn pole(kind: PoleKind, variant: usize) -> SceneryModel {
    static CELLS: [Cell; POLES * PoleKind::ALL.len()] = cells!(POLES * PoleKind::ALL.len());
    let variant = variant % POLES;
    CELLS[kind as usize * POLES + variant]
        .get_or_init(|| {
            let name = format!("{}/{variant}", kind.name());
            let mut s = Stream::from_seed(&name, 0);
            let (body, accent) = match kind {
                PoleKind::Lamp | PoleKind::ArmLamp if s.chance(0.4) => ([0.05, 0.07, 0.06], [0.50, 0.50, 0.48]),
                PoleKind::DiamondSign => ([0.32, 0.33, 0.34], [0.55, 0.36, 0.02]),
                PoleKind::Delineator => ([0.32, 0.33, 0.34], [0.62, 0.62, 0.60]),
                PoleKind::Bollard => ([0.30, 0.03, 0.03], [0.5, 0.5, 0.5]),
                _ => ([0.32, 0.33, 0.34], [0.46, 0.46, 0.45]),
            };
            let mut palette = furniture_palette(&mut s, Semantic::Pole, body, accent);
            if matches!(kind, PoleKind::ParkingSign | PoleKind::NameSign | PoleKind::RoundaboutSign) {
                let mut blue = palette.materials().to_vec();
                blue[usize::from(super::materials::furniture_slot::INK)].albedo = [0.015, 0.05, 0.28];
                palette = Arc::new(Palette::new(blue));
            }
            let shape = Detail::levels([25.0, 60.0, 220.0], move |d| poles::mesh(kind, variant, d));
            let height_m = f64::from(shape.bounds.max.z);
            model(name, shape, palette, DVec2::splat(0.12), height_m)
        })
        .clone()
}

/// A piece of street furniture.
#[must_use]
pub fn furniture(kind: FurnitureKind, variant: usize) -> SceneryModel {
    static CELLS: [Cell; FURNITURE * FurnitureKind::ALL.len()] = cells!(FURNITURE * FurnitureKind::ALL.len());
    let variant = variant % FURNITURE;
    CELLS[kind as usize * FURNITURE + variant]
        .get_or_init(|| {
            let name = format!("{}/{variant}", kind.name());
            let mut s = Stream::from_seed(&name, 0);
            let (body, accent) = match kind {
                FurnitureKind::SmallBin | FurnitureKind::LargeBin => {
                    let lids = [[0.04, 0.04, 0.045], [0.02, 0.05, 0.20], [0.35, 0.24, 0.02]];
                    ([0.045, 0.046, 0.05], lids[variant])
                }
                FurnitureKind::Cabinet => ([0.36, 0.37, 0.36], [0.33, 0.34, 0.33]),
                FurnitureKind::PostBox => ([0.5, 0.5, 0.5], [0.62, 0.42, 0.01]),
                FurnitureKind::Bench => ([0.1, 0.1, 0.1], [0.20, 0.12, 0.06]),
                FurnitureKind::GatePost => ([0.42, 0.40, 0.36], [0.33, 0.32, 0.30]),
                FurnitureKind::Planter => ([0.33, 0.30, 0.27], [0.06, 0.10, 0.04]),
            };
            let palette = furniture_palette(&mut s, Semantic::Furniture, body, accent);
            let shape = Detail::levels([25.0, 60.0, 120.0], move |d| bins::mesh(kind, variant, d));
            let size = shape.bounds.size().as_dvec3();
            model(name, shape, palette, DVec2::new(size.x, size.y) / 2.0, size.z)
        })
        .clone()
}

/// A thing beside the street. Its footprint is what of it lies below [`OVERHEAD_M`].
#[must_use]
pub fn thing(kind: ThingKind, variant: usize) -> SceneryModel {
    static CELLS: [Cell; THING_VARIANTS * ThingKind::ALL.len()] = cells!(THING_VARIANTS * ThingKind::ALL.len());
    let variant = variant % THING_VARIANTS;
    CELLS[kind as usize * THING_VARIANTS + variant]
        .get_or_init(|| {
            let name = format!("{}/{variant}", kind.name());
            let palette = thing_palette(kind, &mut Stream::from_seed(&name, 0));
            let shape = Detail::levels(kind.limits_m(), move |d| things::mesh(kind, variant, d));
            let finest = &shape.levels[0].1;
            let below = Bounds::of(finest.vertices.iter().copied().filter(|p| f64::from(p.z) < OVERHEAD_M));
            let height_m = f64::from(shape.bounds.max.z);
            SceneryModel {
                name,
                palette,
                footprint_min: below.min.truncate().as_dvec2(),
                footprint_max: below.max.truncate().as_dvec2(),
                height_m,
                shape,
            }
        })
        .clone()
}

/// A piece of paving along +x, its middle line y = 0, and its length: for a car's width or for a person's.
#[must_use]
pub fn paving(for_cars: bool) -> (SceneryModel, f64) {
    static CELLS: [Cell; 2] = cells!(2);
    let (length_m, width_m) = if for_cars { (2.5, 3.0) } else { (1.5, 1.2) };
    let model = CELLS[usize::from(for_cars)].get_or_init(|| {
        let mut b = MeshBuilder::new();
        let (length, half) = (length_m as f32, width_m as f32 / 2.0);
        b.cuboid(Vec3::new(0.0, -half, -0.25), Vec3::new(length, half, 0.015), 0);
        let blocks = Material::matt(Semantic::Terrain, [0.21, 0.195, 0.18], Pattern::Blocks, 0.28);
        SceneryModel {
            name: format!("paving/{length_m}"),
            shape: Arc::new(LodSet::new((150.0, b.build("paving", 0.7)), [])),
            palette: Arc::new(Palette::new(vec![blocks])),
            footprint_min: DVec2::new(0.0, -width_m / 2.0),
            footprint_max: DVec2::new(length_m, width_m / 2.0),
            height_m: 0.015,
        }
    });
    (model.clone(), length_m)
}
