//! Cyclists on the road: beside the curb, slower than cars, and under the same rules.

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use crate::body::{Body, Cycle, Step};
use crate::driving::{Cause, IdmParameters, OnRoute, leave_junctions, perceive, turn_ahead};
use crate::footprint::Footprint;
use crate::look::{CyclistLook, Look, TurnSignal};
use crate::outlook::Outlook;
use crate::params::cycling::{
    ASIDE_M, COASTS_MPS2, CRUISE_LIMITS_MPS, CRUISE_MPS, KEEPS_M, POINTS_M, POINTS_MPS, POINTS_SHARE, SHIFT_M,
    TIGHTEST_PER_M,
};
use crate::params::{CYCLIST, STANDS_MPS};
use crate::physics::{DT_S, Physics};
use crate::slot::Slot;
use crate::streets::{LaneGraph, LanePosition, Route, Streets};
use crate::traffic_state::TrafficState;
use cadet_base::math::DVec2;
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// How far ahead that is looked for, and in which steps; and behind the rear wheel, which is past it last.
const LOOKS_M: f64 = 14.0;
const LOOKS_BACK_M: f64 = 0.6;
const STEP_M: f64 = 1.25;

/// How somebody rides.
pub(crate) struct Habits {
    idm: IdmParameters,
    /// Distance from the curb in lanes for cars.
    pub keeps_m: f64,
    /// Whether this one points where they turn.
    points: bool,
}

impl Habits {
    pub fn draw(stream: &mut Stream) -> Self {
        let cruise_mps = stream.clipped_normal(CRUISE_MPS.0, CRUISE_MPS.1);
        // A look ahead that takes nothing: who is made later keeps their draws.
        let points = Stream::from_seed("pointing", stream.clone().next_u64()).chance(POINTS_SHARE);
        let top_speed_mps = cruise_mps.clamp(CRUISE_LIMITS_MPS.0, CRUISE_LIMITS_MPS.1);
        let idm = IdmParameters { top_speed_mps, ..IdmParameters::draw(&CYCLIST, stream) };
        Self { idm, keeps_m: stream.range(KEEPS_M.0, KEEPS_M.1), points }
    }
}

/// A bicycle, and who rides it.
pub(crate) struct Cyclist {
    pub own: Actor<Cycle, CyclistLook>,
    pub route: Route,
    pub standing_steps: u64,
    habits: Habits,
    speed_mps: f64,
    desired_mps: f64,
    interaction_mps2: f64,
    /// The side to which the rider points.
    pointing: TurnSignal,
    cause: Cause,
}

impl Cyclist {
    /// Somebody who rides at a speed at the start of a route.
    pub fn new(own: Actor<Cycle, CyclistLook>, habits: Habits, route: Route, speed_mps: f64) -> Self {
        Self {
            own,
            route,
            standing_steps: 0,
            habits,
            speed_mps,
            desired_mps: speed_mps,
            interaction_mps2: 0.0,
            pointing: TurnSignal::Off,
            cause: Cause::Nothing,
        }
    }
}

impl Behavior for Cyclist {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        (k == 0).then(|| self.own.view())
    }

    fn look(&mut self, slot: Slot, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let graph = &streets.graph;
        let Some(footprint) = around.vehicle(slot) else { return Outlook::default() };
        let offset_m = free_offset_m(&self.route, footprint, around, graph);
        self.route.offset_m += (offset_m - self.route.offset_m).clamp(-SHIFT_M, SHIFT_M);
        self.desired_mps = self.habits.idm.top_speed_mps.min(self.route.speed_for_bends(self.speed_mps, 1.5, graph));
        let rider = OnRoute {
            slot,
            footprint,
            route: &self.route,
            idm: &self.habits.idm,
            axles: None,
            train_m: None,
            reduced_clearance: false,
            around,
            graph,
            step,
        };
        let ahead = rider.in_sight();
        let perceived = perceive(&rider, &ahead);
        (self.interaction_mps2, self.cause) = rider.tightest(&perceived.constraints);
        // In the bend both hands are needed.
        let turn = turn_ahead(&self.route, graph).filter(|(m, _)| (POINTS_M.0..POINTS_M.1).contains(m));
        let is_shown = self.habits.points && self.speed_mps > POINTS_MPS;
        self.pointing = turn.filter(|_| is_shown).map_or(TurnSignal::Off, |(_, side)| side);
        Outlook { way_ahead: ahead, request: perceived.request, ..Outlook::default() }
    }

    fn act(&mut self, physics: &mut Physics, streets: &Streets) {
        let Actor { body, look: CyclistLook { model, ride } } = &mut self.own;
        let accel_mps2 =
            self.habits.idm.pedals(self.habits.idm.free_road(self.speed_mps, self.desired_mps), self.interaction_mps2);
        self.speed_mps = (self.speed_mps + accel_mps2 * DT_S).max(0.0);
        let moved_m = self.speed_mps * DT_S;
        // Pure pursuit of the route.
        let heading = body.heading();
        let reach_m = (0.5 * self.speed_mps + 1.2).clamp(1.8, 4.2);
        let to = self.route.ahead(reach_m, &streets.graph).at - body.at();
        let curvature = 2.0 * heading.perp_dot(to) / to.length_squared().max(1.0);
        let turn_rad = curvature.clamp(-TIGHTEST_PER_M, TIGHTEST_PER_M) * moved_m;
        let turned = |angle_rad: f64| unit(angle_rad).rotate(heading);
        let at = body.at() + turned(turn_rad / 2.0) * moved_m;
        body.guide(physics, &Step { at, velocity: turned(turn_rad) * self.speed_mps, moved_m, turn_rad });
        ride.advance(model, moved_m, turn_rad, accel_mps2 > COASTS_MPS2);
        ride.point(self.pointing);
    }

    fn track(&mut self, slot: Slot, physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        let tail_m = self.own.look.size_lwh().x / 2.0 + 0.5;
        let position = self.own.body.world_from_box(physics).translation;
        leave_junctions(slot, &mut self.route, position, tail_m, &mut around.junctions, &streets.graph);
        self.standing_steps = if self.speed_mps < STANDS_MPS { self.standing_steps + 1 } else { 0 };
    }

    fn cause(&self) -> Cause {
        self.cause
    }

    fn on_lane(&self, _k: usize) -> Option<LanePosition> {
        Some(self.route.position())
    }
}

