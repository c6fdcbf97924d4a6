//! Writes a street plan and its relief as OpenDRIVE 1.7.

use std::fmt::Write;

use super::plan_curve::PlanCurve;
use super::relief::Relief;
use super::street_plan::{End, Street, StreetPlan, Turn};
use crate::math;

/// The curb swings out into the bay over this length.
const BAY_TAPER_M: f64 = 2.5;
/// A street's slope across grows from its ends to the full over this length.
const CROSSFALL_RAMP_M: f64 = 20.0;
/// Height of a curb: a sidewalk's lane lies this much above the carriageway.
pub(super) const CURB_HEIGHT_M: f64 = 0.12;

/// A cubic a + b s + c s^2 + d s^3 from `s` on.
struct Cubic {
    s: f64,
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Cubic {
    fn constant(a: f64) -> Self {
        Self { s: 0.0, a, b: 0.0, c: 0.0, d: 0.0 }
    }

    /// From value `z0` with slope `m0` to `z1` with slope `m1` over `length`.
    fn hermite(s: f64, length: f64, (z0, m0): (f64, f64), (z1, m1): (f64, f64)) -> Self {
        let rise = (z1 - z0) / length;
        let c = (3.0 * rise - 2.0 * m0 - m1) / length;
        let d = (m0 + m1 - 2.0 * rise) / (length * length);
        Self { s, a: z0, b: m0, c, d }
    }

    fn write(&self, out: &mut String, element: &str, s_name: &str) {
        let Self { s, a, b, c, d } = self;
        put(
            out,
            format_args!("<{element} {s_name}=\"{s:.5}\" a=\"{a:.6}\" b=\"{b:.8}\" c=\"{c:.9}\" d=\"{d:.10}\"/>\n"),
        );
    }
}

/// Writing to a `String` can't fail.
fn put(out: &mut String, text: std::fmt::Arguments<'_>) {
    let _ = out.write_fmt(text);
}

struct LaneRecord {
    id: i32,
    kind: &'static str,
    widths: Vec<Cubic>,
    raised: bool,
    predecessor: Option<i32>,
    successor: Option<i32>,
}

struct Section {
    s: f64,
    lanes: Vec<LaneRecord>,
}

/// The whole document. Streets have ids from 1 on, turns follow; junctions have ids from 1 on.
///
/// `crossfall` holds each street's slope across, up to the left.
pub(super) fn write(name: &str, plan: &StreetPlan, relief: &Relief, crossfall: &[f64]) -> String {
    let mut out = String::with_capacity(1 << 20);
    out.push_str("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n");
    put(
        &mut out,
        format_args!("<header revMajor=\"1\" revMinor=\"7\" name=\"{name}\" version=\"1.00\" vendor=\"cadet\"/>\n"),
    );
    for (i, (street, fall)) in plan.streets.iter().zip(crossfall).enumerate() {
        write_street(&mut out, i, street, relief, *fall);
    }
    for (i, turn) in plan.turns.iter().enumerate() {
        write_turn(&mut out, plan, i, turn, relief);
    }
    for junction in 0..plan.num_junctions {
        write_junction(&mut out, plan, junction);
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

/// The lane that traffic arrives on at a street's end, and the one that it leaves on.
fn lanes_at(end: End) -> (i32, i32) {
    match end {
        End::Start => (1, -1),
        End::Finish => (-1, 1),
    }
}

fn contact(end: End) -> &'static str {
    match end {
        End::Start => "start",
        End::Finish => "end",
    }
}

/// The sidewalk's lane beside the carriageway's at a street's end.
fn sidewalk_beside(lane: i32) -> i32 {
    2 * lane
}

fn write_street(out: &mut String, index: usize, street: &Street, relief: &Relief, crossfall: f64) {
    let [from, to] = street.junctions;
    let length = street.curve.length_m();
    put(
        out,
        format_args!(
            "<road name=\"\" length=\"{length:.6}\" id=\"{}\" junction=\"-1\" rule=\"RHT\">\n<link>\
             <predecessor elementType=\"junction\" elementId=\"{}\"/>\
             <successor elementType=\"junction\" elementId=\"{}\"/></link>\n",
            street_id(index),
            from + 1,
            to + 1
        ),
    );
    write_type(out, street.speed_kmh);
    write_shape(out, &street.curve, relief, crossfall);
    write_lanes(out, &street_sections(street), street.speed_kmh > 30);
    out.push_str("</road>\n");
}

fn write_type(out: &mut String, speed_kmh: u32) {
    let kind = if speed_kmh > 30 { "townCollector" } else { "lowSpeed" };
    put(out, format_args!("<type s=\"0.0\" type=\"{kind}\"><speed max=\"{speed_kmh}\" unit=\"km/h\"/></type>\n"));
}

fn street_sections(street: &Street) -> Vec<Section> {
    let side = |sign: i32, bay: Option<f64>, before: bool, after: bool, has_bay: &dyn Fn(bool) -> bool| {
        let mut lanes = vec![LaneRecord {
            id: sign,
            kind: "driving",
            widths: vec![Cubic::constant(street.lane_width_m)],
            raised: false,
            predecessor: before.then_some(sign),
            successor: after.then_some(sign),
        }];
        if let Some(length) = bay {
            let bay_m = street.bay_widths_m[usize::from(sign > 0)];
            lanes.push(LaneRecord {
                id: 2 * sign,
                kind: "parking",
                widths: vec![
                    Cubic::hermite(0.0, BAY_TAPER_M, (0.0, 0.0), (bay_m, 0.0)),
                    Cubic { s: BAY_TAPER_M, ..Cubic::constant(bay_m) },
                    Cubic::hermite(length - BAY_TAPER_M, BAY_TAPER_M, (bay_m, 0.0), (0.0, 0.0)),
                ],
                raised: false,
                predecessor: None,
                successor: None,
            });
        }
        // Bays take number 2 in the middle section, which moves the sidewalk to 3.
        let number = |in_bay_section: bool| sign * if in_bay_section && has_bay(sign < 0) { 3 } else { 2 };
        let in_bays = bay.is_some() || (before && after);
        lanes.push(LaneRecord {
            id: number(in_bays),
            kind: "sidewalk",
            widths: vec![Cubic::constant(street.sidewalk_width_m)],
            raised: true,
            predecessor: before.then(|| number(!in_bays)),
            successor: after.then(|| number(!in_bays)),
        });
        lanes
    };
    let has_bay = |right: bool| street.bays.is_some() && street.bay_widths_m[usize::from(!right)] > 0.0;
    let section = |s: f64, bay: Option<f64>, before: bool, after: bool| {
        let mut lanes = side(1, bay.filter(|_| has_bay(false)), before, after, &has_bay);
        lanes.reverse();
        lanes.extend(side(-1, bay.filter(|_| has_bay(true)), before, after, &has_bay));
        Section { s, lanes }
    };
    match street.bays {
        None => vec![section(0.0, None, false, false)],
        Some((from, to)) => vec![
            section(0.0, None, false, true),
            section(from, Some(to - from), true, true),
            section(to, None, true, false),
        ],
    }
}

fn write_turn(out: &mut String, plan: &StreetPlan, index: usize, turn: &Turn, relief: &Relief) {
    let ((from, from_end), (to, to_end)) = (turn.from, turn.to);
    let (a, b) = (&plan.streets[from], &plan.streets[to]);
    let length = turn.curve.length_m();
    put(
        out,
        format_args!(
            "<road name=\"\" length=\"{length:.6}\" id=\"{}\" junction=\"{}\" rule=\"RHT\">\n<link>\
             <predecessor elementType=\"road\" elementId=\"{}\" contactPoint=\"{}\"/>\
             <successor elementType=\"road\" elementId=\"{}\" contactPoint=\"{}\"/></link>\n",
            turn_id(plan, index),
            turn.junction + 1,
            street_id(from),
            contact(from_end),
            street_id(to),
            contact(to_end)
        ),
    );
    write_type(out, a.speed_kmh.min(b.speed_kmh));
    // Crossings lie level: a street's crossfall begins and ends with its own piece.
    write_shape(out, &turn.curve, relief, 0.0);
    let (arrives, leaves) = (lanes_at(from_end).0, lanes_at(to_end).1);
    let blend = |x: f64, y: f64| vec![Cubic::hermite(0.0, length, (x, 0.0), (y, 0.0))];
    let mut lanes = vec![LaneRecord {
        id: -1,
        kind: "driving",
        widths: blend(a.lane_width_m, b.lane_width_m),
        raised: false,
        predecessor: Some(arrives),
        successor: Some(leaves),
    }];
    if turn.along_curb {
        lanes.push(LaneRecord {
            id: -2,
            kind: "sidewalk",
            widths: blend(a.sidewalk_width_m, b.sidewalk_width_m),
            raised: true,
            predecessor: Some(sidewalk_beside(arrives)),
            successor: Some(sidewalk_beside(leaves)),
        });
    }
    write_lanes(out, &[Section { s: 0.0, lanes }], false);
    out.push_str("</road>\n");
}

fn write_junction(out: &mut String, plan: &StreetPlan, junction: usize) {
    put(out, format_args!("<junction name=\"\" id=\"{}\">\n", junction + 1));
    let here = plan.turns.iter().enumerate().filter(|(_, t)| t.junction == junction);
    for (number, (index, turn)) in here.enumerate() {
        let arrives = lanes_at(turn.from.1).0;
        put(
            out,
            format_args!(
                "<connection id=\"{number}\" incomingRoad=\"{}\" connectingRoad=\"{}\" contactPoint=\"start\">\
                 <laneLink from=\"{arrives}\" to=\"-1\"/>",
                street_id(turn.from.0),
                turn_id(plan, index)
            ),
        );
        if turn.along_curb {
            put(out, format_args!("<laneLink from=\"{}\" to=\"-2\"/>", sidewalk_beside(arrives)));
        }
        out.push_str("</connection>\n");
    }
    out.push_str("</junction>\n");
}

/// Plan view, elevation along the reference line, and superelevation, which lays the lanes on the relief and adds the
/// street's crossfall.
fn write_shape(out: &mut String, curve: &PlanCurve, relief: &Relief, crossfall: f64) {
    out.push_str("<planView>\n");
    let mut s = 0.0;
    for g in &curve.segments {
        let (x, y, hdg) = (g.start.at.x, g.start.at.y, g.start.heading_rad);
        let length = g.length_m;
        put(
            out,
            format_args!("<geometry s=\"{s:.6}\" x=\"{x:.6}\" y=\"{y:.6}\" hdg=\"{hdg:.10}\" length=\"{length:.6}\">"),
        );
        if g.curvature == 0.0 {
            out.push_str("<line/>");
        } else {
            put(out, format_args!("<arc curvature=\"{:.12}\"/>", g.curvature));
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
        math::atan(relief.gradient(pose.at).dot(pose.direction().perp()) + crossfall * crossfall_share(s, length))
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

/// Share of its crossfall that a street has at `s`: none at its ends, all from [`CROSSFALL_RAMP_M`] inside.
fn crossfall_share(s: f64, length: f64) -> f64 {
    let t = (s.min(length - s) / CROSSFALL_RAMP_M.min(length / 2.0)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn write_lanes(out: &mut String, sections: &[Section], center_line: bool) {
    out.push_str("<lanes>\n");
    for section in sections {
        put(out, format_args!("<laneSection s=\"{:.6}\">\n", section.s));
        let side = |out: &mut String, name: &str, keep: &dyn Fn(i32) -> bool| {
            if section.lanes.iter().any(|l| keep(l.id)) {
                put(out, format_args!("<{name}>\n"));
                section.lanes.iter().filter(|l| keep(l.id)).for_each(|l| write_lane(out, l));
                put(out, format_args!("</{name}>\n"));
            }
        };
        side(out, "left", &|id| id > 0);
        let mark = if center_line { "broken" } else { "none" };
        put(
            out,
            format_args!(
                "<center><lane id=\"0\" type=\"none\" level=\"false\">\
                 <roadMark sOffset=\"0.0\" type=\"{mark}\" color=\"white\" width=\"0.12\"/></lane></center>\n"
            ),
        );
        side(out, "right", &|id| id < 0);
        out.push_str("</laneSection>\n");
    }
    out.push_str("</lanes>\n");
}

fn write_lane(out: &mut String, lane: &LaneRecord) {
    put(out, format_args!("<lane id=\"{}\" type=\"{}\" level=\"false\">\n<link>", lane.id, lane.kind));
    for (element, id) in [("predecessor", lane.predecessor), ("successor", lane.successor)] {
        if let Some(id) = id {
            put(out, format_args!("<{element} id=\"{id}\"/>"));
        }
    }
    out.push_str("</link>\n");
    for width in &lane.widths {
        width.write(out, "width", "sOffset");
    }
    if lane.raised {
        put(out, format_args!("<height sOffset=\"0.0\" inner=\"{CURB_HEIGHT_M}\" outer=\"{CURB_HEIGHT_M}\"/>\n"));
    }
    out.push_str("</lane>\n");
}
