//! People on foot: they walk along pavements, keep out of each other's way, and cross the road when it is free.

use std::sync::Arc;

use super::car::Car;
use super::driver::Obstacle;
use super::footing::Nearby;
use super::pavement::Pavements;
use super::physics::{DT_S, Physics};
use super::route::Roads;
use crate::assets::person::PersonModel;
use crate::error::{Error, Result, finite};
use crate::frames;
use crate::math::{self, DPose3, DVec2, DVec3};
use crate::rng::Stream;

/// Gap in traffic, in seconds before the car arrives, that people accept beyond the time they need.
const MARGIN_S: f64 = 2.0;
const CROSSING_MPS: f64 = 1.5;
/// How fast people side-step, m/s.
const SIDESTEP_MPS: f64 = 0.5;
/// Whoever is within this of the place beside or behind the one who leads turns round with them.
const TOGETHER_M: f64 = 3.0;
/// Share of those who have crossed a road that mean to cross another.
const CROSSES_AGAIN: f64 = 0.7;
/// Half a person's width, and the room they leave to things.
const SHOULDER_M: f64 = 0.3;
/// Whoever is farther from their line than this goes there first, and then on along it.
const OFF_LINE_M: f64 = 0.6;
/// How far round others one may step off the line: not into the road.
const ROUND_OTHERS_M: f64 = 0.45;
/// Who could not set a step for this long turns round.
const HELD_S: f64 = 1.2;
/// A car slower than this stands.
const STANDS_MPS: f64 = 0.3;
/// At the far kerb among others one is over the road here.
const OVER_M: f64 = 0.8;

/// What a person is about.
#[derive(Debug, Clone, Copy)]
pub(super) enum Motion {
    /// Standing for good.
    Stands,
    /// Along a walkway, `direction` +1 or -1.
    Walks { walkway: usize, s_m: f64, direction: f64 },
    /// At the kerb, looking for a gap; then over to a place of another walkway.
    Waits { from: DVec2, to: DVec2, walkway: usize, s_m: f64 },
    /// On the road.
    Crosses { to: DVec2, walkway: usize, s_m: f64 },
}

/// A place in a group, relative to the one who leads.
#[derive(Debug, Clone, Copy)]
pub(super) struct Company {
    /// Index of who leads.
    pub leader: usize,
    /// To the left of the leader's place across the walkway's line.
    pub aside_m: f64,
    pub behind_m: f64,
}

/// A person.
pub(super) struct Walker {
    pub id: i32,
    pub model: Arc<PersonModel>,
    pub motion: Motion,
    /// Phase of the gait cycle in [0, 1).
    pub phase: f64,
    pub position: DVec3,
    pub velocity: DVec3,
    pub yaw_rad: f64,
    /// Offset to the left of the walkway's line; what is, what was chosen, and what avoiding others asks for.
    pub lateral_m: f64,
    pub habit_m: f64,
    wanted_m: f64,
    /// 0 to stop, 1 to walk on.
    pace: f64,
    blocked_s: f64,
    /// How long no step was possible.
    held_s: f64,
    nearby: Nearby,
    /// The group that one belongs to without leading it.
    pub company: Option<Company>,
    /// Whether this one means to cross the road.
    pub crosser: bool,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
    choices: Stream,
}

impl Walker {
    /// Somebody who stands where they were put, mid-stride if the model walks.
    pub fn posed(
        physics: &Physics,
        id: i32,
        model: Arc<PersonModel>,
        x_m: f64,
        y_m: f64,
        yaw_rad: f64,
        seed: u64,
    ) -> Result<Self> {
        finite("x", x_m)?;
        finite("y", y_m)?;
        finite("yaw", yaw_rad)?;
        let ground = physics.ground_at(x_m, y_m).ok_or_else(|| Error::Scene {
            reason: format!("a person at ({x_m}, {y_m}) would stand beyond the ground's edge"),
        })?;
        let mut choices = Stream::from_seed("walker", seed);
        let phase = choices.unit();
        Ok(Self {
            id,
            model,
            motion: Motion::Stands,
            phase,
            position: DVec3::new(x_m, y_m, ground.z_m),
            velocity: DVec3::ZERO,
            yaw_rad,
            lateral_m: 0.0,
            habit_m: 0.0,
            wanted_m: 0.0,
            pace: 1.0,
            blocked_s: 0.0,
            held_s: 0.0,
            nearby: Nearby::default(),
            company: None,
            crosser: false,
            is_placed: true,
            choices,
        })
    }

