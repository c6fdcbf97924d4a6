//! People at the start and newcomers: alone or in groups, on pavements.

use std::sync::Arc;

use super::World;
use super::footing::BODY_M;
use super::pedestrian::{Company, Motion, Walker};
use super::spawn::EGO_WAY_M;
use crate::assets::person::PersonModel;
use crate::math::{self, DVec2};
use crate::rng::Stream;

/// How likely somebody joins another of the last few who came, and how likely a group of two and more grows.
const COMPANY_SHARE: f64 = 0.75;
const GROWS_SHARE: f64 = 0.7;
const MOST_TOGETHER: usize = 7;
/// A group is joined by who comes at most so many later.
const JOINS_WITHIN: usize = 4;
/// Between shoulders in a row, between rows, and between people who stand and talk.
const ASIDE_M: (f64, f64) = (0.56, 0.86);
const BEHIND_M: (f64, f64) = (0.85, 1.5);
const TALK_M: (f64, f64) = (0.65, 1.1);
/// How many others mean to cross the road.
const CROSSERS_SHARE: f64 = 0.4;
/// Pavements this near to the ego's way are along it, and so many walk there of those who walk elsewhere.
const BESIDE_EGO_WAY_M: f64 = 14.0;
const PEOPLE_ON_EGO_WAY: f64 = 0.7;
/// Between people who do not know each other, and between a person and a parked car.
const STRANGERS_M: f64 = 0.9;
const CAR_M: f64 = 0.4;

impl World {
    /// Somebody in a group, or at a random place of a walkway, between two distances from the ego.
    pub(super) fn new_walker(
        &mut self,
        slot: usize,
        stream: &mut Stream,
        ring_m: (f64, f64),
        hidden: bool,
    ) -> Option<Walker> {
        let (ego, view) = self.ego_place();
        let model = Arc::new(PersonModel::generate(stream.next_u64()));
        let walks = model.walking_speed_mps > 0.0;
        if let Some(leader) = self.group_to_join(slot, walks, hidden.then_some((ego, ring_m.0)), stream) {
            let joined = match self.walkers[leader].motion {
                Motion::Walks { walkway, s_m, direction } => {
                    self.in_a_row(slot, leader, stream, &model, (walkway, s_m, direction))
                }
                _ => self.in_a_circle(slot, leader, stream, &model, hidden),
            };
            if joined.is_some() {
                return joined;
            }
        }
        let way: Vec<DVec2> = self.ego_way().map_or_else(Vec::new, |r| {
            (0..(EGO_WAY_M / 8.0) as usize).map(|k| r.ahead(k as f64 * 8.0, &self.roads).at).collect()
        });
        let mut places: Vec<(usize, f64, f64)> = Vec::new();
        for walkway in self.pavements.usable() {
            let mut s = 1.0;
            while s < self.pavements.length_m(walkway) - 1.0 {
                let at = self.pavements.spot(walkway, s).at;
                let to = at - ego;
                let distance = to.length();
                let in_view = to.dot(view) > 0.7 * distance && distance < 110.0;
                if (ring_m.0..ring_m.1).contains(&distance) && !(hidden && in_view) {
                    let on_way = way.iter().any(|p| (*p - at).length() < BESIDE_EGO_WAY_M);
                    places.push((walkway, s, if on_way { PEOPLE_ON_EGO_WAY } else { 1.0 }));
                }
                s += 3.0;
            }
        }
        let weights: Vec<f64> = places.iter().map(|p| p.2).collect();
        for _ in 0..8 {
            let (walkway, s, _) = *places.get(stream.weighted(&weights))?;
            let s_m = (s + stream.range(0.0, 2.9)).min(self.pavements.length_m(walkway) - 0.5);
            let direction = if stream.chance(0.5) { 1.0 } else { -1.0 };
            let room = self.pavements.room_m(walkway);
            // A little to the own right.
            let lateral_m = stream.clipped_normal(-0.15 * direction, 0.35).clamp(-room, room);
            if self.has_room_for_person(self.on_pavement(walkway, s_m, lateral_m), slot, STRANGERS_M) {
                let mut walker = self.walker_on(stream, model, (walkway, s_m, direction), lateral_m)?;
                walker.crosser = walks && stream.chance(CROSSERS_SHARE);
                return Some(walker);
            }
        }
        None
    }

    /// The one who leads a group of people who walk, or who stand, that a newcomer joins; farther from a place than a
    /// distance, if one is given.
    fn group_to_join(
        &self,
        slot: usize,
        walks: bool,
        away: Option<(DVec2, f64)>,
        stream: &mut Stream,
    ) -> Option<usize> {
        let leader_of = |i: usize| self.walkers[i].company.map_or(i, |c| c.leader);
        let leader = (slot.saturating_sub(JOINS_WITHIN)..slot).rev().map(leader_of).find(|leader| {
            let of = &self.walkers[*leader];
            let alike = match of.motion {
                Motion::Walks { .. } => walks,
                Motion::Stands => !walks,
                Motion::Waits { .. } | Motion::Crosses { .. } => false,
            };
            *leader != slot
                && alike
                && !of.is_placed
                && away.is_none_or(|(place, least_m)| (of.at() - place).length() > least_m)
        });
        let share = leader.map_or(0.0, |leader| match self.group_size(leader) {
            1 => COMPANY_SHARE,
            size if size < MOST_TOGETHER => GROWS_SHARE,
            _ => 0.0,
        });
        let joins = stream.chance(share);
        leader.filter(|_| joins)
    }

