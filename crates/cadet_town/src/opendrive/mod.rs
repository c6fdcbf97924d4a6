//! Reads OpenDRIVE (crate `xodr`) into our network.
//!
//! `xodr` bakes lanes in single precision along the road's own direction; here they become double-precision polylines
//! in **driving** direction, rounded to 0.1 mm so that the last bit of a platform's `sin` leaves no trace.

mod document;
mod levels;
mod map_signals;
mod numbers;
mod offset;
mod warnings;

use std::collections::BTreeMap;

use crate::network::{
    DEFAULT_SPEED_MPS, GeoReference, Lane, LaneId, LaneKind, LaneSurface, PaintColor, PaintedQuad, RoadNetwork,
};
use cadet_base::error::{Error, Result};
use cadet_base::math::{DVec2, DVec3, hypot, lerp};

/// Points of a lane are at most this far apart on curves.
const CURVE_STEP_M: f64 = 1.0;
/// A segment counts as curved when its ends' directions differ by more than this.
const CURVED_RAD: f64 = 0.002;
/// Points nearer than this to the one before are the same point.
const SAME_POINT_M: f64 = 0.01;

/// Lanes are at most this far above or below 0: single precision rounds steeper roads' outlines to zigzags.
const MAX_HEIGHT_M: f64 = 10_000.0;
/// Lanes are at most this wide.
const MAX_LANE_WIDTH_M: f64 = 100.0;

/// Reads the text of an OpenDRIVE map, of any version.
///
/// # Errors
/// [`Error::Map`], naming `map_name` and the reason, with line or road where there is one: not a map, a number that
/// shapes a road and is none, a road or lane that can't be built, no lanes, no driving lane, coordinates not finite,
/// heights beyond 10 km, lanes wider than 100 m.
pub fn load(map_name: &str, xodr_text: &str) -> Result<RoadNetwork> {
    load_with_warnings(map_name, xodr_text).map(|(network, _)| network)
}

