//! Lines along the sidewalks' middles, for people to walk on.

use crate::ground::Ground;
use crate::network::Walkway;
use cadet_base::math::DVec3;

/// Loops shorter than this lead nowhere.
const MIN_LOOP_M: f64 = 30.0;
/// People keep this much of a sidewalk's width free at its two edges together.
const EDGE_M: f64 = 0.6;

/// The lines along the sidewalks of a ground: closed loops round the blocks, the last point equal to the first, and open
/// lines where bridges begin and end.
#[must_use]
pub fn walkways(ground: &Ground) -> Vec<Walkway> {
    let length_m = |line: &[DVec3]| line.windows(2).map(|p| (p[1] - p[0]).truncate().length()).sum::<f64>();
    let is_usable = |line: &&Vec<DVec3>| line.first() != line.last() || length_m(line) >= MIN_LOOP_M;
    let width_m = (ground.sidewalk_width_m - EDGE_M).max(0.5);
    ground.walk_lines().iter().filter(is_usable).map(|line| Walkway { center: line.clone(), width_m }).collect()
}