    fn group_size(&self, leader: usize) -> usize {
        1 + self.members(leader).count()
    }

    fn members(&self, leader: usize) -> impl Iterator<Item = &Walker> {
        self.walkers.iter().filter(move |w| w.company.is_some_and(|c| c.leader == leader))
    }

    /// Two abreast where the pavement has the room, one behind the other where not.
    fn in_a_row(
        &mut self,
        slot: usize,
        leader: usize,
        stream: &mut Stream,
        model: &Arc<PersonModel>,
        (walkway, s_m, direction): (usize, f64, f64),
    ) -> Option<Walker> {
        let apart_m = stream.range(ASIDE_M.0, ASIDE_M.1);
        let row_m = stream.range(BEHIND_M.0, BEHIND_M.1);
        let (size, room) = (self.group_size(leader), self.pavements.room_m(walkway));
        let lead_m = self.walkers[leader].lateral_m;
        let has_room_for_two = room > apart_m / 2.0;
        let (row, is_aside) = if has_room_for_two { (size / 2, size % 2 == 1) } else { (size, false) };
        let behind_m = row as f64 * row_m;
        let aside = self.members(leader).filter_map(|w| w.company).map(|c| c.aside_m).find(|m| *m != 0.0);
        // They share the pavement: the one who leads makes way.
        let side = aside.map_or(if lead_m > 0.0 { -1.0 } else { 1.0 }, f64::signum);
        let aside_m = if is_aside { side * apart_m } else { 0.0 };
        let lateral_m = (lead_m + aside_m).clamp(-room, room);
        let s_m = self.pavements.wrapped(walkway, s_m - direction * behind_m)?;
        if !self.has_room_for_person(self.on_pavement(walkway, s_m, lateral_m), slot, 2.0 * BODY_M) {
            return None;
        }
        if aside.is_none() && is_aside {
            let kept_m = if side > 0.0 { lead_m.min(room - apart_m) } else { lead_m.max(apart_m - room) };
            self.walkers[leader].keep_to(kept_m);
        }
        let mut walker = self.walker_on(stream, Arc::clone(model), (walkway, s_m, direction), lateral_m)?;
        walker.company = Some(Company { leader, aside_m, behind_m });
        Some(walker)
    }

    /// Somebody who stands with others, turned to the first of them.
    fn in_a_circle(
        &mut self,
        slot: usize,
        leader: usize,
        stream: &mut Stream,
        model: &Arc<PersonModel>,
        hidden: bool,
    ) -> Option<Walker> {
        let middle = self.walkers[leader].at();
        let (distance_m, bearing) = (stream.range(TALK_M.0, TALK_M.1), stream.range(-math::PI, math::PI));
        let away = DVec2::new(math::cos(bearing), math::sin(bearing));
        let at = middle + away * distance_m;
        if !self.roads.is_pavement(at) || !self.has_room_for_person(at, slot, 2.0 * BODY_M) {
            return None;
        }
        if !hidden && self.group_size(leader) == 1 {
            self.walkers[leader].yaw_rad = bearing;
        }
        let yaw_rad = math::wrap_angle(bearing + math::PI);
        let mut walker = self.posed_walker(stream, Arc::clone(model), at, yaw_rad)?;
        walker.company = Some(Company { leader, aside_m: 0.0, behind_m: 0.0 });
        Some(walker)
    }

    fn on_pavement(&self, walkway: usize, s_m: f64, lateral_m: f64) -> DVec2 {
        let spot = self.pavements.spot(walkway, s_m);
        spot.at + spot.tangent.perp() * lateral_m
    }

    /// Whether nobody but who is in `slot` is within `apart_m` of a place, and no parked car is near it.
    fn has_room_for_person(&self, at: DVec2, slot: usize, apart_m: f64) -> bool {
        let is_near_somebody =
            self.walkers.iter().enumerate().any(|(i, w)| i != slot && (w.at() - at).length() < apart_m);
        !is_near_somebody && self.parked.iter().all(|p| (p.footprint.closest_point(at) - at).length() >= CAR_M)
    }

    fn walker_on(
        &mut self,
        stream: &mut Stream,
        model: Arc<PersonModel>,
        (walkway, s_m, direction): (usize, f64, f64),
        lateral_m: f64,
    ) -> Option<Walker> {
        let heading = self.pavements.spot(walkway, s_m).tangent * direction;
        let walks = model.walking_speed_mps > 0.0;
        let yaw_rad = if walks { math::atan2(heading.y, heading.x) } else { stream.range(-math::PI, math::PI) };
        let mut walker = self.posed_walker(stream, model, self.on_pavement(walkway, s_m, lateral_m), yaw_rad)?;
        if walks {
            walker.start(walkway, s_m, direction, lateral_m);
        }
        Some(walker)
    }

    fn posed_walker(
        &mut self,
        stream: &mut Stream,
        model: Arc<PersonModel>,
        at: DVec2,
        yaw_rad: f64,
    ) -> Option<Walker> {
        let mut walker =
            Walker::posed(&self.physics, self.next_id, model, at.x, at.y, yaw_rad, stream.next_u64()).ok()?;
        walker.is_placed = false;
        self.next_id += 1;
        Some(walker)
    }

    /// Puts a newcomer in the place of who has gone, whom nobody follows any longer.
    pub(super) fn replace_walker(&mut self, slot: usize, walker: Walker) {
        for other in self.walkers.iter_mut().filter(|w| w.company.is_some_and(|c| c.leader == slot)) {
            other.company = None;
        }
        self.walkers[slot] = walker;
    }
}
