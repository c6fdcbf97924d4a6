//! Where a route turns off, and what who follows it shows of that beforehand.

use crate::look::TurnSignal;
use crate::params::TURNS_RAD;
use crate::streets::{LaneGraph, Route};
use cadet_base::math::{self, DVec2};

/// Leaving a roundabout begins so far before its lane's end.
const LEAVING_M: f64 = 14.0;
/// Drivers signal so long before a junction, from within these distances of it.
const AHEAD_S: f64 = 3.5;
const AHEAD_M: (f64, f64) = (30.0, 50.0);

/// The next junction of a route, if it is turned off there: how far away it begins, below 0 inside it, and to which side.
/// A roundabout is turned off from at its end, to the curb's side; entering it is no turning (StVO 8 (1a)).
pub(crate) fn turn_ahead(route: &Route, graph: &LaneGraph) -> Option<(f64, TurnSignal)> {
    let mut start_m = -route.s_m;
    let mut through: Option<(f64, DVec2, DVec2)> = None;
    for id in &route.lanes {
        let lane = graph.lane(*id);
        if through.is_none() && graph.is_in_roundabout(*id) {
            let leaves_in_m = start_m + lane.length_m() - LEAVING_M;
            return (leaves_in_m <= 0.0).then_some((leaves_in_m, TurnSignal::toward(lane.curb_side())));
        }
        match (&mut through, lane.junction) {
            (None, Some(_)) => through = Some((start_m, lane.start_tangent(), lane.end_tangent())),
            (Some((.., out)), Some(_)) => *out = lane.end_tangent(),
            (None, None) if start_m + lane.length_m() > AHEAD_M.1 => return None,
            (None, None) => {}
            (Some(_), None) => break,
        }
        start_m += lane.length_m();
    }
    let (distance_m, entering, leaving) = through?;
    let turn_rad = math::turn_rad(entering, leaving);
    (turn_rad.abs() > TURNS_RAD).then_some((distance_m, TurnSignal::toward(turn_rad)))
}

/// What a driver at a speed shows of the next junction; who has begun goes on.
pub(crate) fn signal_for(route: &Route, speed_mps: f64, shown: TurnSignal, graph: &LaneGraph) -> TurnSignal {
    let Some((distance_m, side)) = turn_ahead(route, graph) else { return TurnSignal::Off };
    let from_m = if shown == side { AHEAD_M.1 } else { (AHEAD_S * speed_mps).clamp(AHEAD_M.0, AHEAD_M.1) };
    if distance_m < from_m { side } else { TurnSignal::Off }
}
