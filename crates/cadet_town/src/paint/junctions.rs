//! Paint where streets meet: stop lines, fords, zebra crossings, and the arrows of lanes.

use crate::network::{Lane, LaneId, PaintColor, PaintedQuad, RoadNetwork};
use crate::paint::{Paint, STOP_LINE_DEPTH_M};
use crate::signals::{FORD_M, JunctionArm, STOP_LINE_M, Signals};
use cadet_base::math::{DVec2, DVec3};

/// Line, gap, and width of the lines along a ford (RMS-1).
const FORD_DASH_M: (f64, f64, f64) = (0.5, 0.2, 0.12);
/// Paint keeps off curbs.
const OFF_CURB_M: f64 = 0.12;
/// Bars and gaps of a zebra crossing.
const ZEBRA_M: (f64, f64) = (0.5, 0.5);
/// Arrows end this far before the stop line, and again so much before that.
const ARROW_BEFORE_M: f64 = 2.5;
const NEXT_ARROW_M: f64 = 22.0;
/// No arrow begins nearer to the street's other end.
const FREE_BEHIND_M: f64 = 4.0;
/// An arrow, its shaft, and half the width of its head.
const ARROW_M: f64 = 5.0;
const SHAFT_M: (f64, f64) = (3.3, 0.075);
const HEAD_M: (f64, f64) = (1.75, 0.3);
/// Ways that bend less than this go straight on.
const STRAIGHT_RAD: f64 = 0.6;
/// Lines across have numbers of their own, beyond those of maps.
const ACROSS: u32 = 1 << 30;

/// The lines at the lights of a town.
pub(crate) fn draw(network: &RoadNetwork, signals: &Signals, paint: &mut Paint) {
    for arm in signals.junctions.iter().flat_map(|j| &j.arms) {
        let line = ACROSS + arm.lanes[0].0 as u32 * 4;
        for id in arm.lanes.iter().chain(&arm.cycle_lanes) {
            stop_line(arm, network.lane(*id), line, paint);
        }
        if arm.has_ford() {
            ford(arm, line + 1, paint);
        }
        // Where there is one lane, all ways begin on it, and arrows would say nothing.
        if arm.lanes.len() > 1 {
            for id in &arm.lanes {
                arrows(network, *id, line + 2, paint);
            }
        }
    }
    for arm in &signals.zebras {
        zebra(arm, ACROSS + arm.lanes[0].0 as u32 * 4 + 3, paint);
    }
}

fn stop_line(arm: &JunctionArm, lane: &Lane, line: u32, paint: &mut Paint) {
    let end = lane.end();
    let half_m = lane.width_at(lane.length_m()) / 2.0;
    let left_m = (end.truncate() - arm.at).dot(arm.along.perp());
    let at = arm.place(STOP_LINE_M.0, left_m).extend(end.z);
    paint.across(at, arm.along.perp(), (0.1 - half_m, half_m - 0.1), STOP_LINE_DEPTH_M, line);
}

/// Two broken lines across the street.
fn ford(arm: &JunctionArm, line: u32, paint: &mut Paint) {
    let (dash_m, gap_m, width_m) = FORD_DASH_M;
    for before_m in [FORD_M.0, FORD_M.1 - width_m] {
        let at = arm.place(before_m, 0.0).extend(arm.z_m);
        let reach_m = (arm.right_m + OFF_CURB_M, arm.left_m - OFF_CURB_M);
        paint.dashes(at, arm.along.perp(), reach_m, (dash_m, gap_m), width_m, line);
    }
}

/// Bars along the street.
fn zebra(arm: &JunctionArm, line: u32, paint: &mut Paint) {
    let at = arm.place(FORD_M.0, 0.0).extend(arm.z_m);
    paint.dashes(at, arm.along.perp(), (arm.right_m + 0.3, arm.left_m - 0.2), ZEBRA_M, FORD_M.1 - FORD_M.0, line);
}

