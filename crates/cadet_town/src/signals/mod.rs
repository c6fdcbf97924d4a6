//! Traffic lights and zebra crossings: which lanes they hold, when lights are green, where people cross, and what is seen.

mod arm;
mod right_of_way;
mod signal_head;
mod signal_plan;

pub use arm::{ArmId, CrossingRule, JunctionArm, STOP_LINE_M};
pub use signal_head::SignalHead;
pub use signal_plan::{Aspect, SignalPlan};

pub(super) use arm::FORD_M;
use arm::arms_of;

use std::collections::{BTreeMap, BTreeSet};

use crate::network::{LaneId, LaneKind, RoadNetwork};
use cadet_base::instance::Instance;
use cadet_base::math::DVec2;
use cadet_base::rng::StreamKey;

/// Lights farther from who looks are left out of snapshots.
const SEEN_M: f64 = 200.0;
/// Share of the arms without lights that have a zebra crossing, and the widest street.
const ZEBRA_SHARE: f64 = 0.08;
const ZEBRA_MOST_M: f64 = 11.0;

/// A junction with traffic lights.
#[derive(Debug, Clone)]
pub struct SignalledJunction {
    /// Its number in the network.
    pub junction: u32,
    /// The arms whose traffic the lights hold.
    pub arms: Vec<JunctionArm>,
    /// When they are green.
    pub plan: SignalPlan,
}

/// All traffic lights of a town.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    /// The junctions that have some.
    pub junctions: Vec<SignalledJunction>,
    /// Arms without lights whose ford is a zebra crossing.
    pub zebras: Vec<JunctionArm>,
    /// The lights themselves.
    pub heads: Vec<SignalHead>,
    /// By the lanes that they hold.
    by_lane: BTreeMap<LaneId, ArmId>,
}

impl Signals {
    /// The lights of a network with their plans.
    pub(super) fn of(network: &RoadNetwork, key: &StreamKey) -> Self {
        let mut junctions = Vec::new();
        for (junction, lights) in lights_by_junction(network) {
            let mut arms = arms_of(network, junction);
            let light_of = |arm: &JunctionArm| lights.iter().find(|(lane, _)| arm.lanes.contains(lane));
            arms.retain(|arm| light_of(arm).is_some());
            let controllers: Vec<Option<usize>> =
                arms.iter().map(|arm| light_of(arm).and_then(|(_, controller)| *controller)).collect();
            let num_stages = assign_stages(&mut arms, &controllers);
            if arms.is_empty() {
                continue;
            }
            let is_main = |stage: usize| arms.iter().any(|a| a.stage == stage && a.is_main());
            // Where one stage holds all that are lit, the others of the junction get a stage, too.
            let is_main: Vec<bool> = (0..num_stages.max(2)).map(is_main).collect();
            let plan = SignalPlan::draw(&is_main, &mut key.indexed("signals/plan", u64::from(junction)));
            for arm in &mut arms {
                arm.walk_s = plan.walk_s(arm.stage, arm.ford_length_m());
            }
            junctions.push(SignalledJunction { junction, arms, plan });
        }
        let by_lane = junctions
            .iter()
            .enumerate()
            .flat_map(|(junction, lit)| {
                lit.arms.iter().enumerate().flat_map(move |(arm, held)| {
                    let lanes = held.lanes.iter().chain(&held.cycle_lanes);
                    lanes.map(move |lane| (*lane, ArmId { junction, arm }))
                })
            })
            .collect();
        let zebras = draw_zebras(network, &junctions, key);
        Self { junctions, zebras, heads: Vec::new(), by_lane }
    }

    /// Whether a zebra crossing lies before the end of a lane.
    #[must_use]
    pub fn has_zebra(&self, lane: LaneId) -> bool {
        self.zebras.iter().any(|arm| arm.lanes.contains(&lane) || arm.cycle_lanes.contains(&lane))
    }

    /// The arm whose lights hold a lane's traffic.
    #[must_use]
    pub fn arm_of(&self, lane: LaneId) -> Option<ArmId> {
        self.by_lane.get(&lane).copied()
    }

