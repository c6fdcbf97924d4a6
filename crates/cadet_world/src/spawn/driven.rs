//! Driven cars: at random free places of lanes.

use std::ops::Range;
use std::sync::Arc;

use super::config::{DRIVEN_MIX, DRIVEN_TRUCKS_SHARE, DRIVEN_USER_MIX, MOTORWAY_TRUCKS_SHARE};
use super::overlap::comes_toward;
use super::parking::OFF_LANES_M;
use super::spawner::{Entry, Newcomer, Spawner};
use crate::agents::{AgentKind, Car};
use crate::body::{Chassis, settle};
use crate::driving::IdmParameters;
use crate::footprint::Footprint;
use crate::params::driver::SIDE_STANDING_M;
use crate::params::{CAR, LONG_M};
use crate::physics::Physics;
use crate::slot::Slot;
use crate::streets::{CAR_STRAIGHT_WEIGHT, LONG_STRAIGHT_WEIGHT, LaneGraph, LanePosition, Needs, Route};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::actor::ObjectClass;
use cadet_base::math::DVec3;
use cadet_base::plane::heading_rad;
use cadet_town::{Lane, LaneId};

/// How far from a junction, or from who is ahead, newcomers could stop; before the line of a light it is farther.
const BEFORE_JUNCTION_M: f64 = 8.0;
const BEFORE_LIGHT_M: f64 = 15.0;
/// Nobody starts with the front so far from a lit junction: on the line, neither before nor over it.
const ON_LINE_M: Range<f64> = 4.0..7.5;
/// Trucks take bends, and streets, at this share of a car's speed.
const TRUCKS_SLOWER: f64 = 0.85;
/// Distance from a road's beginning within which newcomers come in at the map's edge.
const EDGE_M: f64 = 8.0;
/// A newcomer that needs room has it for so long a way.
const ROOM_AHEAD_M: f64 = 110.0;

/// A chassis standing at the start of a route, heading along it; `None` beyond the ground's edge.
pub(super) fn chassis_on(
    route: &Route,
    model: &Arc<VehicleModel>,
    speed_mps: f64,
    physics: &mut Physics,
    graph: &LaneGraph,
) -> Option<Chassis> {
    let here = route.ahead(0.0, graph);
    let yaw = heading_rad(here.tangent);
    let settled = settle(physics, model, here.at.extend(here.z_m), yaw).ok()?;
    Some(Chassis::new(physics, Arc::clone(model), &settled.world_from_box, speed_mps))
}

/// How likely straight on is for a vehicle against turning off.
pub(super) fn straight_weight(model: &VehicleModel) -> f64 {
    if model.size_lwh.x > LONG_M { LONG_STRAIGHT_WEIGHT } else { CAR_STRAIGHT_WEIGHT }
}

