//! People on foot: they walk along sidewalks, keep out of each other's way, and cross the road when it is free.

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use crate::body::Upright;
use crate::footprint::Footprint;
use crate::look::PersonLook;
use crate::outlook::Outlook;
use crate::params::walking::{
    BLOCKED_S, CROSSES_AGAIN_SHARE, CROSSING_MPS, HELD_S, LOOKS_ACROSS_CHANCE, OFF_LINE_M, OVER_M, ROUND_OTHERS_M,
    SIDESTEP_MPS, TOGETHER_M, TURN_RADPS, WALKS_MPS, ZEBRA_LEAD_M,
};
use crate::params::{CRAWLS_MPS, LOOK_S};
use crate::physics::{DT_S, Physics};
use crate::slot::Slot;
use crate::streets::{LaneGraph, Sidewalks, Streets};
use crate::traffic_state::TrafficState;
use crate::walking::{
    GroupPlace, Motion, Nearby, OnWalkway, Walk, free_line, is_on_road, keep_off, may_start, pace_behind, way_across,
};
use cadet_base::math::{self, DVec2};
use cadet_base::plane::heading_rad;
use cadet_base::rng::Stream;

/// Somebody on foot.
pub(crate) struct Pedestrian {
    pub own: Actor<Upright, PersonLook>,
    pub motion: Motion,
    /// Offset to the left of the walkway's line; what is, what was chosen, and what avoiding others asks for.
    pub lateral_m: f64,
    preferred_m: f64,
    wanted_m: f64,
    /// 0 to stop, 1 to walk on.
    pace: f64,
    blocked_s: f64,
    /// How long no step was possible.
    held_s: f64,
    nearby: Nearby,
    /// The group that one belongs to without leading it.
    pub company: Option<GroupPlace>,
    /// Whether this one means to cross the road.
    pub crosser: bool,
    choices: Stream,
}

impl Pedestrian {
    /// Somebody who stands, for good unless they [`Pedestrian::start`].
    pub fn standing(own: Actor<Upright, PersonLook>, choices: Stream) -> Self {
        Self {
            own,
            motion: Motion::Stands,
            lateral_m: 0.0,
            preferred_m: 0.0,
            wanted_m: 0.0,
            pace: 1.0,
            blocked_s: 0.0,
            held_s: 0.0,
            nearby: Nearby::default(),
            company: None,
            crosser: false,
            choices,
        }
    }

    /// Sets the person on their way along a walkway.
    pub fn start(&mut self, walkway: usize, s_m: f64, direction: f64, lateral_m: f64) {
        self.motion = Motion::Walks { walkway, s_m, direction };
        (self.lateral_m, self.preferred_m, self.wanted_m) = (lateral_m, lateral_m, lateral_m);
    }

    /// Changes the line along the walkway that the person keeps to.
    pub fn keep_to(&mut self, lateral_m: f64) {
        (self.preferred_m, self.wanted_m) = (lateral_m, lateral_m);
    }

    /// Where the next step would lead if nothing were in the way, and what one would be about then.
    fn wanted_step(&mut self, here: DVec2, sidewalks: &Sidewalks) -> (DVec2, Motion) {
        match self.motion {
            Motion::Stands | Motion::Waits { .. } => (here, self.motion),
            Motion::Walks { walkway, s_m, direction } => {
                let step_m = self.own.look.model.walking_speed_mps * self.pace * DT_S;
                let limit_m = SIDESTEP_MPS * DT_S * self.pace.max(0.3);
                if (self.target(sidewalks, walkway, s_m) - here).length() > OFF_LINE_M {
                    // Corners and changes of walkway are walked, not jumped.
                    let target = self.target(sidewalks, walkway, s_m);
                    return (step_towards(here, target, step_m.max(limit_m)), self.motion);
                }
                self.lateral_m += (self.wanted_m - self.lateral_m).clamp(-limit_m, limit_m);
                let motion = match sidewalks.wrapped(walkway, s_m + direction * step_m) {
                    Some(s_m) => Motion::Walks { walkway, s_m, direction },
                    None => self.turn_corner(sidewalks, walkway, direction),
                };
                let Motion::Walks { walkway, s_m, .. } = motion else { return (here, motion) };
                (step_towards(here, self.target(sidewalks, walkway, s_m), (step_m * 1.5).max(limit_m)), motion)
            }
            Motion::Crosses { to, .. } => (step_towards(here, to, CROSSING_MPS * self.pace * DT_S), self.motion),
        }
    }

    /// The point of the person's own line at a distance along a walkway.
    fn target(&self, sidewalks: &Sidewalks, walkway: usize, s_m: f64) -> DVec2 {
        let spot = sidewalks.spot(walkway, s_m);
        spot.at + spot.tangent.perp() * self.lateral_m
    }

