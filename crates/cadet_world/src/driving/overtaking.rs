//! Overtaking a cyclist: whether there is room and time for it, and how far off the own line it leads.

use super::junction_ahead::next_junction;
use super::on_route::OnRoute;
use crate::footprint::Footprint;
use crate::params::overtaking::{
    ACCELERATION_MPS2, AFTER_M, BEFORE_JUNCTION_M, BEHIND_S, BESIDE_M, FALLS_BACK_M, FALLS_BACK_MPS2, LEAST_GAIN_MPS,
    LEAST_RIDER_MPS, LEAST_SPARE_M, LONGEST_S, MOST_ASIDE_M, ONCOMING_MPS, OVERTAKE_SPEED_FACTOR, RETURN_S,
    SIDE_MOVING_M, SIDE_PEOPLE_M, SIDE_STANDING_M, SPARE_M, STEP_S,
};
use crate::params::{COS_SAME_WAY, LONG_M};
use crate::slot::Slot;
use crate::streets::{Ahead, LaneGraph, Route};
use cadet_base::math::{DVec2, DVec3};
use cadet_town::LaneKind;

/// The way that is looked at, ahead and behind.
const LOOKS_M: f64 = 200.0;
const LOOKS_BACK_M: f64 = 25.0;
const SAMPLE_M: f64 = 2.5;

/// On the way past a cyclist.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Overtaking {
    cyclist: Slot,
    /// Offset from the lane's middle to the middle of the road, and the sign that makes it one to the left.
    inward_m: f64,
    inward: f64,
}

impl Overtaking {
    /// Offset to the left of the lane's middle.
    pub fn offset_m(&self) -> f64 {
        self.inward * self.inward_m
    }

    /// How far toward the middle of the road the line beside the cyclist still is from an offset to the left.
    pub fn is_out_by_m(&self, offset_m: f64) -> f64 {
        self.inward_m - self.inward * offset_m
    }

    /// Begins to overtake a cyclist ahead, if it is one and there is room.
    pub fn begin(own: &OnRoute<'_>, ahead: Slot, desired_mps: f64) -> Option<Self> {
        let rider = *own.around.cyclist(ahead)?;
        let rider_mps = rider.velocity.dot(own.footprint.heading);
        let is_worth_it =
            rider_mps > LEAST_RIDER_MPS && OVERTAKE_SPEED_FACTOR * desired_mps > rider_mps + LEAST_GAIN_MPS;
        if !is_worth_it || 2.0 * own.footprint.half_length_m > LONG_M {
            return None;
        }
        let way = Way::of(own.route, own.graph);
        let inward_m = offset_beside(&way, &rider, own.footprint).filter(|m| *m < MOST_ASIDE_M)?;
        let begun = Self { cyclist: ahead, inward_m, inward: way.inward };
        (begun.is_out_by_m(own.route.offset_m) > 0.0 && begun.is_clear(own, &rider, desired_mps, SPARE_M, &way))
            .then_some(begun)
    }

    /// Goes on, until it is done or must be given up.
    pub fn go_on(mut self, own: &OnRoute<'_>, desired_mps: f64) -> Option<Self> {
        let rider = *own.around.cyclist(self.cyclist)?;
        let way = Way::of(own.route, own.graph);
        // Beside the cyclist nobody turns in, wherever the cyclist goes.
        self.inward_m = self.inward_m.max(offset_beside(&way, &rider, own.footprint)?.min(MOST_ASIDE_M));
        let (ahead_m, _) = way.place_of(&rider)?;
        let lengths_m = rider.half_length_m + own.footprint.half_length_m;
        let [own_mps, rider_mps] = [own.footprint, &rider].map(|o| o.velocity.dot(own.footprint.heading));
        let gaining_mps = (own_mps - rider_mps).max(0.0);
        let braking_m = gaining_mps * gaining_mps / (2.0 * FALLS_BACK_MPS2);
        let can_fall_back = ahead_m - lengths_m > FALLS_BACK_M + braking_m;
        if can_fall_back && !self.is_clear(own, &rider, desired_mps, LEAST_SPARE_M, &way) {
            return None;
        }
        (ahead_m > -lengths_m - AFTER_M).then_some(self)
    }

