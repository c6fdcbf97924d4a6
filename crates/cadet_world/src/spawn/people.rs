//! People at the start and newcomers: alone or in groups, on sidewalks.

use std::sync::Arc;

use super::newcomers::standing_person;
use super::spawner::{EGO_WAY_M, Entry, Newcomer, Spawner};
use crate::agents::{AgentKind, Pedestrian};
use crate::footprint::Footprint;
use crate::slot::Slot;
use crate::walking::Motion;
use cadet_assets::person::PersonModel;
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::plane::heading_rad;
use cadet_base::rng::Stream;

/// How many others mean to cross the road.
const CROSSERS_SHARE: f64 = 0.4;
/// Sidewalks this near to the ego's way are along it, and so many walk there of those who walk elsewhere.
const BESIDE_EGO_WAY_M: f64 = 14.0;
const PEOPLE_ON_EGO_WAY: f64 = 0.7;
/// Between people who do not know each other, and between a person and a vehicle or a thing.
const STRANGERS_M: f64 = 0.9;
const CAR_M: f64 = 0.4;

impl Spawner<'_> {
    /// Somebody in a group, or at a random place of a walkway.
    pub(super) fn new_walker(&mut self, by: &mut Newcomer<'_>) -> Option<AgentKind> {
        let ((ego, view), is_newcomer) = (self.arena.ego_place(), by.entry != Entry::Anywhere);
        let model = Arc::new(PersonModel::generate(by.stream.next_u64()));
        let walks = model.walking_speed_mps > 0.0;
        if let Some(leader) = self.group_to_join(by, walks, ego) {
            let joined = match self.pedestrian(leader).motion {
                Motion::Walks { walkway, s_m, direction } => {
                    self.in_a_row(by, leader, &model, (walkway, s_m, direction))
                }
                _ => self.in_a_circle(by, leader, &model),
            };
            if let Some(joined) = joined {
                return Some(joined.into());
            }
        }
        let way: Vec<DVec2> = self.ego_way().map_or_else(Vec::new, |r| {
            (0..(EGO_WAY_M / 8.0) as usize).map(|k| r.ahead(k as f64 * 8.0, &self.arena.streets.graph).at).collect()
        });
        let mut places: Vec<((usize, f64), f64)> = Vec::new();
        let sidewalks = &self.arena.streets.sidewalks;
        for walkway in sidewalks.usable() {
            let mut s = 1.0;
            while s < sidewalks.length_m(walkway) - 1.0 {
                let at = sidewalks.spot(walkway, s).at;
                let to = at - ego;
                let distance = to.length();
                let in_view = to.dot(view) > 0.7 * distance && distance < 110.0;
                if (by.ring_m.0..by.ring_m.1).contains(&distance) && !(is_newcomer && in_view) {
                    let on_way = way.iter().any(|p| (*p - at).length() < BESIDE_EGO_WAY_M);
                    places.push(((walkway, s), if on_way { PEOPLE_ON_EGO_WAY } else { 1.0 }));
                }
                s += 3.0;
            }
        }
        for _ in 0..8 {
            let (walkway, s) = by.stream.try_pick(&places)?;
            let s_m = (s + by.stream.range(0.0, 2.9)).min(sidewalks.length_m(walkway) - 0.5);
            let direction = if by.stream.chance(0.5) { 1.0 } else { -1.0 };
            let room = sidewalks.room_m(walkway);
            // A little to the own right.
            let lateral_m = by.stream.clipped_normal(-0.15 * direction, 0.35).clamp(-room, room);
            if self.has_room_for_person(self.on_sidewalk(walkway, s_m, lateral_m), by.slot, STRANGERS_M) {
                let mut walker = self.walker_on(by.stream, model, (walkway, s_m, direction), lateral_m)?;
                walker.crosser = walks && by.stream.chance(CROSSERS_SHARE);
                return Some(walker.into());
            }
        }
        None
    }

    pub(super) fn on_sidewalk(&self, walkway: usize, s_m: f64, lateral_m: f64) -> DVec3 {
        let spot = self.arena.streets.sidewalks.spot(walkway, s_m);
        (spot.at + spot.tangent.perp() * lateral_m).extend(spot.z_m)
    }

    /// Whether nobody but who is in `slot` is within `apart_m` of a place, and no vehicle or thing is near it.
    pub(super) fn has_room_for_person(&self, place: DVec3, slot: Slot, apart_m: f64) -> bool {
        let at = place.truncate();
        let is_near_somebody =
            self.arena.people().any(|(other, room)| other != slot && (room.center - at).length() < apart_m);
        let is_near = |o: &Footprint| o.distance_m(at) < CAR_M && o.is_level_with(at, place.z);
        !is_near_somebody
            && !self.arena.around.standing.iter().any(is_near)
            && !self.arena.vehicles().any(|(_, o)| is_near(&o))
    }

    pub(super) fn walker_on(
        &self,
        stream: &mut Stream,
        model: Arc<PersonModel>,
        (walkway, s_m, direction): (usize, f64, f64),
        lateral_m: f64,
    ) -> Option<Pedestrian> {
        let heading = self.arena.streets.sidewalks.spot(walkway, s_m).tangent * direction;
        let walks = model.walking_speed_mps > 0.0;
        let yaw_rad = if walks { heading_rad(heading) } else { stream.range(-math::PI, math::PI) };
        let mut walker = self.posed_walker(stream, model, self.on_sidewalk(walkway, s_m, lateral_m), yaw_rad)?;
        if walks {
            walker.start(walkway, s_m, direction, lateral_m);
        }
        Some(walker)
    }

    pub(super) fn posed_walker(
        &self,
        stream: &mut Stream,
        model: Arc<PersonModel>,
        at: DVec3,
        yaw_rad: f64,
    ) -> Option<Pedestrian> {
        standing_person(self.arena, model, at, yaw_rad, stream.next_u64()).ok()
    }
}
