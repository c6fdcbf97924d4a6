//! Writes a motorway as OpenDRIVE 1.7: roads that follow each other, without a junction.

use crate::network::LaneSurface;
use crate::plan::xodr::{
    Cubic, LaneRecord, Link, OuterLine, Section, begin_document, begin_road, write_lanes, write_shape, write_type,
};
use crate::plan::{CrossSection, Motorway, Relief, WhichEnd};

/// The whole document; roads have ids from 1 on.
pub(crate) fn write(name: &str, motorway: &Motorway, relief: &Relief) -> String {
    let mut out = begin_document(name);
    let num_roads = motorway.roads.len();
    let mut from_m = 0.0;
    for (i, curve) in motorway.roads.iter().enumerate() {
        let length = curve.length_m();
        let (before, after) = ((i + num_roads - 1) % num_roads + 1, (i + 1) % num_roads + 1);
        let links = [Link::Road(before, WhichEnd::Finish), Link::Road(after, WhichEnd::Start)];
        begin_road(&mut out, i + 1, length, None, links);
        write_type(&mut out, "motorway", motorway.section.speed_kmh);
        write_shape(&mut out, curve, relief, &|s| motorway.tilt(from_m + s));
        write_lanes(&mut out, &[across(&motorway.section)]);
        out.push_str("</road>\n");
        from_m += length;
    }
    out.push_str("</OpenDRIVE>\n");
    out
}

/// The lanes across, each of which leads to the one of the same number.
fn across(section: &CrossSection) -> Section {
    let usual = LaneSurface::Usual;
    let mut outwards = vec![
        ("median", section.half_median_m, LaneSurface::Grass, OuterLine::None),
        ("border", section.inner_strip_m, usual, OuterLine::Narrow),
    ];
    for (lane, width_m) in section.lanes_m.into_iter().take(section.num_lanes).enumerate() {
        let is_last = lane + 1 == section.num_lanes;
        outwards.push(("driving", width_m, usual, if is_last { OuterLine::Wide } else { OuterLine::Motorway }));
    }
    let beside = if section.shoulder_m > 1.0 { "shoulder" } else { "border" };
    outwards.push((beside, section.shoulder_m, usual, OuterLine::None));
    outwards.push(("shoulder", section.verge_m, LaneSurface::Grass, OuterLine::None));
    let side = |sign: i32| {
        let number = move |k: usize| sign * (k as i32 + 1);
        outwards.iter().enumerate().map(move |(k, (kind, width_m, surface, outer_line))| LaneRecord {
            surface: *surface,
            outer_line: *outer_line,
            predecessor: Some(number(k)),
            successor: Some(number(k)),
            ..LaneRecord::new(number(k), kind, vec![Cubic::constant(*width_m)])
        })
    };
    let mut lanes: Vec<LaneRecord> = side(1).collect();
    lanes.reverse();
    lanes.extend(side(-1));
    Section { s_m: 0.0, center_line_m: None, lanes }
}