    /// What the light at the end of a lane shows; `None` where there is none.
    #[must_use]
    pub fn aspect(&self, lane: LaneId, time_s: f64) -> Option<Aspect> {
        let id = self.arm_of(lane)?;
        let junction = &self.junctions[id.junction];
        Some(junction.plan.aspect(junction.arms[id.arm].stage, time_s))
    }

    /// Whether people may start over the ford of an arm.
    #[must_use]
    pub fn may_walk(&self, id: ArmId, time_s: f64) -> bool {
        let junction = &self.junctions[id.junction];
        junction.arms[id.arm].walk_s.is_some_and(|window| junction.plan.is_within(window, time_s))
    }

    /// How people get over a street from one place to another.
    #[must_use]
    pub fn crossing_rule(&self, from: DVec2, to: DVec2) -> CrossingRule {
        for (junction, lit) in self.junctions.iter().enumerate() {
            for (arm, crossed) in lit.arms.iter().enumerate() {
                let rule = crossed.crossing_rule(ArmId { junction, arm }, from, to);
                if rule != CrossingRule::Anywhere {
                    return rule;
                }
            }
        }
        if self.zebras.iter().any(|arm| arm.is_over(from, to)) { CrossingRule::Zebra } else { CrossingRule::Anywhere }
    }

    /// Whether a place is on a zebra crossing.
    #[must_use]
    pub fn is_on_zebra(&self, place: DVec2) -> bool {
        self.zebras.iter().any(|arm| arm.is_on_ford(place))
    }

    /// The lights near a place as they are lit at a time.
    pub fn lit(&self, time_s: f64, near: DVec2, out: &mut Vec<Instance>) {
        for head in &self.heads {
            if (head.world_from_head.translation.truncate() - near).length() <= SEEN_M {
                out.push(head.lit(self, time_s));
            }
        }
    }
}

/// Zebra crossings at some of the arms without lights: of streets with one lane a direction and sidewalks.
fn draw_zebras(network: &RoadNetwork, lit: &[SignalledJunction], key: &StreamKey) -> Vec<JunctionArm> {
    let has_sidewalk: BTreeSet<u32> = network.of_kind(LaneKind::Sidewalk).map(|l| l.road).collect();
    let junctions: BTreeSet<u32> = network.driving().filter_map(|l| l.junction).collect();
    let mut zebras = Vec::new();
    for junction in junctions.into_iter().filter(|j| lit.iter().all(|l| l.junction != *j)) {
        let s = &mut key.indexed("signals/zebras", u64::from(junction));
        for arm in arms_of(network, junction) {
            let is_drawn = s.chance(ZEBRA_SHARE);
            let lane = network.lane(arm.lanes[0]);
            let is_simple = arm.lanes.len() == 1 && arm.ford_length_m() < ZEBRA_MOST_M;
            if is_drawn && is_simple && has_sidewalk.contains(&lane.road) {
                zebras.push(arm);
            }
        }
    }
    zebras
}

/// By junction the lanes that lights hold, each with its light's controller.
fn lights_by_junction(network: &RoadNetwork) -> BTreeMap<u32, Vec<(LaneId, Option<usize>)>> {
    let mut found: BTreeMap<u32, Vec<(LaneId, Option<usize>)>> = BTreeMap::new();
    for light in &network.lights {
        for lane in &light.lanes {
            if let Some(junction) = network.junction_after(network.lane(*lane)) {
                found.entry(junction).or_default().push((*lane, light.controller));
            }
        }
    }
    found
}

/// Gives arms that face each other one stage, all others one of their own, and the arms of one controller those of the map
/// as far as they face each other. Returns the number of stages.
fn assign_stages(arms: &mut [JunctionArm], controllers: &[Option<usize>]) -> usize {
    let mut num_stages = 0;
    for i in 0..arms.len() {
        let fits = |j: &usize| {
            let one_controller =
                controllers[i].is_none() || controllers[*j].is_none() || controllers[i] == controllers[*j];
            // Two that go in one stage already are enough: a third would cross one of them.
            let count = arms[..i].iter().filter(|a| a.stage == arms[*j].stage).count();
            one_controller && count == 1 && arms[i].faces(&arms[*j])
        };
        arms[i].stage = match (0..i).find(fits) {
            Some(j) => arms[j].stage,
            None => {
                num_stages += 1;
                num_stages - 1
            }
        };
    }
    num_stages
}

#[cfg(test)]
mod tests;
