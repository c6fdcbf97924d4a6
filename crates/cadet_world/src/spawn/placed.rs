//! What the user puts into a scene: agents that stand, and agents that go along a path.

use std::sync::Arc;

use super::newcomers::{guided_vehicle, on_foot, parked_vehicle, ridden_bicycle, standing_person};
use super::overlap::{Cover, check_free};
use crate::agents::{Actor, AgentKind, Fixture, Led, PERSON_HALF_CHORD_M, Script, Scripted, TimedPath};
use crate::arena::Arena;
use crate::body::{Cycle, Upright, settle, stand_up};
use crate::course::{
    Course, FASTEST_CYCLIST_MPS, FASTEST_PERSON_MPS, FASTEST_VEHICLE_MPS, Overlap, Waypoint, check_path,
};
use crate::footprint::Footprint;
use crate::look::FigureLook;
use cadet_assets::cyclist::CyclistModel;
use cadet_assets::imported::FigureModel;
use cadet_assets::person::PersonModel;
use cadet_assets::vehicle::VehicleModel;
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result, finite};
use cadet_base::math::{self, DPose3, DVec2, DVec3};
use cadet_base::plane::unit;
use cadet_base::rng::Stream;

/// How far apart the places of a path are that have to be on the ground.
const CHECKED_EVERY_M: f64 = 1.0;
/// Way after which an agent that goes straight on stops if the ground does not end before.
const FARTHEST_M: f64 = 5000.0;

/// Adds a vehicle, settled on the ground; returns its id.
///
/// # Errors
/// [`Error::Scene`] beyond the ground's edge, where somebody stands, or for a path that makes no sense;
/// [`Error::NotFinite`].
pub(crate) fn add_vehicle(
    arena: &mut Arena,
    model: Arc<VehicleModel>,
    course: &Course,
    overlap: Overlap,
) -> Result<i32> {
    let class = model.class;
    let is_ground = |arena: &Arena, at: DVec2, yaw_rad| {
        settle(&arena.physics, &model, arena.physics.uppermost(at), yaw_rad).map(|_| ())
    };
    let half_m = model.wheelbase_m() / 2.0;
    let Start { script, at, yaw_rad, velocity } = start(arena, course, FASTEST_VEHICLE_MPS, half_m, is_ground)?;
    check_free(arena, None, class, &box_at(model.size_lwh, at, yaw_rad), overlap)?;
    let newcomer = match script {
        Some(script) => {
            let led = Led::Vehicle(guided_vehicle(arena, model, (at, yaw_rad, velocity))?);
            AgentKind::from(Scripted { script, led })
        }
        None => Fixture::Vehicle(parked_vehicle(arena, model, at, yaw_rad)?).into(),
    };
    Ok(arena.put_placed(newcomer))
}

/// Adds a person; returns the id. Who stands does so mid-stride if the model walks.
///
/// # Errors
/// As [`add_vehicle`].
pub(crate) fn add_person(arena: &mut Arena, model_seed: u64, course: &Course, overlap: Overlap) -> Result<i32> {
    let Start { script, at, yaw_rad, velocity } = start_on_foot(arena, ObjectClass::Pedestrian, course, overlap)?;
    let model = if script.is_some() { walking_model(model_seed) } else { PersonModel::generate(model_seed) };
    let person = standing_person(arena, Arc::new(model), at, yaw_rad, model_seed)?;
    let newcomer = match script {
        Some(script) => {
            let Actor { body, look } = person.own;
            let body = Upright { velocity_world: velocity.extend(0.0), ..body };
            AgentKind::from(Scripted { script, led: Led::Person(Actor { body, look }) })
        }
        None => person.into(),
    };
    Ok(arena.put_placed(newcomer))
}

