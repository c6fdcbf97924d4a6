//! Groups of people: who joins whom, and where.

use std::sync::Arc;

use super::spawner::{Entry, Newcomer, Spawner};
use crate::agents::Pedestrian;
use crate::footprint::Footprint;
use crate::slot::Slot;
use crate::walking::{GroupPlace, Motion, room_of};
use cadet_assets::person::PersonModel;
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::plane::{heading_rad, unit};

/// How likely somebody joins another of the last few who came, and how likely a group of two and more grows.
const COMPANY_SHARE: f64 = 0.75;
const GROWS_SHARE: f64 = 0.7;
const MOST_TOGETHER: usize = 7;
/// A group is joined by who comes at most so many later.
const JOINS_WITHIN: usize = 4;
/// Between shoulders in a row, between rows, and between people who stand and talk.
const ASIDE_M: (f64, f64) = (0.62, 0.9);
const BEHIND_M: (f64, f64) = (1.1, 1.6);
const TALK_M: (f64, f64) = (0.65, 1.1);
/// Between others of those who stand together.
const CIRCLE_M: f64 = 0.6;

impl Spawner<'_> {
    /// The one who leads a group of people who walk, or who stand, that somebody joins; as far from the ego as they come
    /// in if it may not be seen.
    pub(super) fn group_to_join(&self, by: &mut Newcomer<'_>, walks: bool, ego: DVec2) -> Option<Slot> {
        let Newcomer { slot, ring_m: (least_m, _), entry, .. } = *by;
        let earlier = self.arena.each::<Pedestrian>().rev().filter(|(other, ..)| *other < slot);
        let leaders = earlier.take(JOINS_WITHIN).map(|(other, _, p)| p.company.map_or(other, |c| c.leader));
        let leader = leaders.into_iter().find(|leader| {
            let is_alike = match self.pedestrian(*leader).motion {
                Motion::Walks { .. } => walks,
                Motion::Stands => !walks,
                Motion::Waits { .. } | Motion::Crosses { .. } => false,
            };
            *leader != slot
                && is_alike
                && !self.arena.agents[*leader].is_placed
                && (entry == Entry::Anywhere || (self.place_of(*leader).truncate() - ego).length() > least_m)
        });
        let share = leader.map_or(0.0, |leader| match self.group_size(leader) {
            1 => COMPANY_SHARE,
            size if size < MOST_TOGETHER => GROWS_SHARE,
            _ => 0.0,
        });
        let joins = by.stream.chance(share);
        leader.filter(|_| joins)
    }

    fn group_size(&self, leader: Slot) -> usize {
        1 + self.members(leader).count()
    }

    fn members(&self, leader: Slot) -> impl Iterator<Item = &Pedestrian> {
        let people = self.arena.each::<Pedestrian>().map(|(.., pedestrian)| pedestrian);
        people.filter(move |p| p.company.is_some_and(|c| c.leader == leader))
    }

    /// Two abreast where the sidewalk has the room, one behind the other where not.
    pub(super) fn in_a_row(
        &mut self,
        by: &mut Newcomer<'_>,
        leader: Slot,
        model: &Arc<PersonModel>,
        (walkway, s_m, direction): (usize, f64, f64),
    ) -> Option<Pedestrian> {
        let apart_m = by.stream.within(ASIDE_M);
        let row_m = by.stream.within(BEHIND_M);
        let (size, room) = (self.group_size(leader), self.arena.streets.sidewalks.room_m(walkway));
        let lead_m = self.pedestrian(leader).lateral_m;
        let has_room_for_two = room > apart_m / 2.0;
        let is_aside = has_room_for_two && size % 2 == 1;
        let companies: Vec<GroupPlace> = self.members(leader).filter_map(|p| p.company).collect();
        // The first of a column is beside the one who leads.
        let column = companies.iter().filter(|c| (c.aside_m != 0.0) == is_aside).map(|c| c.behind_m + row_m);
        let behind_m = column.fold(if is_aside { 0.0 } else { row_m }, f64::max);
        let aside = companies.iter().map(|c| c.aside_m).find(|m| *m != 0.0);
        // They share the sidewalk: the one who leads makes way.
        let side = aside.map_or(if lead_m > 0.0 { -1.0 } else { 1.0 }, f64::signum);
        let aside_m = if is_aside { side * apart_m } else { 0.0 };
        let lateral_m = (lead_m + aside_m).clamp(-room, room);
        let s_m = self.arena.streets.sidewalks.wrapped(walkway, s_m - direction * behind_m)?;
        let at = self.on_sidewalk(walkway, s_m, lateral_m);
        let yaw_rad = heading_rad(self.arena.streets.sidewalks.spot(walkway, s_m).tangent);
        let own = room_of(&Footprint::of_upright(model.size_lwh, at, yaw_rad));
        let meets_somebody = self.arena.people().any(|(other, room)| other != by.slot && room.overlaps(&own));
        if meets_somebody || !self.has_room_for_person(at, by.slot, 0.0) {
            return None;
        }
        if aside.is_none() && is_aside {
            let kept_m = if side > 0.0 { lead_m.min(room - apart_m) } else { lead_m.max(apart_m - room) };
            if let Some(pedestrian) = self.arena.agents[leader].get_mut::<Pedestrian>() {
                pedestrian.keep_to(kept_m);
            }
        }
        let mut walker = self.walker_on(by.stream, Arc::clone(model), (walkway, s_m, direction), lateral_m)?;
        walker.company = Some(GroupPlace { leader, aside_m, behind_m });
        Some(walker)
    }

    /// Somebody who stands with others, turned to the first of them.
    pub(super) fn in_a_circle(
        &mut self,
        by: &mut Newcomer<'_>,
        leader: Slot,
        model: &Arc<PersonModel>,
    ) -> Option<Pedestrian> {
        let middle = self.place_of(leader);
        let (distance_m, bearing) = (by.stream.within(TALK_M), by.stream.range(-math::PI, math::PI));
        let away = unit(bearing);
        let at = middle + (away * distance_m).extend(0.0);
        if !self.arena.streets.graph.is_sidewalk(at) || !self.has_room_for_person(at, by.slot, CIRCLE_M) {
            return None;
        }
        if by.entry == Entry::Anywhere
            && self.group_size(leader) == 1
            && let Some(pedestrian) = self.arena.agents[leader].get_mut::<Pedestrian>()
        {
            pedestrian.own.body.yaw_rad = bearing;
        }
        let yaw_rad = math::wrap_angle(bearing + math::PI);
        let mut walker = self.posed_walker(by.stream, Arc::clone(model), at, yaw_rad)?;
        walker.company = Some(GroupPlace { leader, aside_m: 0.0, behind_m: 0.0 });
        Some(walker)
    }

    /// The pedestrian in a slot.
    pub(super) fn pedestrian(&self, slot: Slot) -> &Pedestrian {
        self.arena.agents[slot].get::<Pedestrian>().expect("pedestrians join pedestrians")
    }

    fn place_of(&self, slot: Slot) -> DVec3 {
        self.pedestrian(slot).own.body.position
    }
}
