//! Vehicles on motorways: on lanes that suit their speed, at that speed, with gaps that nobody has to brake for.

use std::sync::Arc;

use super::driven::{chassis_on, straight_weight};
use super::spawner::{Entry, Newcomer, Spawner};
use crate::agents::{AgentKind, Car};
use crate::body::Body;
use crate::driving::{IdmParameters, LaneView};
use crate::params::CAR;
use crate::streets::{LanePosition, Needs, Route};
use cadet_assets::vehicle::VehicleModel;
use cadet_base::actor::ObjectClass;
use cadet_base::math::DVec3;
use cadet_town::LaneId;

/// Vehicles start so much farther from the ego than on streets, are gone beyond this distance, and newcomers appear before
/// it: farther away than anything is shown.
pub(super) const FARTHER_FACTOR: f64 = 2.5;
pub(super) const GONE_M: f64 = 310.0;
pub(super) const APPEARS_M: (f64, f64) = (252.0, 296.0);
/// Speed limiters of trucks, and what cars go of the limit.
const TRUCKS_MPS: (f64, f64) = (82.0 / 3.6, 89.0 / 3.6);
const CARS_SHARE: f64 = 1.04;
/// Shares of cars in the lanes from the curb.
const LANES: [f64; 3] = [0.4, 0.45, 0.15];
/// Kept at the start: meters and seconds, and how softly whoever is faster could brake.
const GAP_M: f64 = 8.0;
const GAP_S: f64 = 0.9;
const SOFTLY_MPS2: f64 = 1.2;
const PLACES_EVERY_M: f64 = 7.0;
const TRIES: usize = 40;
/// Distance from a road's beginning within which newcomers come in at the map's edge.
const EDGE_M: f64 = 30.0;