/// Adds a bicycle with its rider; returns the id. Who stands has a foot on the ground.
///
/// # Errors
/// As [`add_vehicle`].
pub(crate) fn add_cyclist(arena: &mut Arena, model_seed: u64, course: &Course, overlap: Overlap) -> Result<i32> {
    let model = Arc::new(CyclistModel::generate(model_seed));
    let wheelbase_m = model.wheelbase_m;
    let (start, pose) = start_on_cycle(arena, (model.size_lwh, wheelbase_m), course, overlap)?;
    let turn = Stream::from_seed("wheels", model_seed).unit();
    let own = ridden_bicycle(arena, model, (pose, start.yaw_rad), start.velocity, turn);
    let newcomer = match start.script {
        Some(script) => AgentKind::from(Scripted { script, led: Led::Cyclist(own) }),
        None => Fixture::Cyclist(own).into(),
    };
    Ok(arena.put_placed(newcomer))
}

/// Adds a user's person or rider, who stands or goes as those that are built in do, but is rigid; returns the id.
///
/// # Errors
/// As [`add_vehicle`], and [`Error::Scene`] for somebody who sits and is to move.
pub(crate) fn add_figure(arena: &mut Arena, model: Arc<FigureModel>, course: &Course, overlap: Overlap) -> Result<i32> {
    let class = model.class;
    let newcomer = if class == ObjectClass::Cyclist {
        let (size_lwh, wheelbase_m) = (model.size_lwh, model.wheelbase_m());
        let (start, pose) = start_on_cycle(arena, (size_lwh, wheelbase_m), course, overlap)?;
        let Start { script, yaw_rad, velocity, .. } = start;
        let body = Cycle::new(&mut arena.physics, size_lwh, wheelbase_m / 2.0, pose, yaw_rad, velocity);
        let own = Actor { body, look: FigureLook { model } };
        match script {
            Some(script) => AgentKind::from(Scripted { script, led: Led::RidingFigure(own) }),
            None => Fixture::RidingFigure(own).into(),
        }
    } else {
        if class == ObjectClass::PersonSitting {
            check_stays(course)?;
        }
        let Start { script, at, yaw_rad, velocity } = start_on_foot(arena, class, course, overlap)?;
        let body = Upright { velocity_world: velocity.extend(0.0), ..on_foot(arena, at, yaw_rad)? };
        let own = Actor { body, look: FigureLook { model } };
        match script {
            Some(script) => AgentKind::from(Scripted { script, led: Led::Figure(own) }),
            None => Fixture::Figure(own).into(),
        }
    };
    Ok(arena.put_placed(newcomer))
}

/// How an agent begins on a course.
pub(super) struct Start {
    /// None for one that stands.
    script: Option<Script>,
    pub at: DVec3,
    pub yaw_rad: f64,
    velocity: DVec2,
}

fn start(
    arena: &Arena,
    course: &Course,
    fastest_mps: f64,
    half_chord_m: f64,
    is_ground: impl Fn(&Arena, DVec2, f64) -> Result<()>,
) -> Result<Start> {
    let script = scripted(arena, course, fastest_mps, half_chord_m, is_ground)?;
    let (at, yaw_rad, velocity) = match &script {
        Some(script) => script.start(),
        None => {
            let (at, yaw_rad) = standing(course)?;
            (at, yaw_rad, DVec2::ZERO)
        }
    };
    Ok(Start { script, at: arena.physics.uppermost(at), yaw_rad, velocity })
}

/// The start of somebody on foot or on a seat, where nobody else is.
///
/// # Errors
/// As [`add_vehicle`].
pub(super) fn start_on_foot(arena: &Arena, class: ObjectClass, course: &Course, overlap: Overlap) -> Result<Start> {
    let is_ground = |arena: &Arena, at: DVec2, _| match arena.physics.ground_at(at.extend(f64::INFINITY)) {
        Some(_) => Ok(()),
        None => Err(Error::Scene {
            reason: format!("a person at ({}, {}) would walk beyond the ground's edge", at.x, at.y),
        }),
    };
    let start = start(arena, course, FASTEST_PERSON_MPS, PERSON_HALF_CHORD_M, is_ground)?;
    check_free(arena, None, class, &Cover::Trunk(start.at), overlap)?;
    Ok(start)
}

/// Refuses a course on which somebody who sits would move.
///
/// # Errors
/// [`Error::Scene`].
pub(super) fn check_stays(course: &Course) -> Result<()> {
    match course {
        Course::Stand { .. } | Course::Straight { speed_mps: 0.0, .. } => Ok(()),
        _ => Err(Error::Scene { reason: "a Person_sitting does not move: no path and no speed".to_owned() }),
    }
}

