//! A user's script: an agent goes along a path whatever the others do.

use super::controller::{AgentParts, Controller};
use super::timed_path::TimedPath;
use crate::math::{self, DVec2};
use crate::world::body::{Body, Step};
use crate::world::footprint::Footprint;
use crate::world::look::Appearance;
use crate::world::outlook::Outlook;
use crate::world::physics::{DT_S, Physics};
use crate::world::streets::Ahead;
use crate::world::streets::Roads;
use crate::world::streets::Streets;
use crate::world::traffic_state::TrafficState;
use crate::world::walking::{is_on_road, keep_off};

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

/// Moves a [`Body::Guided`], a [`Body::Cycle`], or a [`Body::Upright`] along a path.
pub(crate) struct Scripted {
    path: TimedPath,
    /// Half the length of the chord of the path that the agent heads along.
    half_chord_m: f64,
    steps: u64,
    s_m: f64,
}

impl Scripted {
    pub fn new(path: TimedPath, half_chord_m: f64) -> Self {
        Self { path, half_chord_m, steps: 0, s_m: 0.0 }
    }

    /// Where the agent is at first: place, heading and velocity.
    pub fn start(&self) -> (DVec2, f64, DVec2) {
        let now = self.path.at_time(0.0);
        let heading = self.path.heading(0.0, self.half_chord_m).unwrap_or(DVec2::X);
        (now.at, math::atan2(heading.y, heading.x), now.velocity)
    }

    /// The turn of this step from a heading toward that of the path.
    fn turn_rad(&self, yaw_rad: f64, most_radps: f64) -> f64 {
        let Some(heading) = self.path.heading(self.s_m, self.half_chord_m) else { return 0.0 };
        let turn_rad = math::wrap_angle(math::atan2(heading.y, heading.x) - yaw_rad);
        turn_rad.clamp(-most_radps * DT_S, most_radps * DT_S)
    }
}

impl Controller for Scripted {
    fn look(&mut self, own: AgentParts<'_>, _around: &TrafficState, _streets: &Streets, _step: u64) -> Outlook {
        if !matches!(own.body, Body::Guided(_) | Body::Cycle(_)) {
            return Outlook::default();
        }
        let count = ((self.path.length_m() - self.s_m).min(SEEN_AHEAD_M) / SAMPLE_M) as usize;
        let way = (0..count).filter_map(|k| {
            let distance_m = k as f64 * SAMPLE_M;
            let tangent = self.path.heading(self.s_m + distance_m, SAMPLE_M / 2.0)?;
            Some(Ahead { distance_m, at: self.path.at_distance(self.s_m + distance_m), tangent })
        });
        Outlook { way_ahead: way.collect(), ..Outlook::default() }
    }

    fn act(&mut self, own: AgentParts<'_>, physics: &mut Physics, _streets: &Streets) {
        self.steps += 1;
        let now = self.path.at_time(self.steps as f64 * DT_S);
        let moved_m = now.s_m - self.s_m;
        self.s_m = now.s_m;
        match (own.body, own.appearance) {
            (Body::Guided(body), _) => {
                // Nobody turns a car that stands.
                let turn_rad = if moved_m > 0.0 { self.turn_rad(body.yaw_rad(), VEHICLE_TURN_RADPS) } else { 0.0 };
                body.guide(physics, &Step { at: now.at, velocity: now.velocity, moved_m, turn_rad });
            }
            (Body::Cycle(body), Appearance::Cyclist { model, ride }) => {
                let turn_rad = if moved_m > 0.0 { self.turn_rad(body.yaw_rad, VEHICLE_TURN_RADPS) } else { 0.0 };
                body.guide(physics, &Step { at: now.at, velocity: now.velocity, moved_m, turn_rad });
                ride.advance(model, moved_m, turn_rad, true);
            }
            (Body::Upright(body), Appearance::Person { model, phase }) => {
                let before = body.position;
                let z_m = physics.ground_at(now.at.x, now.at.y).map_or(before.z, |g| g.z_m);
                body.position = now.at.extend(z_m);
                let climb_mps = if moved_m > 0.0 { (z_m - before.z) / DT_S } else { 0.0 };
                body.velocity_world = now.velocity.extend(climb_mps);
                body.yaw_rad = math::wrap_angle(body.yaw_rad + self.turn_rad(body.yaw_rad, PERSON_TURN_RADPS));
                *phase = (*phase + moved_m / model.cycle_length_m.max(0.1)).fract();
            }
            _ => {}
        }
    }

    fn on_road(&self, body: &Body, roads: &Roads) -> Option<Footprint> {
        let Body::Upright(body) = body else { return None };
        let lead_m = body.velocity_world.truncate().length() * LEAD_S;
        let soon = body.at() + body.heading() * lead_m;
        let is_on_road = is_on_road(body, body.at(), roads) || is_on_road(body, soon, roads);
        is_on_road.then(|| keep_off(body, lead_m))
    }
}