impl Spawner<'_> {
    /// Whether the ego drives on a motorway.
    pub(super) fn is_fast(&self) -> bool {
        self.ego_lane().is_some_and(|lane| self.arena.streets.graph.is_fast(lane))
    }

    /// Writes down anew who is where, for those who are placed next.
    pub(super) fn refresh_traffic_state(&mut self) {
        if self.is_fast() {
            self.arena.refresh_places();
        }
    }

    fn ego_lane(&self) -> Option<LaneId> {
        self.arena.ego_car().route.as_ref().map(|r| r.lanes[0])
    }

    /// Lets the ego roll as fast as it wants to drive, where standing would be dangerous.
    pub(super) fn roll_ego(&mut self) {
        if !self.is_fast() {
            return;
        }
        let wanted_mps = self.arena.ego_car().wanted_mps(&self.arena.streets.graph);
        let (ego, physics) = self.arena.ego_car_mut();
        ego.own.body.roll(wanted_mps, physics);
    }

    /// A vehicle at a free place of a lane. Newcomers appear where they come nearer to the ego.
    pub(super) fn place_fast(
        &mut self,
        by: &mut Newcomer<'_>,
        model: &Arc<VehicleModel>,
        needs: Needs,
    ) -> Option<AgentKind> {
        let is_truck = model.class == ObjectClass::Truck;
        let half_m = model.size_lwh.x / 2.0;
        let mut idm = IdmParameters::draw(&CAR, by.stream);
        idm.desired_speed_factor *= CARS_SHARE;
        let limiter_mps = by.stream.within(TRUCKS_MPS);
        if is_truck {
            idm.top_speed_mps = limiter_mps;
        }
        let (ego, view) = self.arena.ego_place();
        let ego_mps = self.arena.ego_car().own.body.forward_mps(&self.arena.physics);
        let graph = &self.arena.streets.graph;
        let mut places: Vec<((LaneId, f64), f64)> = Vec::new();
        for lane in graph.open_lanes().filter(|l| graph.is_fast(l.id) && (!needs.is_some() || graph.fits(l.id, needs)))
        {
            let from_curb = std::iter::successors(graph.outer_of(lane.id), |id| graph.outer_of(*id)).count();
            if is_truck && from_curb > 0 {
                continue;
            }
            if by.entry == Entry::MapEdge && !graph.begins_with_map(lane) {
                continue;
            }
            let wanted_mps = (idm.desired_speed_factor * lane.speed_limit_mps).min(idm.top_speed_mps);
            let mut s_m = 2.0;
            let most_m = if by.entry == Entry::MapEdge { EDGE_M } else { f64::INFINITY };
            while s_m < lane.length_m().min(most_m) {
                let pose = lane.pose_at(s_m);
                let to = pose.translation.truncate() - ego;
                let distance_m = to.length();
                let is_with_ego = (pose.rotation * DVec3::X).truncate().dot(view) > 0.0;
                let is_ahead = to.dot(view) > 0.0;
                let comes_nearer = if is_with_ego { is_ahead == (wanted_mps < ego_mps) } else { is_ahead };
                if (by.ring_m.0..by.ring_m.1).contains(&distance_m) && (comes_nearer || by.entry != Entry::Unseen) {
                    let near = if by.entry == Entry::Anywhere { 60.0 / (distance_m + 60.0) } else { 1.0 };
                    let own_way = if is_with_ego { 1.3 } else { 1.0 };
                    places.push(((lane.id, s_m), near * own_way * LANES[from_curb.min(2)]));
                }
                s_m += PLACES_EVERY_M;
            }
        }
        for _ in 0..TRIES {
            let (lane, s_m) = by.stream.try_pick(&places)?;
            let s_m = (s_m + by.stream.range(0.0, PLACES_EVERY_M)).min(graph.lane(lane).length_m() - 0.5);
            let at = LanePosition { lane, s_m, left_m: by.stream.clipped_normal(0.0, 0.12) };
            let seed = self.key.indexed("car route", by.stream.next_u64());
            let route = Route::with_needs(at, straight_weight(model), needs, seed, graph);
            let wanted_mps =
                (idm.desired_speed_factor * route.speed_for_bends(30.0, 1.5, graph)).min(idm.top_speed_mps);
            let seen_from = |id: LaneId| LaneView::of(id, s_m, half_m, Some(by.slot), &self.arena.around, graph);
            let seen = seen_from(lane);
            let speed_mps =
                seen.leader.filter(|l| l.gap_m < 90.0).map_or(wanted_mps, |l| wanted_mps.min(l.speed_mps + 1.0));
            let is_free = |gap_m: f64, behind_mps: f64, ahead_mps: f64| {
                let closing_mps = (behind_mps - ahead_mps).max(0.0);
                gap_m > GAP_M + GAP_S * behind_mps + closing_mps * closing_mps / (2.0 * SOFTLY_MPS2)
            };
            // Nor is anybody about to be passed on the curb's side.
            let beside = |id: Option<LaneId>| id.map(seen_from).unwrap_or_default();
            let (inner, outer) = (beside(graph.inner_of(lane)), beside(graph.outer_of(lane)));
            let passes_nobody = inner
                .leader
                .is_none_or(|l| l.speed_mps > speed_mps || is_free(l.gap_m, speed_mps, l.speed_mps))
                && outer.follower.is_none_or(|f| f.speed_mps < speed_mps || is_free(f.gap_m, f.speed_mps, speed_mps));
            let has_gaps = passes_nobody
                && seen.leader.is_none_or(|l| is_free(l.gap_m, speed_mps, l.speed_mps))
                && seen.follower.is_none_or(|f| is_free(f.gap_m, f.speed_mps, speed_mps));
            if seen.is_taken || !has_gaps || speed_mps < 0.5 * wanted_mps {
                continue;
            }
            let physics = &mut self.arena.physics;
            let Some(chassis) = chassis_on(&route, model, speed_mps, physics, graph) else { continue };
            return Some(Car::new(chassis, Some(route), idm).into());
        }
        None
    }
}
