//! That nobody waits for ever for who stands where one would swing out.

use super::*;
use crate::driving::Cause;

#[test]
fn who_would_swing_into_somebody_for_ever_takes_another_way() {
    let mut turned = 0;
    for seed in 0..60 {
        let mut world = World::new(crossing(), StreamKey::scene(seed)).unwrap();
        let graph = &LaneGraph::new(crossing());
        let route = cars(&world)[0].1.route.clone().unwrap();
        let Some(k) = route.lanes.iter().position(|l| graph.lane(*l).junction.is_some()) else { continue };
        let (before, wanted) = (graph.lane(route.lanes[k - 1]), graph.lane(route.lanes[k]));
        let start = (wanted.center[1] - wanted.center[0]).truncate();
        let through = (wanted.center[wanted.center.len() - 1] - wanted.center[0]).truncate();
        if start.normalize().perp_dot(through) > -3.0 {
            continue;
        }
        // At the line of the arm that is turned into, too near to the lane that leads into it.
        let line_m = before.length_m() - route.s_m + wanted.length_m() + 6.0;
        let exit = route.ahead(line_m, graph);
        let at = exit.at + exit.tangent.perp() * 2.1;
        let waypoint = |t_s: f64, p: DVec2| Waypoint { t_s, x_m: p.x, y_m: p.y };
        let stands_there = Course::Path(vec![waypoint(0.0, at + exit.tangent * 0.01), waypoint(1.0, at)]);
        put(&mut world, ObjectClass::Van, 3, &stands_there);
        let from_m = position(&world, world.arena.ego());
        let waits = |world: &mut World| {
            world.step(SECOND);
            matches!(cars(world)[0].1.cause(), Cause::Junction(Refusal::InSweep(_)))
        };
        assert!((0..30).any(|_| waits(&mut world)), "seed {seed}: {:?}", cars(&world)[0].1.cause());
        world.step(50 * SECOND);
        let taken = &cars(&world)[0].1.route.as_ref().unwrap().lanes;
        let gone_m = (position(&world, world.arena.ego()) - from_m).length();
        assert!(!taken.contains(&before.id), "seed {seed}: stands after {gone_m} m, {:?}", cars(&world)[0].1.cause());
        turned += 1;
    }
    assert!(turned >= 3, "{turned}");
}
