//! What the ground is made of.

use strum::VariantArray;

use crate::ground::Cover;
use crate::ground::land::{Crop, YardSurface};
use crate::network::{LaneSurface, PaintColor};
use crate::paint::{LEFT, Wear};
use cadet_base::material::{LidarMaterial, Material, Palette, Pattern, Semantic};
use cadet_base::road_paint::{self, WornPaint};

pub(crate) const ASPHALT: u8 = 0;
pub(crate) const SIDEWALK: u8 = 1;
pub(crate) const CURB: u8 = 2;
pub(crate) const TERRAIN: u8 = 3;
/// White paint by wear, then yellow paint.
pub(crate) const MARKING: u8 = 4;
const YELLOW_MARKING: u8 = MARKING + LEFT.len() as u8;
const BALLAST: u8 = YELLOW_MARKING + LEFT.len() as u8;
const TRACK_SLABS: u8 = BALLAST + 1;
const TRACK_GRASS: u8 = BALLAST + 2;
const BED_EDGE: u8 = BALLAST + 3;
const RAIL: u8 = BALLAST + 4;
const RAIL_SIDE: u8 = BALLAST + 5;
/// One slot a crop, in the order of [`Crop::VARIANTS`].
const FIELD: u8 = BALLAST + 6;
/// A carriageway of setts, then one slot a surface of yards, in the order of [`YardSurface::VARIANTS`].
const SETTS: u8 = FIELD + Crop::VARIANTS.len() as u8 + 1;
/// The red coat of cycle lanes, then what repairs are made of.
const RED: u8 = SETTS + 1 + YardSurface::VARIANTS.len() as u8;
const NEW_ASPHALT: u8 = RED + 1;
const OLD_ASPHALT: u8 = RED + 2;
const BITUMEN: u8 = RED + 3;
const IRON: u8 = RED + 4;
/// From new, dark asphalt to asphalt that has bleached for decades. In KITTI's pictures sunlit asphalt has values from 80 to
/// 200, most of it about 140.
const ASPHALT_ALBEDO: (f32, f32) = (0.135, 0.275);
/// At 905 nm, where asphalts differ less.
const ASPHALT_REFLECTANCE: (f32, f32) = (0.215, 0.245);
const ASPHALT_TINT: [f32; 3] = [1.01, 1.0, 0.98];
/// Repairs, by the albedo of the asphalt about them.
const NEW_BY_ASPHALT: f32 = 0.69;
const OLD_BY_ASPHALT: f32 = 1.23;
const PAINT_REFLECTANCE: f32 = 0.50;

/// What a town's streets are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Asphalt {
    albedo: f32,
    reflectance: f32,
}

impl Asphalt {
    /// Of a town with this wear; in between where nothing was drawn.
    pub(crate) fn of_town(wear: &Wear) -> Self {
        Self::bleached(wear.stream("asphalt", 0).map_or(0.5, |mut s| s.unit() as f32))
    }

    /// 0 for the darkest, 1 for the lightest.
    fn bleached(share: f32) -> Self {
        let between = |(least, most): (f32, f32)| least + (most - least) * share;
        Self { albedo: between(ASPHALT_ALBEDO), reflectance: between(ASPHALT_REFLECTANCE) }
    }

    fn material(self, by_albedo: f32, by_reflectance: f32) -> Material {
        let albedo = ASPHALT_TINT.map(|c| self.albedo * by_albedo * c);
        Material::matt(Semantic::Road, albedo, Pattern::Asphalt, self.reflectance * by_reflectance)
    }

    fn with_paint(self, fresh: [f32; 3], left: f32) -> Material {
        let albedo = WornPaint { left_share: left, asphalt_albedo: self.albedo }.albedo(fresh);
        let reflectance = self.reflectance + (PAINT_REFLECTANCE - self.reflectance) * left;
        Material::matt(Semantic::RoadMarking, albedo, Pattern::Paint, reflectance)
    }
}

