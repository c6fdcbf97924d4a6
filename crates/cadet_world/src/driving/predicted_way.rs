//! Where a vehicle will be on its way: its steering run ahead, without slip of the tires.

use super::pursuit::{Axles, pursue};
use crate::body::{MAX_STEER_RAD, STEER_RATE_RADPS};
use crate::streets::{LaneGraph, Route};
use cadet_base::math::{self, DVec2};
use cadet_base::plane::unit;

/// Middle and heading of a vehicle, every half meter along its route, if it goes at one speed.
pub(crate) struct PredictedWay<'a> {
    route: &'a Route,
    graph: &'a LaneGraph,
    axles: Axles,
    speed_mps: f64,
    /// How far along the route it is.
    from_m: f64,
    rear_axle: DVec2,
    heading: DVec2,
    steer_rad: f64,
}

impl<'a> PredictedWay<'a> {
    /// Between two places.
    pub const STEP_M: f64 = 0.5;

    /// From a place of the route on, where it is on its line with the wheels straight.
    pub fn from(route: &'a Route, from_m: f64, axles: Axles, speed_mps: f64, graph: &'a LaneGraph) -> Self {
        let here = route.ahead(from_m, graph);
        let (heading, rear_axle) = (here.tangent, here.at - here.tangent * axles.rear_m);
        Self { route, graph, axles, speed_mps, from_m, rear_axle, heading, steer_rad: 0.0 }
    }
}

impl Iterator for PredictedWay<'_> {
    type Item = (DVec2, DVec2);

    fn next(&mut self) -> Option<Self::Item> {
        let wanted_rad =
            pursue(self.rear_axle, self.heading, self.axles, self.speed_mps, (self.route, self.from_m), self.graph);
        let most_rad = STEER_RATE_RADPS * Self::STEP_M / self.speed_mps;
        let wanted_rad = wanted_rad.clamp(-MAX_STEER_RAD, MAX_STEER_RAD);
        self.steer_rad += (wanted_rad - self.steer_rad).clamp(-most_rad, most_rad);
        // A single-track model: the rear axle goes where the vehicle points.
        let turn_rad = Self::STEP_M * math::tan(self.steer_rad) / self.axles.wheelbase_m;
        let turned = |by_rad: f64| unit(by_rad).rotate(self.heading);
        self.rear_axle += turned(turn_rad / 2.0) * Self::STEP_M;
        self.heading = turned(turn_rad);
        let middle = self.rear_axle + self.heading * self.axles.rear_m;
        self.from_m += Self::STEP_M;
        let line = self.route.ahead(self.from_m, self.graph);
        self.from_m += (middle - line.at).dot(line.tangent);
        Some((middle, self.heading))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::super::junction_ahead::next_junction;
    use super::*;
    use crate::agents::{Car, axles_of};
    use crate::body::Body;
    use crate::tests::filled;
    use crate::tests::towns::{main_roads, suburb};
    use cadet_town::LaneId;

    /// Where a vehicle is to go, and on which lane across a junction.
    type Predicted = (LaneId, Vec<(DVec2, DVec2)>);

    #[test]
    fn vehicles_turn_where_the_steering_run_ahead_says() {
        // Off the predicted way sideways, and off its heading.
        let (mut off_m, mut off_rad, mut turns) = (Vec::new(), Vec::new(), 0);
        for seed in 0..6 {
            let town = if seed % 2 == 0 { main_roads(seed) } else { suburb(seed) };
            let mut world = filled(town, seed, [40, 0, 0]);
            let mut ways: HashMap<i32, Predicted> = HashMap::new();
            for _ in 0..40 * 10 {
                world.step(6);
                let graph = &world.arena.streets.graph;
                for (_, agent, driver) in world.arena.each::<Car>() {
                    let (chassis, Some(route)) = (&driver.own.body, &driver.route) else { continue };
                    let box_at = chassis.world_from_box(&world.arena.physics);
                    let at = box_at.translation.truncate();
                    let heading = (box_at.rotation * math::DVec3::X).truncate().normalize();
                    if let Some((lane, way)) = ways.get(&agent.id)
                        && route.lanes[0] == *lane
                    {
                        let (there, ahead) =
                            *way.iter().min_by(|a, b| (a.0 - at).length().total_cmp(&(b.0 - at).length())).unwrap();
                        off_m.push(ahead.perp_dot(at - there).abs());
                        off_rad.push(math::asin(ahead.perp_dot(heading)).abs());
                    }
                    let Some((k, start_m)) = next_junction(route, graph, &|_| true) else { continue };
                    let lane = graph.lane(route.lanes[k]);
                    let is_turn =
                        lane.start_tangent().dot(lane.end_tangent()) < 0.7 && !graph.is_in_roundabout(lane.id);
                    if (6.0..9.0).contains(&start_m) && is_turn && ways.get(&agent.id).is_none_or(|w| w.0 != lane.id) {
                        let mps = graph.allowed_mps(lane.id).iter().copied().fold(f64::INFINITY, f64::min);
                        let way = PredictedWay::from(route, 0.0, axles_of(chassis), mps, graph);
                        let count = (start_m + lane.length_m() + 12.0) / PredictedWay::STEP_M;
                        ways.insert(agent.id, (lane.id, way.take(count as usize).collect()));
                        turns += 1;
                    }
                }
            }
        }
        let share_within = |off: &[f64], most: f64| off.iter().filter(|o| **o < most).count() as f64 / off.len() as f64;
        let (near, along) = (share_within(&off_m, 0.12), share_within(&off_rad, 2.5_f64.to_radians()));
        assert!(turns > 40 && off_m.len() > 400, "{turns} turns, {} looks", off_m.len());
        assert!(near > 0.9 && along > 0.9, "{near} of {turns} turns' looks are near, {along} along");
    }
}
