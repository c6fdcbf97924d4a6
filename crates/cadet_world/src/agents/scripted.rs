//! A user's script: an agent goes along a path whatever the others do.

use super::actor::{Actor, ActorView};
use super::behavior::Behavior;
use super::timed_path::{OnPath, TimedPath};
use crate::body::{Cycle, Guided, Step, Upright};
use crate::footprint::Footprint;
use crate::look::{CyclistLook, FigureLook, PersonLook, VehicleLook};
use crate::outlook::Outlook;
use crate::physics::{DT_S, Physics};
use crate::slot::Slot;
use crate::streets::{Ahead, LaneGraph, Streets};
use crate::traffic_state::TrafficState;
use crate::walking::{is_on_road, keep_off};
use cadet_base::math::{self, DVec2};
use cadet_base::plane::heading_rad;

/// How fast agents turn where a path has a corner: a car at full lock at 6 m/s, and a person.
const VEHICLE_TURN_RADPS: f64 = 1.2;
const PERSON_TURN_RADPS: f64 = 3.0;
/// A person looks along the path from this far behind to this far ahead; a vehicle from its rear axle to its front one.
pub(crate) const PERSON_HALF_CHORD_M: f64 = 0.25;
/// How far ahead others see where a vehicle is going.
const SEEN_AHEAD_M: f64 = 60.0;
const SAMPLE_M: f64 = 1.25;
/// Drivers keep off where a person will be in this time.
const LEAD_S: f64 = 1.5;

/// Where a user wants an agent to be, and when.
pub(crate) struct Script {
    path: TimedPath,
    /// Half the length of the chord of the path that the agent heads along.
    half_chord_m: f64,
    steps: u64,
    s_m: f64,
}

impl Script {
    pub fn new(path: TimedPath, half_chord_m: f64) -> Self {
        Self { path, half_chord_m, steps: 0, s_m: 0.0 }
    }

    /// Where the agent is at first: place, heading and velocity.
    pub fn start(&self) -> (DVec2, f64, DVec2) {
        let now = self.path.at_time(0.0);
        let heading = self.path.heading(0.0, self.half_chord_m).unwrap_or(DVec2::X);
        (now.at, heading_rad(heading), now.velocity)
    }

    /// One step on; returns the place and how far the agent has come.
    fn go_on(&mut self) -> (OnPath, f64) {
        self.steps += 1;
        let now = self.path.at_time(self.steps as f64 * DT_S);
        let moved_m = now.s_m - self.s_m;
        self.s_m = now.s_m;
        (now, moved_m)
    }

    /// The turn of this step from a heading toward that of the path.
    fn turn_rad(&self, yaw_rad: f64, most_radps: f64) -> f64 {
        let Some(heading) = self.path.heading(self.s_m, self.half_chord_m) else { return 0.0 };
        let turn_rad = math::wrap_angle(heading_rad(heading) - yaw_rad);
        turn_rad.clamp(-most_radps * DT_S, most_radps * DT_S)
    }

    /// Leads somebody on foot to a place of this step.
    fn lead(&self, body: &mut Upright, physics: &Physics, now: &OnPath, moved_m: f64) {
        let before = body.position;
        let z_m = physics.ground_at(now.at.extend(before.z)).map_or(before.z, |g| g.z_m);
        body.position = now.at.extend(z_m);
        let climb_mps = if moved_m > 0.0 { (z_m - before.z) / DT_S } else { 0.0 };
        body.velocity_world = now.velocity.extend(climb_mps);
        body.yaw_rad = math::wrap_angle(body.yaw_rad + self.turn_rad(body.yaw_rad, PERSON_TURN_RADPS));
    }
}

/// An agent that follows a script.
pub(crate) struct Scripted {
    pub script: Script,
    pub led: Led,
}

/// What a script leads.
pub(crate) enum Led {
    Vehicle(Actor<Guided, VehicleLook>),
    Cyclist(Actor<Cycle, CyclistLook>),
    Person(Actor<Upright, PersonLook>),
    Figure(Actor<Upright, FigureLook>),
    RidingFigure(Actor<Cycle, FigureLook>),
}

impl Scripted {
    /// The body of somebody who is led on foot.
    fn person(&self) -> Option<&Upright> {
        self.actor(0)?.body.person()
    }
}

impl Behavior for Scripted {
    fn actor(&self, k: usize) -> Option<ActorView<'_>> {
        (k == 0).then(|| match &self.led {
            Led::Vehicle(actor) => actor.view(),
            Led::Cyclist(actor) => actor.view(),
            Led::Person(actor) => actor.view(),
            Led::Figure(actor) => actor.view(),
            Led::RidingFigure(actor) => actor.view(),
        })
    }

    fn look(&mut self, slot: Slot, around: &TrafficState, _streets: &Streets, _step: u64) -> Outlook {
        if self.person().is_some() {
            return Outlook::default();
        }
        let Script { path, s_m, .. } = &self.script;
        let z_m = around.vehicle(slot).map_or(0.0, |f| f.z_m);
        let count = ((path.length_m() - s_m).min(SEEN_AHEAD_M) / SAMPLE_M) as usize;
        let way = (0..count).filter_map(|k| {
            let distance_m = k as f64 * SAMPLE_M;
            let tangent = path.heading(s_m + distance_m, SAMPLE_M / 2.0)?;
            Some(Ahead { distance_m, at: path.at_distance(s_m + distance_m), z_m, tangent })
        });
        Outlook { way_ahead: way.collect(), ..Outlook::default() }
    }

    fn act(&mut self, physics: &mut Physics, _streets: &Streets) {
        let Self { script, led } = self;
        let (now, moved_m) = script.go_on();
        let step = |yaw_rad: f64| {
            // Nobody turns a car that stands.
            let turn_rad = if moved_m > 0.0 { script.turn_rad(yaw_rad, VEHICLE_TURN_RADPS) } else { 0.0 };
            Step { at: now.at, velocity: now.velocity, moved_m, turn_rad }
        };
        match led {
            Led::Vehicle(Actor { body, .. }) => body.guide(physics, &step(body.yaw_rad())),
            Led::Cyclist(Actor { body, look: CyclistLook { model, ride } }) => {
                let step = step(body.yaw_rad);
                body.guide(physics, &step);
                ride.advance(model, moved_m, step.turn_rad, true);
            }
            Led::Person(Actor { body, look }) => {
                script.lead(body, physics, &now, moved_m);
                look.walk(moved_m);
            }
            Led::Figure(Actor { body, .. }) => script.lead(body, physics, &now, moved_m),
            Led::RidingFigure(Actor { body, .. }) => body.guide(physics, &step(body.yaw_rad)),
        }
    }

    fn on_road(&self, graph: &LaneGraph) -> Option<Footprint> {
        let body = self.person()?;
        let lead_m = body.velocity_world.truncate().length() * LEAD_S;
        let soon = body.at() + body.heading() * lead_m;
        let is_on_road = is_on_road(body, body.at(), graph) || is_on_road(body, soon, graph);
        is_on_road.then(|| keep_off(body, lead_m))
    }
}
