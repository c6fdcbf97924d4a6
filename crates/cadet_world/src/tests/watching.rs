//! Looks at traffic as it goes on: nobody touches anybody, and nothing jams.

use super::*;

/// By so much who turns or squeezes past may touch, as `benches/traffic.py` has it.
const OVERLAP_M: f64 = 0.02;

/// Steps for some seconds and looks at everything four times a second: nobody overlaps, flies, sinks, tips or loses the
/// numbers. Returns how far the driven cars went in all.
pub(super) fn watch(world: &mut World, seconds: u32, name: &str) -> f64 {
    let mut gone_m = 0.0;
    for tick in 0..seconds * 4 {
        world.step(SECOND / 4);
        let driven: Vec<&Agent> = cars(world).into_iter().map(|(agent, _)| agent).collect();
        let rectangles = boxes(world, driven.iter().copied().chain(parked(world)));
        let walkers = walkers(world);
        for (i, (id, a)) in rectangles.iter().enumerate().take(driven.len()) {
            let pose = driven[i].actor().body.world_from_box(&world.arena.physics);
            assert!(pose.translation.is_finite() && pose.rotation.is_finite(), "{name}: car {id} is lost");
            let up = pose.rotation * DVec3::Z;
            assert!(up.z > 0.9, "{name}: car {id} has tipped over at tick {tick}: {up}");
            let ground = world.ground_height(pose.translation.x, pose.translation.y).expect("on the ground");
            let above = pose.translation.z - ground;
            assert!(above.abs() < 0.25, "{name}: car {id} is {above} m above the ground at tick {tick}");
            gone_m += a.velocity.length() / 4.0;
            for (other, b) in &rectangles[i + 1..] {
                assert!(
                    !a.grown(-OVERLAP_M / 2.0).overlaps(&b.grown(-OVERLAP_M / 2.0)),
                    "{name}: cars {id} ({}) and {other} overlap at tick {tick}, {a:?} and {b:?}",
                    driven[i].actor().look.model().name,
                );
            }
            for (walker, _) in &walkers {
                let apart_m = a.distance_m(place(world, walker));
                assert!(apart_m > 0.05, "{name}: car {id} runs into walker {} at tick {tick}", walker.id);
            }
        }
        for (walker, pedestrian) in &walkers {
            let p = position(world, walker);
            assert!(p.is_finite());
            assert!((p.z - world.ground_height(p.x, p.y).expect("on the ground")).abs() < 1e-6);
            if matches!(pedestrian.motion, Motion::Crosses { .. }) {
                continue;
            }
            // Narrow lanes end nearer to their middles, and at corners curb stones reach into lanes.
            let graph = &world.arena.streets.graph;
            let is_within = |at: &LanePosition| at.left_m.abs() < graph.lane(at.lane).width_at(at.s_m) / 2.0;
            let is_on_curb = graph.is_sidewalk(p);
            let lane = graph.nearest(p, None, 1.4).filter(is_within).filter(|_| !is_on_curb);
            let motion = pedestrian.motion;
            assert!(lane.is_none(), "{name}: walker {} is on lane {lane:?} at tick {tick}, {motion:?}", walker.id);
        }
    }
    gone_m
}

/// No car in traffic has stood for so long.
pub(super) fn nobody_stands(world: &World, longest_s: f64, name: &str) {
    for (agent, driver) in cars(world) {
        let stood_s = driver.standing_steps as f64 * DT_S;
        assert!(stood_s < longest_s, "{name}: {} stands for {stood_s} s, {:?}", agent.id, driver.cause());
    }
}

/// Watches traffic in which cars go so fast in the mean, and none stands for so long.
pub(super) fn flows(world: &mut World, seconds: u32, (least_mps, longest_s): (f64, f64), name: &str) {
    let gone_m = watch(world, seconds, name);
    let num_cars = cars(world).len() as f64;
    assert!(gone_m > least_mps * f64::from(seconds) * num_cars, "{name}: {gone_m} m in all by {num_cars} cars");
    nobody_stands(world, longest_s, name);
}