    /// Sets the person on their way along a walkway.
    pub fn start(&mut self, walkway: usize, s_m: f64, direction: f64, lateral_m: f64) {
        self.motion = Motion::Walks { walkway, s_m, direction };
        (self.lateral_m, self.habit_m, self.wanted_m) = (lateral_m, lateral_m, lateral_m);
    }

    /// Changes the line along the walkway that the person keeps to.
    pub fn keep_to(&mut self, lateral_m: f64) {
        (self.habit_m, self.wanted_m) = (lateral_m, lateral_m);
    }

    pub fn pose(&self) -> DPose3 {
        frames::upright(self.position, self.yaw_rad)
    }

    pub fn at(&self) -> DVec2 {
        self.position.truncate()
    }

    fn heading(&self) -> DVec2 {
        DVec2::new(math::cos(self.yaw_rad), math::sin(self.yaw_rad))
    }

    /// What drivers have to reckon with: a person on the road, and where they will be in the next second and a half.
    pub fn in_the_way(&self, roads: &Roads) -> Option<Obstacle> {
        let on_road = match self.motion {
            Motion::Crosses { .. } => true,
            Motion::Stands => roads.nearest(self.position, None, 2.6).is_some() && !roads.is_pavement(self.at()),
            Motion::Walks { .. } | Motion::Waits { .. } => false,
        };
        let lead_m = if matches!(self.motion, Motion::Crosses { .. }) { 1.5 * CROSSING_MPS } else { 0.0 };
        on_road.then(|| Obstacle {
            center: self.at() + self.heading() * (lead_m / 2.0),
            heading: self.heading(),
            half_length_m: lead_m / 2.0 + 0.5,
            half_width_m: 0.5,
            velocity: DVec2::ZERO,
        })
    }

    /// One step on foot. `places` is where everybody is at present, `cars` what the driven cars cover.
    pub fn walk(&mut self, physics: &Physics, pavements: &Pavements, places: &[DVec2], cars: &[Obstacle]) {
        let (before, from, lateral_m) = (self.position, self.at(), self.lateral_m);
        let (wanted, motion) = self.wanted_step(pavements);
        let line = match motion {
            Motion::Walks { walkway, s_m, .. } => Some(self.target(pavements, walkway, s_m)),
            _ => None,
        };
        let keeps_to_line =
            |p: DVec2| line.is_none_or(|line| (p - line).length() < ROUND_OTHERS_M.max((from - line).length()));
        let step =
            if wanted == from { Some(from) } else { self.nearby.step(from, wanted, places, cars, keeps_to_line) };
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
            let over_m = if self.held_s > 0.5 { OVER_M } else { 0.05 };
            if (goal - to).length() < over_m {
                let direction = if self.choices.chance(0.5) { 1.0 } else { -1.0 };
                self.start(walkway, s_m, direction, 0.0);
            }
        }
        let moved = to - from;
        if moved.length_squared() > 0.0 {
            // The edge of the world: stay on the last ground.
            let Some(ground) = physics.ground_at(to.x, to.y) else { return };
            self.position = to.extend(ground.z_m);
            let turn = math::wrap_angle(math::atan2(moved.y, moved.x) - self.yaw_rad);
            self.yaw_rad = math::wrap_angle(self.yaw_rad + turn.clamp(-3.0 * DT_S, 3.0 * DT_S));
            self.phase = (self.phase + moved.length() / self.model.cycle_length_m.max(0.1)).fract();
        }
        self.velocity = (self.position - before) / DT_S;
    }

    /// Where the next step would lead if nothing were in the way, and what one would be about then.
    fn wanted_step(&mut self, pavements: &Pavements) -> (DVec2, Motion) {
        let here = self.at();
        match self.motion {
            Motion::Stands | Motion::Waits { .. } => (here, self.motion),
            Motion::Walks { walkway, s_m, direction } => {
                let step_m = self.model.walking_speed_mps * self.pace * DT_S;
                let limit_m = SIDESTEP_MPS * DT_S * self.pace.max(0.3);
                if (self.target(pavements, walkway, s_m) - here).length() > OFF_LINE_M {
                    // Corners and changes of walkway are walked, not jumped.
                    let target = self.target(pavements, walkway, s_m);
                    return (step_towards(here, target, step_m.max(limit_m)), self.motion);
                }
                self.lateral_m += (self.wanted_m - self.lateral_m).clamp(-limit_m, limit_m);
                let motion = match pavements.wrapped(walkway, s_m + direction * step_m) {
                    Some(s_m) => Motion::Walks { walkway, s_m, direction },
                    None => self.turn_corner(pavements, walkway, direction),
                };
                let Motion::Walks { walkway, s_m, .. } = motion else { return (here, motion) };
                (step_towards(here, self.target(pavements, walkway, s_m), (step_m * 1.5).max(limit_m)), motion)
            }
            Motion::Crosses { to, .. } => (step_towards(here, to, CROSSING_MPS * self.pace * DT_S), self.motion),
        }
    }

    /// The point of the person's own line at a distance along a walkway.
    fn target(&self, pavements: &Pavements, walkway: usize, s_m: f64) -> DVec2 {
        let spot = pavements.spot(walkway, s_m);
        spot.at + spot.tangent.perp() * self.lateral_m
    }

    fn turn_corner(&mut self, pavements: &Pavements, walkway: usize, direction: f64) -> Motion {
        let at_end = direction > 0.0;
        let onward = pavements.onward(walkway, at_end);
        let next = onward.get(self.choices.below(onward.len())).copied();
        let (walkway, direction) = next.unwrap_or((walkway, -direction));
        let s_m = if direction > 0.0 { 0.0 } else { pavements.length_m(walkway) };
        self.habit_m = self.habit_m.clamp(-pavements.room_m(walkway), pavements.room_m(walkway));
        self.wanted_m = self.habit_m;
        Motion::Walks { walkway, s_m, direction }
    }
}

