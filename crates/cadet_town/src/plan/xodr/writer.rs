//! Writes a street plan and its relief as OpenDRIVE 1.7.

use crate::network::LaneSurface;
use crate::plan::junction::{CycleTurn, PlannedTurn, Roundabout, StreetEnd};
use crate::plan::xodr::{
    CYCLE_FORD_M, Cubic, LaneRecord, Link, OuterLine, Section, begin_document, begin_road, driven_surface, driving_id,
    outermost_lane, put, ridden_id, sidewalk_id, street_sections, write_controllers, write_junction_controllers,
    write_lanes, write_signals, write_type,
};
use crate::plan::{LineStyle, PlanCurve, Relief, Street, StreetKind, StreetPlan, WhichEnd};
use cadet_base::math;

/// A lane has to have an inner edge: an island's is a circle of this radius.
const ISLAND_MIDDLE_M: f64 = 0.5;

/// A street's slope across grows from its ends to the full over this length.
const CROSSFALL_RAMP_M: f64 = 20.0;

/// The whole document. Streets have ids from 1 on, turns follow, those of bicycles last; junctions have ids from 1 on.
///
/// `crossfall` holds each street's slope across, up to the left.
pub(crate) fn write(name: &str, plan: &StreetPlan, relief: &Relief, crossfall: &[f64]) -> String {
    let mut out = begin_document(name);
    for (i, (street, fall)) in plan.streets.iter().zip(crossfall).enumerate() {
        write_street(&mut out, (plan, i), street, relief, *fall);
    }
    for (i, turn) in plan.turns.iter().enumerate() {
        write_turn(&mut out, plan, i, turn, relief);
    }
    for (i, turn) in plan.cycle_turns.iter().enumerate() {
        write_cycle_turn(&mut out, plan, i, turn, relief);
    }
    for (junction, ring) in plan.roundabouts.iter().enumerate().filter_map(|(j, ring)| Some((j, ring.as_ref()?))) {
        write_island(&mut out, cycle_turn_id(plan, plan.cycle_turns.len() + junction), ring, relief);
    }
    write_controllers(&mut out, plan);
    for junction in 0..plan.num_junctions {
        write_junction(&mut out, plan, junction);
    }
    for junction in (0..plan.num_junctions).filter(|j| plan.roundabouts[*j].is_some()) {
        put!(
            &mut out,
            "<junctionGroup name=\"\" id=\"{0}\" type=\"roundabout\"><junctionReference junction=\"{0}\"/>\
                 </junctionGroup>\n",
            junction + 1
        );
    }
    out.push_str("</OpenDRIVE>\n");
    out
}

fn street_id(street: usize) -> usize {
    street + 1
}

fn turn_id(plan: &StreetPlan, turn: usize) -> usize {
    plan.streets.len() + turn + 1
}

fn cycle_turn_id(plan: &StreetPlan, turn: usize) -> usize {
    turn_id(plan, plan.turns.len() + turn)
}

/// The sign of the ids of the lanes that traffic arrives on at a street's end; it leaves on those of the other sign.
fn arriving_sign(end: WhichEnd) -> i32 {
    match end {
        WhichEnd::Start => 1,
        WhichEnd::Finish => -1,
    }
}

fn write_street(
    out: &mut String,
    (plan, index): (&StreetPlan, usize),
    street: &Street,
    relief: &Relief,
    crossfall: f64,
) {
    let length = street.curve.length_m();
    begin_road(out, street_id(index), length, None, street.junctions.map(Link::Junction));
    write_street_type(out, &street.style, street.style.speed_kmh);
    write_shape(out, &street.curve, relief, &|s| crossfall * crossfall_share(s, length));
    write_lanes(out, &street_sections(street));
    write_signals(out, plan, index);
    out.push_str("</road>\n");
}

fn write_street_type(out: &mut String, style: &LineStyle, speed_kmh: u32) {
    let kind = if style.country.is_some() {
        "rural"
    } else if style.kind == StreetKind::Aisle {
        "townPrivate"
    } else if style.kind == StreetKind::Campus {
        "pedestrian"
    } else if speed_kmh > 30 {
        "townCollector"
    } else {
        "lowSpeed"
    };
    write_type(out, kind, speed_kmh);
}

