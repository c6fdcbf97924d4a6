//! Roundabouts: who comes gives way, all go round the same way, and nobody signals but to leave.

use super::*;
use crate::look::TurnSignal;
use cadet_assets::props::{ARROW_BOARD, ROUNDABOUT_SIGN, Shipped};
use cadet_town::{Lane, LaneKind, PropConfig, SuburbConfig};

/// A suburb whose junctions are roundabouts wherever they may be.
fn town(seed: u64) -> Arc<Town> {
    let config = SuburbConfig { blocks: (2, 2), block_m: (85.0, 120.0), roundabout_share: 1.0, ..Default::default() };
    towns::bare(seed, &config, PropConfig::default())
}

/// The lane that an agent is on, if it leads through a roundabout, and how far along it is.
fn on_ring<'a>(world: &'a World, agent: &Agent) -> Option<(&'a Lane, f64)> {
    let LanePosition { lane: id, s_m, .. } = agent.behavior().on_lane(0)?;
    let graph = &world.arena.streets.graph;
    graph.is_in_roundabout(id).then(|| (graph.lane(id), s_m))
}

#[test]
fn traffic_goes_round_without_touching_or_jamming_and_signals_to_leave() {
    let (mut entered, mut cyclists_entered) = (0, 0);
    let (mut early, mut leaving, mut late_looks) = (0, 0, 0);
    for seed in 0..4 {
        let name = format!("roundabouts {seed}");
        let mut world = filled(town(seed), seed, [22, 10, 6]);
        let mut was_on = std::collections::BTreeSet::new();
        for _ in 0..16 {
            watch(&mut world, 5, &name);
            for (_, agent) in world.arena.active() {
                let Some((lane, s_m)) = on_ring(&world, agent) else {
                    was_on.remove(&agent.id);
                    continue;
                };
                let is_new = was_on.insert(agent.id);
                entered += usize::from(is_new && agent.get::<Car>().is_some());
                cyclists_entered += usize::from(is_new && agent.get::<Cyclist>().is_some());
                if let Some(driver) = agent.get::<Car>() {
                    let shows = driver.own.look.signal != TurnSignal::Off;
                    let is_late = s_m > lane.length_m() - 12.0;
                    early += usize::from(shows && s_m < lane.length_m() - 16.0);
                    late_looks += usize::from(is_late);
                    leaving += usize::from(shows && is_late);
                }
            }
            nobody_stands(&world, 45.0, &name);
        }
    }
    assert!(entered >= 30 && cyclists_entered >= 4, "{entered} cars, {cyclists_entered} cyclists");
    assert!(early == 0 && late_looks >= 8 && leaving == late_looks, "{early} early, {leaving} of {late_looks} leaving");
}

#[test]
fn roundabouts_lie_in_asphalt_about_a_lawn_and_hold_what_belongs_there() {
    let (mut num_islands, mut num_entries) = (0, 0);
    for seed in 0..6 {
        let town = town(seed);
        let network = &town.network;
        assert!(network.roundabouts.len() >= 3, "{seed}: {:?}", network.roundabouts);
        let kind = |p: DVec2| town.ground.kind_at(p.x, p.y);
        let islands: Vec<&Lane> =
            network.lanes.iter().filter(|l| l.kind == LaneKind::Median && l.junction.is_none()).collect();
        assert_eq!(islands.len(), network.roundabouts.len(), "{seed}");
        for island in &islands {
            let points = &island.center[1..];
            let center = points.iter().map(|p| p.truncate()).sum::<DVec2>() / points.len() as f64;
            let radius_m = (points[0].truncate() - center).length() + island.width_m[0] / 2.0;
            assert!((8.4..10.6).contains(&radius_m), "{seed}: an island of {radius_m} m");
            for (p, k) in points.iter().zip(0..) {
                let out = (p.truncate() - center).normalize();
                assert_eq!(kind(center + out * (radius_m - 0.6)), Some(cadet_town::GroundKind::Terrain), "{seed} {k}");
                let on_road = kind(center + out * (radius_m + 2.2));
                assert_eq!(on_road, Some(cadet_town::GroundKind::Road), "{seed} {k}");
            }
            num_islands += 1;
        }
        for lane in network.driving().filter(|l| network.is_in_roundabout(l)) {
            let nearest = |p: &DVec3| islands.iter().map(|i| i.project(*p).1).fold(f64::INFINITY, f64::min);
            let least_m = lane.center.iter().map(nearest).fold(f64::INFINITY, f64::min);
            assert!(least_m > 5.0, "{seed}: {least_m} m from an island's line");
        }
        // Each by the mesh that all of a kind share.
        let count = |kind: Shipped| {
            let shape = kind.model(0).shape;
            town.scenery.iter().filter(|i| Arc::ptr_eq(&shape, &i.shape)).count()
        };
        let entries = network.driving().filter(|l| network.ends_at_roundabout(l)).count();
        assert_eq!((count(ROUNDABOUT_SIGN), count(ARROW_BOARD)), (entries, entries), "{seed}");
        num_entries += entries;
    }
    assert!(num_islands >= 24 && num_entries >= 70, "{num_islands} islands, {num_entries} entries");
}