    /// Whether the way beside the cyclist is free for as long as it takes.
    fn is_clear(&self, own: &OnRoute<'_>, rider: &Footprint, desired_mps: f64, spare_m: f64, way: &Way) -> bool {
        let OnRoute { footprint, around, graph, .. } = *own;
        let half_width_m = footprint.half_width_m;
        let Some((ahead_m, _)) = way.place_of(rider) else { return false };
        let gain_m = ahead_m + rider.half_length_m + footprint.half_length_m + AFTER_M;
        let speeds_mps = [footprint.velocity, rider.velocity].map(|v| v.dot(footprint.heading));
        let Some((time_s, way_m)) = time_and_way(gain_m, speeds_mps, OVERTAKE_SPEED_FACTOR * desired_mps) else {
            return false;
        };
        let free_m = next_junction(own.route, graph, &|_| true).map_or(own.route.remaining_m(graph), |(_, m)| m);
        if graph.lane(own.route.lanes[0]).junction.is_some()
            || way_m + footprint.half_length_m + BEFORE_JUNCTION_M > free_m
        {
            return false;
        }
        let passed: Vec<&Ahead> = way.middle.iter().filter(|a| (0.0..way_m).contains(&a.distance_m)).collect();
        let lines = || {
            let inward = |a: &Ahead| a.tangent.perp() * self.inward;
            passed.iter().map(move |a| (a.at + inward(a) * self.inward_m, inward(a), a.z_m))
        };
        let is_straight = passed.iter().all(|a| a.tangent.dot(passed[0].tangent) > COS_SAME_WAY);
        let is_road = || lines().all(|(at, inward, _)| is_on_lane(at + inward * half_width_m, graph));
        let keeps_off = |o: &Footprint, side_m: f64| {
            !lines().any(|(at, _, z_m)| o.is_within(at, half_width_m + side_m) && o.is_level_with(at, z_m))
        };
        let meets = |o: &Footprint| {
            let Some((distance_m, inward_m)) = way.place_of(o) else { return false };
            let beside_m = o.half_width_m + SIDE_MOVING_M;
            if !(-half_width_m - beside_m..self.inward_m + half_width_m + beside_m).contains(&inward_m) {
                return false;
            }
            if o.heading.dot(footprint.heading) < COS_SAME_WAY {
                let nearer_m = o.velocity.length().max(ONCOMING_MPS) * time_s;
                return distance_m > -footprint.half_length_m && distance_m < way_m + nearer_m + spare_m;
            }
            let (speed_mps, lengths_m) = (o.velocity.dot(footprint.heading), o.half_length_m + footprint.half_length_m);
            if distance_m > 0.0 {
                // Nobody may be ahead of the cyclist where one turns in, but for those who are gone by then.
                let is_slow = speed_mps < speeds_mps[1] + LEAST_GAIN_MPS;
                return is_slow && distance_m < gain_m + lengths_m + AFTER_M;
            }
            // A vehicle that follows in the own lane is no hindrance; one that comes up on another lane is.
            let comes_up_m = BEHIND_S * (speed_mps - speeds_mps[0]).max(0.0);
            inward_m > half_width_m && distance_m > -lengths_m - AFTER_M - comes_up_m
        };
        let others = || around.vehicles.iter().filter(|v| v.agent != own.slot && v.agent != self.cyclist);
        is_straight
            && is_road()
            && around.standing_in_lanes.iter().all(|o| keeps_off(o, SIDE_STANDING_M))
            && around.people_on_road.iter().all(|o| keeps_off(o, SIDE_PEOPLE_M))
            && !others().any(|v| meets(&v.footprint))
    }
}

