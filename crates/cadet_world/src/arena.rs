//! All agents with what they share: bodies, streets, and what they know of each other.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::agents::{ActorView, Agent, AgentKind, Car, Fixture, Gone, OfKind};
use super::footprint::Footprint;
use super::lane_use::OnLane;
use super::physics::Physics;
use super::retouch::Retouch;
use super::slot::{EGO, Slot};
use super::streets::Streets;
use super::traffic_state::{PersonAt, TrafficState, VehicleAt};
use super::walking::room_of;
use cadet_base::actor::BodyEnd;
use cadet_base::error::Result;
use cadet_base::math::{DVec2, DVec3};
use cadet_town::Town;

/// The agents by slot, the ego first.
pub(super) struct Arena {
    pub agents: Vec<Agent>,
    pub physics: Physics,
    pub streets: Streets,
    pub around: TrafficState,
    /// Slots of those that may move, rising.
    active: Vec<Slot>,
    next_id: i32,
    /// By id: the end of an actor that was near when it was first labeled. Its annotated box stays as it was drawn then.
    pub labeled_ends: BTreeMap<i32, BodyEnd>,
    /// By id: what snapshots show otherwise.
    pub retouched: BTreeMap<i32, Retouch>,
}

impl Arena {
    /// # Errors
    /// [`cadet_base::Error::Scene`] for a ground without triangles.
    pub fn new(town: &Arc<Town>) -> Result<Self> {
        let physics = Physics::new(Arc::clone(town))?;
        let streets = Streets::new(town);
        let mut around = TrafficState::new(&streets.graph);
        for obstacle in &town.obstacles {
            let z_m = town.ground.height_at(obstacle.center.x, obstacle.center.y).unwrap_or(0.0);
            around.stand(Footprint::standing(obstacle, z_m), &streets.graph);
        }
        let (labeled_ends, retouched) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self {
            agents: Vec::new(),
            physics,
            streets,
            around,
            active: Vec::new(),
            next_id: 0,
            labeled_ends,
            retouched,
        })
    }

    /// The id that the next newcomer gets; the ego's is 0.
    pub fn next_id(&self) -> i32 {
        self.next_id
    }

    /// Puts an agent into the arena; returns its slot.
    pub fn put(&mut self, kind: impl Into<AgentKind>) -> Slot {
        let slot = self.agents.len();
        let agent = self.named(kind.into());
        if let Some(Fixture::Vehicle(_)) = agent.get() {
            self.around.stand(agent.actor().footprint(&self.physics), &self.streets.graph);
        } else {
            self.active.push(slot);
        }
        self.around.add_slot();
        self.agents.push(agent);
        slot
    }

    /// Puts an agent of the user's into the arena, where it is never replaced; returns its id.
    pub fn put_placed(&mut self, kind: impl Into<AgentKind>) -> i32 {
        let slot = self.put(kind);
        let agent = &mut self.agents[slot];
        agent.is_placed = true;
        agent.id
    }

    /// Puts an agent that moves in the place of one that has gone.
    pub fn replace(&mut self, gone: Slot, kind: AgentKind) {
        if self.agents[gone].get::<Gone>().is_some() {
            self.active.insert(self.active.partition_point(|slot| *slot < gone), gone);
        }
        self.clear(gone);
        self.agents[gone] = self.named(kind);
    }

    /// Takes an agent that moves out of the world; its slot is free for a newcomer.
    pub fn remove(&mut self, gone: Slot) {
        self.clear(gone);
        self.active.retain(|slot| *slot != gone);
        let class = self.agents[gone].actor().look.class();
        self.agents[gone].kind = Gone { class }.into();
    }

    fn clear(&mut self, gone: Slot) {
        self.around.forget(gone);
        for slot in &self.active {
            self.agents[*slot].behavior_mut().forget(gone);
        }
        for (_, actor) in self.agents[gone].actors() {
            if let Some(body) = actor.body.handle() {
                self.physics.remove(body);
            }
        }
    }

    /// Slots of those who have left the world, with who had them.
    pub fn vacant(&self) -> impl Iterator<Item = (Slot, &Gone)> {
        self.agents.iter().enumerate().filter_map(|(slot, agent)| Some((slot, agent.get::<Gone>()?)))
    }

    /// All who are in the world, by slot.
    pub fn present(&self) -> impl Iterator<Item = (Slot, &Agent)> {
        self.agents.iter().enumerate().filter(|(_, agent)| agent.get::<Gone>().is_none())
    }

    fn named(&mut self, kind: AgentKind) -> Agent {
        let agent = Agent { id: self.next_id, kind, is_placed: false };
        self.next_id += agent.actors().count() as i32;
        agent
    }

    /// The ego.
    pub fn ego(&self) -> &Agent {
        &self.agents[EGO]
    }

    /// The ego, as the car that it is.
    pub fn ego_car(&self) -> &Car {
        self.ego().get::<Car>().expect("the ego is a car")
    }

    /// The ego's car to be changed, and the physics that its body is in.
    pub fn ego_car_mut(&mut self) -> (&mut Car, &mut Physics) {
        (self.agents[EGO].get_mut::<Car>().expect("the ego is a car"), &mut self.physics)
    }

    /// Where the ego is and which way it looks, in the plane.
    pub fn ego_place(&self) -> (DVec2, DVec2) {
        let pose = self.ego().actor().body.world_from_box(&self.physics);
        (pose.translation.truncate(), (pose.rotation * DVec3::X).truncate().normalize())
    }

    /// The agents that may move, by slot.
    pub fn active(&self) -> impl DoubleEndedIterator<Item = (Slot, &Agent)> {
        self.active.iter().map(|slot| (*slot, &self.agents[*slot]))
    }

    /// Those who may move of one kind, by slot.
    pub fn each<K: OfKind>(&self) -> impl DoubleEndedIterator<Item = (Slot, &Agent, &K)> {
        self.active().filter_map(|(slot, agent)| Some((slot, agent, K::of(agent)?)))
    }

    fn active_actors(&self) -> impl Iterator<Item = (Slot, ActorView<'_>)> {
        self.active().flat_map(|(slot, agent)| agent.actors().map(move |(_, actor)| (slot, actor)))
    }

    /// What the vehicles that move cover.
    pub fn vehicles(&self) -> impl Iterator<Item = (Slot, Footprint)> {
        let vehicles = self.active_actors().filter(|(_, actor)| actor.body.person().is_none());
        vehicles.map(|(slot, actor)| (slot, actor.footprint(&self.physics)))
    }

    /// What the people take up.
    pub fn people(&self) -> impl Iterator<Item = (Slot, Footprint)> {
        let people = self.active_actors().filter(|(_, actor)| actor.body.person().is_some());
        people.map(|(slot, actor)| (slot, room_of(&actor.footprint(&self.physics))))
    }

    /// What drivers have to keep off because of people on the road.
    pub fn on_road(&self) -> impl Iterator<Item = Footprint> {
        self.active().filter_map(|(_, agent)| agent.behavior().on_road(&self.streets.graph))
    }

    /// All look around.
    pub fn look(&mut self, step: u64) {
        self.refresh_traffic_state();
        let mut outlooks = Vec::with_capacity(self.active.len());
        for slot in &self.active {
            let behavior = self.agents[*slot].behavior_mut();
            outlooks.push((*slot, behavior.look(*slot, &self.around, &self.streets, step)));
        }
        self.around.publish(outlooks, &self.streets.graph, step);
    }

    /// One physics step, with what all do before it and after it.
    pub fn step(&mut self) {
        for slot in &self.active {
            self.agents[*slot].behavior_mut().act(&mut self.physics, &self.streets);
        }
        self.physics.step();
        self.refresh_places();
        // The oldest agent first: of two who would set foot on one place, that must not hang on their slots.
        let mut by_age = self.active.clone();
        by_age.sort_unstable_by_key(|slot| self.agents[*slot].id);
        for slot in &by_age {
            self.agents[*slot].behavior_mut().track(*slot, &self.physics, &mut self.around, &self.streets);
        }
    }

    /// Writes down where everybody is, and who drives where.
    fn refresh_traffic_state(&mut self) {
        self.refresh_places();
        let around = &mut self.around;
        around.people_on_road.clear();
        around.lane_use.clear();
        for slot in &self.active {
            let agent = &self.agents[*slot];
            let behavior = agent.behavior();
            around.people_on_road.extend(behavior.on_road(&self.streets.graph));
            for (k, (_, actor)) in agent.actors().enumerate() {
                if let Some(at) = behavior.on_lane(k) {
                    let half_length_m = actor.look.size_lwh().x / 2.0;
                    let speed_mps = actor.body.forward_mps(&self.physics);
                    around.lane_use.push(OnLane { agent: *slot, at, half_length_m, speed_mps });
                }
            }
        }
    }

    /// Writes down what vehicles cover and where people are.
    pub fn refresh_places(&mut self) {
        let Self { agents, physics, active, around, .. } = self;
        around.vehicles.clear();
        around.people.clear();
        for slot in active.iter().copied() {
            for (_, actor) in agents[slot].actors() {
                let (footprint, is_cycle) = (actor.footprint(physics), actor.body.is_cycle());
                if actor.body.person().is_some() {
                    around.people.push(PersonAt { agent: slot, room: room_of(&footprint) });
                } else {
                    around.vehicles.push(VehicleAt { agent: slot, footprint, is_cycle });
                }
            }
        }
    }

    /// Gives all but the ego other slots.
    #[cfg(test)]
    pub fn shuffle(&mut self, stream: &mut cadet_base::rng::Stream) {
        use super::agents::Pedestrian;
        let mut order: Vec<Slot> = (1..self.agents.len()).collect();
        stream.shuffle(&mut order);
        order.insert(0, EGO);
        let mut new_slot = vec![0; order.len()];
        for (new, old) in order.iter().enumerate() {
            new_slot[*old] = new;
        }
        let mut agents: Vec<Option<Agent>> = std::mem::take(&mut self.agents).into_iter().map(Some).collect();
        self.agents = order.iter().map(|old| agents[*old].take().expect("each once")).collect();
        for agent in &mut self.agents {
            if let Some(company) = agent.get_mut::<Pedestrian>().and_then(|p| p.company.as_mut()) {
                company.leader = new_slot[company.leader];
            }
        }
        self.active.iter_mut().for_each(|slot| *slot = new_slot[*slot]);
        self.active.sort_unstable();
    }
}
