//! All agents with what they share: bodies, streets, and what they know of each other.

use std::sync::Arc;

use super::body::{Body, Upright};
use super::footprint::Footprint;
use super::lane_use::OnLane;
use super::physics::Physics;
use super::slot::{EGO, Slot};
use super::streets::Streets;
use super::traffic_state::{PersonAt, TrafficState, VehicleAt};
use crate::actor::ObjectClass;
use crate::error::Result;
use crate::math::{DVec2, DVec3};
use crate::town::Town;
use crate::world::agents::Agent;
use crate::world::agents::{Controller, Parked};
use crate::world::look::Appearance;

/// An agent before it has an id.
pub(super) struct AgentSpec {
    pub class: ObjectClass,
    pub body: Body,
    pub controller: Box<dyn Controller>,
    pub appearance: Appearance,
    /// Put there by the user: never replaced.
    pub is_placed: bool,
}

/// The agents by slot, the ego first.
pub(super) struct Arena {
    pub agents: Vec<Agent>,
    pub physics: Physics,
    pub streets: Streets,
    pub around: TrafficState,
    /// Slots of those that may move, rising.
    active: Vec<Slot>,
    /// Slots of those who have left the world.
    vacant: Vec<Slot>,
    next_id: i32,
}

impl Arena {
    /// # Errors
    /// [`crate::Error::Scene`] for a ground without triangles.
    pub fn new(town: &Arc<Town>) -> Result<Self> {
        let physics = Physics::new(Arc::clone(town))?;
        let streets = Streets::new(town);
        let mut around = TrafficState::new(&streets.roads);
        for o in &town.obstacles {
            let (half_length_m, half_width_m) = (o.half.x, o.half.y);
            let footprint =
                Footprint { center: o.center, heading: o.axis, half_length_m, half_width_m, velocity: DVec2::ZERO };
            around.stand(footprint, &streets.roads);
        }
        Ok(Self { agents: Vec::new(), physics, streets, around, active: Vec::new(), vacant: Vec::new(), next_id: 0 })
    }

    /// The id that the next newcomer gets; the ego's is 0.
    pub fn next_id(&self) -> i32 {
        self.next_id
    }

    /// Puts an agent into the arena; returns its slot.
    pub fn put(&mut self, newcomer: AgentSpec) -> Slot {
        let slot = self.agents.len();
        let agent = self.named(newcomer);
        if let Body::Fixed(_) = agent.body {
            let footprint = agent.footprint(&self.physics);
            self.around.stand(footprint, &self.streets.roads);
        } else {
            self.active.push(slot);
        }
        self.around.add_slot();
        self.agents.push(agent);
        slot
    }

    /// Puts an agent that moves in the place of one that has gone.
    pub fn replace(&mut self, gone: Slot, newcomer: AgentSpec) {
        let agent = self.named(newcomer);
        if let Some(i) = self.vacant.iter().position(|slot| *slot == gone) {
            self.vacant.remove(i);
            self.active.insert(self.active.partition_point(|slot| *slot < gone), gone);
        }
        self.clear(gone);
        self.agents[gone] = agent;
    }

    /// Takes an agent that moves out of the world; its slot is free for a newcomer.
    pub fn remove(&mut self, gone: Slot) {
        self.clear(gone);
        self.active.retain(|slot| *slot != gone);
        self.vacant.push(gone);
        // What has no body in rapier's world has no place either.
        self.agents[gone].body = Body::Upright(Upright::standing(DVec3::ZERO, 0.0));
        self.agents[gone].controller = Box::new(Parked);
    }

    fn clear(&mut self, gone: Slot) {
        self.around.forget(gone);
        for slot in &self.active {
            self.agents[*slot].controller.forget(gone);
        }
        self.agents[gone].body.remove_from(&mut self.physics);
    }

    /// Slots of those who have left the world.
    pub fn vacant(&self) -> &[Slot] {
        &self.vacant
    }

    /// All who are in the world, by slot.
    pub fn present(&self) -> impl Iterator<Item = (Slot, &Agent)> {
        self.agents.iter().enumerate().filter(|(slot, _)| !self.vacant.contains(slot))
    }

    fn named(&mut self, newcomer: AgentSpec) -> Agent {
        let AgentSpec { class, body, controller, appearance, is_placed } = newcomer;
        let id = self.next_id;
        self.next_id += 1;
        Agent { id, class, body, controller, appearance, is_placed, labeled_end: None }
    }

    /// The ego.
    pub fn ego(&self) -> &Agent {
        &self.agents[EGO]
    }

    /// Where the ego is and which way it looks, in the plane.
    pub fn ego_place(&self) -> (DVec2, DVec2) {
        let pose = self.ego().body.world_from_box(&self.physics);
        (pose.translation.truncate(), (pose.rotation * DVec3::X).truncate().normalize())
    }

    /// The agents that may move, by slot.
    pub fn active(&self) -> impl DoubleEndedIterator<Item = (Slot, &Agent)> {
        self.active.iter().map(|slot| (*slot, &self.agents[*slot]))
    }

    /// Those that have a controller of one kind.
    pub fn controlled_by<T: Controller>(&self) -> impl DoubleEndedIterator<Item = (Slot, &Agent, &T)> {
        self.active().filter_map(|(slot, agent)| Some((slot, agent, agent.controlled_by::<T>()?)))
    }