/// The offset from the lane's middle to the road's that keeps off a cyclist; `None` for one who is nowhere near.
fn offset_beside(way: &Way, rider: &Footprint, own: &Footprint) -> Option<f64> {
    let (_, inward_m) = way.place_of(rider)?;
    Some(inward_m + rider.half_width_m + BESIDE_M + own.half_width_m)
}

/// How long it takes to gain so much on the cyclist and to be back in the lane, and how far one goes meanwhile; `None` if
/// it takes too long.
fn time_and_way(gain_m: f64, [own_mps, rider_mps]: [f64; 2], desired_mps: f64) -> Option<(f64, f64)> {
    let (mut time_s, mut way_m, mut speed_mps) = (0.0, 0.0, own_mps);
    while way_m - rider_mps * time_s < gain_m {
        time_s += STEP_S;
        way_m += speed_mps * STEP_S;
        speed_mps = (speed_mps + ACCELERATION_MPS2 * STEP_S).min(desired_mps);
        if time_s > LONGEST_S {
            return None;
        }
    }
    Some((time_s + RETURN_S, way_m + RETURN_S * speed_mps))
}

/// Whether cars drive at a place, and no junction is there.
fn is_on_lane(at: DVec2, graph: &LaneGraph) -> bool {
    graph.driving_near(at, MOST_ASIDE_M).any(|lane| {
        let (s_m, distance_m) = lane.project(DVec3::new(at.x, at.y, 0.0));
        lane.kind == LaneKind::Driving && lane.junction.is_none() && distance_m < lane.width_at(s_m) / 2.0
    })
}

/// The middle of the lane, from behind oneself to as far as one looks.
struct Way {
    middle: Vec<Ahead>,
    /// The sign that makes offsets to the left lead to the middle of the road.
    inward: f64,
}

impl Way {
    fn of(route: &Route, graph: &LaneGraph) -> Self {
        let count = ((LOOKS_M + LOOKS_BACK_M) / SAMPLE_M) as usize;
        let middle = |k: usize| {
            let place = route.ahead(k as f64 * SAMPLE_M - LOOKS_BACK_M, graph);
            Ahead { at: place.at - place.tangent.perp() * route.offset_m, ..place }
        };
        Self { middle: (0..count).map(middle).collect(), inward: -graph.lane(route.lanes[0]).curb_side() }
    }

    /// How far ahead a place is, and how far toward the road's middle off the lane's; `None` for what is nowhere near.
    fn place_of(&self, o: &Footprint) -> Option<(f64, f64)> {
        let p = o.center;
        let square_m2 = |a: &&Ahead| (a.at - p).length_squared();
        let nearest = self.middle.iter().min_by(|a, b| square_m2(a).total_cmp(&square_m2(b)))?;
        let to = p - nearest.at;
        let (along_m, inward_m) = (nearest.tangent.dot(to), self.inward * nearest.tangent.perp_dot(to));
        let is_near = along_m.abs() < 2.0 * SAMPLE_M && o.is_level_with(nearest.at, nearest.z_m);
        is_near.then_some((nearest.distance_m + along_m, inward_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_and_way_follow_from_constant_acceleration() {
        // At the desired speed already: gain over the difference of speeds.
        let (time_s, way_m) = time_and_way(20.0, [9.0, 5.0], 9.0).unwrap();
        assert!((time_s - RETURN_S - 5.0).abs() < STEP_S, "{time_s} s");
        assert!((way_m - 9.0 * time_s).abs() < 1e-9, "{way_m} m");
        // From the cyclist's speed on: half a t^2 until the desired speed, d^2 / 2 a gained by then.
        let gained_m = 16.0 / (2.0 * ACCELERATION_MPS2);
        let expected_s = 4.0 / ACCELERATION_MPS2 + (20.0 - gained_m) / 4.0;
        let (time_s, _) = time_and_way(20.0, [5.0, 5.0], 9.0).unwrap();
        assert!((time_s - RETURN_S - expected_s).abs() < 2.0 * STEP_S, "{time_s} s in place of {expected_s}");
        assert!(time_and_way(20.0, [5.0, 5.0], 5.5).is_none());
    }
}