fn write_turn(out: &mut String, plan: &StreetPlan, index: usize, turn: &PlannedTurn, relief: &Relief) {
    let (a, b) = (&plan.streets[turn.from.street].style, &plan.streets[turn.to.street].style);
    let length = turn.curve.length_m();
    write_way(out, plan, (turn_id(plan, index), turn.junction), [turn.from, turn.to], (&turn.curve, relief));
    let (arrives, leaves) = (arriving_sign(turn.from.end), -arriving_sign(turn.to.end));
    let lane = |id: i32, kind: &'static str, [at_start_m, at_end_m]: [f64; 2], links: Option<[i32; 2]>| LaneRecord {
        predecessor: links.map(|[from, _]| from),
        successor: links.map(|[_, to]| to),
        ..LaneRecord::new(id, kind, vec![Cubic::hermite(0.0, length, (at_start_m, 0.0), (at_end_m, 0.0))])
    };
    let mut lanes = Vec::new();
    if turn.paved_left_m.iter().any(|m| *m > 0.0) {
        lanes.push(lane(1, "restricted", turn.paved_left_m, None));
    }
    if turn.is_track {
        let tracks_m = [a.median_width_m / 2.0, b.median_width_m / 2.0];
        lanes.push(lane(-1, "tram", tracks_m, Some([arrives, leaves])));
    } else {
        let driven = [driving_id(a, arrives, turn.lanes[0]), driving_id(b, leaves, turn.lanes[1])];
        let widths_m = [a.lane_width_m, b.lane_width_m];
        let mut record = LaneRecord { surface: driven_surface(a), ..lane(-1, "driving", widths_m, Some(driven)) };
        if let Some(ring) = turn.on_ring {
            record.widths = Cubic::plateau((ring.from_m, ring.to_m, length), ring.lane_m, widths_m);
        }
        lanes.push(record);
    }
    if turn.along_curb {
        let walked = [sidewalk_id(a, arrives), sidewalk_id(b, leaves)];
        let (kind, surface) = outermost_lane(a);
        let widths_m = [a.sidewalk_width_m, b.sidewalk_width_m];
        let cycle_m = [a, b].map(|style| style.cycle_lane.map_or(0.0, |c| c.width_m));
        if turn_walk_id(plan, turn) < -2 {
            lanes.push(lane(-2, "restricted", cycle_m, None));
        }
        lanes.push(LaneRecord { surface, ..lane(turn_walk_id(plan, turn), kind, widths_m, Some(walked)) });
    }
    write_lanes(out, &[Section { s_m: 0.0, center_line_m: None, lanes }]);
    out.push_str("</road>\n");
}

/// The island of a roundabout: a road that closes on itself, of which there is a median alone.
fn write_island(out: &mut String, id: usize, ring: &Roundabout, relief: &Relief) {
    let curve = ring.island();
    begin_road(out, id, curve.length_m(), None, [Link::None; 2]);
    write_shape(out, &curve, relief, &|_| 0.0);
    let lanes = vec![LaneRecord::new(1, "median", vec![Cubic::constant(ring.island_m - ISLAND_MIDDLE_M)])];
    write_lanes(out, &[Section { s_m: 0.0, center_line_m: None, lanes }]);
    out.push_str("</road>\n");
}

/// Id of the sidewalk's lane of a turn along a curb: beyond the strip of road that cycle lanes go on as.
fn turn_walk_id(plan: &StreetPlan, turn: &PlannedTurn) -> i32 {
    let has_cycle_lane = |at: StreetEnd| plan.streets[at.street].style.cycle_lane.is_some();
    if has_cycle_lane(turn.from) || has_cycle_lane(turn.to) { -3 } else { -2 }
}

/// A way of bicycles through a junction, a road of its own.
fn write_cycle_turn(out: &mut String, plan: &StreetPlan, index: usize, turn: &CycleTurn, relief: &Relief) {
    write_way(out, plan, (cycle_turn_id(plan, index), turn.junction), [turn.from, turn.to], (&turn.curve, relief));
    let [a, b] = [turn.from, turn.to].map(|at| &plan.streets[at.street].style);
    let (length, [at_start_m, at_end_m]) = (turn.curve.length_m(), turn.widths_m);
    let lane = LaneRecord {
        surface: if turn.is_red { LaneSurface::Red } else { LaneSurface::Usual },
        outer_line: if turn.has_lines { OuterLine::CycleFord } else { OuterLine::None },
        predecessor: Some(ridden_id(a, arriving_sign(turn.from.end))),
        successor: Some(ridden_id(b, -arriving_sign(turn.to.end))),
        ..LaneRecord::new(-1, "biking", vec![Cubic::hermite(0.0, length, (at_start_m, 0.0), (at_end_m, 0.0))])
    };
    let center_line_m = turn.has_lines.then_some(CYCLE_FORD_M);
    write_lanes(out, &[Section { s_m: 0.0, center_line_m, lanes: vec![lane] }]);
    out.push_str("</road>\n");
}

/// The head of a road through a junction: its number, the streets that it joins, its speed, and its shape.
fn write_way(
    out: &mut String,
    plan: &StreetPlan,
    (id, junction): (usize, usize),
    [from, to]: [StreetEnd; 2],
    (curve, relief): (&PlanCurve, &Relief),
) {
    let (a, b) = (&plan.streets[from.street].style, &plan.streets[to.street].style);
    let links = [from, to].map(|at| Link::Road(street_id(at.street), at.end));
    begin_road(out, id, curve.length_m(), Some(junction), links);
    write_street_type(out, a, a.speed_kmh.min(b.speed_kmh));
    // Crossings lie level: a street's crossfall begins and ends with its own piece.
    write_shape(out, curve, relief, &|_| 0.0);
}

