//! At the outer edges: rails on embankments and before posts, delineators, and noise walls.

use std::ops::Range;
use std::sync::Arc;

use crate::countryside::motorway::CarriagewaySide;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::Placer;
use cadet_assets::props::{DELINEATOR, MOTORWAY_RAIL, NOISE_WALL};
use cadet_assets::scenery::MOTORWAY_PIECE_M;
use cadet_base::math::DVec2;
use cadet_base::plane::OrientedRect;
use cadet_base::rng::Stream;

/// Delineators stand so far apart and from the asphalt (HLB, German guideline for delineators).
const DELINEATOR_EVERY_M: f64 = 50.0;
const DELINEATOR_OFF_M: f64 = 0.5;
/// Rails stand so far from the asphalt, where the land falls off by more than this, and for so many pieces at least.
const RAIL_OFF_M: f64 = 1.0;
const RAIL_FROM_M: f64 = 1.4;
const RAIL_LEAST_PIECES: usize = 6;
/// Share of the sides of roads with a noise wall, how much of the side it takes, and where it stands.
const WALL_SHARE: f64 = 0.2;
const WALL_OF_SIDE: (f64, f64) = (0.3, 0.9);
const WALL_OFF_M: f64 = 3.0;

pub(super) fn furnish(
    s: &mut Stream,
    side: &CarriagewaySide,
    shields: &[Range<f64>],
    taken: &mut Occupancy,
    placer: &mut Placer,
) {
    let length_m = side.frontage.length_m();
    let count = (length_m / MOTORWAY_PIECE_M).round().max(1.0) as usize;
    let step_m = length_m / count as f64;
    let wall = noise_wall(s, count);
    if let Some((pieces, variant)) = &wall {
        let model = NOISE_WALL.model(*variant);
        for k in pieces.clone() {
            let [from, to] = [k, k + 1].map(|i| side.beside(step_m * i as f64, WALL_OFF_M));
            // Its front is to the road.
            placer.lay(&model, Arc::clone(&model.palette), to, from);
            let (along, half) = ((to - from).normalize_or(DVec2::X), DVec2::new(step_m / 2.0, 1.2));
            taken.take(OrientedRect { center: (from + to) / 2.0, axis: along, half });
        }
    }
    let is_wanted = |k: usize| {
        let at_m = step_m * (k as f64 + 0.5);
        let [road_z, land_z] =
            [0.0, side.land.roadside.reach_m()].map(|off_m| placer.site.on_ground(side.beside(at_m, off_m)).z);
        let has_wall = wall.as_ref().is_some_and(|(pieces, _)| pieces.contains(&k));
        road_z - land_z > RAIL_FROM_M || has_wall || shields.iter().any(|r| r.contains(&at_m))
    };
    let wanted: Vec<bool> = (0..count).map(is_wanted).collect();
    let rail = MOTORWAY_RAIL.model(0);
    let mut k = 0;
    while k < count {
        let run = wanted[k..].iter().take_while(|w| **w == wanted[k]).count();
        if wanted[k] && (run >= RAIL_LEAST_PIECES || k == 0 || k + run == count) {
            for piece in k..k + run {
                let [from, to] = [piece, piece + 1].map(|i| side.beside(step_m * i as f64, RAIL_OFF_M));
                placer.lay(&rail, Arc::clone(&rail.palette), to, from);
            }
        }
        k += run;
    }
    delineators(side, placer);
}

/// The pieces of a side that are a noise wall, and its variant.
fn noise_wall(s: &mut Stream, count: usize) -> Option<(Range<usize>, usize)> {
    let (is_there, share, at, variant) =
        (s.chance(WALL_SHARE), s.range(WALL_OF_SIDE.0, WALL_OF_SIDE.1), s.unit(), s.below(NOISE_WALL.num_variants()));
    let pieces = (share * count as f64) as usize;
    let first = (at * (count - pieces) as f64) as usize;
    is_there.then_some((first..first + pieces, variant))
}

fn delineators(side: &CarriagewaySide, placer: &mut Placer) {
    let model = DELINEATOR.model(0);
    let count = (side.frontage.length_m() / DELINEATOR_EVERY_M).round().max(1.0);
    let step_m = side.frontage.length_m() / count;
    for k in 0..count as usize {
        let at_m = step_m * (k as f64 + 0.5);
        placer.put(&model, Arc::clone(&model.palette), side.beside(at_m, DELINEATOR_OFF_M), -side.frontage.along(at_m));
    }
}
