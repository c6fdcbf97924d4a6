//! Along country roads: delineators, guard rails at bends, signs, and behind the ditch hedgerows and rows of trees.

use std::sync::Arc;

use crate::countryside::{Country, runs};
use crate::network::{RightOfWay, RoadNetwork};
use crate::placement::{Boundary, Placer};
use crate::plots::Frontage;
use crate::signals::Signals;
use cadet_assets::props::{DELINEATOR, DIAMOND_SIGN, GUARD_RAIL, ROUND_SIGN, Shipped, TRIANGLE_SIGN};
use cadet_assets::scenery::materials::herbs_palette;
use cadet_assets::scenery::{CROP_VARIANTS, HERBS_M, TreeKind, herbs, num_variants, tree};
use cadet_base::math::{DVec2, wrap_angle};
use cadet_base::plane::heading_rad;
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
    country: &mut Country,
) {
    let lane = frontage.lane.map(|id| network.lane(id));
    let right_of_way = lane.and_then(|lane| RightOfWay::of(lane, network, signals));
    // Both sides of a road agree on what it has.
    let mut road = key.indexed("country/road", u64::from(frontage.road));
    let (has_delineators, has_rails) = (road.chance(DELINEATOR_SHARE), road.chance(RAIL_SHARE));
    if has_delineators {
        delineators(frontage, country);
    }
    if has_rails {
        rails(s, frontage, country);
    }
    signs(s, frontage, right_of_way, country.placer);
    herbs_along(s, frontage, country);
    green(s, frontage, country);
}

/// The place so far from the carriageway beside a distance along the frontage.
fn beside(frontage: &Frontage, at_m: f64, off_m: f64) -> DVec2 {
    frontage.behind(at_m, off_m - frontage.sidewalk_at(at_m))
}

/// Puts delineators at the same distances from both ends, so that those of both sides face each other.
fn delineators(frontage: &Frontage, country: &mut Country) {
    let model = DELINEATOR.model(0);
    let room_m = frontage.length_m() - 2.0 * CLEAR_OF_JUNCTION_M;
    let count = (room_m / DELINEATOR_EVERY_M).floor();
    if count < 1.0 {
        return;
    }
    let mut at_m = (frontage.length_m() - count * DELINEATOR_EVERY_M) / 2.0;
    for _ in 0..=count as usize {
        let place = beside(frontage, at_m, DELINEATOR_OFF_M);
        if country.is_clear(place, DELINEATOR_OFF_M - 0.1, 0.3) {
            country.placer.put_plain(&model, place, -frontage.along(at_m));
        }
        at_m += DELINEATOR_EVERY_M;
    }
}

/// Outside of bends.
fn rails(s: &mut Stream, frontage: &Frontage, country: &mut Country) {
    let palette = GUARD_RAIL.palette(0, s);
    let heading = |m: f64| heading_rad(frontage.along(m.clamp(0.0, frontage.length_m())));
    let last_m = frontage.length_m() - CLEAR_OF_JUNCTION_M - RAIL_PIECE_M;
    let count = ((last_m - CLEAR_OF_JUNCTION_M) / RAIL_PIECE_M).floor().max(0.0) as usize;
    // Positive turns left, away from this side.
    let turns = |m: f64| wrap_angle(heading(m + 12.0) - heading(m - 8.0)) / 20.0 > 1.0 / RAIL_BELOW_RADIUS_M;
    let at = |k: usize| CLEAR_OF_JUNCTION_M + k as f64 * RAIL_PIECE_M;
    // The ways to farms stay open.
    let is_open = |k: usize| {
        country.taken.is_free_at(beside(frontage, at(k) + RAIL_PIECE_M / 2.0, RAIL_OFF_M), RAIL_PIECE_M / 2.0)
    };
    let wanted: Vec<bool> = (0..count).map(|k| turns(at(k)) && is_open(k)).collect();
    for piece in runs(&wanted).into_iter().filter(|run| run.len() >= RAIL_LEAST_PIECES).flatten() {
        let [from, to] = [at(piece), at(piece + 1)].map(|m| beside(frontage, m, RAIL_OFF_M));
        if [from, to].iter().all(|p| country.placer.site.is_clear(*p, 0.6)) {
            // The sheet is to the right of its run: toward the road.
            country.placer.run(Boundary::Fence(GUARD_RAIL, 0), &palette, to, from);
        }
    }
}