fn write_junction(out: &mut String, plan: &StreetPlan, junction: usize) {
    put!(out, "<junction name=\"\" id=\"{}\">\n", junction + 1);
    let mut number = 0;
    let mut connect = |out: &mut String, from: StreetEnd, way: usize, links: &[(i32, i32)]| {
        let road = street_id(from.street);
        put!(
            out,
            "<connection id=\"{number}\" incomingRoad=\"{road}\" connectingRoad=\"{way}\" contactPoint=\"start\">"
        );
        for (from, to) in links {
            put!(out, "<laneLink from=\"{from}\" to=\"{to}\"/>");
        }
        out.push_str("</connection>\n");
        number += 1;
    };
    let style_and_sign = |from: StreetEnd| (&plan.streets[from.street].style, arriving_sign(from.end));
    for (index, turn) in plan.turns.iter().enumerate().filter(|(_, t)| t.junction == junction) {
        let (style, sign) = style_and_sign(turn.from);
        let arrives = if turn.is_track { sign } else { driving_id(style, sign, turn.lanes[0]) };
        let links = [(arrives, -1), (sidewalk_id(style, sign), turn_walk_id(plan, turn))];
        let links = if turn.along_curb { &links[..] } else { &links[..1] };
        connect(out, turn.from, turn_id(plan, index), links);
    }
    for (index, turn) in plan.cycle_turns.iter().enumerate().filter(|(_, t)| t.junction == junction) {
        let (style, sign) = style_and_sign(turn.from);
        connect(out, turn.from, cycle_turn_id(plan, index), &[(ridden_id(style, sign), -1)]);
    }
    write_junction_controllers(out, plan, junction);
    out.push_str("</junction>\n");
}

/// Plan view, elevation along the reference line, and superelevation, which lays the lanes on the relief and adds the
/// street's crossfall, given at distances along it.
pub(crate) fn write_shape(out: &mut String, curve: &PlanCurve, relief: &Relief, crossfall: &dyn Fn(f64) -> f64) {
    out.push_str("<planView>\n");
    let mut s = 0.0;
    for g in &curve.segments {
        let (x, y, hdg) = (g.start.at.x, g.start.at.y, g.start.heading_rad);
        let length = g.length_m;
        put!(out, "<geometry s=\"{s:.6}\" x=\"{x:.6}\" y=\"{y:.6}\" hdg=\"{hdg:.10}\" length=\"{length:.6}\">");
        if g.curvature_per_m == 0.0 {
            out.push_str("<line/>");
        } else {
            put!(out, "<arc curvature=\"{:.12}\"/>", g.curvature_per_m);
        }
        out.push_str("</geometry>\n");
        s += length;
    }
    out.push_str("</planView>\n");
    let length = curve.length_m();
    let step = if curve.min_radius_m() < 60.0 { 3.0 } else { 15.0 };
    let count = (length / step).ceil().max(1.0) as usize;
    let knots: Vec<f64> = (0..=count).map(|i| length * i as f64 / count as f64).collect();
    let tilt = |s: f64| {
        let pose = curve.pose_at(s);
        math::atan(relief.gradient(pose.at).dot(pose.direction().perp()) + crossfall(s))
    };
    let along = |s: f64| {
        let pose = curve.pose_at(s);
        (relief.height(pose.at), relief.gradient(pose.at).dot(pose.direction()))
    };
    let across = |s: f64| {
        let (a, b) = ((s - 0.2).max(0.0), (s + 0.2).min(length));
        (tilt(s), (tilt(b) - tilt(a)) / (b - a))
    };
    let profile = |out: &mut String, element: &str, value: &dyn Fn(f64) -> (f64, f64)| {
        for pair in knots.windows(2) {
            Cubic::hermite(pair[0], pair[1] - pair[0], value(pair[0]), value(pair[1])).write(out, element, "s");
        }
    };
    out.push_str("<elevationProfile>\n");
    profile(out, "elevation", &along);
    out.push_str("</elevationProfile>\n<lateralProfile>\n");
    profile(out, "superelevation", &across);
    out.push_str("</lateralProfile>\n");
}

/// Share of its crossfall that a street has at `s_m`: none at its ends, all from [`CROSSFALL_RAMP_M`] inside.
fn crossfall_share(s_m: f64, length_m: f64) -> f64 {
    let t = (s_m.min(length_m - s_m) / CROSSFALL_RAMP_M.min(length_m / 2.0)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
