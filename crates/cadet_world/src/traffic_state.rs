//! What agents know of each other: they read it when they look, and nobody writes to it then.

use super::footprint::Footprint;
use super::junctions::Junctions;
use super::lane_use::LaneUse;
use super::outlook::Outlook;
use super::slot::Slot;
use crate::streets::{Ahead, LaneGraph};
use crate::walking::Walk;
use cadet_base::math::DVec2;

/// Room between a vehicle that stands beside a lane and the lane's middle at which drivers need not reckon with it.
const OFF_LANES_M: f64 = 1.7;
/// Room between a vehicle that stands beside a lane for bicycles and the lane's middle at which riders need not reckon
/// with it.
const OFF_CYCLE_LANES_M: f64 = 0.7;

/// A vehicle that moves, or may.
#[derive(Debug, Clone, Copy)]
pub(super) struct VehicleAt {
    pub agent: Slot,
    pub footprint: Footprint,
    /// Whether it is a bicycle with its rider.
    pub is_cycle: bool,
}

/// A person.
#[derive(Debug, Clone, Copy)]
pub(super) struct PersonAt {
    pub agent: Slot,
    /// What nobody else on foot enters.
    pub room: Footprint,
}

/// The blackboard that all agents share.
pub(super) struct TrafficState {
    /// Vehicles and things that stand for good.
    pub standing: Vec<Footprint>,
    /// Those of them in or near a lane, which drivers have to reckon with.
    pub standing_in_lanes: Vec<Footprint>,
    /// Vehicles that move, by rising slot; of a train all cars, from the front.
    pub vehicles: Vec<VehicleAt>,
    /// People, by rising slot.
    pub people: Vec<PersonAt>,
    /// What drivers have to keep off for the sake of people on the road.
    pub people_on_road: Vec<Footprint>,
    /// The places of all vehicles on the lanes.
    pub lane_use: LaneUse,
    pub junctions: Junctions,
    /// By slot: the way that a driver has looked at, empty for others.
    ways_ahead: Vec<Vec<Ahead>>,
    /// By slot: what a pedestrian is about.
    walks: Vec<Option<Walk>>,
    /// By slot: where somebody is changing to.
    claims: Vec<Option<Footprint>>,
}

impl TrafficState {
    pub fn new(graph: &LaneGraph) -> Self {
        Self {
            standing: Vec::new(),
            standing_in_lanes: Vec::new(),
            vehicles: Vec::new(),
            people: Vec::new(),
            people_on_road: Vec::new(),
            lane_use: LaneUse::default(),
            junctions: Junctions::new(graph),
            ways_ahead: Vec::new(),
            walks: Vec::new(),
            claims: Vec::new(),
        }
    }

    /// Something stands there for good.
    pub fn stand(&mut self, footprint: Footprint, graph: &LaneGraph) {
        self.standing.push(footprint);
        if !graph.is_beside_lanes(&footprint, OFF_LANES_M)
            || !graph.keeps_off_cycle_lanes(&footprint, OFF_CYCLE_LANES_M)
        {
            self.standing_in_lanes.push(footprint);
        }
    }

    /// Makes room for one agent more.
    pub fn add_slot(&mut self) {
        self.ways_ahead.push(Vec::new());
        self.walks.push(None);
        self.claims.push(None);
    }

    /// Forgets whoever was in a slot.
    pub fn forget(&mut self, agent: Slot) {
        self.junctions.forget(agent);
        self.ways_ahead[agent].clear();
        self.walks[agent] = None;
        self.claims[agent] = None;
    }

    /// What a moving vehicle covers, of a train its first car.
    pub fn vehicle(&self, agent: Slot) -> Option<&Footprint> {
        self.vehicle_at(agent).map(|v| &v.footprint)
    }

    /// What a moving vehicle covers, if it is a bicycle with its rider.
    pub fn cyclist(&self, agent: Slot) -> Option<&Footprint> {
        self.vehicle_at(agent).filter(|v| v.is_cycle).map(|v| &v.footprint)
    }

    /// The vehicles that could come to a place on its road, those on other levels left out.
    pub fn vehicles_level_with(&self, at: DVec2, z_m: f64) -> impl Iterator<Item = &VehicleAt> {
        self.vehicles.iter().filter(move |v| v.footprint.is_level_with(at, z_m))
    }

    fn vehicle_at(&self, agent: Slot) -> Option<&VehicleAt> {
        let i = self.vehicles.partition_point(|v| v.agent < agent);
        self.vehicles.get(i).filter(|v| v.agent == agent)
    }

    /// What a person takes up.
    pub fn room(&self, agent: Slot) -> Option<&Footprint> {
        let i = self.people.binary_search_by_key(&agent, |p| p.agent).ok()?;
        Some(&self.people[i].room)
    }

    /// A person has set a step, and may have turned.
    pub fn move_person(&mut self, agent: Slot, at: DVec2, heading: DVec2) {
        if let Ok(i) = self.people.binary_search_by_key(&agent, |p| p.agent) {
            let room = &mut self.people[i].room;
            (room.center, room.heading) = (at, heading);
        }
    }

    /// The way that a driver has looked at.
    pub fn way_ahead(&self, agent: Slot) -> &[Ahead] {
        &self.ways_ahead[agent]
    }

    /// Lets all know what all have found at a look, and decides who may cross junctions.
    pub fn publish(&mut self, outlooks: Vec<(Slot, Outlook)>, graph: &LaneGraph, step: u64) {
        let mut requests = Vec::new();
        for (slot, outlook) in outlooks {
            self.ways_ahead[slot] = outlook.way_ahead;
            self.claims[slot] = outlook.claim;
            self.walks[slot] = outlook.walk;
            requests.extend(outlook.request);
        }
        self.junctions.resolve(&requests, &self.lane_use, graph, step);
    }

    /// The places that somebody is changing to, by rising slot.
    pub fn claims(&self) -> impl Iterator<Item = (Slot, &Footprint)> {
        self.claims.iter().enumerate().filter_map(|(slot, claim)| Some((slot, claim.as_ref()?)))
    }

    /// What a pedestrian was about at the last look.
    pub fn walk_of(&self, agent: Slot) -> Option<Walk> {
        self.walks[agent]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::towns::{main_roads, suburb};
    use cadet_base::math::DVec3;
    use cadet_base::plane::OrientedRect;
    use cadet_town::LaneKind;

    #[test]
    fn what_stands_in_a_lane_is_reckoned_with_however_wide_the_lane() {
        let mut widest_m = 0.0_f64;
        for town in [suburb(0), suburb(1), main_roads(0)] {
            let graph = LaneGraph::new(town);
            for lane in graph.open_lanes().filter(|l| l.kind == LaneKind::Driving && l.length_m() > 6.0) {
                let middle_m = lane.length_m() / 2.0;
                let (pose, width_m) = (lane.pose_at(middle_m), lane.width_at(middle_m));
                widest_m = widest_m.max(width_m);
                let out = (pose.rotation * DVec3::Y).truncate() * lane.curb_side();
                let center = pose.translation.truncate() + out * (width_m / 2.0 + 0.3);
                let rect = OrientedRect { center, axis: out.perp(), half: DVec2::new(2.0, 0.45) };
                let mut around = TrafficState::new(&graph);
                around.stand(Footprint::standing(&rect, pose.translation.z), &graph);
                assert_eq!(around.standing_in_lanes.len(), 1, "15 cm inside a lane of {width_m} m");
            }
        }
        assert!(widest_m > 4.2, "{widest_m} m");
    }
}