pub(crate) fn slot(cover: Cover) -> u8 {
    match cover {
        Cover::Carriageway => ASPHALT,
        Cover::CurbStone => CURB,
        Cover::Sidewalk => SIDEWALK,
        Cover::Terrain => TERRAIN,
        Cover::Bed(LaneSurface::Grass) => TRACK_GRASS,
        Cover::Bed(LaneSurface::Ballast) => BALLAST,
        Cover::Bed(LaneSurface::Slabs) => TRACK_SLABS,
        Cover::Bed(LaneSurface::Usual | LaneSurface::Setts | LaneSurface::Red) => ASPHALT,
        Cover::Setts => SETTS,
        Cover::Yard(surface) => SETTS + 1 + surface as u8,
        Cover::BedEdge | Cover::Abutment => BED_EDGE,
        Cover::Field(crop) => FIELD + crop as u8,
        Cover::Shoulder => FIELD + Crop::VARIANTS.len() as u8,
    }
}

/// The slot of paint that is so worn, or of a rail, which is not.
pub(crate) fn paint(color: PaintColor, wear: usize) -> u8 {
    let first = match color {
        PaintColor::White => MARKING,
        PaintColor::Yellow => YELLOW_MARKING,
        PaintColor::Steel => return RAIL,
        PaintColor::Dark => return RAIL_SIDE,
        PaintColor::Red => return RED,
        PaintColor::NewAsphalt => return NEW_ASPHALT,
        PaintColor::OldAsphalt => return OLD_ASPHALT,
        PaintColor::Bitumen => return BITUMEN,
        PaintColor::Iron => return IRON,
    };
    first + wear.min(LEFT.len() - 1) as u8
}

/// What grows on fields, and the soil under it; then the shoulder: gravel, dry grass between.
fn fields() -> impl Iterator<Item = Material> {
    let shoulder = Material::matt(Semantic::Terrain, [0.170, 0.163, 0.137], Pattern::Asphalt, 0.32);
    let crops = Crop::VARIANTS.iter().map(|crop| {
        let (albedo, reflectance) = match crop {
            Crop::Meadow => ([0.090, 0.128, 0.044], 0.47),
            Crop::Stubble => ([0.172, 0.160, 0.092], 0.42),
            Crop::Soil => ([0.082, 0.074, 0.056], 0.26),
            Crop::Greens => ([0.058, 0.112, 0.036], 0.50),
            Crop::Maize => ([0.100, 0.100, 0.045], 0.40),
            Crop::Wood => ([0.044, 0.050, 0.026], 0.32),
        };
        Material::matt(Semantic::Terrain, albedo, Pattern::Grass, reflectance)
    });
    crops.chain([shoulder])
}

/// Setts of a street, and what covers yards.
fn yards() -> impl Iterator<Item = Material> {
    let setts = Material::matt(Semantic::Road, [0.205, 0.195, 0.18], Pattern::Blocks, 0.28);
    let surfaces = YardSurface::VARIANTS.iter().map(|surface| {
        let (albedo, pattern, reflectance) = match surface {
            YardSurface::Asphalt => ([0.187, 0.184, 0.178], Pattern::Asphalt, 0.24),
            YardSurface::Pavers => ([0.23, 0.215, 0.20], Pattern::Blocks, 0.30),
            YardSurface::Slabs => ([0.25, 0.24, 0.225], Pattern::Slabs, 0.33),
        };
        Material::matt(Semantic::Road, albedo, pattern, reflectance)
    });
    std::iter::once(setts).chain(surfaces)
}

/// New asphalt, bleached asphalt, bitumen, cast iron that tires have polished a little.
fn repairs(asphalt: Asphalt) -> [Material; 4] {
    [
        asphalt.material(NEW_BY_ASPHALT, 0.74),
        asphalt.material(OLD_BY_ASPHALT, 1.17),
        Material::matt(Semantic::Road, [0.052, 0.051, 0.050], Pattern::Plain, 0.09),
        Material::matt(Semantic::Road, [0.088, 0.080, 0.073], Pattern::Plain, 0.14),
    ]
}

