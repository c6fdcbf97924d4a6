//! What water and snow leave of what a surface reflects: one answer for cameras and LIDARs.

use cadet_base::material::{Material, Pattern, Semantic};

/// Refractive index of water, for the eye and at 905 nm.
pub const WATER_INDEX: f64 = 1.328;
/// Rain wets all of a surface whose normal rises by this, and nothing of a wall.
const ALL_WET_RISE: f32 = 0.5;
/// Snow begins to lie where a normal rises by this, and covers so much faster than its rise.
const SNOW_FROM_RISE: f32 = 0.4;
const SNOW_PER_RISE: f32 = 2.0;

/// What snow covers of a surface whose normal rises so steeply, by what it covers of level ones.
#[inline(always)]
#[must_use]
pub fn snow_share(rise: f32) -> f32 {
    ((rise - SNOW_FROM_RISE) * SNOW_PER_RISE).clamp(0.0, 1.0)
}

/// How wet a surface gets whose normal rises so steeply, by the wetness of level ones.
#[inline(always)]
#[must_use]
pub fn wet_share(rise: f32) -> f32 {
    (rise * (1.0 / ALL_WET_RISE)).clamp(0.0, 1.0)
}

/// Whether water soaks into a surface, so that it darkens: into paved ground, plaster, tiles, wood, and cloth, not into
/// coats, leaves, and lawns, which hold no film.
#[must_use]
pub fn absorbs_water(material: &Material) -> bool {
    let is_closed =
        material.is_transparent() || material.semantic.is_vehicle() || material.semantic == Semantic::Terrain;
    let holds_none = matches!(
        material.pattern,
        Pattern::Leaves | Pattern::Grass | Pattern::Lamp | Pattern::Window | Pattern::Reflector
    );
    !is_closed && !holds_none && (material.specular == 0.0 || material.semantic.is_ground())
}

/// Share of the light that comes back from a diffuse surface under a film of water, against the same surface dry, if so much
/// goes through the film's face.
///
/// What comes up below the face is kept inside by total reflection, all but 1 / n^2 of it, and meets the surface again
/// (Angstrom 1925). Water a few millimetres deep absorbs nothing to speak of.
#[inline(always)]
#[must_use]
pub fn under_film(reflectance: f64, entering_share: f64) -> f64 {
    let leaves = 1.0 / (WATER_INDEX * WATER_INDEX);
    entering_share * entering_share * leaves / (1.0 - reflectance.clamp(0.0, 1.0) * (1.0 - leaves))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covers_grow_with_the_rise_without_a_step() {
        for share in [snow_share, wet_share] {
            let shares: Vec<f32> = (0..=1000).map(|k| share(k as f32 * 1e-3)).collect();
            assert!(shares.windows(2).all(|pair| (0.0..0.0021).contains(&(pair[1] - pair[0]))));
            assert_eq!((share(-0.7), share(0.0), share(1.0)), (0.0, 0.0, 1.0));
        }
    }

    #[test]
    fn what_is_coated_or_grows_does_not_darken() {
        let of = |semantic, pattern| Material::matt(semantic, [0.3; 3], pattern, 0.3);
        let coated = |semantic| Material { specular: 0.04, ..of(semantic, Pattern::Plain) };
        for dark in [
            of(Semantic::Road, Pattern::Asphalt),
            of(Semantic::RoadMarking, Pattern::Paint),
            of(Semantic::Sidewalk, Pattern::Slabs),
            of(Semantic::Building, Pattern::Tiles),
            of(Semantic::Fence, Pattern::Wood),
            of(Semantic::Person, Pattern::Cloth),
        ] {
            assert!(absorbs_water(&dark), "{dark:?}");
        }
        for bright in [
            coated(Semantic::Car),
            of(Semantic::Car, Pattern::Plain),
            coated(Semantic::Furniture),
            of(Semantic::Vegetation, Pattern::Leaves),
            of(Semantic::Terrain, Pattern::Grass),
        ] {
            assert!(!absorbs_water(&bright), "{bright:?}");
        }
    }
}
