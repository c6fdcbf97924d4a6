//! What who drives or rides along a route has to brake for: traffic, people, junctions, the end of the road.

use super::idm::{IdmParameters, gap_along};
use super::junction_ahead::look_at_junction;
use super::pursuit::Axles;
use crate::math::DVec2;
use crate::world::footprint::Footprint;
use crate::world::junctions::{Refusal, Request};
use crate::world::roads::Roads;
use crate::world::route::{Ahead, Route};
use crate::world::slot::{EGO, Slot};
use crate::world::traffic_state::TrafficState;

/// How far a driver looks.
const SIGHT_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// How far one looks when standing, and at least before the front bumper.
const NEAR_M: f64 = 12.0;
const BEFORE_FRONT_M: f64 = 8.0;
/// How far one looks on a motorway.
const FAST_SIGHT_M: f64 = 260.0;
/// Room kept beside what stands, and beside what moves.
pub(crate) const SIDE_STANDING_M: f64 = 0.12;
const SIDE_MOVING_M: f64 = 0.25;
/// The same beside what moves, of who has waited long: two buses pass each other in narrow lanes with less than usual.
const SIDE_MOVING_REDUCED_M: f64 = 0.08;
/// And beside a post or what else stands.
const SIDE_STANDING_REDUCED_M: f64 = 0.04;
/// What is kept in front of all of a vehicle that turns, usually and then.
const SWEPT_M: (f64, f64) = (0.1, 0.03);

/// Where the front stops before the end of a road.
const BEFORE_END_M: f64 = 1.0;

/// What a driver brakes for most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cause {
    /// Nothing: the road is free, or nobody drives.
    Nothing,
    /// A vehicle that stands for good in the lane.
    Parked,
    /// A vehicle that moves.
    Vehicle(Slot),
    /// A person on the road.
    Person,
    /// The end of the road.
    RoadEnd,
    /// A junction that others cross or queue behind.
    Junction(Refusal),
}

/// Something to keep a gap to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constraint {
    /// From the front bumper.
    pub gap_m: f64,
    /// Its speed along the route.
    pub speed_mps: f64,
    pub cause: Cause,
}

/// What who follows a route finds ahead, and asks of the next junction.
pub(super) struct Perceived {
    pub constraints: Vec<Constraint>,
    pub request: Option<Request>,
}

/// Who goes along a route.
pub(super) struct OnRoute<'a> {
    pub slot: Slot,
    pub footprint: &'a Footprint,
    pub route: &'a Route,
    pub idm: &'a IdmParameters,
    /// Of who steers.
    pub axles: Option<Axles>,
    /// All of a train whose first car this is.
    pub train_m: Option<f64>,
    /// Whether it makes do with little room beside others, having waited.
    pub reduced_clearance: bool,
}

impl OnRoute<'_> {
    /// Its speed ahead.
    pub fn speed_mps(&self) -> f64 {
        self.footprint.velocity.dot(self.footprint.heading)
    }

    pub fn length_m(&self) -> f64 {
        self.train_m.unwrap_or(2.0 * self.footprint.half_length_m)
    }

    /// The places ahead on its route, from its middle on, that matter at its speed.
    pub fn in_sight(&self, roads: &Roads) -> Vec<Ahead> {
        let most_m = if roads.is_fast(self.route.lanes[0]) { FAST_SIGHT_M } else { SIGHT_M };
        let count = (self.sight_m().min(most_m) / SAMPLE_M) as usize;
        (0..count).map(|k| self.route.ahead(k as f64 * SAMPLE_M, roads)).collect()
    }

    /// How far ahead of its middle it matters what stands: where it stops comfortably, and two seconds more.
    fn sight_m(&self) -> f64 {
        let speed_mps = self.speed_mps().max(0.0);
        let near_m = NEAR_M.max(self.footprint.half_length_m + BEFORE_FRONT_M);
        speed_mps * speed_mps / (2.0 * self.idm.comfortable_mps2) + 2.0 * speed_mps + near_m
    }

    /// The constraint by which its front comes to a stand after so much.
    pub fn stop_in(&self, front_m: f64, cause: Cause) -> Constraint {
        Constraint { gap_m: front_m + self.idm.minimum_gap_m, speed_mps: 0.0, cause }
    }

    /// The gap to what is in the way along the places ahead, if it comes nearer than `side_m` to the vehicle's sides.
    fn gap_to(&self, o: &Footprint, side_m: f64, ahead: &[Ahead], cause: Cause) -> Option<Constraint> {
        let Footprint { half_length_m, half_width_m, .. } = *self.footprint;
        let (gap_m, speed_mps) = gap_along(ahead, SAMPLE_M, half_length_m, half_width_m + side_m, o)?;
        Some(Constraint { gap_m, speed_mps, cause })
    }

    /// The constraint that takes most off the acceleration, and how much that is.
    pub fn tightest(&self, constraints: &[Constraint]) -> (f64, Cause) {
        let speed_mps = self.speed_mps();
        constraints
            .iter()
            .map(|c| (self.idm.interaction_accel(speed_mps, c.gap_m, c.speed_mps), c.cause))
            .fold((0.0, Cause::Nothing), |worst, one| if one.0 < worst.0 { one } else { worst })
    }
}

/// The traffic on the line so far to the left of the route's: in the lane that one is changing to.
pub(super) fn traffic_aside<'a>(
    own: &'a OnRoute<'_>,
    aside_m: f64,
    ahead: &[Ahead],
    around: &'a TrafficState,
) -> impl Iterator<Item = Constraint> + 'a {
    let aside: Vec<Ahead> = ahead.iter().map(|a| Ahead { at: a.at + a.tangent.perp() * aside_m, ..*a }).collect();
    let others = around.vehicles.iter().map(|v| (v.agent, &v.footprint));
    let claimed = around.claims().map(|(other, claim)| (other, &claim.footprint));
    others
        .chain(claimed)
        .filter(|(other, _)| *other != own.slot)
        .filter_map(move |(other, o)| own.gap_to(o, SIDE_MOVING_M, &aside, Cause::Vehicle(other)))
}