    fn turn_corner(&mut self, sidewalks: &Sidewalks, walkway: usize, direction: f64) -> Motion {
        let at_end = direction > 0.0;
        let onward = sidewalks.onward(walkway, at_end);
        let next = onward.get(self.choices.below(onward.len())).copied();
        let (walkway, direction) = next.unwrap_or((walkway, -direction));
        let s_m = if direction > 0.0 { 0.0 } else { sidewalks.length_m(walkway) };
        self.preferred_m = self.preferred_m.clamp(-sidewalks.room_m(walkway), sidewalks.room_m(walkway));
        self.wanted_m = self.preferred_m;
        Motion::Walks { walkway, s_m, direction }
    }

    /// Looks around while walking: stays with a group, side-steps, stops, turns back, or stops at the curb to cross.
    fn look_on_walkway(&mut self, own: OnWalkway, around: &TrafficState, streets: &Streets) {
        let OnWalkway { walkway, s_m, direction, .. } = own;
        if self.held_s > HELD_S {
            self.held_s = 0.0;
            self.company = None;
            self.motion = Motion::Walks { walkway, s_m, direction: -direction };
            return;
        }
        let leader = self.company.and_then(|c| around.walk_of(c.leader).map(|walk| (walk, c)));
        if let Some((walk, company)) = leader
            && let Motion::Walks { walkway: other, s_m: theirs, direction: same } = walk.motion
        {
            // A group keeps its places, and turns round with the one who leads.
            let is_near = (theirs - s_m).abs() < TOGETHER_M + company.behind_m;
            if other == walkway && (same == direction || is_near) {
                let direction = same;
                self.motion = Motion::Walks { walkway, s_m, direction };
                let behind_m = (theirs - s_m) * direction - company.behind_m;
                let room = streets.sidewalks.room_m(walkway);
                let line_m = (walk.wanted_m + company.aside_m).clamp(-room, room);
                self.avoid(&OnWalkway { direction, ..own }, line_m, around, &streets.sidewalks);
                self.pace = self.pace.min(1.0) * (walk.pace_share + 0.4 * behind_m).clamp(0.0, 1.4);
                self.pace = self.pace.min(pace_behind(&own, around, &streets.sidewalks));
                return;
            }
        }
        self.avoid(&own, self.preferred_m, around, &streets.sidewalks);
        self.pace = self.pace.min(pace_behind(&own, around, &streets.sidewalks));
        if self.crosser && self.pace > 0.5 && self.choices.chance(LOOKS_ACROSS_CHANCE) {
            let position = own.at.extend(own.z_m);
            if let Some(wait) = way_across(position, walkway, s_m, around, streets) {
                self.motion = wait;
                self.pace = 0.0;
                self.crosser = self.choices.chance(CROSSES_AGAIN_SHARE);
            }
        }
    }

    /// Side-steps what stands and who comes, to return to the line `line_m`; stops where there is no way past, and turns
    /// back after a while.
    fn avoid(&mut self, own: &OnWalkway, line_m: f64, around: &TrafficState, sidewalks: &Sidewalks) {
        match free_line(own, line_m, self.preferred_m.abs(), around, sidewalks) {
            Some(lateral_m) => {
                self.wanted_m = lateral_m;
                // Side-step first, then walk on.
                self.pace = if (lateral_m - self.lateral_m).abs() > 0.6 { 0.5 } else { 1.0 };
                self.blocked_s = 0.0;
            }
            None => {
                self.pace = 0.0;
                self.blocked_s += LOOK_S;
                if self.blocked_s > BLOCKED_S {
                    self.blocked_s = 0.0;
                    self.pace = 1.0;
                    let OnWalkway { walkway, s_m, direction, .. } = *own;
                    self.motion = Motion::Walks { walkway, s_m, direction: -direction };
                }
            }
        }
    }
}

