//! Roads that lie over each other. The ground is one height field, so a bridge and what passes below it melt.

use std::collections::{BTreeMap, BTreeSet};

use crate::town::network::road_network::{Lane, LaneKind};
use crate::town::opendrive::warnings::Said;

/// Lanes are compared where they share a cell of this size.
const CELL_M: f64 = 3.0;
/// Lanes of one level differ by less in a cell, those of two roads and those of one, which may be steep and banked.
const LEVEL_M: f64 = 1.5;
const LEVEL_OF_ROAD_M: f64 = 2.6;

/// Warnings about each pair of roads that cross at two heights; `name_of` gives a road's name in the map.
pub(in crate::town) fn warnings<'a>(lanes: &[Lane], name_of: impl Fn(u32) -> &'a str) -> Vec<Said> {
    let mut heights_by_cell: BTreeMap<(i64, i64), Vec<(u32, f64)>> = BTreeMap::new();
    let mut said = Vec::new();
    let mut pairs = BTreeSet::new();
    for lane in lanes.iter().filter(|l| matches!(l.kind, LaneKind::Driving | LaneKind::Biking | LaneKind::Tram)) {
        for p in &lane.center {
            let cell = ((p.x / CELL_M).floor() as i64, (p.y / CELL_M).floor() as i64);
            let here = heights_by_cell.entry(cell).or_default();
            if here.iter().any(|(road, z)| *road == lane.road && (z - p.z).abs() < LEVEL_M) {
                continue;
            }
            let level_m = |road: u32| if road == lane.road { LEVEL_OF_ROAD_M } else { LEVEL_M };
            for (road, z) in here.iter().filter(|(road, z)| (z - p.z).abs() >= level_m(*road)) {
                let (low, high) = (road.min(&lane.road), road.max(&lane.road));
                if !pairs.insert((*low, *high)) {
                    continue;
                }
                let [a, b] = [name_of(*road), name_of(lane.road)];
                // Adding 0 takes the sign off -0.
                let [z_a, z_b] = [*z, p.z].map(|z| z.round() + 0.0);
                said.push(Said {
                    kind: "levels".to_owned(),
                    line: None,
                    road: format!("{a} and {b}"),
                    text: format!(
                        "roads {a} and {b} cross at heights {z_a} and {z_b} m: not supported, the ground joins them by a \
                         slope; leave one of them out for a level street"
                    ),
                });
            }
            here.push((lane.road, p.z));
        }
    }
    said
}
