//! Lights of generated suburbs and of the shared maps.

use crate::ground::GroundKind;
use crate::network::Lane;
use crate::placement::PropConfig;
use crate::plan::SuburbConfig;
use crate::signals::*;
use crate::testing::shared_map;
use crate::{Town, generate_suburb};
use cadet_base::math::DVec3;

fn config() -> SuburbConfig {
    SuburbConfig { blocks: (3, 3), main_share: 0.7, signal_share: 1.0, ..SuburbConfig::default() }
}

fn town(seed: u64) -> Town {
    let props = PropConfig { greenery: 0.0, clutter: 0.0, ..PropConfig::default() };
    Town::suburb(&StreamKey::scene(seed), &config(), &props).unwrap()
}

/// Whether the middles of two lanes cross in the plane.
fn cross(a: &Lane, b: &Lane) -> bool {
    a.center.windows(2).any(|p| {
        b.center.windows(2).any(|q| {
            let [p0, p1, q0, q1] = [p[0], p[1], q[0], q[1]].map(DVec3::truncate);
            let side = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
            side(p0, p1, q0) * side(p0, p1, q1) < 0.0 && side(q0, q1, p0) * side(q0, q1, p1) < 0.0
        })
    })
}

#[test]
fn ways_that_cross_are_never_green_at_once_but_for_left_turns_across_oncoming_traffic() {
    let (mut num_pairs, mut num_left) = (0, 0);
    for seed in 0..12 {
        let key = StreamKey::scene(seed);
        let network = generate_suburb(&key, &config()).unwrap().network;
        let signals = Signals::of(&network, &key);
        assert!(!signals.junctions.is_empty(), "seed {seed} has no lights");
        for junction in &signals.junctions {
            let ways: Vec<(LaneId, &Lane)> = junction
                .arms
                .iter()
                .flat_map(|arm| &arm.lanes)
                .flat_map(|from| network.lane(*from).successors.iter().map(|way| (*from, network.lane(*way))))
                .collect();
            for (i, (from, way)) in ways.iter().enumerate() {
                for (other_from, other) in &ways[i + 1..] {
                    if !cross(way, other) || network.lane(*from).road == network.lane(*other_from).road {
                        continue;
                    }
                    num_pairs += 1;
                    let turns_left = way.turn_rad() > 0.5 || other.turn_rad() > 0.5;
                    let opposite = way.start_tangent().dot(other.start_tangent()) < -0.5;
                    num_left += usize::from(turns_left && opposite);
                    if turns_left && opposite {
                        continue;
                    }
                    for k in 0..(junction.plan.cycle_s() * 4.0) as usize {
                        let time_s = k as f64 * 0.25;
                        let goes = |lane| matches!(signals.aspect(lane, time_s), Some(Aspect::Green | Aspect::Yellow));
                        assert!(!(goes(*from) && goes(*other_from)), "seed {seed}: {from:?} and {other_from:?} cross");
                    }
                }
            }
        }
    }
    assert!(num_pairs > 200 && num_left > 20, "{num_pairs} pairs, {num_left} with a left turn");
}

#[test]
fn every_arm_of_a_junction_with_lights_has_one_and_none_does_without_the_share() {
    for seed in 0..6 {
        let key = StreamKey::scene(seed);
        let made = generate_suburb(&key, &config()).unwrap();
        let signals = Signals::of(&made.network, &key);
        for junction in &signals.junctions {
            let all = arms_of(&made.network, junction.junction);
            assert_eq!(junction.arms.len(), all.len(), "seed {seed}, junction {}", junction.junction);
            assert!(junction.arms.len() >= 3 && junction.plan.cycle_s() < 140.0);
            for (arm, of_road) in junction.arms.iter().zip(&all) {
                assert_eq!(arm.lanes, of_road.lanes);
                assert!((4.0..32.0).contains(&arm.ford_length_m()), "{} m across", arm.ford_length_m());
            }
        }
        let lights = made.xodr.matches("type=\"1000001\"").count();
        assert_eq!(lights, signals.junctions.iter().map(|j| j.arms.len()).sum::<usize>());
        assert_eq!(made.network.lights.len(), lights);
        assert!(made.network.lights.iter().all(|l| l.controller.is_some()));
        let none = generate_suburb(&key, &SuburbConfig { signal_share: 0.0, ..config() }).unwrap();
        assert!(none.network.lights.is_empty() && !none.xodr.contains("<signal"));
    }
}

#[test]
fn lights_of_shared_maps_hold_lanes_before_junctions() {
    for (map, signs) in [("Town01.xodr", 36), ("Town02.xodr", 24)] {
        let Some(network) = shared_map(map) else { continue };
        assert_eq!(network.lights.len(), signs, "{map}");
        let signals = Signals::of(&network, &StreamKey::scene(1));
        let arms: usize = signals.junctions.iter().map(|j| j.arms.len()).sum();
        assert!(arms >= signs * 3 / 4, "{map}: {arms} arms");
        for junction in &signals.junctions {
            assert!(junction.arms.len() >= 2, "{map}: junction {}", junction.junction);
        }
    }
}