fn signs(s: &mut Stream, frontage: &Frontage, right_of_way: Option<RightOfWay>, placer: &mut Placer) {
    let length_m = frontage.length_m();
    let mut put = |kind: Shipped, variant: usize, at_m: f64| {
        let place = beside(frontage, at_m, SIGN_OFF_M);
        if placer.site.is_clear(place, 0.8) {
            placer.put_plain(&kind.model(variant), place, -frontage.along(at_m));
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
fn herbs_along(s: &mut Stream, frontage: &Frontage, country: &mut Country) {
    let roadside = &country.land.roadside;
    let (verge_m, reach_m) = (roadside.verge_m, roadside.reach_m());
    // Mown or left to grow.
    let share = s.pick(&[(0.12, 0.35), (0.4, 0.4), (0.75, 0.25)]) * country.greenery.min(1.3);
    let palettes: Vec<_> = (0..3).map(|_| herbs_palette(s)).collect();
    let mut at_m = 1.0;
    while at_m + HERBS_M.0 < frontage.length_m() {
        for strip_m in [(verge_m + 0.1, verge_m + 0.5 * roadside.ditch_m), (reach_m - 0.3, reach_m + 0.9)] {
            let (is_there, variant, off_m) = (s.chance(share), s.below(CROP_VARIANTS), s.within(strip_m));
            let palette = &palettes[s.below(palettes.len())];
            let [a, b] = [at_m, at_m + HERBS_M.0].map(|m| beside(frontage, m, off_m));
            if is_there && [a, b].iter().all(|p| country.is_clear(*p, HERBS_M.1 + 0.2, 2.0)) {
                country.placer.lay(&herbs(variant), Arc::clone(palette), a, b);
            }
        }
        at_m += HERBS_M.0 * s.range(0.8, 1.4);
    }
}

/// What grows along one stretch.
#[derive(Clone, Copy)]
enum VergeGrowth {
    Nothing,
    /// Trees of one kind at even distances.
    Row,
    Mixed(&'static Mixture),
}

/// Plants by their weights, and how far behind the ditch and from each other they grow.
struct Mixture {
    kinds: [(TreeKind, f64); 3],
    off_m: (f64, f64),
    step_m: (f64, f64),
}

const HEDGEROW: Mixture = Mixture {
    kinds: [(TreeKind::Shrub, 0.66), (TreeKind::Garden, 0.24), (TreeKind::Wood, 0.10)],
    off_m: (0.6, 2.6),
    step_m: (1.0, 2.4),
};
const SCATTERED: Mixture = Mixture {
    kinds: [(TreeKind::Shrub, 0.45), (TreeKind::Garden, 0.35), (TreeKind::Street, 0.20)],
    off_m: (0.8, 7.0),
    step_m: (6.0, 40.0),
};

/// Stretch by stretch, behind the ditch.
fn green(s: &mut Stream, frontage: &Frontage, country: &mut Country) {
    let [_, variants, ..] = num_variants();
    let behind_m = country.land.roadside.reach_m();
    let growths = [
        (VergeGrowth::Nothing, 0.45 / country.greenery.max(0.2)),
        (VergeGrowth::Mixed(&HEDGEROW), 0.22),
        (VergeGrowth::Row, 0.15),
        (VergeGrowth::Mixed(&SCATTERED), 0.18),
    ];
    let mut from_m = s.range(2.0, 12.0);
    while from_m < frontage.length_m() - 4.0 {
        let to_m = (from_m + s.within(STRETCH_M)).min(frontage.length_m() - 2.0);
        let growth = s.pick(&growths);
        let (row_every_m, row_variant) = (s.range(8.0, 14.0), s.below(variants));
        let mut at_m = from_m;
        while country.greenery > 0.0 && at_m < to_m {
            let (kind, variant, off_m, step_m) = match growth {
                VergeGrowth::Nothing => break,
                VergeGrowth::Row => (TreeKind::Street, row_variant + s.below(2), 1.0, row_every_m * s.range(0.85, 1.2)),
                VergeGrowth::Mixed(of) => {
                    (s.pick(&of.kinds), s.below(variants), s.within(of.off_m), s.within(of.step_m))
                }
            };
            country.plant(kind, &tree(kind, variant), s, beside(frontage, at_m, behind_m + off_m));
            at_m += step_m;
        }
        from_m = to_m;
    }
}