impl Behavior for Pedestrian {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        (k == 0).then(|| self.own.view())
    }

    fn look(&mut self, slot: Slot, around: &TrafficState, streets: &Streets, step: u64) -> Outlook {
        let (at, heading) = (self.own.body.at(), self.own.body.heading());
        self.nearby.look(slot, self.own.body.position, &around.people, &around.standing);
        match self.motion {
            Motion::Stands => {}
            Motion::Walks { walkway, s_m, direction } => {
                let walking_speed_mps = self.own.look.model.walking_speed_mps;
                let z_m = self.own.body.position.z;
                let on_walkway = OnWalkway { slot, at, z_m, walkway, s_m, direction, walking_speed_mps };
                self.look_on_walkway(on_walkway, around, streets);
            }
            Motion::Waits { from, to, walkway, s_m } => {
                let across = (to - from).normalize_or(DVec2::X);
                self.own.body.yaw_rad = heading_rad(across);
                if may_start((from, to), self.own.body.position.z, around, streets, step) {
                    self.pace = 1.0;
                    self.motion = Motion::Crosses { to, walkway, s_m };
                }
            }
            Motion::Crosses { .. } => {
                let front = at + heading * 0.8;
                // Moving vehicles are let pass; standing ones let people pass, and mutual waiting would never end.
                let is_blocked = around
                    .vehicles_level_with(front, self.own.body.position.z)
                    .map(|v| &v.footprint)
                    .filter(|f| f.velocity.length() > CRAWLS_MPS)
                    .any(|f| f.distance_m(front) < 0.4);
                self.pace = if is_blocked { 0.0 } else { 1.0 };
            }
        }
        let walk = Walk { motion: self.motion, pace_share: self.pace, wanted_m: self.wanted_m };
        Outlook { walk: Some(walk), ..Outlook::default() }
    }

    /// One step on foot: one person after the other, so that two never take the same place.
    fn track(&mut self, slot: Slot, physics: &Physics, around: &mut TrafficState, streets: &Streets) {
        let sidewalks = &streets.sidewalks;
        let (before, from, lateral_m) = (self.own.body.position, self.own.body.at(), self.lateral_m);
        let (wanted, motion) = self.wanted_step(from, sidewalks);
        let line = match motion {
            Motion::Walks { walkway, s_m, .. } => Some(self.target(sidewalks, walkway, s_m)),
            _ => None,
        };
        let (graph, stray_m) = (&streets.graph, line.map_or(0.0, |line| ROUND_OTHERS_M.max((from - line).length())));
        let is_sidewalk = |p: DVec2| graph.is_sidewalk(p.extend(before.z));
        let leaves_sidewalk = |p: DVec2, line: DVec2| !is_sidewalk(p) && is_sidewalk(from) && is_sidewalk(line);
        let keeps_to_line =
            |p: DVec2| line.is_none_or(|line| (p - line).length() <= stray_m && !leaves_sidewalk(p, line));
        let step = if wanted == from {
            Some(from)
        } else {
            let own = around.room(slot);
            own.and_then(|own| self.nearby.step(own, wanted, &around.people, &around.vehicles, keeps_to_line))
        };
        match step {
            Some(_) => {
                self.motion = motion;
                self.held_s = 0.0;
            }
            None => {
                self.lateral_m = lateral_m;
                self.held_s += DT_S;
            }
        }
        let to = step.unwrap_or(from);
        if let Motion::Crosses { to: goal, walkway, s_m } = self.motion {
            let left_m = (goal - to).length();
            // Where others stand at the goal, any place beside the road will do.
            let is_beside_goal = self.held_s > 0.5 && left_m < OVER_M && streets.graph.is_sidewalk(to.extend(before.z));
            if left_m < 0.05 || is_beside_goal {
                let direction = if self.choices.chance(0.5) { 1.0 } else { -1.0 };
                self.start(walkway, s_m, direction, 0.0);
            }
        }
        let moved = to - from;
        let Actor { body, look } = &mut self.own;
        if moved.length_squared() > 0.0 {
            // The edge of the world: stay on the last ground.
            let Some(ground) = physics.ground_at(to.extend(before.z)) else { return };
            body.position = to.extend(ground.z_m);
            // Who side-steps faces on.
            if moved.length() > WALKS_MPS * DT_S {
                let turn = math::wrap_angle(heading_rad(moved) - body.yaw_rad);
                let most = TURN_RADPS * DT_S;
                body.yaw_rad = math::wrap_angle(body.yaw_rad + turn.clamp(-most, most));
            }
            look.walk(moved.length());
            around.move_person(slot, to, body.heading());
        }
        body.velocity_world = (body.position - before) / DT_S;
    }

    /// A person on the road, and where they will be in the next second and a half.
    fn on_road(&self, graph: &LaneGraph) -> Option<Footprint> {
        let body = &self.own.body;
        match self.motion {
            Motion::Crosses { to, .. } => {
                // Drivers let pass who is on a zebra crossing, and not only out of their own way.
                let is_let_over = graph.signals().is_on_zebra(body.at());
                let whole_m = (to - body.at()).length().min(ZEBRA_LEAD_M);
                Some(keep_off(body, if is_let_over { whole_m } else { 1.5 * CROSSING_MPS }))
            }
            Motion::Stands => is_on_road(body, body.at(), graph).then(|| keep_off(body, 0.0)),
            Motion::Walks { .. } | Motion::Waits { .. } => None,
        }
    }

    fn forget(&mut self, gone: Slot) {
        self.company = self.company.filter(|c| c.leader != gone);
    }
}

fn step_towards(from: DVec2, to: DVec2, step_m: f64) -> DVec2 {
    let d = to - from;
    let length = d.length();
    if length <= step_m { to } else { from + d * (step_m / length) }
}
