//! The world at one instant, as the sensors see it.

use std::sync::Arc;

use super::{SNAPSHOT_RADIUS_M, World};
use crate::actor::{ActorState, ObjectClass};
use crate::assets::vehicle::VehicleModel;
use crate::instance::Instance;
use crate::math::{DPose3, DVec3};

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
}

/// An actor with its parts, to be sorted by id.
struct Posed {
    state: ActorState,
    parts: Vec<Instance>,
}

impl World {
    /// The world as it is now: the town's scenery, then the actors within 250 m of the ego by rising id.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let ego = self.ego();
        let middle = ego.world_from_ego.translation;
        let is_near = |p: DVec3| (p - middle).length() <= SNAPSHOT_RADIUS_M;
        let mut posed: Vec<Posed> = Vec::new();
        for car in &self.cars[1..] {
            let pose = car.chassis.world_from_box(&self.physics);
            if is_near(pose.translation) {
                let speeds =
                    (car.chassis.velocity_world(&self.physics), car.chassis.angular_velocity_world(&self.physics));
                posed.push(vehicle(car.id, car.model(), pose, speeds, &car.chassis.wheels(), true));
            }
        }
        for parked in self.parked.iter().filter(|p| is_near(p.settled.world_from_box.translation)) {
            let pose = parked.settled.world_from_box;
            posed.push(vehicle(parked.id, &parked.model, pose, Default::default(), &parked.wheels(), false));
        }
        for walker in self.walkers.iter().filter(|w| is_near(w.position)) {
            let state = ActorState {
                id: walker.id,
                class: ObjectClass::Pedestrian,
                model: walker.model.name.clone(),
                size_lwh: walker.model.size_lwh,
                annotated: walker.model.annotated,
                world_from_box: walker.pose(),
                velocity_world: walker.velocity,
                angular_velocity_world: DVec3::ZERO,
            };
            let body = Instance {
                shape: Arc::new(walker.model.pose(walker.phase)),
                palette: Arc::clone(&walker.model.palette),
                world_from_local: state.world_from_box,
                actor_id: state.id,
            };
            posed.push(Posed { state, parts: vec![body] });
        }
        posed.sort_by_key(|p| p.state.id);
        let mut instances = self.town.scenery.clone();
        let mut actors = Vec::with_capacity(posed.len());
        for p in posed {
            instances.extend(p.parts);
            actors.push(p.state);
        }
        Snapshot { time_s: self.time_s(), ego, instances, actors }
    }
}

fn vehicle(
    id: i32,
    model: &VehicleModel,
    world_from_box: DPose3,
    (velocity_world, angular_velocity_world): (DVec3, DVec3),
    box_from_wheels: &[DPose3; 4],
    is_driven: bool,
) -> Posed {
    let part = |shape, local: DPose3| Instance {
        shape: Arc::clone(shape),
        palette: Arc::clone(&model.palette),
        world_from_local: world_from_box * local,
        actor_id: id,
    };
    let mut parts = vec![part(&model.body, DPose3::IDENTITY)];
    if let Some(driver) = model.driver.as_ref().filter(|_| is_driven) {
        parts.push(part(driver, DPose3::IDENTITY));
    }
    if let Some(wheel) = &model.wheel {
        parts.extend(box_from_wheels.iter().map(|w| part(wheel, *w)));
    }
    let state = ActorState {
        id,
        class: model.class,
        model: model.name.clone(),
        size_lwh: model.size_lwh,
        annotated: model.annotated,
        world_from_box,
        velocity_world,
        angular_velocity_world,
    };
    Posed { state, parts }
}