/// The start of a bicycle of a size and a wheelbase where nobody else is, and its pose there.
fn start_on_cycle(
    arena: &Arena,
    (size_lwh, wheelbase_m): (DVec3, f64),
    course: &Course,
    overlap: Overlap,
) -> Result<(Start, DPose3)> {
    let half_m = wheelbase_m / 2.0;
    let is_ground = |arena: &Arena, at: DVec2, yaw_rad| {
        stand_up(&arena.physics, half_m, arena.physics.uppermost(at), yaw_rad).map(|_| ())
    };
    let start = start(arena, course, FASTEST_CYCLIST_MPS, half_m, is_ground)?;
    check_free(arena, None, ObjectClass::Cyclist, &box_at(size_lwh, start.at, start.yaw_rad), overlap)?;
    let pose = stand_up(&arena.physics, half_m, start.at, start.yaw_rad)?;
    Ok((start, pose))
}

/// What a box covers at a place.
pub(crate) fn box_at(size_lwh: DVec3, at: DVec3, yaw_rad: f64) -> Cover {
    Cover::Box(Footprint::of_upright(size_lwh, at, yaw_rad))
}

/// The person of a seed, drawn again until one walks.
fn walking_model(model_seed: u64) -> PersonModel {
    let mut stream = Stream::from_seed("walking person", model_seed);
    let mut model = PersonModel::generate(model_seed);
    while model.walking_speed_mps <= 0.0 {
        model = PersonModel::generate(stream.next_u64());
    }
    model
}

fn standing(course: &Course) -> Result<(DVec2, f64)> {
    match course {
        Course::Stand { x_m, y_m, yaw_rad } | Course::Straight { x_m, y_m, yaw_rad, .. } => {
            Ok((DVec2::new(finite("x", *x_m)?, finite("y", *y_m)?), finite("yaw", *yaw_rad)?))
        }
        Course::Path(_) => unreachable!("a path has a script"),
    }
}

/// The script of a course on which the agent moves. `is_ground` says whether it can be at a place, heading somewhere.
fn scripted(
    arena: &Arena,
    course: &Course,
    fastest_mps: f64,
    half_chord_m: f64,
    is_ground: impl Fn(&Arena, DVec2, f64) -> Result<()>,
) -> Result<Option<Script>> {
    let points = match course {
        Course::Stand { .. } => return Ok(None),
        Course::Straight { speed_mps, .. } => {
            let speed_mps = finite("speed", *speed_mps)?;
            if !(0.0..=fastest_mps).contains(&speed_mps) {
                let expected = format!("0 to {fastest_mps} m/s");
                return Err(Error::OutOfRange { what: "speed", value: speed_mps.to_string(), expected });
            }
            let (from, yaw_rad) = standing(course)?;
            is_ground(arena, from, yaw_rad)?;
            // At a standstill there is no way to head along.
            if speed_mps == 0.0 {
                return Ok(None);
            }
            let heading = unit(yaw_rad);
            let steps = (1..=(FARTHEST_M / CHECKED_EVERY_M) as u32).map(|k| f64::from(k) * CHECKED_EVERY_M);
            let way_m =
                steps.take_while(|s| is_ground(arena, from + heading * *s, yaw_rad).is_ok()).last().unwrap_or(0.0);
            let to = from + heading * way_m;
            if way_m == 0.0 {
                return Ok(None);
            }
            [(0.0, from), (way_m / speed_mps, to)].map(|(t_s, p)| Waypoint { t_s, x_m: p.x, y_m: p.y }).to_vec()
        }
        Course::Path(points) => {
            check_path(points, fastest_mps)?;
            for pair in points.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|p| DVec2::new(p.x_m, p.y_m));
                let yaw_rad = math::atan2(b.y - a.y, b.x - a.x);
                let count = ((b - a).length() / CHECKED_EVERY_M).ceil().max(1.0);
                for k in 0..=count as u32 {
                    is_ground(arena, a.lerp(b, f64::from(k) / count), yaw_rad)?;
                }
            }
            points.clone()
        }
    };
    Ok(Some(Script::new(TimedPath::new(&points), half_chord_m)))
}
