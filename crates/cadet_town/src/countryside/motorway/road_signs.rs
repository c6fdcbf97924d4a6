//! Boards, gantries, speed limits, kilometer plates and telephones, and where rails have to shield them.

use std::ops::Range;

use crate::countryside::motorway::{CarriagewaySide, GANTRY_SHARE, stand};
use crate::placement::Placer;
use cadet_assets::props::{EMERGENCY_TELEPHONE, KILOMETER_PLATE, MOTORWAY_BOARD, SPEED_SIGN, Shipped};
use cadet_assets::scenery::gantry;
use cadet_base::rng::Stream;

/// Middles of posts stand so far from the asphalt.
const SMALL_OFF_M: f64 = 1.4;
const BOARD_OFF_M: f64 = 4.2;
const LEG_OFF_M: f64 = 1.7;
/// Shares of the sides of roads with a board, a pair of speed limits, and a telephone.
const BOARD_SHARE: f64 = 0.3;
const LIMIT_SHARE: f64 = 0.45;
const TELEPHONE_SHARE: f64 = 0.35;
/// Rails begin so far before what they shield, and end so far behind it.
const SHIELD_M: (f64, f64) = (60.0, 20.0);
/// The speed that nobody is told.
const UNLIMITED_KMH: u32 = 130;
const KILOMETER_EVERY_M: f64 = 500.0;

/// Places all posts of a side; returns the stretches that want a rail.
pub(super) fn place(s: &mut Stream, side: &CarriagewaySide, placer: &mut Placer) -> Vec<Range<f64>> {
    let (frontage, plan) = (side.frontage, side.plan);
    let length_m = frontage.length_m();
    let mut shields = Vec::new();
    let mut shield = |at_m: f64| shields.push(at_m - SHIELD_M.0..at_m + SHIELD_M.1);
    let on_frontage = |at_m: f64| {
        // Bridges are told along the middle, which runs with the first carriageway or against it.
        let (middle, _) = plan.middle(at_m);
        frontage.line.s_of_nearest_point(middle).unwrap_or(0.0)
    };
    let bridge_m = plan.bridge_m.map(on_frontage);
    if let Some(at_m) = bridge_m {
        shield(at_m);
    }
    let is_open = |at_m: f64, before_m: f64| {
        (30.0..length_m - 30.0).contains(&at_m) && bridge_m.is_none_or(|b| (b - at_m).abs() > before_m)
    };
    let put = |kind: Shipped, variant: usize, at_m: f64, off_m: f64, placer: &mut Placer| {
        placer.put_plain(&kind.model(variant), side.beside(at_m, off_m), -frontage.along(at_m));
    };
    let (has_gantry, gantry_m, gantry_variant) = (s.chance(GANTRY_SHARE), s.range(0.15, 0.85) * length_m, s.below(4));
    if has_gantry && is_open(gantry_m, 60.0) {
        // From behind the rail to the middle of the median.
        let reach_m = plan.half_paved_m + LEG_OFF_M;
        let outer = side.beside(gantry_m, LEG_OFF_M);
        let along = frontage.along(gantry_m);
        let center = outer - frontage.out(gantry_m) * (reach_m / 2.0);
        let model = gantry(gantry_variant, reach_m / 2.0, plan.num_lanes);
        stand(&model, placer.site.on_ground(center), -along, placer);
        shield(gantry_m);
    }
    let (has_board, board_m, board_variant) = (s.chance(BOARD_SHARE), s.range(0.1, 0.9) * length_m, s.below(6));
    if has_board && is_open(board_m, 80.0) && (!has_gantry || (board_m - gantry_m).abs() > 120.0) {
        put(MOTORWAY_BOARD, board_variant, board_m, BOARD_OFF_M, placer);
        shield(board_m);
    }
    let (has_limit, limit_m) = (s.chance(LIMIT_SHARE), s.range(0.1, 0.9) * length_m);
    if has_limit && plan.speed_kmh < UNLIMITED_KMH && is_open(limit_m, 30.0) {
        for off_m in [SMALL_OFF_M, -(plan.half_paved_m - plan.half_median_m) - 0.5] {
            put(SPEED_SIGN, (plan.speed_kmh / 10).max(1) as usize - 1, limit_m, off_m, placer);
        }
    }
    let (has_telephone, telephone_m) = (s.chance(TELEPHONE_SHARE), s.range(0.2, 0.8) * length_m);
    if has_telephone && plan.has_hard_shoulder && is_open(telephone_m, 15.0) {
        let place = side.beside(telephone_m, SMALL_OFF_M + 0.4);
        placer.put_plain(&EMERGENCY_TELEPHONE.model(0), place, -frontage.out(telephone_m));
    }
    let mut at_m = 40.0;
    while at_m < length_m {
        if is_open(at_m, 8.0) {
            put(KILOMETER_PLATE, plan.number, at_m, SMALL_OFF_M + 0.2, placer);
        }
        at_m += KILOMETER_EVERY_M;
    }
    shields
}
