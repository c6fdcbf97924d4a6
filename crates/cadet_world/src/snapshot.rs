//! The world at one instant, as the sensors see it.

use super::arena::Arena;
use super::junctions::Refusal;
use super::retouch::Retouch;
use super::slot::{EGO, Slot};
use crate::agents::{ActorView, Agent};
use crate::driving::Cause;
use crate::look::{LampLight, PosedBox};
use cadet_assets::vehicle::{HALOGEN, low_beams};
use cadet_base::actor::{ActorState, BodyEnd, BrakesFor};
use cadet_base::instance::Instance;
use cadet_base::lamp::Lamp;
use cadet_base::math::{DPose3, DVec3};
use cadet_base::rng::StreamKey;
use cadet_town::Town;

/// Actors farther than this from the ego are left out of snapshots.
const SNAPSHOT_RADIUS_M: f64 = 250.0;

/// The ego vehicle at one instant.
#[derive(Debug, Clone)]
pub struct EgoState {
    /// The ego's box frame: x forward, y left, z up, origin on the ground under the middle of the car.
    pub world_from_ego: DPose3,
    /// Velocity of that origin.
    pub velocity_world: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity_world: DVec3,
}

/// Immutable poses and shapes. The ego's own shape is not among them.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Seconds since the scene's start.
    pub time_s: f64,
    /// The ego vehicle.
    pub ego: EgoState,
    /// Every visible thing, static ones first.
    pub instances: Vec<Instance>,
    /// Every actor but the ego, by rising id.
    pub actors: Vec<ActorState>,
    /// The ego's low beams in the world, at night.
    pub ego_lamps: Vec<Lamp>,
}

impl Snapshot {
    /// The town's scenery, by day or at night, the lights as they are lit, then the agents near the ego by rising id.
    pub(super) fn of(
        arena: &Arena,
        town: &Town,
        key: StreamKey,
        ego: EgoState,
        time_s: f64,
        needs_lamps: bool,
        night_scenery: Option<&[Instance]>,
    ) -> Self {
        let middle = ego.world_from_ego.translation;
        let others = arena.present().filter(|(slot, _)| *slot != EGO).flat_map(|(_, agent)| {
            let brakes_for = brakes_for(arena, agent);
            agent.actors().map(move |(id, actor)| (id, actor, brakes_for))
        });
        let mut near: Vec<(i32, ActorView<'_>, Option<BrakesFor>, DPose3)> = others
            .filter_map(|(id, actor, brakes_for)| {
                let world_from_box = actor.body.world_from_box(&arena.physics);
                let shown = match arena.retouched.get(&id) {
                    None => world_from_box,
                    Some(Retouch::Absent) => return None,
                    Some(Retouch::Moved { box_from_shown }) => world_from_box * *box_from_shown,
                };
                Some((id, actor, brakes_for, shown))
            })
            .filter(|(.., pose)| (pose.translation - middle).length() <= SNAPSHOT_RADIUS_M)
            .collect();
        near.sort_by_key(|(id, ..)| *id);
        let mut instances = night_scenery.map_or_else(|| town.scenery.clone(), <[Instance]>::to_vec);
        town.signals.lit(time_s, middle.truncate(), &mut instances);
        let light = LampLight { time_s, key, needs_lamps, is_night: night_scenery.is_some() };
        let mut actors = Vec::with_capacity(near.len());
        for (id, actor, brakes_for, world_from_box) in near {
            let ActorView { body, look } = actor;
            let box_from_wheels = body.box_from_wheels();
            look.parts(&PosedBox { actor_id: id, world_from_box, box_from_wheels, light: &light }, &mut instances);
            let near_end = arena.labeled_ends.get(&id).copied();
            let near_end = near_end.unwrap_or_else(|| BodyEnd::nearer(&world_from_box, middle));
            let mut velocity_world = body.velocity_world(&arena.physics);
            if arena.retouched.contains_key(&id) {
                let true_from_world = body.world_from_box(&arena.physics).rotation.inverse();
                velocity_world = world_from_box.rotation * (true_from_world * velocity_world);
            }
            actors.push(ActorState {
                id,
                class: look.class(),
                model: look.model().name.to_owned(),
                size_lwh: look.size_lwh(),
                annotated: look.annotated_from(near_end),
                world_from_box,
                velocity_world,
                angular_velocity_world: body.angular_velocity_world(&arena.physics),
                brakes_for,
            });
        }
        let beams = || low_beams(arena.ego().actor().look.size_lwh(), HALOGEN);
        let ego_lamps =
            night_scenery.map_or_else(Vec::new, |_| beams().map(|l| l.placed(&ego.world_from_ego)).to_vec());
        Self { time_s, ego, instances, actors, ego_lamps }
    }
}

/// What an agent's driver brakes for, by the ids of actors.
pub(super) fn brakes_for(arena: &Arena, agent: &Agent) -> Option<BrakesFor> {
    let id = |slot: Slot| arena.agents[slot].id;
    match agent.behavior().cause() {
        Cause::Nothing => None,
        Cause::Parked => Some(BrakesFor::Obstacle),
        Cause::Vehicle(slot) => Some(BrakesFor::Vehicle(id(slot))),
        Cause::Person => Some(BrakesFor::Person),
        Cause::RoadEnd => Some(BrakesFor::RoadEnd),
        Cause::Junction(Refusal::Light) => Some(BrakesFor::Light),
        Cause::Junction(
            Refusal::Yields(slot) | Refusal::Taken(slot) | Refusal::InSweep(slot) | Refusal::ExitFull(slot),
        ) => Some(BrakesFor::Junction(Some(id(slot)))),
        Cause::Junction(Refusal::Undecided) => Some(BrakesFor::Junction(None)),
    }
}
