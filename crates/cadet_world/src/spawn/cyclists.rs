//! Cyclists: at random free places beside the curbs of streets, alone or behind another.

use std::sync::Arc;

use super::newcomers::ridden_bicycle;
use super::overlap::comes_toward;
use super::spawner::{Newcomer, Spawner};
use crate::agents::{AgentKind, Cyclist, Habits};
use crate::body::stand_up;
use crate::footprint::Footprint;
use crate::slot::Slot;
use crate::streets::{LaneGraph, Route};
use cadet_assets::cyclist::CyclistModel;
use cadet_base::math::DVec3;
use cadet_base::plane::heading_rad;
use cadet_base::rng::Stream;
use cadet_town::{Lane, LaneId, LaneKind};

/// How likely straight on is for a cyclist against turning off.
const STRAIGHT: f64 = 1.5;
/// How likely somebody rides behind the last who came, and how far behind.
const COMPANY_SHARE: f64 = 0.35;
const BEHIND_M: (f64, f64) = (3.2, 7.0);
/// How far from a junction newcomers could stop; before the line of a light it is farther.
const BEFORE_JUNCTION_M: f64 = 6.0;
const BEFORE_LIGHT_M: f64 = 12.0;
/// How likely a lane on the ego's way is in comparison with others, and one on which one rides toward the ego.
const ON_EGO_WAY: f64 = 0.15;
const TOWARD_EGO: f64 = 3.0;
/// Room before and behind at the start.
const HEADWAY_M: f64 = 4.0;
/// Shorter ways are not begun.
const SHORTEST_WAY_M: f64 = 30.0;

impl Spawner<'_> {
    /// A cyclist behind another, or at a random free place of a street.
    pub(super) fn new_cyclist(&mut self, by: &mut Newcomer<'_>) -> Option<AgentKind> {
        let model = Arc::new(CyclistModel::generate(by.stream.next_u64()));
        if by.stream.chance(COMPANY_SHARE)
            && let Some((lane, s_m)) = self.last_cyclist(by.slot)
        {
            let behind_m = model.size_lwh.x + by.stream.within(BEHIND_M);
            if s_m > behind_m + 1.0
                && let Some(joined) = self.cyclist_at(by, &model, (lane, s_m - behind_m), BEHIND_M.0 - 1.0)
            {
                return Some(joined);
            }
        }
        let mut places = self.places_on(lanes_to_ride(&self.arena.streets.graph), model.size_lwh.x / 2.0, by);
        // On narrow streets who starts ahead of the ego would be followed for long; who comes toward it is seen.
        let way: Vec<LaneId> = self.ego_way().map_or_else(Vec::new, |route| route.lanes.into());
        let graph = &self.arena.streets.graph;
        let share = |id: LaneId| match graph.lane(id).road {
            _ if way.contains(&id) => ON_EGO_WAY,
            road if way.iter().any(|on_way| graph.lane(*on_way).road == road) => TOWARD_EGO,
            _ => 1.0,
        };
        places.iter_mut().for_each(|((lane, _), weight)| *weight *= share(*lane));
        for _ in 0..30 {
            let (lane, s_m) = by.stream.try_pick(&places)?;
            let s_m = s_m + by.stream.range(0.0, 3.5);
            if let Some(newcomer) = self.cyclist_at(by, &model, (lane, s_m), HEADWAY_M) {
                return Some(newcomer);
            }
        }
        None
    }

    /// Where the cyclist who came last is, if they came just before and are not in a junction.
    fn last_cyclist(&self, slot: Slot) -> Option<(LaneId, f64)> {
        let (other, agent, cyclist) = self.arena.each::<Cyclist>().rev().find(|(other, ..)| *other != slot)?;
        let lane = cyclist.route.lanes[0];
        let is_near = other.abs_diff(slot) <= 2 && !agent.is_placed;
        (is_near && self.arena.streets.graph.lane(lane).junction.is_none()).then_some((lane, cyclist.route.s_m))
    }

    /// A cyclist at a place of a lane, if it is free.
    fn cyclist_at(
        &mut self,
        by: &mut Newcomer<'_>,
        model: &Arc<CyclistModel>,
        (lane, s_m): (LaneId, f64),
        headway_m: f64,
    ) -> Option<AgentKind> {
        let graph = &self.arena.streets.graph;
        let seed = self.key.indexed("cyclist route", by.stream.next_u64());
        let habits = Habits::draw(&mut Stream::from_seed("cyclist habits", by.stream.next_u64()));
        let route = Route::by_bicycle(lane, s_m, STRAIGHT, habits.keeps_m, seed, graph);
        let here = route.ahead(0.0, graph);
        let rectangle = here.covered_by(model.size_lwh, 0.0);
        let long = Footprint { half_length_m: rectangle.half_length_m + headway_m, ..rectangle.grown(0.2) };
        let is_taken = self.arena.vehicles().any(|(other, f)| {
            // A vehicle that comes from behind needs room to brake.
            let is_behind = (f.center - here.at).dot(here.tangent) < 0.0;
            let braking_m = if is_behind { f.velocity.length() } else { 0.0 };
            let long = Footprint { half_length_m: long.half_length_m + braking_m, ..long };
            let is_near = long.overlaps(&f) || rectangle.grown(0.5).overlaps(&f);
            other != by.slot && (is_near || comes_toward(&f, &rectangle))
        }) || self.arena.around.standing.iter().any(|o| rectangle.grown(0.2).overlaps(o))
            || self.arena.on_road().any(|o| long.overlaps(&o));
        if is_taken || route.remaining_m(graph) < SHORTEST_WAY_M {
            return None;
        }
        // As fast as still allows a stop before the junction.
        let free_m = graph.lane(lane).length_m() - s_m;
        let before_m = if graph.signals().arm_of(lane).is_some() { BEFORE_LIGHT_M } else { BEFORE_JUNCTION_M };
        let stop_mps = (2.0 * (free_m - before_m).max(0.0)).sqrt();
        let speed_mps = route.speed_for_bends(5.0, 1.5, graph).min(stop_mps).min(4.5);
        let yaw_rad = heading_rad(here.tangent);
        let pose = stand_up(&self.arena.physics, model.wheelbase_m / 2.0, here.at.extend(here.z_m), yaw_rad).ok()?;
        let velocity = here.tangent * speed_mps;
        let own = ridden_bicycle(self.arena, Arc::clone(model), (pose, yaw_rad), velocity, by.stream.unit());
        Some(Cyclist::new(own, habits, route, speed_mps).into())
    }
}

/// Lanes for bicycles, and driving lanes that have none at the curb.
fn lanes_to_ride(graph: &LaneGraph) -> impl Iterator<Item = &Lane> {
    let is_outermost = |lane: &Lane| {
        let s_m = lane.length_m() / 2.0;
        let middle = lane.pose_at(s_m);
        let out = middle.rotation * DVec3::Y * lane.curb_side();
        let heading_rad = cadet_base::frames::yaw_of(&middle);
        let beside = middle.translation + out * lane.width_at(s_m);
        let is_beside_cycle_lane = graph.is_on_cycle_lane(beside.truncate(), 0.3);
        !is_beside_cycle_lane && graph.nearest(beside, Some(heading_rad), 1.0).is_none_or(|other| other.lane == lane.id)
    };
    graph.lanes().iter().filter(move |lane| {
        lane.junction.is_none()
            && match lane.kind {
                LaneKind::Biking => true,
                LaneKind::Driving => !graph.is_fast(lane.id) && is_outermost(lane),
                _ => false,
            }
    })
}