/// The offset to the left of the lane's middle at which one rides before anything is in the way.
fn usual_offset_m(route: &Route, graph: &LaneGraph) -> f64 {
    route.usual_m(graph.lane(route.lanes[0]), route.s_m)
}

/// The offset at which one rides: the usual one, or farther off the curb where something stands in the lane.
fn free_offset_m(route: &Route, own: &Footprint, around: &TrafficState, graph: &LaneGraph) -> f64 {
    let usual_m = usual_offset_m(route, graph);
    let is_near = |o: &&Footprint| (o.center - own.center).length() < LOOKS_M + o.half_length_m;
    let near: Vec<&Footprint> = around.standing_in_lanes.iter().filter(is_near).collect();
    if near.is_empty() {
        return usual_m;
    }
    let behind_m = own.half_length_m + LOOKS_BACK_M;
    let places: Vec<(DVec2, DVec2)> = (0..((LOOKS_M + behind_m) / STEP_M) as usize)
        .map(|k| route.ahead(k as f64 * STEP_M - behind_m, graph))
        .map(|a| (a.at - a.tangent.perp() * route.offset_m, a.tangent.perp()))
        .collect();
    let is_free = |offset_m: f64| {
        let line = places.iter().map(|(middle, left)| *middle + *left * offset_m);
        line.into_iter().all(|p| near.iter().all(|o| o.distance_m(p) > own.half_width_m + ASIDE_M))
    };
    let off_curb = -graph.lane(route.lanes[0]).curb_side();
    let lines_m = (0..12).map(|k| usual_m + off_curb * 0.12 * f64::from(k));
    lines_m.take_while(|m| off_curb * *m < 0.3).find(|m| is_free(*m)).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::towns::slope;
    use cadet_base::math::DVec3;
    use cadet_town::LaneId;

    #[test]
    fn a_cyclist_keeps_aside_until_the_rear_wheel_is_past_a_car() {
        let graph = LaneGraph::new(slope(0.0));
        let car = Footprint {
            center: DVec2::new(10.0, -1.35),
            heading: DVec2::X,
            half_length_m: 2.2,
            half_width_m: 0.9,
            z_m: 0.0,
            velocity: DVec2::ZERO,
        };
        let mut around = TrafficState::new(&graph);
        around.stand(car, &graph);
        // By how much it rides farther to the left than usual, its middle so far beyond the car's front.
        let aside_m = |beyond_m: f64| {
            let s_m = 90.0 + 12.2 + beyond_m;
            let (seed, mut stream) = (Stream::from_seed("way", 1), Stream::from_seed("habits", 1));
            let route = Route::by_bicycle(LaneId(0), s_m, 1.0, Habits::draw(&mut stream).keeps_m, seed, &graph);
            let own = route.ahead(0.0, &graph).covered_by(DVec3::new(1.9, 0.66, 1.7), 0.0);
            free_offset_m(&route, &own, &around, &graph) - usual_offset_m(&route, &graph)
        };
        assert!(aside_m(-8.0) > 0.4, "before it: {}", aside_m(-8.0));
        for beyond_m in [-2.0, 0.0, 0.5, 0.9] {
            assert_eq!(aside_m(beyond_m), aside_m(-8.0), "{beyond_m} m beyond");
        }
        assert_eq!(aside_m(4.0), 0.0, "well past it");
    }
}
