//! Cyclists on lanes of their own: in their middle, across junctions, and passed by cars that stay in theirs.

use std::collections::{BTreeMap, BTreeSet};

use super::towns::cycle_lanes;
use super::*;
use cadet_town::LaneKind;

/// What minutes of traffic have shown.
#[derive(Default)]
struct Seen {
    /// Distances from the middle of a cycle lane, and heights over it, of who rides there.
    off_m: Vec<f64>,
    /// Cyclists who came out of a junction: from a cycle lane onto one, and in another way.
    crossed: usize,
    changed: usize,
    /// Cars beside somebody on a cycle lane, and those of them that pulled out.
    passed: BTreeSet<(i32, i32)>,
    pulled_out: usize,
    /// Descriptions of all that is wrong.
    wrong: Vec<String>,
}

/// Describes somebody: who they are, where, and what they are about.
fn tell(world: &World, agent: &Agent) -> String {
    let (name, behavior) = (agent.actor().look.model().name, agent.behavior());
    let (own, lane, cause) = (footprint(world, agent), behavior.on_lane(0), behavior.cause());
    format!("{} {name}, {own:?}, on {lane:?}, {cause:?}", agent.id)
}

fn ride(world: &mut World, seconds: u32, name: &str, seen: &mut Seen) {
    // Cars queue behind a light for longer than anybody waits elsewhere.
    let plans = world.arena.streets.graph.signals().junctions.iter().map(|j| j.plan.longest_red_s());
    let longest_s = 60.0 + plans.fold(0.0, f64::max);
    let mut before: BTreeMap<i32, (DVec2, LaneKind, Option<LaneKind>)> = Default::default();
    for tick in 0..seconds * 4 {
        world.step(SECOND / 4);
        let graph = &world.arena.streets.graph;
        let riders = cyclists(world);
        let driven = cars(world);
        let all: Vec<&Agent> =
            riders.iter().map(|r| r.0).chain(driven.iter().map(|d| d.0)).chain(parked(world)).collect();
        let boxes = boxes(world, all.iter().copied());
        for (i, (_, a)) in boxes.iter().enumerate().take(riders.len() + driven.len()) {
            for (k, (_, b)) in boxes[i + 1..].iter().enumerate() {
                if a.overlaps(b) {
                    let [one, other] = [i, i + 1 + k].map(|i| tell(world, all[i]));
                    seen.wrong.push(format!("{name}, tick {tick}: {one} and {other}"));
                }
            }
        }
        for (agent, cyclist) in &riders {
            let stands_s = cyclist.standing_steps as f64 * DT_S;
            if stands_s >= longest_s {
                seen.wrong.push(format!("{name}, tick {tick}: stands: {}", tell(world, agent)));
            }
            let (here, lane) = (place(world, agent), graph.lane(cyclist.route.lanes[0]));
            let mut entered_from = None;
            if let Some((was, kind, crosses_from)) = before.get(&agent.id).copied() {
                let step_m = (here - was).length();
                assert!(step_m < 2.5, "{name}, tick {tick}: {} jumps {step_m} m", agent.id);
                if lane.junction.is_some() {
                    entered_from = crosses_from.or(Some(kind));
                } else if let Some(came_from) = crosses_from {
                    let keeps = (came_from, lane.kind) == (LaneKind::Biking, LaneKind::Biking);
                    *if keeps { &mut seen.crossed } else { &mut seen.changed } += 1;
                }
            }
            before.insert(agent.id, (here, lane.kind, entered_from));
            let (s_m, off_m) = lane.project(position(world, agent));
            if lane.kind == LaneKind::Biking && lane.junction.is_none() && s_m > 2.0 {
                seen.off_m.push(off_m);
            }
            let rider = footprint(world, agent);
            for (car, driver) in driven.iter().filter(|_| lane.kind == LaneKind::Biking && lane.junction.is_none()) {
                let own = footprint(world, car);
                let beside = (own.center - rider.center).dot(rider.heading).abs() < 1.0;
                let is_faster = own.velocity.dot(rider.heading) > rider.velocity.length() + 1.0;
                if beside && is_faster && (own.center - rider.center).length() < 5.0 {
                    seen.passed.insert((car.id, agent.id));
                    seen.pulled_out += usize::from(driver.overtaking.is_some());
                }
            }
        }
        for (agent, driver) in &driven {
            let stands_s = driver.standing_steps as f64 * DT_S;
            if stands_s >= longest_s {
                seen.wrong.push(format!("{name}, tick {tick}: stands: {}", tell(world, agent)));
            }
        }
    }
}

#[test]
fn cyclists_keep_to_the_middle_of_their_lanes_cross_junctions_and_are_passed() {
    let mut seen = Seen::default();
    for seed in 0..8 {
        let mut world = filled(cycle_lanes(seed), seed, [18, 16, 12]);
        ride(&mut world, 120, &format!("seed {seed}"), &mut seen);
    }
    let worst_m = seen.off_m.iter().copied().fold(0.0, f64::max);
    let near = seen.off_m.iter().filter(|m| **m < 0.15).count() as f64 / seen.off_m.len() as f64;
    let counts = format!(
        "{} looks, worst {worst_m} m, {near} near, {} crossed, {} changed, {} passed, {} pulled out",
        seen.off_m.len(),
        seen.crossed,
        seen.changed,
        seen.passed.len(),
        seen.pulled_out
    );
    assert!(seen.wrong.is_empty(), "{} wrong: {:#?}", seen.wrong.len(), &seen.wrong[..seen.wrong.len().min(30)]);
    assert!(worst_m < 0.4 && near > 0.95, "{counts}");
    assert!(seen.crossed > 20 && seen.changed > 20 && seen.passed.len() > 20, "{counts}");
    assert_eq!(seen.pulled_out, 0, "{counts}");
}