impl Spawner<'_> {
    /// Places of lanes for something of a half length, every 4 m: lane and distance along it, and weight.
    pub(super) fn places_on<'a>(
        &self,
        lanes: impl Iterator<Item = &'a Lane>,
        half_m: f64,
        by: &Newcomer<'_>,
    ) -> Vec<((LaneId, f64), f64)> {
        let (ego, view) = self.arena.ego_place();
        let graph = &self.arena.streets.graph;
        let mut places: Vec<((LaneId, f64), f64)> = Vec::new();
        for lane in lanes {
            let mut s = half_m + 1.0;
            let most_m = match by.entry {
                Entry::MapEdge if !graph.begins_with_map(lane) => continue,
                Entry::MapEdge => half_m + 1.0 + EDGE_M,
                Entry::Anywhere | Entry::Unseen => f64::INFINITY,
            };
            while s < (lane.length_m() - half_m - 6.0).min(most_m) {
                let p = lane.pose_at(s);
                let to = p.translation.truncate() - ego;
                let distance = to.length();
                let in_view = to.dot(view) > 0.7 * distance && distance < 140.0;
                if (by.ring_m.0..by.ring_m.1).contains(&distance) && !(by.entry == Entry::Unseen && in_view) {
                    // Nearer is likelier, and newcomers head for the ego.
                    let toward = (p.rotation * DVec3::X).truncate().dot(to) < 0.0;
                    let weight = match by.entry {
                        Entry::Anywhere => 40.0 / (distance + 30.0),
                        _ if toward => 1.0,
                        _ => 0.25,
                    };
                    places.push(((lane.id, s), weight));
                }
                s += 4.0;
            }
        }
        places
    }

    /// A car or a truck at a random free place of a lane.
    pub(super) fn new_car(&mut self, by: &mut Newcomer<'_>) -> Option<AgentKind> {
        let (own_mix, mix) = (self.config.shares(&DRIVEN_USER_MIX, &[]), self.config.shares(&DRIVEN_MIX, &[]));
        let model = match self.user_models.draw(by.stream, &own_mix, |_| true) {
            Some(model) => model,
            None => {
                let class = by.stream.pick(&mix);
                let seed = by.stream.next_u64();
                let of = |class| Arc::new(VehicleModel::of_traffic(class, seed).expect("the class has shapes"));
                let trucks = if self.is_fast() { MOTORWAY_TRUCKS_SHARE } else { DRIVEN_TRUCKS_SHARE };
                // A truck where the streets have room for it, and for all its way to the next corners.
                if let Some(model) = self.config.rare(&[(ObjectClass::Truck, trucks)], seed).map(of)
                    && let Some(newcomer) = self.place_car(by, &model, Needs::of_truck(model.size_lwh))
                {
                    return Some(newcomer);
                }
                of(class)
            }
        };
        self.place_car(by, &model, Needs::of_van(model.size_lwh))
    }

    /// A vehicle of a given shape.
    fn place_car(&mut self, by: &mut Newcomer<'_>, model: &Arc<VehicleModel>, needs: Needs) -> Option<AgentKind> {
        if self.is_fast() {
            return self.place_fast(by, model, needs);
        }
        let graph = &self.arena.streets.graph;
        let half_m = model.size_lwh.x / 2.0;
        // Farther off the middle one would not get past what stands beside it; a truck's corners need all of its room.
        let beside_m = OFF_LANES_M - model.size_lwh.y / 2.0 - SIDE_STANDING_M;
        let most_m = if needs.keeps_in_lane { 0.0 } else { beside_m.max(0.0) };
        let lanes = graph.open_lanes().filter(|l| !needs.is_some() || graph.fits(l.id, needs));
        let places = self.places_on(lanes, half_m, by);
        let vehicles: Vec<(Slot, Footprint)> = self.arena.vehicles().collect();
        let on_road: Vec<Footprint> = self.arena.on_road().collect();
        for _ in 0..30 {
            let (lane_id, s_m) = by.stream.try_pick(&places)?;
            let lane = graph.lane(lane_id);
            let s_m = s_m + by.stream.range(0.0, 3.5);
            let left_m = by.stream.clipped_normal(0.0, 0.1).clamp(-most_m, most_m);
            let is_lit = graph.signals().arm_of(lane_id).is_some();
            if is_lit && ON_LINE_M.contains(&(lane.length_m() - s_m - half_m)) {
                continue;
            }
            let seed = self.key.indexed("car route", by.stream.next_u64());
            let at = LanePosition { lane: lane_id, s_m, left_m };
            let route = Route::with_needs(at, straight_weight(model), needs, seed, graph);
            let here = route.ahead(0.0, graph);
            let rectangle = here.covered_by(model.size_lwh, 0.0);
            // Sideways little room, along the lane a headway.
            let long =
                Footprint { half_length_m: half_m + 8.0, half_width_m: rectangle.half_width_m + 0.2, ..rectangle };
            let taken = vehicles.iter().any(|(other, f)| {
                // A vehicle that comes from behind needs room to brake.
                let half_length_m = long.half_length_m + 1.8 * f.velocity.length();
                let is_near = Footprint { half_length_m, ..long }.overlaps(f) || rectangle.grown(0.5).overlaps(f);
                *other != by.slot && (is_near || comes_toward(f, &rectangle))
            }) || self.arena.around.standing.iter().any(|o| rectangle.grown(0.1).overlaps(o))
                || on_road.iter().any(|o| long.overlaps(o));
            if taken || route.remaining_m(graph) < 30.0 || !route.fits(ROOM_AHEAD_M, graph) {
                continue;
            }
            // As fast as still allows a stop before the junction and behind whoever is ahead.
            let free_m = vehicles
                .iter()
                .map(|(_, f)| (f.center - here.at).dot(here.tangent))
                .filter(|d| *d > 0.0)
                .fold(lane.length_m() - s_m, f64::min);
            let before_m = if is_lit { BEFORE_LIGHT_M } else { BEFORE_JUNCTION_M };
            let stop = (2.0 * 1.5 * (free_m - half_m - before_m).max(0.0)).sqrt();
            let speed = (0.9 * route.speed_for_bends(8.0, 1.5, graph)).min(stop);
            let mut idm = IdmParameters::draw(&CAR, by.stream);
            if model.class == ObjectClass::Truck {
                idm.desired_speed_factor *= TRUCKS_SLOWER;
            }
            let physics = &mut self.arena.physics;
            let Some(chassis) = chassis_on(&route, model, speed, physics, graph) else { continue };
            return Some(Car::new(chassis, Some(route), idm).into());
        }
        None
    }
}
