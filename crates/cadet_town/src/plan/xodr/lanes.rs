//! The lanes of a street as OpenDRIVE: median, driving lanes, parking bays, sidewalk, and the lines between them.

use crate::network::{CURB_HEIGHT_M, LaneSurface};
use crate::plan::xodr::{Cubic, put};
use crate::plan::{EDGE_LINE_INSET_M, LineStyle, Street, StreetKind, country_roads};

/// The curb swings out into the bay over this length.
const BAY_TAPER_M: f64 = 2.5;
/// Narrower carriageways have no center line.
const CENTER_LINE_FROM_M: f64 = 5.5;
/// Line and gap of a broken line in town, its width, and where the first begins (RMS-1, German guideline for markings).
const DASH_M: (f64, f64) = (3.0, 6.0);
const LINE_WIDTH_M: f64 = 0.12;
const FIRST_DASH_M: f64 = 1.0;
/// Line and gap of a broken line on motorways, its width, and the width of the line along a hard shoulder (RMS-1).
const MOTORWAY_DASH_M: (f64, f64) = (6.0, 12.0);
const MOTORWAY_LINE_M: f64 = 0.15;
const WIDE_LINE_M: f64 = 0.3;
/// The line beside a cycle lane: wide where cars keep off it; line, gap, and width where they may use it; and line, gap, and
/// width of those along it over a junction.
const CYCLE_LINE_M: f64 = 0.25;
const ADVISORY_DASH_M: (f64, f64) = (1.0, 1.0);
pub(crate) const CYCLE_FORD_M: (f64, f64, f64) = (0.5, 0.25, 0.25);

/// Line that is painted along the outer border of a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OuterLine {
    None,
    Broken,
    /// The line along the edge of a carriageway, a little inside of it.
    Edge,
    /// Between the lanes of a motorway, beside its median, and beside its hard shoulder.
    Motorway,
    Narrow,
    Wide,
    /// Beside a cycle lane: of one for bicycles alone, of one that cars may use, over a junction, and beside bays.
    CycleLane,
    Advisory,
    CycleFord,
    Bays,
}

/// A lane of a section.
pub(crate) struct LaneRecord {
    pub id: i32,
    pub kind: &'static str,
    pub widths: Vec<Cubic>,
    /// What covers it, where the map says so.
    pub surface: LaneSurface,
    /// Line that is painted along its outer border.
    pub outer_line: OuterLine,
    pub predecessor: Option<i32>,
    pub successor: Option<i32>,
}

impl LaneRecord {
    /// A lane of usual asphalt without a line, which leads to no other.
    pub fn new(id: i32, kind: &'static str, widths: Vec<Cubic>) -> Self {
        let (surface, outer_line) = (LaneSurface::Usual, OuterLine::None);
        Self { id, kind, widths, surface, outer_line, predecessor: None, successor: None }
    }
}

/// The lanes from a place on, up to the next section.
pub(crate) struct Section {
    pub s_m: f64,
    /// Line, gap, and width of the broken line in the middle, if there is one.
    pub center_line_m: Option<(f64, f64, f64)>,
    pub lanes: Vec<LaneRecord>,
}

/// Streets of a zone of 30 km/h and narrow ones have none, nor have those with a median, or with one lane a direction and
/// cycle lanes that cars may use.
fn center_line_m(style: &LineStyle) -> Option<(f64, f64, f64)> {
    let is_between_advisory = style.lanes_per_side == 1 && style.cycle_lane.is_some_and(|c| c.is_advisory);
    let has_one = style.speed_kmh > 30
        && style.median_width_m == 0.0
        && 2.0 * style.driven_half_width_m() > CENTER_LINE_FROM_M
        && !is_between_advisory;
    let (line_m, gap_m) = if style.country.is_some() { country_roads::DASH_M } else { DASH_M };
    has_one.then_some((line_m, gap_m, LINE_WIDTH_M))
}

/// What the outermost lane of a road is, and what covers it.
pub(crate) fn outermost_lane(style: &LineStyle) -> (&'static str, LaneSurface) {
    match style.kind {
        _ if style.country.is_some() => ("shoulder", LaneSurface::Grass),
        StreetKind::Campus => ("sidewalk", LaneSurface::Setts),
        StreetKind::Usual | StreetKind::Aisle => ("sidewalk", LaneSurface::Usual),
    }
}

/// What covers driving lanes.
pub(crate) fn driven_surface(style: &LineStyle) -> LaneSurface {
    if style.kind == StreetKind::Campus { LaneSurface::Setts } else { LaneSurface::Usual }
}

/// Id of a driving lane: 0 is beside the middle of the road; `sign` is that of its side's ids.
pub(crate) fn driving_id(style: &LineStyle, sign: i32, lane: usize) -> i32 {
    sign * (i32::from(style.median_width_m > 0.0) + 1 + lane as i32)
}