/// Reads a map, and says in lines that name it what was passed over on the way.
///
/// # Errors
/// As [`load`].
pub fn load_with_warnings(map_name: &str, xodr_text: &str) -> Result<(RoadNetwork, Vec<String>)> {
    let fail = |reason: String| Error::Map { map: map_name.to_owned(), reason: in_one_line(&reason) };
    let fail_at =
        |line: usize, reason: &str| Error::Map { map: format!("{map_name}:{line}"), reason: in_one_line(reason) };
    let document = document::parse(xodr_text).map_err(|(line, reason)| match line {
        Some(line) => fail_at(line, &reason),
        None => fail(reason),
    })?;
    let passed_over = numbers::check(&document).map_err(|(line, reason)| fail_at(line, &reason))?;
    let offset_m = offset::offset_m(&document);
    let near_text = offset::moved_back(&document, offset_m);
    let (map, provenance) = xodr::load_str_with_provenance(&near_text).map_err(|e| fail(e.to_string()))?;
    if let Some(warning) = provenance.warnings.iter().find(|warning| loses_a_lane(warning, &passed_over)) {
        return Err(fail(warning.to_string()));
    }
    let baked: Vec<(&xodr::Lane, Option<LaneLine>)> = map
        .lanes()
        .iter()
        .filter(|l| l.layer == xodr::Layer::Permanent)
        .map(|lane| {
            let road = || map.road_lane(lane.id).and_then(|place| map.road(place.road)).map_or("", xodr::Road::od_id);
            Ok((lane, polyline(lane).map_err(|reason| fail(format!("road {}: {reason}", road())))?))
        })
        .collect::<Result<_>>()?;
    // Lanes too short to have two points are stepped over: their followers become their predecessors' followers.
    let mut ids = BTreeMap::new();
    for (lane, line) in &baked {
        if line.is_some() {
            ids.insert(lane.id.0, LaneId(ids.len()));
        }
    }
    let by_xodr_id: BTreeMap<usize, &xodr::Lane> = baked.iter().map(|(l, _)| (l.id.0, *l)).collect();
    let junctions = junction_numbers(&map);
    let mut lanes: Vec<Lane> = Vec::with_capacity(ids.len());
    for (lane, line) in &baked {
        let Some(line) = line else { continue };
        let place = map.road_lane(lane.id);
        let road = place.and_then(|p| map.road(p.road));
        let middle = lane.center.length() / 2.0;
        let speed_limit_mps = match map.speed_limit_at(lane.id, middle) {
            Some(xodr::SpeedLimit::Max(v)) if v.is_finite() && v > 0.5 => f64::from(v),
            _ => DEFAULT_SPEED_MPS,
        };
        let surface = map.lane_material_at(lane.id, middle).map_or("", |m| m.surface.as_str());
        let mut successors = Vec::new();
        follow(lane, &by_xodr_id, &ids, 8, &mut successors);
        let road_number = place.map_or(u32::MAX, |p| p.road.0 as u32);
        lanes.push(Lane {
            kind: kind_of(lane.kind, LaneSurface::from_name(surface)),
            surface: LaneSurface::from_name(surface),
            successors,
            junction: road.and_then(|r| r.junction()).map(|id| junctions[id]),
            speed_limit_mps,
            keeps_left: place.is_some_and(|p| (p.od_id > 0) == (lane.direction != xodr::Direction::Backward)),
            ..Lane::new(LaneId(lanes.len()), road_number, line.points.clone(), line.widths.clone())
        });
    }
    drop_links_between_kinds(&mut lanes);
    if lanes.is_empty() {
        return Err(fail("the map has no lanes".to_owned()));
    }
    if !lanes.iter().any(|l| l.kind == LaneKind::Driving) {
        return Err(fail(format!("none of the map's {} lanes is for driving", lanes.len())));
    }
    let lane_marks = lane_marks(&map);
    let (lights, unused_lights) = map_signals::lights(&map, &ids, &lanes, offset_m);
    let signs = map_signals::signs(&map, &ids, &lanes);
    let roundabouts = roundabouts(&map, &junctions);
    let road_name = |road: u32| map.roads().get(road as usize).map_or("", xodr::Road::od_id);
    let mut said: Vec<Said> = passed_over.into_iter().map(PassedOver::said).collect();
    said.extend(levels::warnings(&lanes, road_name));
    said.extend(unused_lights);
    said.extend(
        provenance
            .warnings
            .iter()
            .filter(|w| !is_of_passed_over(w) && !is_of_no_cars_link(w, &map))
            .map(Said::by_reader),
    );
    let network =
        RoadNetwork { lanes, lane_marks, lights, signs, roundabouts, offset_m, geo_reference: geo_reference(&map) };
    said.extend(warnings::of_travel_direction(&document).filter(|_| !network.is_left_hand()));
    said.extend(network.is_left_hand().then(warnings::of_left_hand_traffic));
    said.extend((offset_m != DVec2::ZERO).then(|| warnings::of_offset(offset_m)));
    Ok((network, warnings::lines(map_name, said)))
}

fn geo_reference(map: &xodr::RoadNetwork) -> Option<GeoReference> {
    let xodr::GeoReference { proj, offset } = map.geo_reference();
    let offset = offset.unwrap_or_default();
    let projection = proj.as_ref().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())?;
    Some(GeoReference { projection, offset_m: [offset.x, offset.y, offset.z], heading_rad: offset.hdg })
}

/// The painted lines of a map, without those of roadworks and those whose place is no number.
fn lane_marks(map: &xodr::RoadNetwork) -> Vec<PaintedQuad> {
    let is_permanent =
        |id: &Option<xodr::LaneId>| id.and_then(|id| map.lane(id)).is_none_or(|l| l.layer == xodr::Layer::Permanent);
    let marks = map.road_marks().iter().filter(|m| is_permanent(&m.left) && is_permanent(&m.right));
    let point = |p: &xodr::Point| (DVec3::new(p.x.into(), p.y.into(), p.z.into()) * 1e4).round() / 1e4;
    marks
        .flat_map(|m| &m.lines)
        .zip(0_u32..)
        .flat_map(|(painted, line)| {
            let color = if painted.color == "yellow" { PaintColor::Yellow } else { PaintColor::White };
            let corners = |piece: &[xodr::Point; 4]| [0, 1, 2, 3].map(|i| point(&piece[i]));
            painted.pieces.iter().map(move |piece| PaintedQuad { corners: corners(piece), color, line })
        })
        .filter(|quad| quad.corners.iter().all(|p| p.is_finite()))
        .collect()
}