#[test]
fn posts_stand_beside_the_road_near_the_stop_line_and_heads_face_the_traffic() {
    for seed in 0..4 {
        let town = town(seed);
        let signals = &town.signals;
        let mut num_posts = 0;
        for head in &signals.heads {
            let ArmId { junction, arm } = head.arm;
            let arm = &signals.junctions[junction].arms[arm];
            let at = head.world_from_head.translation.truncate();
            let facing = (head.world_from_head.rotation * DVec3::X).truncate();
            let above_m = head.world_from_head.translation.z - town.ground.height_at(at.x, at.y).unwrap();
            if head.kind == cadet_assets::scenery::HeadKind::Walk {
                assert!(facing.dot(arm.along).abs() < 1e-6);
                assert!((2.0..2.6).contains(&above_m), "{above_m}");
                continue;
            }
            assert!(facing.dot(arm.along) < -0.999);
            let before_m = STOP_LINE_M.0 - (arm.at - at).dot(arm.along);
            assert!((0.5..3.0).contains(&before_m), "seed {seed}: {before_m} m behind the stop line");
            if above_m < 4.0 {
                num_posts += 1;
                assert_ne!(town.ground.kind_at(at.x, at.y), Some(GroundKind::Road), "seed {seed}: a post on the road");
            } else {
                // It hangs over the lanes of its own traffic.
                let left_m = (at - arm.at).dot(arm.along.perp());
                assert!((arm.right_m..arm.lanes.len() as f64 * 3.5).contains(&left_m), "{left_m} m");
            }
        }
        let arms: usize = signals.junctions.iter().map(|j| j.arms.len()).sum();
        assert!(num_posts + 1 >= arms && arms > 2, "seed {seed}: {num_posts} posts at {arms} arms");
    }
}

#[test]
fn what_is_lit_is_a_function_of_seed_and_time() {
    let (a, b, other) = (town(3), town(3), town(4));
    let lit = |town: &Town, time_s: f64| -> Vec<[bool; 3]> {
        town.signals.heads.iter().map(|h| h.lenses(&town.signals, time_s)).collect()
    };
    let mut seen = BTreeSet::new();
    for k in 0..400 {
        let time_s = f64::from(k) * 0.37;
        assert_eq!(lit(&a, time_s), lit(&b, time_s));
        seen.extend(lit(&a, time_s));
        assert!(lit(&a, time_s).iter().all(|lenses| lenses.contains(&true)), "a dark light");
    }
    // Red, red and yellow, green, yellow, and nothing else.
    assert_eq!(seen.len(), 4, "{seen:?}");
    assert_ne!(lit(&a, 5.0), lit(&other, 5.0));
}

#[test]
fn people_cross_on_fords_and_not_beside_them() {
    let town = town(5);
    let signals = &town.signals;
    let (mut fords, mut refused) = (0, 0);
    for (j, junction) in signals.junctions.iter().enumerate() {
        for (a, arm) in junction.arms.iter().enumerate().filter(|(_, arm)| arm.has_ford()) {
            let way = |before_m: f64| (arm.place(before_m, arm.right_m - 1.0), arm.place(before_m, arm.left_m + 1.0));
            let (from, to) = way(2.5);
            let id = ArmId { junction: j, arm: a };
            assert_eq!(signals.crossing_rule(from, to), CrossingRule::Ford(id));
            assert_eq!(signals.crossing_rule(to, from), CrossingRule::Ford(id));
            fords += 1;
            let (from, to) = way(12.0);
            assert_eq!(signals.crossing_rule(from, to), CrossingRule::Nowhere);
            refused += 1;
            let walking = (0..200).filter(|t| signals.may_walk(id, f64::from(*t))).count();
            assert!((4..150).contains(&walking), "{walking} of 200 s");
        }
    }
    assert!(fords > 3 && refused > 3);
}

#[test]
fn some_arms_without_lights_have_a_zebra_crossing_where_people_may_cross() {
    let (mut zebras, mut arms) = (0, 0);
    for seed in 0..12 {
        let key = StreamKey::scene(seed);
        let network = generate_suburb(&key, &SuburbConfig::default()).unwrap().network;
        let signals = Signals::of(&network, &key);
        assert!(signals.junctions.is_empty() && signals.zebras.len() == Signals::of(&network, &key).zebras.len());
        let is_in_junction = |id: &LaneId| network.lane(*id).junction.is_some();
        arms += network.driving().filter(|l| l.junction.is_none() && l.successors.iter().any(is_in_junction)).count();
        zebras += signals.zebras.len();
        for arm in &signals.zebras {
            let way = |before_m: f64| (arm.place(before_m, arm.right_m - 1.0), arm.place(before_m, arm.left_m + 1.0));
            let ((from, to), (beside, over)) = (way(2.5), way(9.0));
            assert_eq!(
                (signals.crossing_rule(from, to), signals.crossing_rule(to, from)),
                (CrossingRule::Zebra, CrossingRule::Zebra)
            );
            assert_eq!(signals.crossing_rule(beside, over), CrossingRule::Anywhere);
            assert!(signals.is_on_zebra((from + to) / 2.0) && !signals.is_on_zebra((beside + over) / 2.0));
        }
    }
    assert!((0.02..0.14).contains(&(f64::from(zebras as u32) / f64::from(arms as u32))), "{zebras} of {arms}");
}
