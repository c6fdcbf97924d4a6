//! Along country roads: delineators, guard rails at bends, signs, and behind the ditch hedgerows and rows of trees.

use std::sync::Arc;

use crate::RoadNetwork;
use crate::ground::land::fields::Land;
use crate::network::road_network::RightOfWay;
use crate::placement::boundary::Boundary;
use crate::placement::occupancy::Occupancy;
use crate::placement::placer::Placer;
use crate::plots::frontage::{Frontage, right_of};
use crate::signals::Signals;
use cadet_assets::props::{DELINEATOR, DIAMOND_SIGN, GUARD_RAIL, ROUND_SIGN, Shipped, TRIANGLE_SIGN};
use cadet_assets::scenery::materials::herbs_palette;
use cadet_assets::scenery::{CROP_VARIANTS, HERBS_M, TreeKind, herbs, num_variants, tree};
use cadet_base::math::{DVec2, wrap_angle};
use cadet_base::rng::{Stream, StreamKey};

/// Delineators stand so far apart and so far from the carriageway (HLB, German guideline for delineators).
const DELINEATOR_EVERY_M: f64 = 50.0;
const DELINEATOR_OFF_M: f64 = 0.5;
/// Share of the roads with delineators, and how far they keep from junctions.
const DELINEATOR_SHARE: f64 = 0.85;
const CLEAR_OF_JUNCTION_M: f64 = 8.0;
/// Guard rails stand outside of bends that are tighter than this, so far from the carriageway, in pieces.
const RAIL_BELOW_RADIUS_M: f64 = 260.0;
const RAIL_OFF_M: f64 = 0.95;
const RAIL_PIECE_M: f64 = 4.8;
const RAIL_SHARE: f64 = 0.6;
/// No piece stands alone.
const RAIL_LEAST_PIECES: usize = 4;
/// Stretches of one kind of growth along a road.
const STRETCH_M: (f64, f64) = (35.0, 120.0);
/// Signs stand so far from the carriageway.
const SIGN_OFF_M: f64 = 1.5;

/// Furnishes one side of a road.
pub(super) fn furnish(
    (key, network, signals): (&StreamKey, &RoadNetwork, &Signals),
    s: &mut Stream,
    frontage: &Frontage,
    land: &Land,
    greenery: f64,
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let lane = frontage.lane.map(|id| network.lane(id));
    let right_of_way = lane.and_then(|lane| RightOfWay::of(lane, network, signals));
    // Both sides of a road agree on what it has.
    let mut road = key.indexed("country/road", u64::from(frontage.road));
    let (has_delineators, has_rails) = (road.chance(DELINEATOR_SHARE), road.chance(RAIL_SHARE));
    if has_delineators {
        delineators(frontage, taken, placer);
    }
    if has_rails {
        rails(s, frontage, taken, placer);
    }
    signs(s, frontage, right_of_way, placer);
    herbs_along(s, frontage, land, greenery, taken, placer);
    green(s, frontage, land, greenery, taken, placer);
}

/// The place so far from the carriageway beside a distance along the frontage.
fn beside(frontage: &Frontage, at_m: f64, off_m: f64) -> DVec2 {
    frontage.at(at_m) + right_of(frontage.along(at_m)) * (off_m - frontage.sidewalk_at(at_m))
}

/// Puts delineators at the same distances from both ends, so that those of both sides face each other.
fn delineators(frontage: &Frontage, taken: &Occupancy, placer: &mut Placer) {
    let model = DELINEATOR.model(0);
    let room_m = frontage.length_m() - 2.0 * CLEAR_OF_JUNCTION_M;
    let count = (room_m / DELINEATOR_EVERY_M).floor();
    if count < 1.0 {
        return;
    }
    let mut at_m = (frontage.length_m() - count * DELINEATOR_EVERY_M) / 2.0;
    for _ in 0..=count as usize {
        let place = beside(frontage, at_m, DELINEATOR_OFF_M);
        if placer.site.is_clear(place, DELINEATOR_OFF_M - 0.1) && taken.is_free_at(place, 0.3) {
            placer.put(&model, Arc::clone(&model.palette), place, -frontage.along(at_m));
        }
        at_m += DELINEATOR_EVERY_M;
    }
}

/// Outside of bends.
fn rails(s: &mut Stream, frontage: &Frontage, taken: &Occupancy, placer: &mut Placer) {
    let palette = GUARD_RAIL.palette(0, s);
    let heading = |m: f64| {
        let along = frontage.along(m.clamp(0.0, frontage.length_m()));
        cadet_base::math::atan2(along.y, along.x)
    };
    let last_m = frontage.length_m() - CLEAR_OF_JUNCTION_M - RAIL_PIECE_M;
    let count = ((last_m - CLEAR_OF_JUNCTION_M) / RAIL_PIECE_M).floor().max(0.0) as usize;
    // Positive turns left, away from this side.
    let turns = |m: f64| wrap_angle(heading(m + 12.0) - heading(m - 8.0)) / 20.0 > 1.0 / RAIL_BELOW_RADIUS_M;
    let at = |k: usize| CLEAR_OF_JUNCTION_M + k as f64 * RAIL_PIECE_M;
    // The ways to farms stay open.
    let is_open =
        |k: usize| taken.is_free_at(beside(frontage, at(k) + RAIL_PIECE_M / 2.0, RAIL_OFF_M), RAIL_PIECE_M / 2.0);
    let wanted: Vec<bool> = (0..count).map(|k| turns(at(k)) && is_open(k)).collect();
    let mut k = 0;
    while k < count {
        let run = wanted[k..].iter().take_while(|w| **w).count();
        if run >= RAIL_LEAST_PIECES {
            for piece in k..k + run {
                let [from, to] = [at(piece), at(piece + 1)].map(|m| beside(frontage, m, RAIL_OFF_M));
                if placer.site.is_clear(from, 0.6) && placer.site.is_clear(to, 0.6) {
                    // The sheet is to the right of its run: toward the road.
                    placer.run(Boundary::Fence(GUARD_RAIL, 0), &palette, to, from);
                }
            }
        }
        k += run.max(1);
    }
}

