//! Whether there is room behind a junction for who crosses it.

use super::request::Request;
use super::reservations::Junctions;
use crate::lane_use::LaneUse;
use crate::params::junctions::LONGEST_TAIL_M;
use crate::slot::Slot;
use crate::streets::LaneGraph;

/// The vehicle that leaves too little room on the lanes after a junction, up to the next one: one that stands there, or
/// one that was promised the room that the lanes have. Trams stand for long at the ends of their lines: behind one that
/// moves, too, another tram finds room or stops before the junction.
pub(super) fn exit_blocked_by(
    own: &Request,
    lane_use: &LaneUse,
    junctions: &Junctions,
    graph: &LaneGraph,
) -> Option<Slot> {
    let exit = *own.exits.first()?;
    let (promised_m, promised_to) = junctions
        .promised(own.slot, exit)
        .fold((0.0, None), |(sum_m, first), (slot, m)| (sum_m + m, first.or(Some(slot))));
    let needed_m = own.room_m + promised_m;
    let mut from_m = 0.0;
    for lane in &own.exits {
        if let Some(last) = lane_use.last_on(*lane, own.slot, own.is_tram) {
            return (from_m + last.tail_m() < needed_m).then_some(last.agent);
        }
        from_m += graph.lane(*lane).length_m();
        if from_m > needed_m + LONGEST_TAIL_M {
            return None;
        }
    }
    promised_to.filter(|_| from_m < needed_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::junctions::reservations::Reservation;
    use crate::lane_use::OnLane;
    use crate::streets::LanePosition;
    use crate::tests::towns::{main_roads, tram_main_roads};
    use cadet_town::{Lane, LaneId, LaneKind};

    /// Whether the room of a vehicle of 20 m on these lanes after a junction is taken, if one of 10 m moves or stands with
    /// its tail so far along them.
    fn taken(graph: &LaneGraph, exits: &[LaneId], is_tram: bool, (tail_m, speed_mps): (f64, f64)) -> bool {
        let own = Request { room_m: 22.0, exits: exits.to_vec(), is_tram, ..Request::of_car(1, &[]) };
        let mut s_m = tail_m + 5.0;
        let mut lanes = exits.iter();
        let mut lane = *lanes.next().unwrap();
        while s_m > graph.lane(lane).length_m() {
            s_m -= graph.lane(lane).length_m();
            lane = *lanes.next().unwrap();
        }
        let mut lane_use = LaneUse::default();
        lane_use.push(OnLane { agent: 2, at: LanePosition { lane, s_m, left_m: 0.0 }, half_length_m: 5.0, speed_mps });
        let by = exit_blocked_by(&own, &lane_use, &Junctions::new(graph), graph);
        assert!(by.is_none_or(|slot| slot == 2));
        by.is_some()
    }

    /// Lanes after a junction up to the next one, the first of them shorter than a vehicle.
    fn exits_in_pieces(graph: &LaneGraph, kind: LaneKind) -> impl Iterator<Item = Vec<LaneId>> {
        let is_first = move |l: &&Lane| {
            let comes_out = l.predecessors.iter().any(|p| graph.lane(*p).junction.is_some());
            l.kind == kind && l.junction.is_none() && comes_out && l.length_m() < 10.0
        };
        graph.lanes().iter().filter(is_first).map(|first| {
            let mut exits = vec![first.id];
            while let Some(next) = graph.lane(exits[exits.len() - 1]).successors.first() {
                if graph.lane(*next).junction.is_some() {
                    break;
                }
                exits.push(*next);
            }
            exits
        })
    }

    #[test]
    fn a_junction_is_kept_free_where_the_lane_behind_it_is_in_pieces() {
        let graph = LaneGraph::new(main_roads(3));
        let mut count = 0;
        for exits in exits_in_pieces(&graph, LaneKind::Driving) {
            count += 1;
            assert!(taken(&graph, &exits, false, (12.0, 0.0)), "{exits:?}: who stands 12 m on");
            assert!(!taken(&graph, &exits, false, (24.0, 0.0)), "{exits:?}: who leaves room");
            assert!(!taken(&graph, &exits, false, (12.0, 5.0)), "{exits:?}: who goes on");
        }
        assert!(count > 3, "{count} such lanes");
    }

    #[test]
    fn a_tram_finds_room_at_the_end_of_its_line_or_keeps_the_junction_free() {
        let mut count = 0;
        for seed in 0..6 {
            let graph = LaneGraph::new(tram_main_roads(seed));
            let ends = exits_in_pieces(&graph, LaneKind::Tram).filter(|exits| {
                let last = graph.lane(exits[exits.len() - 1]);
                last.junction.is_none() && last.successors.is_empty()
            });
            for exits in ends {
                count += 1;
                assert!(taken(&graph, &exits, true, (12.0, 5.0)), "{exits:?}: who will stand");
                assert!(!taken(&graph, &exits, false, (12.0, 5.0)), "{exits:?}: a bus goes on");
                assert!(!taken(&graph, &exits, true, (24.0, 0.0)), "{exits:?}: who leaves room");
            }
        }
        assert!(count > 3, "{count} such ends");
    }

    #[test]
    fn room_that_was_promised_to_somebody_is_nobody_elses() {
        let roads = LaneGraph::new(main_roads(3));
        for exits in exits_in_pieces(&roads, LaneKind::Driving) {
            let room_m = exits.iter().map(|id| roads.lane(*id).length_m()).sum::<f64>() / 2.0 + 1.0;
            let own = Request { room_m, exits: exits.clone(), ..Request::of_car(1, &[]) };
            let mut junctions = Junctions::new(&roads);
            assert_eq!(exit_blocked_by(&own, &LaneUse::default(), &junctions, &roads), None);
            let (lane, tail_m, clear_at_m) = (exits[0], f64::NEG_INFINITY, None);
            junctions.held.push(Reservation { slot: 2, lane, since_step: 0, exit: lane, room_m, tail_m, clear_at_m });
            assert_eq!(exit_blocked_by(&own, &LaneUse::default(), &junctions, &roads), Some(2), "{exits:?}");
        }
    }
}
