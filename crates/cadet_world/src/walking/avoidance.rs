//! Which line along a sidewalk is free of things and people, and how fast one may walk behind others.

use crate::footprint::Footprint;
use crate::params::LEVEL_M;
use crate::params::walking::{BODY_M, CLOSES_S, FOLLOWS_M, SHOULDER_M, STRIDE_M, WALKS_MPS};
use crate::slot::Slot;
use crate::streets::Sidewalks;
use crate::traffic_state::{PersonAt, TrafficState};
use cadet_base::math::DVec2;

/// Somebody who walks along a walkway.
pub(crate) struct OnWalkway {
    pub slot: Slot,
    pub at: DVec2,
    pub z_m: f64,
    pub walkway: usize,
    pub s_m: f64,
    /// +1 or -1.
    pub direction: f64,
    pub walking_speed_mps: f64,
}

/// The line nearest to `line_m` that is free in the next steps, to the own right first; `None` where there is no way
/// past. Lines are offsets to the left of the walkway's, at most `widest_m` of them off the sidewalk.
pub(crate) fn free_line(
    own: &OnWalkway,
    line_m: f64,
    widest_m: f64,
    around: &TrafficState,
    sidewalks: &Sidewalks,
) -> Option<f64> {
    let here = own.at;
    let is_near = |o: &&Footprint| {
        (o.center - here).length() < o.half_length_m + o.half_width_m + 3.5 && o.is_level_with(here, own.z_m)
    };
    let near: Vec<&Footprint> = around.standing.iter().filter(is_near).collect();
    let others: Vec<&PersonAt> = others(own, around).filter(|p| (p.room.center - here).length() < 3.2).collect();
    let is_free = |lateral: f64| {
        [0.7, 1.5, 2.3].iter().all(|ahead| {
            let spot = sidewalks.spot(own.walkway, own.s_m + own.direction * ahead);
            let p = spot.at + spot.tangent.perp() * lateral;
            let clear_of_things = near.iter().all(|o| o.distance_m(p) > SHOULDER_M + 0.1);
            let clear_of_people = others.iter().all(|other| {
                // Where they will be when we get there.
                let then = other.room.center + other.room.velocity * (ahead / own.walking_speed_mps.max(0.5));
                (then - p).length() > 2.0 * SHOULDER_M
            });
            clear_of_things && clear_of_people
        })
    };
    let right = -own.direction;
    let room_m = sidewalks.room_m(own.walkway).max(widest_m);
    [0.0, 0.35, -0.35, 0.7, -0.7, 1.05, -1.05, 1.4, -1.4]
        .iter()
        .map(|d| line_m + right * d)
        .filter(|l| l.abs() <= room_m)
        .find(|l| is_free(*l))
}

/// The other people on the own level.
fn others<'a>(own: &OnWalkway, around: &'a TrafficState) -> impl Iterator<Item = &'a PersonAt> {
    let (slot, z_m) = (own.slot, own.z_m);
    around.people.iter().filter(move |p| p.agent != slot && (p.room.z_m - z_m).abs() < LEVEL_M)
}

/// The share of the own speed that keeps a stride from those who walk the same way ahead.
pub(crate) fn pace_behind(own: &OnWalkway, around: &TrafficState, sidewalks: &Sidewalks) -> f64 {
    let ahead = sidewalks.spot(own.walkway, own.s_m).tangent * own.direction;
    let paces = others(own, around).filter_map(|other| {
        let offset = other.room.center - own.at;
        let (along_m, aside_m) = (offset.dot(ahead), offset.perp_dot(ahead).abs());
        let speed_mps = other.room.velocity.dot(ahead);
        let is_followed = (0.0..FOLLOWS_M).contains(&along_m) && aside_m < 2.0 * BODY_M && speed_mps > WALKS_MPS;
        is_followed.then(|| (speed_mps + (along_m - STRIDE_M) / CLOSES_S) / own.walking_speed_mps.max(0.5))
    });
    paces.fold(f64::INFINITY, f64::min).max(0.0)
}