    /// What the vehicles that move cover.
    pub fn vehicles(&self) -> impl Iterator<Item = (Slot, Footprint)> {
        let vehicles = self.active().filter(|(_, agent)| !matches!(agent.body, Body::Upright(_)));
        vehicles.map(|(slot, agent)| (slot, agent.footprint(&self.physics)))
    }

    /// Where the people are.
    pub fn people(&self) -> impl Iterator<Item = (Slot, DVec2)> {
        self.active().filter_map(|(slot, agent)| match &agent.body {
            Body::Upright(body) => Some((slot, body.at())),
            _ => None,
        })
    }

    /// What drivers have to keep off because of people on the road.
    pub fn on_road(&self) -> impl Iterator<Item = Footprint> {
        self.active().filter_map(|(_, agent)| agent.controller.on_road(&agent.body, &self.streets.roads))
    }

    /// All look around.
    pub fn look(&mut self, step: u64) {
        self.refresh_traffic_state();
        let mut outlooks = Vec::with_capacity(self.active.len());
        for slot in &self.active {
            let (controller, own) = self.agents[*slot].parts_mut(*slot);
            outlooks.push((*slot, controller.look(own, &self.around, &self.streets, step)));
        }
        self.around.publish(outlooks, &self.streets.roads, step);
    }

    /// One physics step, with what all do before it and after it.
    pub fn step(&mut self) {
        for slot in &self.active {
            let (controller, own) = self.agents[*slot].parts_mut(*slot);
            controller.act(own, &mut self.physics, &self.streets);
        }
        for slot in &self.active {
            if let Some(leader) = self.agents[*slot].controller.follows()
                && let Ok([agent, leader]) = self.agents.get_disjoint_mut([*slot, leader])
            {
                let (controller, own) = agent.parts_mut(*slot);
                controller.follow(own, leader.controller.as_ref(), &mut self.physics);
            }
        }
        self.physics.step();
        self.refresh_places();
        // The oldest agent first: of two who would set foot on one place, that must not hang on their slots.
        let mut by_age = self.active.clone();
        by_age.sort_unstable_by_key(|slot| self.agents[*slot].id);
        for slot in &by_age {
            let (controller, own) = self.agents[*slot].parts_mut(*slot);
            controller.track(own, &self.physics, &mut self.around, &self.streets);
        }
    }

    /// Writes down where everybody is, and who drives where.
    fn refresh_traffic_state(&mut self) {
        self.refresh_places();
        let around = &mut self.around;
        for person in &mut around.people {
            if let Body::Upright(body) = &self.agents[person.agent].body {
                person.heading = body.heading();
                person.speed_mps = body.velocity_world.truncate().length();
            }
        }
        around.people_on_road.clear();
        around.lane_use.clear();
        for slot in &self.active {
            let agent = &self.agents[*slot];
            around.people_on_road.extend(agent.controller.on_road(&agent.body, &self.streets.roads));
            if let Some((lane, s_m)) = agent.controller.on_lane() {
                let half_length_m = agent.appearance.size_lwh().x / 2.0;
                let speed_mps = agent.body.forward_mps(&self.physics);
                around.lane_use.push(OnLane { lane, agent: *slot, s_m, half_length_m, speed_mps });
            }
        }
    }

    /// Writes down what vehicles cover and where people are.
    pub fn refresh_places(&mut self) {
        let around = &mut self.around;
        around.vehicles.clear();
        around.people.clear();
        for slot in &self.active {
            let agent = &self.agents[*slot];
            match &agent.body {
                Body::Upright(body) => {
                    let (heading, speed_mps) = (DVec2::X, 0.0);
                    around.people.push(PersonAt { agent: *slot, at: body.at(), heading, speed_mps });
                }
                body => {
                    let (footprint, is_cycle) = (agent.footprint(&self.physics), matches!(body, Body::Cycle(_)));
                    around.vehicles.push(VehicleAt { agent: *slot, footprint, is_cycle });
                }
            }
        }
    }

    /// Gives all but the ego other slots.
    #[cfg(test)]
    pub fn shuffle(&mut self, stream: &mut crate::rng::Stream) {
        use crate::world::agents::{Pedestrian, Trailer};
        let mut order: Vec<Slot> = (1..self.agents.len()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, stream.below(i + 1));
        }
        order.insert(0, EGO);
        let mut new_slot = vec![0; order.len()];
        for (new, old) in order.iter().enumerate() {
            new_slot[*old] = new;
        }
        let mut agents: Vec<Option<Agent>> = std::mem::take(&mut self.agents).into_iter().map(Some).collect();
        self.agents = order.iter().map(|old| agents[*old].take().expect("each once")).collect();
        for agent in &mut self.agents {
            if let Some(trailer) = agent.controlled_by_mut::<Trailer>() {
                trailer.leader = new_slot[trailer.leader];
            }
            if let Some(company) = agent.controlled_by_mut::<Pedestrian>().and_then(|p| p.company.as_mut()) {
                company.leader = new_slot[company.leader];
            }
        }
        for slots in [&mut self.active, &mut self.vacant] {
            slots.iter_mut().for_each(|slot| *slot = new_slot[*slot]);
        }
        self.active.sort_unstable();
    }
}
