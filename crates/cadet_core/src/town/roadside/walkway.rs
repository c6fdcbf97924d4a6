//! Lines along the sidewalks' middles, for people to walk on.

use crate::town::Walkway;
use crate::town::ground::Ground;
use crate::town::ground::region::with_steps;

/// Loops shorter than this lead nowhere.
const MIN_LOOP_M: f64 = 30.0;
/// People keep this much of a sidewalk's width free at its two edges together.
const EDGE_M: f64 = 0.6;

/// The lines along the sidewalks of a ground: closed loops round the blocks, the last point equal to the first.
#[must_use]
pub fn walkways(ground: &Ground) -> Vec<Walkway> {
    let loops = ground.walk_rings().iter().map(|ring| with_steps(ring, 1.9));
    loops
        .filter_map(|mut ring| {
            ring.push(*ring.first()?);
            let length: f64 = ring.windows(2).map(|p| (p[1] - p[0]).length()).sum();
            let center = ring.iter().map(|p| ground.height_at(p.x, p.y).map(|z| p.extend(z))).collect::<Option<_>>()?;
            let width_m = (ground.sidewalk_width_m - EDGE_M).max(0.5);
            (length >= MIN_LOOP_M).then_some(Walkway { center, width_m })
        })
        .collect()
}
