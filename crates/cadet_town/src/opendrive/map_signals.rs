//! The traffic lights and the signs of priority of an OpenDRIVE map: which lanes they hold before which junction.

use std::collections::{BTreeMap, BTreeSet};

use crate::network::{Lane, LaneId, LaneKind, MapLight, RightOfWay};
use crate::opendrive::Said;
use cadet_base::math::DVec2;

/// Traffic lights for vehicles in the catalogs that maps use.
const LIGHT: &str = "1000001";
/// Signs of priority by their numbers in the German catalog, which maps of other countries use too (CARLA's towns).
const SIGNS: [(&str, RightOfWay); 4] = [
    ("205", RightOfWay::Yield),
    ("206", RightOfWay::Stop),
    ("301", RightOfWay::Priority),
    ("306", RightOfWay::Priority),
];

/// The lights of a map that hold lanes which were read, and warnings of those that hold none; `ids` leads from the
/// reader's lanes to ours, and `offset_m` from its places to the map's own.
pub(crate) fn lights(
    map: &xodr::RoadNetwork,
    ids: &BTreeMap<usize, LaneId>,
    lanes: &[Lane],
    offset_m: DVec2,
) -> (Vec<MapLight>, Vec<Said>) {
    let (mut lights, mut warnings) = (Vec::new(), Vec::new());
    for signal in map.signals().iter().filter(|s| s.kind == LIGHT) {
        let held = lanes_held(signal, ids, lanes);
        if held.is_empty() {
            warnings.push(without_lanes(signal, map, offset_m));
        } else {
            lights.push(MapLight { lanes: held, controller: signal.controllers.first().map(|c| c.0) });
        }
    }
    (lights, warnings)
}

/// The warning of a light that holds no lane.
fn without_lanes(signal: &xodr::Signal, map: &xodr::RoadNetwork, offset_m: DVec2) -> Said {
    let place = signal.lanes.first().and_then(|lane| map.road_lane(*lane));
    let road = place.and_then(|place| map.road(place.road)).map_or("", xodr::Road::od_id);
    let at_m = DVec2::new(signal.position.x.into(), signal.position.y.into()) + offset_m;
    let text = format!(
        "traffic light {:?} at ({:.1}, {:.1}) left out: no driving lane leads from it to a junction; check its \
         orientation and <validity>",
        signal.name, at_m.x, at_m.y
    );
    Said::of_road("light without lanes", road.to_owned(), text)
}

/// What signs say of lanes that were read, by rising lane; of two at one lane the first counts.
pub(crate) fn signs(
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

/// The lanes that end at a junction: of a light in one those that lead there, of one before it those that its lane goes
/// on to, over as many pieces as there are.
fn held_by(applied: LaneId, lanes: &[Lane]) -> Vec<LaneId> {
    let is_in_junction = |id: &LaneId| lanes[id.0].junction.is_some();
    if lanes[applied.0].kind != LaneKind::Driving {
        return Vec::new();
    }
    let goes_back = is_in_junction(&applied);
    let is_on_its_way = |id: &LaneId| lanes[id.0].road == lanes[applied.0].road;
    let (mut held, mut seen, mut next) = (Vec::new(), BTreeSet::new(), vec![applied]);
    while let Some(id) = next.pop() {
        if !seen.insert(id) {
            continue;
        }
        let lane = &lanes[id.0];
        if goes_back && is_in_junction(&id) {
            next.extend(lane.predecessors.iter().filter(|id| is_on_its_way(id) || !is_in_junction(id)));
        } else if goes_back || lane.successors.iter().any(is_in_junction) {
            held.push(id);
        } else {
            next.extend(&lane.successors);
        }
    }
    held
}
