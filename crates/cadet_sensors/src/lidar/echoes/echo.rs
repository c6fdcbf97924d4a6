//! Which surface returns a beam, and how much: panes, what is behind them, and the snow on both.

use super::draws::Draws;
use crate::lidar::reflectance::{FALLEN_SNOW, pane, reflectance, under_snow};
use cadet_base::material::{LidarMaterial, Material, Pattern, Semantic};

/// Share of a glass surface's area that is dusty or printed enough to return light itself, and the reflectance there: fitted
/// to what comes back from the windows of KITTI's cars.
const DIRTY_SHARE: f64 = 0.45;
const DIRT: LidarMaterial = LidarMaterial::diffuse(0.012);
/// Within 2.5 degrees of the normal a glass surface's mirror image hits the receiver.
const GLINT_COS: f64 = 0.999;

/// A surface in a beam's way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HitSurface<'a> {
    pub range_m: f64,
    /// Cosine of the incidence angle, 0..1.
    pub cos_incidence: f64,
    pub material: &'a Material,
    /// What the place on the surface makes of the material's reflectance: 1 for what is alike everywhere.
    pub texture_factor: f64,
    /// The share of it that snow covers; 0 for ground, whose snow is the air's affair.
    pub snow_cover: f64,
    /// Towards the sensor, where surfaces are recorded.
    pub normal_velo: [f32; 3],
    pub actor_id: i32,
}

/// The surface that returns it, with the reflectance that is left after lobe and glass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Echo {
    pub range_m: f64,
    pub reflectance: f64,
    pub cos_incidence: f64,
    pub normal_velo: [f32; 3],
    pub pattern: Pattern,
    /// True if some of it comes from a retroreflector.
    pub retro: bool,
    pub actor_id: i32,
    pub semantic: Semantic,
}

/// What a retroreflector returns over what a white diffuse surface does: plates are detected at any range in clear air.
pub(super) const RETROREFLECTION_FACTOR: f64 = 1e3;

/// What returns the light of a beam that meets `transparent` (a pane of glass) and then `opaque`.
pub(crate) fn first_echo(
    transparent: Option<HitSurface<'_>>,
    opaque: Option<HitSurface<'_>>,
    draws: &Draws,
) -> Option<Echo> {
    let transparent = transparent.filter(|p| opaque.is_none_or(|s| p.range_m < s.range_m));
    let mut transmittance = 1.0;
    if let Some(transparent) = transparent {
        let own = |reflectance| Echo {
            range_m: transparent.range_m,
            reflectance,
            cos_incidence: transparent.cos_incidence,
            normal_velo: transparent.normal_velo,
            pattern: transparent.material.pattern,
            retro: false,
            actor_id: transparent.actor_id,
            semantic: transparent.material.semantic,
        };
        // The other end of the draw is dirt's.
        if draws.pane_chance() > 1.0 - transparent.snow_cover {
            return Some(own(reflectance(&FALLEN_SNOW, transparent.cos_incidence)));
        }
        if transparent.cos_incidence > GLINT_COS {
            return Some(own(1.0));
        }
        if draws.pane_chance() < DIRTY_SHARE {
            return Some(own(reflectance(&DIRT, transparent.cos_incidence)));
        }
        let once = f64::from(transparent.material.lidar.transmission) * (1.0 - pane(transparent.cos_incidence));
        transmittance = once * once;
        if opaque.is_some_and(|s| s.actor_id != transparent.actor_id) {
            // Out again on the far side.
            transmittance *= transmittance;
        }
    }
    let opaque = opaque?;
    let lidar = &opaque.material.lidar;
    let retro = lidar.retro && transmittance > 0.05;
    let gain = if retro { RETROREFLECTION_FACTOR } else { 1.0 };
    let bare = reflectance(lidar, opaque.cos_incidence) * opaque.texture_factor * gain;
    Some(Echo {
        range_m: opaque.range_m,
        reflectance: under_snow(bare, opaque.cos_incidence, opaque.snow_cover) * transmittance,
        cos_incidence: opaque.cos_incidence,
        normal_velo: opaque.normal_velo,
        pattern: opaque.material.pattern,
        retro,
        actor_id: opaque.actor_id,
        semantic: opaque.material.semantic,
    })
}