/// Id of the lane that bicycles use: the cycle lane, or the outermost one for cars.
pub(crate) fn ridden_id(style: &LineStyle, sign: i32) -> i32 {
    driving_id(style, sign, style.lanes_per_side - usize::from(style.cycle_lane.is_none()))
}

/// Id of the sidewalk's lane where there are no bays.
pub(crate) fn sidewalk_id(style: &LineStyle, sign: i32) -> i32 {
    driving_id(style, sign, style.lanes_per_side + usize::from(style.cycle_lane.is_some()))
}

/// Whether a section of a street has one before it and one behind it.
#[derive(Clone, Copy)]
struct Neighbors {
    before: bool,
    after: bool,
}

/// The lane sections of a street: one, or three where it has bays.
pub(crate) fn street_sections(street: &Street) -> Vec<Section> {
    let style = &street.style;
    let has_bay = |sign: i32| street.bays.stretch_m.is_some() && street.bays.widths_m[usize::from(sign > 0)] > 0.0;
    let side = |sign: i32, bay: Option<f64>, neighbors: Neighbors| {
        let Neighbors { before, after } = neighbors;
        let through = |id: i32, kind: &'static str, width_m: f64| LaneRecord {
            predecessor: before.then_some(id),
            successor: after.then_some(id),
            ..LaneRecord::new(id, kind, vec![Cubic::constant(width_m)])
        };
        let mut lanes = Vec::new();
        if style.median_width_m > 0.0 {
            let kind = if style.tracks.is_some() { "tram" } else { "median" };
            let surface = style.tracks.unwrap_or_default();
            lanes.push(LaneRecord { surface, ..through(sign, kind, style.median_width_m / 2.0) });
        }
        for lane in 0..style.lanes_per_side {
            let mut record = through(driving_id(style, sign, lane), "driving", style.lane_width_m);
            record.surface = driven_surface(style);
            if lane + 1 < style.lanes_per_side {
                record.outer_line = OuterLine::Broken;
            } else if style.country.is_some_and(|c| c.has_edge_lines) {
                record.outer_line = OuterLine::Edge;
            } else if let Some(cycle_lane) = style.cycle_lane {
                record.outer_line = if cycle_lane.is_advisory { OuterLine::Advisory } else { OuterLine::CycleLane };
            }
            lanes.push(record);
        }
        if let Some(cycle_lane) = style.cycle_lane {
            let outer_line = if bay.is_some() { OuterLine::Bays } else { OuterLine::None };
            lanes.push(LaneRecord { outer_line, ..through(ridden_id(style, sign), "biking", cycle_lane.width_m) });
        }
        let bay_id = sidewalk_id(style, sign);
        if let Some(length) = bay {
            let bay_m = street.bays.widths_m[usize::from(sign > 0)];
            let widths = Cubic::plateau((BAY_TAPER_M, length - BAY_TAPER_M, length), bay_m, [0.0; 2]);
            lanes.push(LaneRecord::new(bay_id, "parking", widths));
        }
        // Bays take the sidewalk's number in the middle section, which moves the sidewalk out by one.
        let number = |in_bay_section: bool| bay_id + if in_bay_section && has_bay(sign) { sign } else { 0 };
        let in_bays = bay.is_some() || (before && after);
        let (kind, surface) = outermost_lane(style);
        lanes.push(LaneRecord {
            surface,
            predecessor: before.then(|| number(!in_bays)),
            successor: after.then(|| number(!in_bays)),
            ..LaneRecord::new(number(in_bays), kind, vec![Cubic::constant(style.sidewalk_width_m)])
        });
        lanes
    };
    let section = |s_m: f64, bay: Option<f64>, neighbors: Neighbors| {
        let mut lanes = side(1, bay.filter(|_| has_bay(1)), neighbors);
        lanes.reverse();
        lanes.extend(side(-1, bay.filter(|_| has_bay(-1)), neighbors));
        Section { s_m, center_line_m: center_line_m(style), lanes }
    };
    match street.bays.stretch_m {
        None => vec![section(0.0, None, Neighbors { before: false, after: false })],
        Some((from, to)) => vec![
            section(0.0, None, Neighbors { before: false, after: true }),
            section(from, Some(to - from), Neighbors { before: true, after: true }),
            section(to, None, Neighbors { before: true, after: false }),
        ],
    }
}