/// All that one has to brake for, given the places ahead on the route.
pub(super) fn perceive(
    own: &OnRoute<'_>,
    ahead: &[Ahead],
    around: &TrafficState,
    roads: &Roads,
    step: u64,
) -> Perceived {
    let junction = look_at_junction(own, around, roads, step);
    let constraints =
        traffic_ahead(own, ahead, around, roads).into_iter().chain(road_end(own, roads)).chain(junction.stop);
    Perceived { constraints: constraints.collect(), request: junction.request }
}

/// Vehicles and people on the route, or where the vehicle is about to sweep.
fn traffic_ahead(own: &OnRoute<'_>, ahead: &[Ahead], around: &TrafficState, roads: &Roads) -> Vec<Constraint> {
    let footprint = own.footprint;
    let usual_m = (SIDE_STANDING_M, SIDE_MOVING_M, SWEPT_M.0);
    let (side_standing_m, side_moving_m, swept_m) =
        if own.reduced_clearance { (SIDE_STANDING_REDUCED_M, SIDE_MOVING_REDUCED_M, SWEPT_M.1) } else { usual_m };
    let (low, high) =
        ahead.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), a| (lo.min(a.at), hi.max(a.at)));
    let standing = || around.standing_in_lanes.iter().map(|o| (Cause::Parked, side_standing_m, o));
    // Of two side by side, the one whose front is farther on goes first: else each would wait for the other.
    let others = || around.vehicles.iter().filter(|v| v.agent != own.slot && !footprint.leads(&v.footprint));
    let moving = || others().map(|v| (Cause::Vehicle(v.agent), side_moving_m, &v.footprint));
    let people = around.people_on_road.iter().map(|o| (Cause::Person, SIDE_MOVING_M, o));
    let claims = around.claims().filter(|(other, _)| *other != own.slot);
    let claimed = claims.map(|(other, claim)| (Cause::Vehicle(other), SIDE_MOVING_M, &claim.footprint));
    let mut constraints: Vec<Constraint> = standing()
        .chain(moving())
        .chain(claimed)
        .chain(people)
        .filter(|(_, side_m, o)| {
            let reach_m = o.half_length_m + o.half_width_m + footprint.half_width_m + side_m;
            (o.center - o.center.clamp(low, high)).length() < reach_m
        })
        .filter_map(|(cause, side_m, o)| own.gap_to(o, side_m, ahead, cause))
        .collect();
    // In a bend a car sweeps more than its corridor: would its rectangle meet another's a little farther on?
    let swept = [0.8, 1.6, 2.6].into_iter().find_map(|reach_m| {
        let there = own.route.ahead(reach_m, roads);
        let swept = Footprint { center: there.at, heading: there.tangent, ..*footprint }.grown(swept_m);
        let meets = |o: &Footprint| {
            let to = o.center - footprint.center;
            to.length() < 14.0 && to.dot(footprint.heading) > 0.0 && swept.overlaps(o)
        };
        let (cause, ..) = standing().chain(moving()).find(|(_, _, o)| meets(o))?;
        Some(Constraint { gap_m: reach_m - 0.6, speed_mps: 0.0, cause })
    });
    constraints.extend(swept);
    constraints
}

/// The end of the road. Where it is the map's, all but the ego drive on and leave the world.
fn road_end(own: &OnRoute<'_>, roads: &Roads) -> Option<Constraint> {
    let sight_m = own.sight_m();
    let stays = own.slot == EGO || own.train_m.is_some() || !own.route.leads_off_map(sight_m, roads);
    let end_m = own.route.ends_in_m(roads).filter(|m| stays && *m < sight_m)?;
    Some(own.stop_in(end_m - own.footprint.half_length_m - BEFORE_END_M, Cause::RoadEnd))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::world::params::CAR;
    use crate::world::tests::towns::{ground, lane, line, town};

    #[test]
    fn a_dead_end_is_seen_where_one_can_still_stop_comfortably() {
        let mut network = crate::town::RoadNetwork::default();
        lane(&mut network, &line(DVec2::ZERO, DVec2::new(400.0, 0.0)), None, &|_, _| 0.0);
        let roads = Roads::new(town(network, ground(450.0, 10.0, &|_, _| 0.0), Vec::new()));
        let idm = CAR.draw(&mut Stream::from_seed("idm", 1));
        for speed_mps in [5.0, 14.0, 25.0, 36.0] {
            let stops_m = speed_mps * speed_mps / (2.0 * idm.comfortable_mps2);
            let route = Route::along([crate::town::LaneId(0)].into(), 400.0 - 2.2 - stops_m);
            let at = route.ahead(0.0, &roads);
            let (half_length_m, half_width_m) = (2.2, 0.9);
            let velocity = at.tangent * speed_mps;
            let own = Footprint { center: at.at, heading: at.tangent, half_length_m, half_width_m, velocity };
            let (axles, train_m, reduced_clearance) = (None, None, false);
            let route = &route;
            let rider = OnRoute { slot: EGO, footprint: &own, route, idm: &idm, axles, train_m, reduced_clearance };
            let around = TrafficState::new(&roads);
            let ahead = rider.in_sight(&roads);
            let (_, cause) = rider.tightest(&perceive(&rider, &ahead, &around, &roads, 0).constraints);
            assert_eq!(cause, Cause::RoadEnd, "{speed_mps} m/s, {stops_m} m before the end");
        }
    }
}
