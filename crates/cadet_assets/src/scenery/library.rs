//! The prototypes: each is made once a process, when it is first asked for, and depends on its kind and variant only.

use super::building::{Design, House};
use super::city::CityDesign;
use super::hall::HallDesign;
use super::house::HouseDesign;
use super::materials::{house_palette, plant_palette};
use super::tree::TreeDesign;
use super::{
    CityKind, Detail, HALL_VARIANTS, HallKind, HouseKind, NUM_CITY_HOUSES, SceneryModel, TreeKind, city_palette,
    garage as garages, hall_palette, hedge as hedges,
};
use cadet_base::geometry::Memo;
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// Lengths that hedges and fences come in, the longest first.
pub const PIECE_LENGTHS_M: [f64; 5] = [9.6, 4.8, 2.4, 1.2, 0.6];

/// People pass below what is higher.
pub const OVERHEAD_M: f64 = 1.9;
const HOUSES: usize = 5;
const TREES: usize = 6;
const HEDGES: usize = hedges::SECTIONS_M.len();

/// How many variants [`house`], [`tree`], and [`hedge`] have; a larger number wraps.
#[must_use]
pub fn num_variants() -> [usize; 3] {
    [HOUSES, TREES, HEDGES]
}

type Models<K> = Memo<K, SceneryModel>;

/// A house; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn house(kind: HouseKind, variant: usize) -> House {
    static MODELS: Models<(HouseKind, usize)> = Memo::new();
    let variant = variant % HOUSES;
    let design = HouseDesign::new(kind, variant);
    let model = MODELS.get((kind, variant), || {
        let design = design.clone();
        let name = format!("{}/{variant}", kind.as_ref());
        let palette = house_palette(&mut Stream::from_seed(&name, 0), design.flat_roof);
        let half = DVec2::new(f64::from(design.depth_m), f64::from(design.width_m)) / 2.0;
        let height_m = f64::from(design.height());
        let shape = Detail::levels([42.0, 88.0, f32::INFINITY], move |d| design.mesh(d));
        SceneryModel::about_origin(name, shape, palette, half, height_m)
    });
    House { model, design: Design::Garden(design) }
}

/// A house of a closed row; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn city_house(kind: CityKind, variant: usize) -> House {
    static MODELS: Models<(CityKind, usize)> = Memo::new();
    let variant = variant % NUM_CITY_HOUSES[kind as usize];
    let design = CityDesign::new(kind, variant);
    let model = MODELS.get((kind, variant), || {
        let design = design.clone();
        let name = format!("{}/{variant}", kind.as_ref());
        let palette = design.lit_shops(city_palette(&mut Stream::from_seed(&name, 0)));
        let half = DVec2::new(f64::from(design.depth_m), f64::from(design.width_m)) / 2.0;
        let height_m = f64::from(design.height());
        let shape = Detail::levels([42.0, 88.0, f32::INFINITY], move |d| design.mesh(d));
        SceneryModel::about_origin(name, shape, palette, half, height_m)
    });
    House { model, design: Design::Row(design) }
}

/// A large building; x is its depth (the front at +x), y its width along the street.
#[must_use]
pub fn hall(kind: HallKind, variant: usize) -> SceneryModel {
    static MODELS: Models<(HallKind, usize)> = Memo::new();
    let variant = variant % HALL_VARIANTS;
    MODELS.get((kind, variant), || {
        let design = HallDesign::new(kind, variant);
        let name = format!("{}/{variant}", kind.as_ref());
        let palette = hall_palette(kind, &mut Stream::from_seed(&name, 0));
        let half = DVec2::new(f64::from(design.depth_m), f64::from(design.width_m)) / 2.0;
        let height_m = f64::from(design.height());
        let shape = Detail::levels([50.0, 100.0, f32::INFINITY], move |d| design.mesh(d));
        SceneryModel::about_origin(name, shape, palette, half, height_m)
    })
}

/// A garage of one or two bays; the doors face +x.
#[must_use]
pub fn garage(bays: usize) -> SceneryModel {
    static MODELS: Models<usize> = Memo::new();
    let bays = bays.clamp(1, 2);
    MODELS.get(bays, || {
        let name = format!("garage/{bays}");
        let palette = house_palette(&mut Stream::from_seed(&name, 0), true);
        let half = DVec2::new(f64::from(garages::DEPTH_M), f64::from(garages::BAY_M) * bays as f64) / 2.0;
        let shape = Detail::levels([38.0, 88.0, f32::INFINITY], move |d| garages::mesh(bays, d));
        SceneryModel::about_origin(name, shape, palette, half, f64::from(garages::HEIGHT_M) + 0.2)
    })
}

/// A tree; the trunk stands at the origin. The footprint is the crown's.
#[must_use]
pub fn tree(kind: TreeKind, variant: usize) -> SceneryModel {
    static MODELS: Models<(TreeKind, usize)> = Memo::new();
    let variant = variant % TREES;
    MODELS.get((kind, variant), || {
        let design = TreeDesign::new(kind, variant);
        let name = format!("{}/{variant}", kind.as_ref());
        let palette = plant_palette(&mut Stream::from_seed(&name, 0), kind.is_evergreen());
        let half = DVec2::splat(f64::from(design.crown_radius_m));
        let height_m = f64::from(design.height_m);
        SceneryModel::about_origin(name, design.shape().into(), palette, half, height_m)
    })
}

/// A piece of hedge along +x, of length [`PIECE_LENGTHS_M`]`[piece]`.
#[must_use]
pub fn hedge(variant: usize, piece: usize) -> SceneryModel {
    const PIECES: usize = PIECE_LENGTHS_M.len();
    static MODELS: Models<(usize, usize)> = Memo::new();
    let (variant, piece) = (variant % HEDGES, piece % PIECES);
    MODELS.get((variant, piece), || {
        let length_m = PIECE_LENGTHS_M[piece];
        let (height, depth) = hedges::SECTIONS_M[variant];
        let name = format!("hedge/{variant}/{length_m}");
        let palette = plant_palette(&mut Stream::from_seed("hedge", variant as u64), variant % 2 == 0);
        let shape = Detail::levels([18.0, 40.0, 180.0], move |d| hedges::mesh(variant, length_m as f32, d));
        SceneryModel::along_x(name, shape, palette, (length_m, f64::from(depth) / 2.0), height.into())
    })
}
