//! Whether there is room behind a junction for who crosses it.

use super::approach::Crossing;
use crate::town::LaneId;
use crate::world::junctions::Junctions;
use crate::world::lane_use::LaneUse;
use crate::world::roads::Roads;
use crate::world::slot::Slot;

/// Trams that have no more than this of their line before them reckon with others standing at its end.
const NEAR_LINE_END_M: f64 = 200.0;
/// From the middle to the end of the longest vehicle.
const LONGEST_TAIL_M: f64 = 9.0;

/// Who leaves too little room on the lanes after a junction, up to the next one. At the end of its line a tram stands for
/// long: the next finds room behind it, or stops before the junction.
pub(super) fn exit_blocked_by(
    own: &Crossing<'_>,
    exits: &[LaneId],
    room_m: f64,
    lane_use: &LaneUse,
    junctions: &Junctions,
    roads: &Roads,
) -> Option<Slot> {
    let exit = *exits.first()?;
    let (promised_m, promised_to) = junctions
        .promised(own.slot, exit)
        .fold((0.0, None), |(sum_m, first), (car, m)| (sum_m + m, first.or(Some(car))));
    let needed_m = room_m + promised_m;
    let is_end = own.is_tram && own.route.remaining_m(roads) < NEAR_LINE_END_M;
    let mut from_m = 0.0;
    for lane in exits.iter().take_while(|l| roads.lane(**l).junction.is_none()) {
        if let Some(last) = lane_use.last_on(*lane, own.slot, is_end) {
            return (from_m + last.tail_m() < needed_m).then_some(last.agent);
        }
        from_m += roads.lane(*lane).length_m();
        if from_m > needed_m + LONGEST_TAIL_M {
            return None;
        }
    }
    promised_to.filter(|_| is_end && from_m < needed_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec2;
    use crate::town::{Lane, LaneKind};
    use crate::world::footprint::Footprint;
    use crate::world::lane_use::OnLane;
    use crate::world::route::Route;
    use crate::world::tests::towns::{main_roads, tram_main_roads};
    use crate::world::track::Track;

    /// Whether the room of a vehicle of 20 m on these lanes after a junction is taken, if one of 10 m moves or stands with
    /// its tail so far along them.
    fn taken(roads: &Roads, route: &Route, exits: &[LaneId], is_tram: bool, (tail_m, speed_mps): (f64, f64)) -> bool {
        let footprint = Footprint {
            center: DVec2::ZERO,
            heading: DVec2::X,
            half_length_m: 10.0,
            half_width_m: 1.2,
            velocity: DVec2::ZERO,
        };
        let own = Crossing { slot: 1, route, footprint: &footprint, axles: None, length_m: 20.0, is_tram };
        let mut s_m = tail_m + 5.0;
        let mut lanes = exits.iter();
        let mut lane = *lanes.next().unwrap();
        while s_m > roads.lane(lane).length_m() {
            s_m -= roads.lane(lane).length_m();
            lane = *lanes.next().unwrap();
        }
        let mut lane_use = LaneUse::default();
        lane_use.push(OnLane { lane, agent: 2, s_m, half_length_m: 5.0, speed_mps });
        let by = exit_blocked_by(&own, exits, 22.0, &lane_use, &Junctions::new(roads), roads);
        assert!(by.is_none_or(|slot| slot == 2));
        by.is_some()
    }

    /// Lanes after a junction up to the next one, the first of them shorter than a vehicle.
    fn exits_in_pieces(roads: &Roads, kind: LaneKind) -> impl Iterator<Item = Vec<LaneId>> {
        let is_first = move |l: &&Lane| {
            let comes_out = l.predecessors.iter().any(|p| roads.lane(*p).junction.is_some());
            l.kind == kind && l.junction.is_none() && comes_out && l.length_m() < 10.0
        };
        roads.lanes().iter().filter(is_first).map(|first| {
            let mut exits = vec![first.id];
            while let Some(next) = roads.lane(exits[exits.len() - 1]).successors.first() {
                exits.push(*next);
                if roads.lane(*next).junction.is_some() {
                    break;
                }
            }
            exits
        })
    }

    #[test]
    fn a_junction_is_kept_free_where_the_lane_behind_it_is_in_pieces() {
        let roads = Roads::new(main_roads(3));
        let route = Route::along([LaneId(0)].into(), 0.0);
        let mut count = 0;
        for exits in exits_in_pieces(&roads, LaneKind::Driving) {
            count += 1;
            assert!(taken(&roads, &route, &exits, false, (12.0, 0.0)), "{exits:?}: who stands 12 m on");
            assert!(!taken(&roads, &route, &exits, false, (24.0, 0.0)), "{exits:?}: who leaves room");
            assert!(!taken(&roads, &route, &exits, false, (12.0, 5.0)), "{exits:?}: who goes on");
        }
        assert!(count > 3, "{count} such lanes");
    }

    #[test]
    fn a_tram_finds_room_at_the_end_of_its_line_or_keeps_the_junction_free() {
        let mut count = 0;
        for seed in 0..6 {
            let roads = Roads::new(tram_main_roads(seed));
            let ends = exits_in_pieces(&roads, LaneKind::Tram).filter(|exits| {
                let last = roads.lane(exits[exits.len() - 1]);
                last.junction.is_none() && last.successors.is_empty()
            });
            for exits in ends {
                let length_m: f64 = exits.iter().map(|l| roads.lane(*l).length_m()).sum();
                let track = Track::through(exits[0], &roads);
                let route = Route::along(track.lanes_from(track.length_m() - length_m - 1.0), 0.0);
                count += 1;
                assert!(taken(&roads, &route, &exits, true, (12.0, 5.0)), "{exits:?}: who will stand");
                assert!(!taken(&roads, &route, &exits, false, (12.0, 5.0)), "{exits:?}: a bus goes on");
                assert!(!taken(&roads, &route, &exits, true, (24.0, 0.0)), "{exits:?}: who leaves room");
            }
        }
        assert!(count > 3, "{count} such ends");
    }
}