fn signs(s: &mut Stream, frontage: &Frontage, right_of_way: Option<RightOfWay>, placer: &mut Placer) {
    let length_m = frontage.length_m();
    let mut put = |kind: Shipped, variant: usize, at_m: f64| {
        let place = beside(frontage, at_m, SIGN_OFF_M);
        if placer.site.is_clear(place, 0.8) {
            let model = kind.model(variant);
            placer.put(&model, Arc::clone(&model.palette), place, -frontage.along(at_m));
        }
    };
    let (after, between) = (s.chance(0.5), s.chance(0.2));
    let (variant, at_m) = (s.below(3), s.range(0.3, 0.7) * length_m);
    if right_of_way == Some(RightOfWay::Yield) {
        put(TRIANGLE_SIGN, variant, length_m - 3.0);
    } else if right_of_way == Some(RightOfWay::Priority) && after && length_m > 60.0 {
        put(DIAMOND_SIGN, variant, 20.0);
    }
    if between && length_m > 100.0 {
        put(ROUND_SIGN, 1 + 2 * variant, at_m);
    }
}

/// Tall grass and herbs: at the verge's outer edge, in the ditch, and on the field's balk.
fn herbs_along(
    s: &mut Stream,
    frontage: &Frontage,
    land: &Land,
    greenery: f64,
    taken: &Occupancy,
    placer: &mut Placer,
) {
    let (verge_m, reach_m) = (land.roadside.verge_m, land.roadside.reach_m());
    // Mown or left to grow.
    let share = [0.12, 0.4, 0.75][s.weighted(&[0.35, 0.4, 0.25])] * greenery.min(1.3);
    let palettes: Vec<_> = (0..3).map(|_| herbs_palette(s)).collect();
    let mut at_m = 1.0;
    while at_m + HERBS_M.0 < frontage.length_m() {
        for (from_m, to_m) in [(verge_m + 0.1, verge_m + 0.5 * land.roadside.ditch_m), (reach_m - 0.3, reach_m + 0.9)] {
            let (is_there, variant, off_m) = (s.chance(share), s.below(CROP_VARIANTS), s.range(from_m, to_m));
            let palette = &palettes[s.below(palettes.len())];
            let [a, b] = [at_m, at_m + HERBS_M.0].map(|m| beside(frontage, m, off_m));
            let is_clear = |p: DVec2| placer.site.is_clear(p, HERBS_M.1 + 0.2) && taken.is_free_at(p, 2.0);
            if is_there && is_clear(a) && is_clear(b) {
                placer.lay(&herbs(variant), Arc::clone(palette), a, b);
            }
        }
        at_m += HERBS_M.0 * s.range(0.8, 1.4);
    }
}

/// What grows along one stretch.
#[derive(Clone, Copy)]
enum VergeGrowth {
    Nothing,
    Hedgerow,
    Row,
    Scattered,
}

/// Stretch by stretch, behind the ditch.
fn green(s: &mut Stream, frontage: &Frontage, land: &Land, greenery: f64, taken: &Occupancy, placer: &mut Placer) {
    let [_, variants, ..] = num_variants();
    let behind_m = land.roadside.reach_m();
    let mut from_m = s.range(2.0, 12.0);
    while from_m < frontage.length_m() - 4.0 {
        let to_m = (from_m + s.range(STRETCH_M.0, STRETCH_M.1)).min(frontage.length_m() - 2.0);
        let shares = [0.45 / greenery.max(0.2), 0.22, 0.15, 0.18];
        let growth = [VergeGrowth::Nothing, VergeGrowth::Hedgerow, VergeGrowth::Row, VergeGrowth::Scattered]
            [s.weighted(&shares)];
        let (row_every_m, row_variant) = (s.range(8.0, 14.0), s.below(variants));
        let mut at_m = from_m;
        while greenery > 0.0 && at_m < to_m {
            let (kind, variant, off_m, step_m) = match growth {
                VergeGrowth::Nothing => break,
                VergeGrowth::Hedgerow => {
                    let kind = [TreeKind::Shrub, TreeKind::Garden, TreeKind::Wood][s.weighted(&[0.66, 0.24, 0.10])];
                    (kind, s.below(variants), s.range(0.6, 2.6), s.range(1.0, 2.4))
                }
                VergeGrowth::Row => (TreeKind::Street, row_variant + s.below(2), 1.0, row_every_m * s.range(0.85, 1.2)),
                VergeGrowth::Scattered => {
                    let kind = [TreeKind::Shrub, TreeKind::Garden, TreeKind::Street][s.weighted(&[0.45, 0.35, 0.20])];
                    (kind, s.below(variants), s.range(0.8, 7.0), s.range(6.0, 40.0))
                }
            };
            let model = tree(kind, variant);
            let place = beside(frontage, at_m, behind_m + off_m);
            if placer.site.is_clear(place, room_m(kind, model.footprint_max.x)) && taken.is_free_at(place, 2.0) {
                let _ = placer.plant_model(kind, &model, s, place);
            }
            at_m += step_m;
        }
        from_m = to_m;
    }
}

/// How far a plant keeps from the carriageway: where leaves hang low, so far that none is in the way.
pub(super) fn room_m(kind: TreeKind, radius_m: f64) -> f64 {
    match kind {
        TreeKind::Street => 2.2,
        _ => (radius_m + 0.8).clamp(1.2, 5.6),
    }
}
