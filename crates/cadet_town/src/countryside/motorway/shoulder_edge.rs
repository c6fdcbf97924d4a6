//! At the outer edges: rails on embankments and before posts, delineators, and noise walls.

use std::ops::Range;

use crate::countryside::motorway::CarriagewaySide;
use crate::countryside::{Country, runs};
use crate::placement::Placer;
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

pub(super) fn furnish(s: &mut Stream, side: &CarriagewaySide, shields: &[Range<f64>], country: &mut Country) {
    let Country { land, taken, placer, .. } = country;
    let (count, step_m) = side.pieces(MOTORWAY_PIECE_M);
    let ends = |piece: usize, off_m: f64| [piece, piece + 1].map(|i| side.beside(step_m * i as f64, off_m));
    let (wall, variant) = noise_wall(s, count);
    let model = NOISE_WALL.model(variant);
    for piece in wall.clone() {
        let [from, to] = ends(piece, WALL_OFF_M);
        // Its front is to the road.
        placer.lay_plain(&model, to, from);
        let (along, half) = ((to - from).normalize_or(DVec2::X), DVec2::new(step_m / 2.0, 1.2));
        taken.take(OrientedRect { center: (from + to) / 2.0, axis: along, half });
    }
    let is_wanted = |k: usize| {
        let at_m = step_m * (k as f64 + 0.5);
        let [road_z, land_z] =
            [0.0, land.roadside.reach_m()].map(|off_m| placer.site.on_ground(side.beside(at_m, off_m)).z);
        road_z - land_z > RAIL_FROM_M || wall.contains(&k) || shields.iter().any(|r| r.contains(&at_m))
    };
    let wanted: Vec<bool> = (0..count).map(is_wanted).collect();
    let rail = MOTORWAY_RAIL.model(0);
    let is_kept = |run: &Range<usize>| run.len() >= RAIL_LEAST_PIECES || run.start == 0 || run.end == count;
    for piece in runs(&wanted).into_iter().filter(is_kept).flatten() {
        let [from, to] = ends(piece, RAIL_OFF_M);
        placer.lay_plain(&rail, to, from);
    }
    delineators(side, placer);
}

/// The pieces of a side that are a noise wall, on most sides none, and its variant.
fn noise_wall(s: &mut Stream, count: usize) -> (Range<usize>, usize) {
    let (is_there, share, at, variant) =
        (s.chance(WALL_SHARE), s.within(WALL_OF_SIDE), s.unit(), s.below(NOISE_WALL.num_variants()));
    let pieces = (share * count as f64) as usize;
    let first = (at * (count - pieces) as f64) as usize;
    (first..first + if is_there { pieces } else { 0 }, variant)
}

fn delineators(side: &CarriagewaySide, placer: &mut Placer) {
    let model = DELINEATOR.model(0);
    let (count, step_m) = side.pieces(DELINEATOR_EVERY_M);
    for k in 0..count {
        let at_m = step_m * (k as f64 + 0.5);
        placer.put_plain(&model, side.beside(at_m, DELINEATOR_OFF_M), -side.frontage.along(at_m));
    }
}