/// Dry asphalt, concrete slabs and curb stones, grass, worn paint; reflectances at 905 nm.
pub(crate) fn palette(asphalt: Asphalt) -> Palette {
    let mut materials = vec![
        asphalt.material(1.0, 1.0),
        Material::matt(Semantic::Sidewalk, [0.235, 0.228, 0.213], Pattern::Slabs, 0.33),
        Material::matt(Semantic::Sidewalk, [0.275, 0.268, 0.253], Pattern::Plain, 0.36),
        Material::matt(Semantic::Terrain, [0.075, 0.115, 0.040], Pattern::Grass, 0.45),
    ];
    for fresh in [road_paint::WHITE_ALBEDO, road_paint::YELLOW_ALBEDO] {
        materials.extend(LEFT.map(|left| asphalt.with_paint(fresh, left)));
    }
    materials.extend([
        // Broken stone browned by rust, concrete, mown grass, edges of concrete.
        Material::matt(Semantic::Terrain, [0.105, 0.090, 0.076], Pattern::Asphalt, 0.24),
        Material::matt(Semantic::Road, [0.235, 0.228, 0.213], Pattern::Slabs, 0.30),
        Material::matt(Semantic::Terrain, [0.085, 0.125, 0.043], Pattern::Grass, 0.45),
        Material::matt(Semantic::Road, [0.25, 0.24, 0.225], Pattern::Plain, 0.33),
        rail(),
        Material::matt(Semantic::Road, [0.045, 0.036, 0.030], Pattern::Plain, 0.10),
    ]);
    materials.extend(fields());
    materials.extend(yards());
    materials.push(Material::matt(Semantic::Road, [0.215, 0.085, 0.065], Pattern::Asphalt, 0.30));
    materials.extend(repairs(asphalt));
    Palette::new(materials)
}

/// The head of a rail, polished by wheels: it mirrors the sky for the camera, and sends little of a slanting beam back.
fn rail() -> Material {
    Material {
        albedo: [0.30, 0.30, 0.31],
        roughness: 0.3,
        specular: 0.35,
        lidar: LidarMaterial { gloss: 0.5, roughness: 0.25, ..LidarMaterial::diffuse(0.12) },
        ..Material::matt(Semantic::Road, [0.0; 3], Pattern::Plain, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::Vec3;
    use cadet_base::rng::Stream;

    #[test]
    fn towns_have_asphalt_of_their_own_and_the_darkest_is_half_as_light_as_the_lightest() {
        let of_seed = |seed| Asphalt::of_town(&Wear::new(&mut Stream::from_seed("wear", seed))).albedo;
        let mut albedos: Vec<f32> = (0..400).map(of_seed).collect();
        assert_eq!(albedos[7], of_seed(7));
        albedos.sort_unstable_by(f32::total_cmp);
        assert!(albedos[20] < 0.15 && albedos[380] > 0.26, "{} {}", albedos[20], albedos[380]);
        assert!((albedos[200] - 0.205).abs() < 0.015, "{}", albedos[200]);
    }

    #[test]
    fn worn_paint_and_repairs_lie_in_the_asphalt_about_them() {
        for share in [0.0, 0.4, 1.0] {
            let palette = palette(Asphalt::bleached(share));
            let materials = palette.materials();
            let green = |slot: u8| materials[usize::from(slot)].albedo[1];
            for wear in 0..LEFT.len() {
                for color in [PaintColor::White, PaintColor::Yellow] {
                    let paint = materials[usize::from(paint(color, wear))].albedo;
                    let found = WornPaint::of_albedo(Vec3::from(paint));
                    assert!((found.asphalt_albedo - green(ASPHALT)).abs() < 1e-3, "{found:?}");
                    assert!((found.left_share - LEFT[wear]).abs() < 1e-3, "{found:?}");
                }
            }
            assert!(green(NEW_ASPHALT) < green(ASPHALT) && green(ASPHALT) < green(OLD_ASPHALT));
        }
    }
}