/// The lanes of a road.
pub(crate) fn write_lanes(out: &mut String, sections: &[Section]) {
    out.push_str("<lanes>\n");
    for section in sections {
        put!(out, "<laneSection s=\"{:.6}\">\n", section.s_m);
        let side = |out: &mut String, name: &str, keep: &dyn Fn(i32) -> bool| {
            if section.lanes.iter().any(|l| keep(l.id)) {
                put!(out, "<{name}>\n");
                section.lanes.iter().filter(|l| keep(l.id)).for_each(|l| write_lane(out, section.s_m, l));
                put!(out, "</{name}>\n");
            }
        };
        side(out, "left", &|id| id > 0);
        out.push_str("<center><lane id=\"0\" type=\"none\" level=\"false\">");
        if let Some((line_m, gap_m, width_m)) = section.center_line_m {
            write_broken_line(out, section.s_m, (line_m, gap_m), width_m);
        } else {
            put!(out, "<roadMark sOffset=\"0.0\" type=\"none\" color=\"white\" width=\"{LINE_WIDTH_M}\"/>");
        }
        out.push_str("</lane></center>\n");
        side(out, "right", &|id| id < 0);
        out.push_str("</laneSection>\n");
    }
    out.push_str("</lanes>\n");
}

/// Dashes from `s_m` on, as they follow each other from the street's beginning.
fn write_broken_line(out: &mut String, s_m: f64, dash_m: (f64, f64), width_m: f64) {
    let period_m = dash_m.0 + dash_m.1;
    let passed = ((s_m - FIRST_DASH_M) / period_m).ceil().max(0.0);
    let first_m = FIRST_DASH_M + passed * period_m - s_m;
    put!(
        out,
        "<roadMark sOffset=\"0.0\" type=\"broken\" color=\"white\" width=\"{width_m}\">\
             <type name=\"broken\" width=\"{width_m}\"><line length=\"{}\" space=\"{}\" tOffset=\"0.0\" \
             sOffset=\"{first_m:.6}\" rule=\"caution\" width=\"{width_m}\"/></type></roadMark>",
        dash_m.0,
        dash_m.1
    );
}

/// A solid line so far inside of the lane's outer border; `id` is the lane's.
fn write_solid_line(out: &mut String, id: i32, inset_m: f64, width_m: f64) {
    let inside_m = if id > 0 { -inset_m } else { inset_m };
    put!(
        out,
        "<roadMark sOffset=\"0.0\" type=\"solid\" color=\"white\" width=\"{width_m}\">\
             <type name=\"solid\" width=\"{width_m}\"><line length=\"0.0\" space=\"0.0\" tOffset=\"{inside_m}\" \
             sOffset=\"0.0\" rule=\"no passing\" width=\"{width_m}\"/></type></roadMark>\n"
    );
}

fn write_lane(out: &mut String, s_m: f64, lane: &LaneRecord) {
    put!(out, "<lane id=\"{}\" type=\"{}\" level=\"false\">\n<link>", lane.id, lane.kind);
    for (element, id) in [("predecessor", lane.predecessor), ("successor", lane.successor)] {
        if let Some(id) = id {
            put!(out, "<{element} id=\"{id}\"/>");
        }
    }
    out.push_str("</link>\n");
    for width in &lane.widths {
        width.write(out, "width", "sOffset");
    }
    match lane.outer_line {
        OuterLine::None => {}
        OuterLine::Broken => write_broken_line(out, s_m, DASH_M, LINE_WIDTH_M),
        OuterLine::Motorway => write_broken_line(out, s_m, MOTORWAY_DASH_M, MOTORWAY_LINE_M),
        OuterLine::Edge => write_solid_line(out, lane.id, EDGE_LINE_INSET_M, LINE_WIDTH_M),
        OuterLine::Narrow => write_solid_line(out, lane.id, 0.0, MOTORWAY_LINE_M),
        OuterLine::Wide => write_solid_line(out, lane.id, 0.0, WIDE_LINE_M),
        OuterLine::CycleLane => write_solid_line(out, lane.id, 0.0, CYCLE_LINE_M),
        OuterLine::Advisory => write_broken_line(out, s_m, ADVISORY_DASH_M, LINE_WIDTH_M),
        OuterLine::CycleFord => write_broken_line(out, s_m, (CYCLE_FORD_M.0, CYCLE_FORD_M.1), CYCLE_FORD_M.2),
        OuterLine::Bays => write_solid_line(out, lane.id, 0.0, LINE_WIDTH_M),
    }
    if let Some(surface) = lane.surface.name() {
        put!(out, "<material sOffset=\"0.0\" surface=\"{surface}\" friction=\"0.7\"/>\n");
    }
    if matches!(lane.kind, "median" | "sidewalk") && lane.surface == LaneSurface::Usual {
        put!(out, "<height sOffset=\"0.0\" inner=\"{CURB_HEIGHT_M}\" outer=\"{CURB_HEIGHT_M}\"/>\n");
    }
    out.push_str("</lane>\n");
}