fn step_towards(from: DVec2, to: DVec2, step_m: f64) -> DVec2 {
    let d = to - from;
    let length = d.length();
    if length <= step_m { to } else { from + d * (step_m / length) }
}

/// Everybody on foot looks around: side-steps, stops, turns back, waits at kerbs and sets out across.
pub(super) fn look(
    walkers: &mut [Walker],
    pavements: &Pavements,
    roads: &Roads,
    standing: &[Obstacle],
    footprints: &[Obstacle],
    cars: &[Car],
) {
    let places: Vec<(DVec2, DVec2, f64)> =
        walkers.iter().map(|w| (w.at(), w.heading(), w.velocity.truncate().length())).collect();
    let spots: Vec<DVec2> = places.iter().map(|p| p.0).collect();
    for i in 0..walkers.len() {
        walkers[i].nearby.look(i, &spots, standing);
        let leader = walkers[i].company.and_then(|c| walkers.get(c.leader).map(|w| (w.motion, w.pace, w.wanted_m, c)));
        let walker = &mut walkers[i];
        match walker.motion {
            Motion::Stands => {}
            Motion::Walks { walkway, s_m, direction } => {
                if walker.held_s > HELD_S {
                    walker.held_s = 0.0;
                    walker.company = None;
                    walker.motion = Motion::Walks { walkway, s_m, direction: -direction };
                    continue;
                }
                if let Some((Motion::Walks { walkway: other, s_m: theirs, direction: same }, pace, lateral, c)) = leader
                {
                    // A group keeps its places, and turns round with the one who leads.
                    let is_near = (theirs - s_m).abs() < TOGETHER_M + c.behind_m;
                    if other == walkway && (same == direction || is_near) {
                        let direction = same;
                        walker.motion = Motion::Walks { walkway, s_m, direction };
                        let behind_m = (theirs - s_m) * direction - c.behind_m;
                        let room = pavements.room_m(walkway);
                        let line_m = (lateral + c.aside_m).clamp(-room, room);
                        avoid(walker, i, walkway, s_m, direction, line_m, pavements, standing, &places);
                        walker.pace = walker.pace.min(1.0) * (pace + 0.4 * behind_m).clamp(0.0, 1.4);
                        continue;
                    }
                }
                let line_m = walker.habit_m;
                avoid(walker, i, walkway, s_m, direction, line_m, pavements, standing, &places);
                if walker.crosser && walker.pace > 0.5 {
                    consider_crossing(walker, walkway, s_m, pavements, roads, standing);
                }
            }
            Motion::Waits { from, to, walkway, s_m } => {
                let across = (to - from).normalize_or(DVec2::X);
                walker.yaw_rad = math::atan2(across.y, across.x);
                if free_to_cross(from, to, cars, footprints) {
                    walker.pace = 1.0;
                    walker.motion = Motion::Crosses { to, walkway, s_m };
                }
            }
            Motion::Crosses { .. } => {
                let front = walker.at() + walker.heading() * 0.8;
                // Who drives is let pass; who stands lets pass, and waiting for each other would never end.
                let passes = |f: &&Obstacle| f.velocity.length() > STANDS_MPS;
                let blocked = footprints.iter().filter(passes).any(|f| (f.closest_point(front) - front).length() < 0.4);
                walker.pace = if blocked { 0.0 } else { 1.0 };
            }
        }
    }
}

