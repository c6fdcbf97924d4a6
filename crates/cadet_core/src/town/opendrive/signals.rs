//! The traffic lights and the signs of priority of an OpenDRIVE map: which lanes they hold before which junction.

use std::collections::BTreeMap;

use crate::town::network::road_network::RightOfWay;
use crate::town::network::road_network::{Lane, LaneId, LaneKind, MapLight};

/// Traffic lights for vehicles in the catalogs that maps use.
const LIGHT: &str = "1000001";
/// Signs of priority by their numbers in the German catalog, which maps of other countries use too (CARLA's towns).
const SIGNS: [(&str, RightOfWay); 4] = [
    ("205", RightOfWay::Yield),
    ("206", RightOfWay::Stop),
    ("301", RightOfWay::Priority),
    ("306", RightOfWay::Priority),
];
/// Lanes that follow each other from a light or a sign to the junction, at most.
const MOST_PIECES: usize = 6;

/// The lights of a map that hold lanes which were read; `ids` leads from the reader's lanes to ours.
pub(in crate::town) fn lights(map: &xodr::RoadNetwork, ids: &BTreeMap<usize, LaneId>, lanes: &[Lane]) -> Vec<MapLight> {
    let lights = map.signals().iter().filter(|s| s.kind == LIGHT);
    lights
        .filter_map(|signal| {
            let held = lanes_held(signal, ids, lanes);
            let controller = signal.controllers.first().map(|c| c.0);
            (!held.is_empty()).then_some(MapLight { lanes: held, controller })
        })
        .collect()
}

/// What signs say of lanes that were read, by rising lane; of two at one lane the first counts.
pub(in crate::town) fn signs(
    map: &xodr::RoadNetwork,
    ids: &BTreeMap<usize, LaneId>,
    lanes: &[Lane],
) -> BTreeMap<LaneId, RightOfWay> {
    let mut signs = BTreeMap::new();
    for signal in map.signals() {
        let Some((_, says)) = SIGNS.iter().find(|(number, _)| *number == signal.kind) else { continue };
        for lane in lanes_held(signal, ids, lanes) {
            signs.entry(lane).or_insert(*says);
        }
    }
    signs
}

/// The lanes before a junction that a signal holds, rising.
fn lanes_held(signal: &xodr::Signal, ids: &BTreeMap<usize, LaneId>, lanes: &[Lane]) -> Vec<LaneId> {
    let applied = signal.lanes.iter().filter_map(|lane| ids.get(&lane.0));
    let mut held: Vec<LaneId> = applied.flat_map(|lane| held_by(*lane, lanes)).collect();
    held.sort_unstable();
    held.dedup();
    held
}

/// The lanes before the junction: of a light in it those that lead there, of one before it where the lane goes on to.
fn held_by(applied: LaneId, lanes: &[Lane]) -> Vec<LaneId> {
    let lane = &lanes[applied.0];
    if lane.kind != LaneKind::Driving {
        return Vec::new();
    }
    let is_in_junction = |id: &LaneId| lanes[id.0].junction.is_some();
    if lane.junction.is_some() {
        return lane.predecessors.iter().copied().filter(|id| !is_in_junction(id)).collect();
    }
    let mut last = applied;
    for _ in 0..MOST_PIECES {
        let next = &lanes[last.0].successors;
        if next.iter().any(is_in_junction) {
            return vec![last];
        }
        let [one] = next.as_slice() else { break };
        last = *one;
    }
    Vec::new()
}