/// Numbers the junctions by their ids, from 1 on, as the map's roads come to them.
fn junction_numbers(map: &xodr::RoadNetwork) -> BTreeMap<&str, u32> {
    let mut numbers = BTreeMap::new();
    for id in map.roads().iter().filter_map(xodr::Road::junction) {
        let next = numbers.len() as u32 + 1;
        numbers.entry(id).or_insert(next);
    }
    numbers
}

/// The numbers of the junctions that the map calls roundabouts, ascending.
fn roundabouts(map: &xodr::RoadNetwork, junctions: &BTreeMap<&str, u32>) -> Vec<u32> {
    let groups = map.junction_groups().iter().filter(|g| g.kind == xodr::JunctionGroupKind::Roundabout);
    let ids = groups.flat_map(|g| &g.junctions);
    let mut numbers: Vec<u32> = ids.filter_map(|id| junctions.get(id.as_str()).copied()).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Whether the reader speaks of what was passed over, of which more is known.
fn is_of_passed_over(warning: &xodr::Warning) -> bool {
    matches!(warning, xodr::Warning::GeometryDropped { .. } | xodr::Warning::RoadSkipped { .. })
}

/// Whether a warning is of a gap between lanes that no car follows, such as shoulders and sidewalks of CARLA's towns.
fn is_of_no_cars_link(warning: &xodr::Warning, map: &xodr::RoadNetwork) -> bool {
    let xodr::Warning::LinkGap { road_id, lane: od_id, .. } = warning else { return false };
    let is_meant = |lane: &&xodr::Lane| {
        let place = map.road_lane(lane.id).filter(|place| place.od_id == *od_id);
        place.and_then(|place| map.road(place.road)).is_some_and(|road| road.od_id() == road_id)
    };
    !map.lanes().iter().filter(is_meant).any(|lane| lane.kind.is_drivable())
}

/// Whether the reader left out what cars drive on. Smaller losses, such as a sign's or a road mark's, pass.
fn loses_a_lane(warning: &xodr::Warning, passed_over: &[PassedOver]) -> bool {
    use xodr::Warning as W;
    let is_passed_over = |road: &str, s_m: Option<f64>| passed_over.iter().any(|p| p.road == road && p.s_m == s_m);
    match warning {
        W::GeometryDropped { road_id, s } => return !is_passed_over(road_id, *s),
        W::RoadSkipped { road_id, .. } => return !is_passed_over(road_id, None),
        _ => {}
    }
    matches!(
        warning,
        W::LaneIdUnreadable { .. } | W::LaneOnWrongSide { .. } | W::LaneIdRepeated { .. } | W::IncludeDropped { .. }
    )
}

fn kind_of(kind: xodr::LaneType, surface: LaneSurface) -> LaneKind {
    use xodr::LaneType as T;
    match kind {
        k if k.is_drivable() => LaneKind::Driving,
        T::Sidewalk => LaneKind::Sidewalk,
        T::Parking | T::Stop => LaneKind::Parking,
        T::Biking => LaneKind::Biking,
        T::Shoulder if surface == LaneSurface::Grass => LaneKind::Verge,
        T::Shoulder | T::Border | T::Curb | T::Restricted | T::RoadWorks => LaneKind::Shoulder,
        T::Median => LaneKind::Median,
        T::Tram | T::Rail => LaneKind::Tram,
        _ => LaneKind::Other,
    }
}

/// The lanes that one reaches off the end of `lane`, stepping over those that were not kept.
fn follow(
    lane: &xodr::Lane,
    by_xodr_id: &BTreeMap<usize, &xodr::Lane>,
    kept: &BTreeMap<usize, LaneId>,
    depth: usize,
    out: &mut Vec<LaneId>,
) {
    for next in &lane.successors {
        if let Some(id) = kept.get(&next.0) {
            if !out.contains(id) {
                out.push(*id);
            }
        } else if let (true, Some(short)) = (depth > 0, by_xodr_id.get(&next.0)) {
            follow(short, by_xodr_id, kept, depth - 1, out);
        }
    }
}

/// Keeps only links from a kind to the same kind, and those between a driving lane and a way of bicycles through a
/// junction; sorts them, and adds the way back.
fn drop_links_between_kinds(lanes: &mut [Lane]) {
    let kinds: Vec<LaneKind> = lanes.iter().map(|l| l.kind).collect();
    let is_in_junction: Vec<bool> = lanes.iter().map(|l| l.junction.is_some()).collect();
    let begins_or_ends_ride = |a: usize, b: usize| {
        kinds[a] == LaneKind::Biking && kinds[b] == LaneKind::Driving && is_in_junction[a] && !is_in_junction[b]
    };
    let mut links = Vec::new();
    for lane in lanes.iter_mut() {
        let (id, kind) = (lane.id, lane.kind);
        lane.successors.retain(|n| {
            let joins = begins_or_ends_ride(n.0, id.0) || begins_or_ends_ride(id.0, n.0);
            (kinds[n.0] == kind || joins) && *n != id
        });
        lane.successors.sort_unstable();
        links.extend(lane.successors.iter().map(|n| (*n, id)));
    }
    for (to, from) in links {
        lanes[to.0].predecessors.push(from);
    }
}

/// A lane's middle in driving direction.
struct LaneLine {
    points: Vec<DVec3>,
    widths: Vec<f64>,
}

/// The lane's points, denser on curves; `None` where it is too short to have two.
fn polyline(lane: &xodr::Lane) -> std::result::Result<Option<LaneLine>, String> {
    let points: Vec<DVec3> =
        lane.center.points().iter().map(|p| DVec3::new(p.x.into(), p.y.into(), p.z.into())).collect();
    let tangents: Vec<DVec3> =
        lane.center.tangents().iter().map(|t| DVec3::new(t.x.into(), t.y.into(), t.z.into())).collect();
    let width = |i: usize| f64::from(lane.widths.get(i).or(lane.widths.last()).copied().unwrap_or(lane.width));
    if points.iter().any(|p| !p.is_finite() || p.abs().max_element() > 1e6) {
        return Err("a lane's coordinates are not finite or beyond 1000 km from the map's middle".to_owned());
    }
    if let Some(p) = points.iter().find(|p| p.z.abs() > MAX_HEIGHT_M) {
        return Err(format!(
            "a lane is at a height of {:.0} m, expected at most {MAX_HEIGHT_M} m above or below 0",
            p.z
        ));
    }
    let widest_m = (0..points.len()).map(width).fold(0.0, f64::max);
    if widest_m > MAX_LANE_WIDTH_M {
        return Err(format!("a lane is {widest_m:.1} m wide, expected at most {MAX_LANE_WIDTH_M} m"));
    }
    let mut line = LaneLine { points: Vec::new(), widths: Vec::new() };
    let mut push = |p: DVec3, w: f64| {
        let p = (p * 1e4).round() / 1e4;
        let far = |q: &DVec3| hypot(p.x - q.x, p.y - q.y) > SAME_POINT_M;
        if line.points.last().is_none_or(far) {
            line.points.push(p);
            line.widths.push((w.max(0.0) * 1e4).round() / 1e4);
        }
    };
    for i in 0..points.len() {
        if i > 0 && tangents.len() == points.len() {
            let (a, b) = (points[i - 1], points[i]);
            let length = (b - a).length();
            let turn = (tangents[i - 1] - tangents[i]).length();
            let step = if turn > CURVED_RAD { CURVE_STEP_M } else { 2.0 };
            // A hair less, so that a length of just one step is one piece on every machine.
            let pieces = (length / step - 1e-3).ceil().clamp(1.0, 64.0) as usize;
            for k in 1..pieces {
                let t = k as f64 / pieces as f64;
                push(hermite(a, tangents[i - 1] * length, b, tangents[i] * length, t), lerp(width(i - 1), width(i), t));
            }
        }
        push(points[i], width(i));
    }
    // The end is where the next lane begins: it replaces a last point that came too near.
    if let (Some(end), Some(last)) = (points.last(), line.points.last_mut()) {
        *last = (*end * 1e4).round() / 1e4;
    }
    if line.points.len() < 2 || line.widths.iter().all(|w| *w < 0.01) {
        return Ok(None);
    }
    if lane.direction == xodr::Direction::Backward {
        line.points.reverse();
        line.widths.reverse();
    }
    Ok(Some(line))
}

fn hermite(a: DVec3, slope_a: DVec3, b: DVec3, slope_b: DVec3, t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + slope_a * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + slope_b * (t3 - t2)
}

#[cfg(test)]
mod tests;

use document::{line_of, number, road_of};
use numbers::PassedOver;
use warnings::{Said, in_one_line};