/// Side-steps what stands and who comes, to return to the line `line_m`; stops where there is no way past, and turns back
/// after a while.
fn avoid(
    walker: &mut Walker,
    index: usize,
    walkway: usize,
    s_m: f64,
    direction: f64,
    line_m: f64,
    pavements: &Pavements,
    standing: &[Obstacle],
    places: &[(DVec2, DVec2, f64)],
) {
    let room = pavements.room_m(walkway);
    let here = walker.at();
    let near: Vec<&Obstacle> =
        standing.iter().filter(|o| (o.center - here).length() < o.half_length_m + o.half_width_m + 3.5).collect();
    let others: Vec<&(DVec2, DVec2, f64)> =
        places.iter().enumerate().filter(|(j, p)| *j != index && (p.0 - here).length() < 3.2).map(|(_, p)| p).collect();
    let is_free = |lateral: f64| {
        [0.7, 1.5, 2.3].iter().all(|ahead| {
            let spot = pavements.spot(walkway, s_m + direction * ahead);
            let p = spot.at + spot.tangent.perp() * lateral;
            let clear_of_things = near.iter().all(|o| (o.closest_point(p) - p).length() > SHOULDER_M + 0.1);
            let clear_of_people = others.iter().all(|(at, heading, speed)| {
                // Where they will be when we get there.
                let then = *at + *heading * (*speed * ahead / walker.model.walking_speed_mps.max(0.5));
                (then - p).length() > 2.0 * SHOULDER_M
            });
            clear_of_things && clear_of_people
        })
    };
    // The nearest free line to the wanted one, to the own right first.
    let right = -direction;
    let choice = [0.0, 0.35, -0.35, 0.7, -0.7, 1.05, -1.05, 1.4, -1.4]
        .iter()
        .map(|d| line_m + right * d)
        .filter(|l| l.abs() <= room.max(walker.habit_m.abs()))
        .find(|l| is_free(*l));
    match choice {
        Some(lateral) => {
            walker.wanted_m = lateral;
            // Side-step first, then walk on.
            walker.pace = if (lateral - walker.lateral_m).abs() > 0.6 { 0.5 } else { 1.0 };
            walker.blocked_s = 0.0;
        }
        None => {
            walker.pace = 0.0;
            walker.blocked_s += 3.0 * DT_S;
            if walker.blocked_s > 2.5 {
                walker.blocked_s = 0.0;
                walker.pace = 1.0;
                walker.motion = Motion::Walks { walkway, s_m, direction: -direction };
            }
        }
    }
}

/// Looks for a pavement straight across, with a driving lane between and nothing parked in the way.
fn consider_crossing(
    walker: &mut Walker,
    walkway: usize,
    s_m: f64,
    pavements: &Pavements,
    roads: &Roads,
    standing: &[Obstacle],
) {
    if !walker.choices.chance(0.06) {
        return;
    }
    let spot = pavements.spot(walkway, s_m);
    let from = walker.at();
    for across in [spot.tangent.perp(), -spot.tangent.perp()] {
        let Some((other, other_s_m, to)) = pavements.opposite(walkway, from, across) else { continue };
        let way = |t: f64| from.lerp(to, t);
        let clear = (0..=20)
            .map(|k| way(f64::from(k) / 20.0))
            .all(|p| standing.iter().all(|o| (o.closest_point(p) - p).length() > SHOULDER_M + 0.1));
        let over_a_lane = (1..10)
            .map(|k| way(f64::from(k) / 10.0))
            .any(|p| roads.nearest(p.extend(walker.position.z), None, 1.0).is_some());
        if clear && over_a_lane {
            walker.motion = Motion::Waits { from, to, walkway: other, s_m: other_s_m };
            walker.pace = 0.0;
            walker.crosser = walker.choices.chance(CROSSES_AGAIN);
            return;
        }
    }
}

/// Whether no car will be on the way across before the walker is over.
fn free_to_cross(from: DVec2, to: DVec2, cars: &[Car], footprints: &[Obstacle]) -> bool {
    let need_s = (to - from).length() / CROSSING_MPS + MARGIN_S;
    let way = to - from;
    let distance_to_way = |p: DVec2| {
        let t = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        (from + way * t - p).length()
    };
    cars.iter().zip(footprints).all(|(car, footprint)| {
        let speed = footprint.velocity.length();
        let standing = speed < 0.2;
        let half_m = footprint.half_length_m;
        if distance_to_way(footprint.center) < half_m + 1.2 {
            return false;
        }
        car.way_ahead().iter().filter(|a| distance_to_way(a.at) < footprint.half_width_m + 0.6).all(|a| {
            let gap_m = a.distance_m - half_m;
            if standing { gap_m > 2.5 } else { gap_m > speed * need_s }
        })
    })
}
