//! Paint on the carriageway: the lines of the map, stop lines and give-way lines where nothing else rules, as thin
//! quadrilaterals.

use crate::network::{PaintedQuad, RightOfWay, RoadNetwork};
use crate::paint::{Paint, STOP_LINE_DEPTH_M, cycle_markings, junctions};
use crate::signals::Signals;
use cadet_base::math::DVec3;

/// A give-way line: dash and gap across the lane, depth along it.
const GIVE_WAY_M: (f64, f64, f64) = (0.5, 0.25, 0.35);
/// Lines across a lane lie this far before its end.
const BEFORE_JUNCTION_M: f64 = 0.8;
/// Lines across have numbers beyond those of the map's lines.
pub(crate) const ACROSS: u32 = 1 << 29;

/// The quadrilaterals, counter-clockwise from above, laid on the surface nearest to each place, which is so high and a road or not.
pub(crate) fn draw(
    network: &RoadNetwork,
    signals: &Signals,
    surface_near: &dyn Fn(DVec3) -> Option<(f64, bool)>,
) -> Vec<PaintedQuad> {
    let mut paint = Paint::new(surface_near, false);
    network.lane_marks.iter().for_each(|mark| paint.along(mark));
    for lane in network.driving().filter(|l| l.junction.is_none()) {
        // The lines of lights and zebra crossings are drawn with them.
        if signals.has_zebra(lane.id) {
            continue;
        }
        let (at, side) = lane.middle_and_left(lane.length_m() - BEFORE_JUNCTION_M);
        let half = lane.width_at(lane.length_m()) / 2.0;
        let line = lane.id.0 as u32 + ACROSS;
        match RightOfWay::of(lane, network, signals) {
            Some(RightOfWay::Stop) => paint.across(at, side, (-half + 0.1, half - 0.1), STOP_LINE_DEPTH_M, line),
            Some(RightOfWay::Yield) => {
                let (dash_m, gap_m, depth_m) = GIVE_WAY_M;
                paint.dashes(at, side, (-half + 0.1, half), (dash_m, gap_m), depth_m, line);
            }
            _ => {}
        }
    }
    paint.is_on_roads = true;
    cycle_markings::draw(network, &mut paint);
    junctions::draw(network, signals, &mut paint);
    paint.quads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Lane, LaneId};
    use cadet_base::math;

    /// Lanes that end at the origin, one beside the other if they are of one road, and a lane that leads on.
    fn junction_of(arriving: &[(u32, f64)]) -> RoadNetwork {
        let lane = |id: usize, road: u32, center: Vec<DVec3>, speed_limit_mps: f64| Lane {
            speed_limit_mps,
            ..Lane::new(LaneId(id), road, center, vec![3.0; 2])
        };
        let beyond = arriving.len();
        let mut lanes: Vec<Lane> = arriving
            .iter()
            .enumerate()
            .map(|(i, (road, speed))| {
                let along = DVec3::new(math::cos(f64::from(*road)), math::sin(f64::from(*road)), 0.0);
                let beside = DVec3::new(-along.y, along.x, 0.0) * (3.0 * i as f64);
                let mut lane = lane(i, *road, vec![beside - along * 14.0, beside - along * 4.0], *speed);
                lane.successors = vec![LaneId(beyond)];
                lane
            })
            .collect();
        let mut across = lane(beyond, 99, vec![DVec3::ZERO, DVec3::X * 10.0], 8.0);
        across.junction = Some(1);
        lanes.push(across);
        RoadNetwork { lanes, ..RoadNetwork::default() }
    }

    fn bars(arriving: &[(u32, f64)]) -> usize {
        draw(&junction_of(arriving), &Signals::default(), &|_| Some((0.0, true))).len()
    }

    #[test]
    fn side_streets_give_way_to_a_fast_street_that_goes_through_not_to_one_that_ends() {
        let (fast, slow) = (13.9, 8.3);
        assert!(bars(&[(1, fast), (2, fast), (3, slow)]) > 0, "both arms of a fast street arrive");
        assert_eq!(bars(&[(1, fast), (2, slow), (3, slow)]), 0, "a fast street ends");
        assert_eq!(bars(&[(1, fast), (1, fast), (2, slow), (3, slow)]), 0, "one of two lanes ends");
        assert!(bars(&[(1, fast), (2, fast)]) > 0, "stop lines where all are fast");
    }
}