/// Which ways a lane leads: left, straight on, right.
pub(crate) fn ways(network: &RoadNetwork, id: LaneId) -> [bool; 3] {
    let mut ways = [false; 3];
    let from = network.lane(id);
    for next in from.successors.iter().map(|next| network.lane(*next)).filter(|next| next.kind == from.kind) {
        let bend = next.turn_rad();
        let leads = [bend > STRAIGHT_RAD, bend.abs() <= STRAIGHT_RAD, bend < -STRAIGHT_RAD];
        ways.iter_mut().zip(leads).for_each(|(way, leads)| *way |= leads);
    }
    ways
}

fn arrows(network: &RoadNetwork, id: LaneId, line: u32, paint: &mut Paint) {
    let ways = ways(network, id);
    let first_m = STOP_LINE_M.1 + ARROW_BEFORE_M + ARROW_M;
    for tail_m in [first_m, first_m + NEXT_ARROW_M] {
        // Where a street is too short for the second there is none.
        if place(network, id, tail_m + FREE_BEHIND_M, 0.0).is_some() {
            arrow(&|x_m, y_m| place(network, id, tail_m - x_m, y_m), ways, line, paint);
        }
    }
}

/// The place `before_m` before the end of a lane, on it or on those that lead to it alone, and `left_m` to the left of
/// its middle.
fn place(network: &RoadNetwork, id: LaneId, before_m: f64, left_m: f64) -> Option<DVec3> {
    let (mut lane, mut before_m) = (network.lane(id), before_m);
    while before_m > lane.length_m() {
        let [only] = lane.predecessors.as_slice() else { return None };
        before_m -= lane.length_m();
        lane = network.lane(*only);
        if lane.junction.is_some() {
            return None;
        }
    }
    let (middle, left) = lane.middle_and_left(lane.length_m() - before_m);
    Some(middle + (left * left_m).extend(0.0))
}

/// One arrow; `place` is so far ahead of the beginning of its shaft and to its left.
fn arrow(place: &dyn Fn(f64, f64) -> Option<DVec3>, ways: [bool; 3], line: u32, paint: &mut Paint) {
    let mut part = |corners: [(f64, f64); 4]| {
        if let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|(x, y)| place(x, y)) {
            paint.along(&PaintedQuad { corners: [a, b, c, d], color: PaintColor::White, line });
        }
    };
    let (shaft_m, half_m) = SHAFT_M;
    let turns = [(ways[0], 1.0), (ways[2], -1.0)];
    let end_m = if ways[1] { shaft_m } else { shaft_m - 0.3 };
    part([(0.0, -half_m), (end_m, -half_m), (end_m, half_m), (0.0, half_m)]);
    let (head_m, wide_m) = HEAD_M;
    if ways[1] {
        let from_m = ARROW_M - head_m;
        part([(from_m, -wide_m), (ARROW_M, -0.01), (ARROW_M, 0.01), (from_m, wide_m)]);
    }
    for (_, side) in turns.into_iter().filter(|(leads, _)| *leads) {
        // Mirrored corners go round the other way.
        let mut mirrored = |corners: [(f64, f64); 4]| {
            let [a, b, c, d] = corners.map(|(x, y)| (x, y * side));
            part(if side > 0.0 { [a, b, c, d] } else { [d, c, b, a] });
        };
        // Aside a little lower where the shaft goes on, to the end of the shaft where it does not.
        let from_m = if ways[1] { 1.5 } else { 2.7 };
        mirrored([(from_m, -half_m), (from_m + 0.75, 0.40), (from_m + 0.60, 0.52), (from_m - 0.1, half_m)]);
        let base = DVec2::new(from_m + 0.68, 0.46);
        let (ahead, aside) = (DVec2::new(0.5, 0.866), DVec2::new(0.866, -0.5));
        let (p, q, tip) = (base + aside * wide_m, base - aside * wide_m, base + ahead * 0.85);
        let hair = aside * 0.01;
        mirrored([p, tip + hair, tip - hair, q].map(|v| (v.x, v.y)));
    }
}
