//! Priority on the road: who yields hinders nobody, and who stops does so at the line.

use std::collections::BTreeMap;

use super::towns::{country_roads, main_roads, suburb};
use super::*;
use crate::driving::{Cause, line_m};
use cadet_base::rng::Stream;
use cadet_town::{LaneId, RightOfWay};

/// What one may brake for those who had to let one go first: comfortably, and a little more.
const HARDEST_MPS2: f64 = 2.1;

/// Filled as the default policy fills streets.
fn busy(seed: u64) -> World {
    let town = match seed % 3 {
        0 => country_roads(seed),
        1 => main_roads(seed),
        _ => suburb(seed),
    };
    filled(town, seed, [20, 0, 3])
}

/// The lane before the next junction of a vehicle, and how far its front is from it.
fn approach(world: &World, agent: &Agent) -> Option<(LaneId, f64)> {
    let route = match (agent.get::<Car>(), agent.get::<Cyclist>()) {
        (Some(driver), _) => driver.route.as_ref()?,
        (_, Some(cyclist)) => &cyclist.route,
        _ => return None,
    };
    let graph = &world.arena.streets.graph;
    let k = route.lanes.iter().position(|l| graph.lane(*l).junction.is_some()).filter(|k| *k > 0)?;
    let to_m: f64 = route.lanes.iter().take(k).map(|l| graph.lane(*l).length_m()).sum();
    Some((route.lanes[k - 1], to_m - route.s_m - agent.actor().look.size_lwh().x / 2.0))
}

#[test]
fn nobody_with_priority_brakes_hard_for_who_has_to_yield_and_all_stop_at_the_line() {
    let (mut had_priority, mut for_minor, mut hard) = (0, 0, Vec::new());
    let mut off_m: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for seed in 0..12 {
        let mut world = busy(seed);
        let mut before: BTreeMap<i32, f64> = BTreeMap::new();
        // The right of way of each one's approach, kept while it crosses.
        let mut came_by: BTreeMap<usize, Option<RightOfWay>> = BTreeMap::new();
        for tick in 1..=600 {
            world.step(12);
            let graph = &world.arena.streets.graph;
            for (slot, agent) in world.arena.active() {
                let lane = agent.behavior().on_lane(0).map(|at| graph.lane(at.lane));
                if lane.is_some_and(|l| l.junction.is_none()) {
                    came_by.insert(slot, approach(&world, agent).and_then(|(lane, _)| graph.right_of_way(lane)));
                }
            }
            for (_, agent) in world.arena.active() {
                let speed_mps = agent.actor().body.forward_mps(&world.arena.physics);
                let accel_mps2 = before.insert(agent.id, speed_mps).map_or(0.0, |was| (speed_mps - was) / 0.2);
                let Some((lane, front_m)) = approach(&world, agent) else { continue };
                let has_priority = graph.right_of_way(lane) == Some(RightOfWay::Priority);
                had_priority += usize::from(has_priority);
                let Cause::Junction(refusal) = agent.behavior().cause() else { continue };
                let (stands, is_in_sweep) = (speed_mps.abs() < 0.02, matches!(refusal, Refusal::InSweep(_)));
                // A vehicle that has stood behind another sets off.
                let before_m = front_m - line_m(lane, graph);
                let is_looked_at = tick % 5 == 0 && tick <= 300 && stands && before_m < 3.0;
                if is_looked_at && !is_in_sweep && refusal != Refusal::Undecided {
                    off_m.entry(agent.actor().look.class().kitti_name()).or_default().push(before_m.abs());
                }
                let (Refusal::Taken(other) | Refusal::Yields(other)) = refusal else { continue };
                let is_minor = matches!(came_by.get(&other), Some(Some(RightOfWay::Yield | RightOfWay::Stop)));
                if has_priority && is_minor {
                    for_minor += 1;
                    if accel_mps2 < -HARDEST_MPS2 {
                        hard.push(format!("seed {seed}, tick {tick}: {} for {other}: {accel_mps2}", agent.id));
                    }
                }
            }
        }
    }
    assert!(had_priority > 10_000 && for_minor > 300, "{for_minor} of {had_priority} looks");
    // They brake for those at 7 % of looks; at 14 % if nobody yielded, since all came alike.
    assert!(10 * for_minor < had_priority, "{for_minor} of {had_priority} looks");
    assert!(hard.is_empty(), "{} of {for_minor}: {:#?}", hard.len(), &hard[..hard.len().min(10)]);
    assert!(off_m.len() >= 4, "{:?}", off_m.keys());
    for (class, off_m) in &off_m {
        let worst_m = off_m.iter().copied().fold(0.0_f64, f64::max);
        let near = off_m.iter().filter(|m| **m < 0.2).count() as f64 / off_m.len() as f64;
        assert!(worst_m < 0.35 && near > 0.95, "{class}: {near} of {} near, {worst_m} m", off_m.len());
    }
}

#[test]
fn the_order_of_slots_changes_nothing() {
    for seed in 0..6 {
        let places = |is_shuffled: bool| {
            let mut world = busy(seed);
            let walking = TrafficConfig { num_cars: 0, num_pedestrians: 30, ..TrafficConfig::default() };
            world.spawn_traffic(&walking).unwrap();
            if is_shuffled {
                world.arena.shuffle(&mut Stream::from_seed("slots", seed));
            }
            for step in 0..u64::from(20 * SECOND) {
                if step % 3 == 0 {
                    world.arena.look(step);
                }
                world.arena.step();
            }
            let bits = |agent: &Agent| {
                let pose = agent.actor().body.world_from_box(&world.arena.physics);
                let (t, r) = (pose.translation, pose.rotation);
                (agent.id, [t.x, t.y, t.z, r.x, r.y, r.z, r.w].map(f64::to_bits))
            };
            let mut places: Vec<_> = world.arena.active().map(|(_, agent)| bits(agent)).collect();
            places.sort_unstable();
            places
        };
        let (usual, shuffled) = (places(false), places(true));
        let moved = usual.iter().zip(&shuffled).filter(|(a, b)| a != b).count();
        assert!(usual.len() > 15 && moved == 0, "seed {seed}: {moved} of {} elsewhere", usual.len());
    }
}
