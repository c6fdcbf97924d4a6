//! Roads that lie over each other as no bridge can: too low for a car to pass, or winding over themselves. There the ground,
//! which has one height at each place, joins both.

use std::collections::BTreeSet;

use crate::network::{CLEARANCE_M, Crossing, Lane, Overpass, crossings};
use crate::opendrive::Said;

/// Roads of one level differ by less where they lie over each other.
const ONE_LEVEL_M: f64 = 1.5;

/// Warnings about each pair of roads that cross at two heights; `name_of` gives a road's name in the map.
pub(crate) fn warnings<'a>(lanes: &[Lane], name_of: impl Fn(u32) -> &'a str) -> Vec<Said> {
    let (high, low): (Vec<Crossing>, Vec<Crossing>) =
        crossings(lanes, ONE_LEVEL_M).into_iter().partition(|c| c.upper.z - c.lower.z >= CLEARANCE_M);
    let spirals = Overpass::grouped(&high).into_iter().filter(Overpass::is_spiral).flat_map(|spiral| spiral.crossings);
    let mut pairs = BTreeSet::new();
    let mut said = Vec::new();
    for crossing in low.into_iter().chain(spirals) {
        let [a, b] = crossing.lanes.map(|lane| lanes[lane].road);
        if !pairs.insert((a.min(b), a.max(b))) {
            continue;
        }
        // Adding 0 takes the sign off -0.
        let [z_a, z_b] = [crossing.upper, crossing.lower].map(|p| p.z.round() + 0.0);
        let [a, b] = [a, b].map(&name_of);
        let text = format!(
            "roads {a} and {b} cross at heights {z_a} and {z_b} m: a bridge needs {CLEARANCE_M} m and a road that does \
             not wind over itself, so the ground joins them by a slope; leave one of them out for a level street"
        );
        said.push(Said::of_road("levels", format!("{a} and {b}"), text));
    }
    said
}
