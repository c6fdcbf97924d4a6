//! Where carriageway, curb and sidewalk lie in plan: clean rings made from the strips of lanes.
//!
//! Boolean operations and offsets run on integers of 1 mm (crate `i_overlay`), which makes them exact in topology and
//! the same on every machine.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;
use i_overlay::i_float::int::angle::Angle;
use i_overlay::i_float::int::point::IntPoint;
use i_overlay::mesh::int::arc::ArcOptions;
use i_overlay::mesh::int::outline::offset::IntOutlineOffset;
use i_overlay::mesh::int::style::{IntLineJoin, IntOutlineStyle};

use crate::error::{Error, Result};
use crate::math::DVec2;
use crate::plane::bounds;
use crate::town::ground::land::fields::{Crop, Land};
use crate::town::ground::land::yards::YardSurface;
use crate::town::network::road_network::{Lane, LaneKind, LaneSurface, RoadNetwork};

/// A closed line: outer boundaries run counter-clockwise, holes clockwise; the first point is not repeated.
pub(in crate::town) type Ring = Vec<DVec2>;

pub(in crate::town) type Contour = Vec<IntPoint<i32>>;
pub(in crate::town) type Shapes = Vec<Vec<Contour>>;

const UNITS_PER_M: f64 = 1e3;
/// Largest extent of a map: what 1 mm in 32 bits can hold, with room for the offsets' arithmetic.
const MAX_EXTENT_M: f64 = 40_000.0;
/// Width of a curb stone.
const CURB_WIDTH_M: f64 = 0.15;
/// Width of the stones that edge the bed of a track; they begin this far inside of it, so that no outline meets another.
const BED_EDGE_M: f64 = 0.14;
const BED_INSET_M: f64 = 0.04;
/// Cracks up to twice this are closed.
const CRACK_M: (f64, f64) = (0.4, 0.5);
/// Strips are this much too wide to either side until cracks are closed: edges that two lanes share would else cross each
/// other again and again within their rounding.
const WIDEN_M: f64 = 0.02;
/// Smaller islands in a carriageway, and smaller gaps between sidewalks, are filled.
const SMALL_HOLE_M2: (f64, f64) = (15.0, 60.0);
/// Width of the gravel along the asphalt of country roads.
const SHOULDER_M: f64 = 0.45;
/// Fields end so far from a ditch and from each other's middle line; smaller ones are left to grass.
const BALK_M: f64 = 0.5;
const LEAST_FIELD_M2: f64 = 250.0;
/// Corners that stand out less are straightened: in outlines, and between the steps that lead to them.
const STRAIGHT_M: f64 = 0.015;
const STRAIGHT_BETWEEN_M: f64 = 0.008;

/// The regions of a road network in plan.
#[derive(Debug, Clone)]
pub(in crate::town) struct Regions {
    /// Outline of the carriageway: the foot of the curb.
    pub(in crate::town) carriageway: Vec<Ring>,
    /// Outline of carriageway and curb stones.
    pub(in crate::town) curb: Vec<Ring>,
    /// Outline of carriageway, curb stones and sidewalk.
    pub(in crate::town) sidewalk: Vec<Ring>,
    /// Outline of medians, where grass grows inside of the curb stones.
    pub(in crate::town) green: Vec<Ring>,
    /// Outline of the beds of tracks that are not paved with asphalt, stone edges left out, by what covers them.
    pub(in crate::town) beds: Vec<(LaneSurface, Vec<Ring>)>,
    /// Outline of those beds with their edges of stone.
    pub(in crate::town) bed_edges: Vec<Ring>,
    /// Lines along the middle of the sidewalk.
    pub(in crate::town) walks: Vec<Ring>,
    /// Width of the sidewalk, curb stone included, wherever the map does not say more; 0 in open country.
    pub(in crate::town) sidewalk_width_m: f64,
    /// Outline of country roads with their shoulders of gravel.
    pub(in crate::town) shoulder: Vec<Ring>,
    /// Lines along which the ground beside country roads bends.
    pub(in crate::town) roadside: Vec<Ring>,
    /// What grows where in open country.
    pub(in crate::town) fields: Vec<(Crop, Vec<Ring>)>,
    /// Paved ground beside streets.
    pub(in crate::town) yards: Vec<(YardSurface, Vec<Ring>)>,
}

fn is_paved(kind: LaneKind) -> bool {
    matches!(kind, LaneKind::Driving | LaneKind::Parking | LaneKind::Biking | LaneKind::Shoulder | LaneKind::Tram)
}

impl Regions {
    /// The regions of a network, and of the land about it where that is open country.
    ///
    /// # Errors
    /// [`Error::Map`] where the network is larger than 40 km, or has no carriageway.
    pub(in crate::town) fn of(network: &RoadNetwork, land: Option<&Land>) -> Result<Self> {
        let fail = |reason: String| Error::Map { map: "ground".to_owned(), reason };
        let points = || network.lanes.iter().flat_map(|l| &l.center).map(|p| p.truncate());
        let (min, max) = bounds(points());
        let extent = (max - min).max_element();
        if extent.is_nan() || extent > MAX_EXTENT_M {
            return Err(fail(format!("the network is {extent} m across, expected less than {MAX_EXTENT_M} m")));
        }
        let frame = Frame { origin: ((min + max) / 2.0).round() };
        let strips = |keep: &dyn Fn(LaneKind) -> bool| -> Vec<Contour> {
            network.lanes.iter().filter(|l| keep(l.kind)).filter_map(|l| frame.strip(l)).collect()
        };
        let carriageway = clean(union(&strips(&is_paved)), CRACK_M.0, SMALL_HOLE_M2.0);
        if carriageway.is_empty() {
            return Err(fail("the network has no carriageway".to_owned()));
        }
        if network.is_rural() {
            return Ok(Self::in_open_country(&frame, &carriageway, land));
        }
        let sidewalk_width_m = network.usual_sidewalk_m();
        let mut sidewalk = strips(&|k| k == LaneKind::Sidewalk);
        sidewalk.extend(grow(&carriageway, sidewalk_width_m + WIDEN_M).into_iter().flatten());
        let sidewalk = clean(union(&sidewalk), CRACK_M.1, SMALL_HOLE_M2.1);
        let rings = |shapes: &Shapes| frame.rings(shapes);
        let green = rings(&union(&strips(&|k| k == LaneKind::Median)));
        let inside_green = Inside::new(&green);
        let beds_of = |surface: LaneSurface, inset_m: f64| {
            let tracks = network.tracks().filter(|l| l.surface == surface && l.junction.is_none());
            let strips: Vec<Contour> = tracks.filter_map(|l| frame.strip(l)).collect();
            if strips.is_empty() { Vec::new() } else { rings(&grow(&clean(union(&strips), CRACK_M.0, 0.0), -inset_m)) }
        };
        let surfaces = [LaneSurface::Grass, LaneSurface::Ballast, LaneSurface::Slabs];
        let with_beds = || surfaces.into_iter().filter(|s| network.tracks().any(|l| l.surface == *s));
        let mut walks = rings(&grow(&carriageway, (CURB_WIDTH_M + sidewalk_width_m) / 2.0));
        // Nobody walks round on a median.
        walks.retain(|ring| {
            let along = with_steps(ring, 2.0);
            2 * along.iter().filter(|p| inside_green.contains(**p)).count() < along.len()
        });
        Ok(Self {
            curb: rings(&grow(&carriageway, CURB_WIDTH_M)),
            walks,
            beds: with_beds().map(|s| (s, beds_of(s, BED_INSET_M + BED_EDGE_M))).collect(),
            bed_edges: with_beds().flat_map(|s| beds_of(s, BED_INSET_M)).collect(),
            green,
            carriageway: rings(&carriageway),
            sidewalk: rings(&sidewalk),
            sidewalk_width_m,
            shoulder: Vec::new(),
            roadside: Vec::new(),
            fields: Vec::new(),
            yards: Vec::new(),
        })
    }

    /// Without curbs and sidewalks: everything ends where the asphalt does.
    fn in_open_country(frame: &Frame, carriageway: &Shapes, land: Option<&Land>) -> Self {
        let edge = frame.rings(carriageway);
        let bends_m = land.map_or_else(Vec::new, |l| l.roadside.bends_m().to_vec());
        Self {
            curb: edge.clone(),
            sidewalk: edge.clone(),
            walks: Vec::new(),
            beds: Vec::new(),
            bed_edges: Vec::new(),
            green: Vec::new(),
            sidewalk_width_m: 0.0,
            shoulder: land.map_or_else(Vec::new, |_| frame.rings(&grow(carriageway, SHOULDER_M))),
            roadside: bends_m.iter().flat_map(|m| frame.rings(&grow(carriageway, *m))).collect(),
            fields: land.map_or_else(Vec::new, |l| frame.fields(carriageway, l)),
            carriageway: edge,
            yards: Vec::new(),
        }
    }
}

/// Meters to integers and back.
pub(in crate::town) struct Frame {
    pub(in crate::town) origin: DVec2,
}

impl Frame {
    pub(in crate::town) fn point(&self, p: DVec2) -> IntPoint<i32> {
        let q = ((p - self.origin) * UNITS_PER_M).round();
        IntPoint::new(q.x as i32, q.y as i32)
    }

    fn strip(&self, lane: &Lane) -> Option<Contour> {
        let n = lane.center.len();
        let at = |i: usize| lane.center[i].truncate();
        // Where a lane closes on itself its ends have one direction.
        let is_closed = lane.is_closed();
        let side = |i: usize| {
            let is_seam = is_closed && (i == 0 || i == n - 1);
            let (before, after) = if is_seam { (n - 2, 1) } else { (i.saturating_sub(1), (i + 1).min(n - 1)) };
            let along = (at(after) - at(before)).normalize_or_zero();
            along.perp() * (lane.width_m[i] / 2.0 + WIDEN_M)
        };
        let right = (0..n).map(|i| self.point(at(i) - side(i)));
        let left = (0..n).rev().map(|i| self.point(at(i) + side(i)));
        let ring = thin_out(&right.chain(left).collect::<Contour>(), STRAIGHT_BETWEEN_M);
        (ring.len() >= 3).then_some(ring)
    }

    /// What roads and balks leave of each parcel.
    fn fields(&self, carriageway: &Shapes, land: &Land) -> Vec<(Crop, Vec<Ring>)> {
        let roads: Vec<Contour> = grow(carriageway, land.roadside.reach_m() + BALK_M).into_iter().flatten().collect();
        let mut fields = Vec::new();
        for parcel in &land.parcels {
            let outline: Contour = parcel.outline.iter().map(|p| self.point(*p)).collect();
            let mut overlay = Overlay::new_custom(outline.len() + 64, IntOverlayOptions::default(), Solver::FRAG);
            overlay.add_source(&[outline], ShapeType::Subject);
            overlay.add_source(&roads, ShapeType::Clip);
            let left = overlay.overlay(OverlayRule::Difference, FillRule::NonZero);
            for (piece, crop) in left.into_iter().zip(parcel.crops.iter().cycle()) {
                let shrunk = grow(&vec![piece], -BALK_M);
                for shape in shrunk.into_iter().filter(|s| s.first().is_some_and(|c| area_m2(c) > LEAST_FIELD_M2)) {
                    fields.push((*crop, self.rings(&vec![shape])));
                }
            }
        }
        fields
    }

    pub(in crate::town) fn rings(&self, shapes: &Shapes) -> Vec<Ring> {
        shapes.iter().flatten().map(|c| self.ring(c)).filter(|r| r.len() >= 3).collect()
    }

    fn ring(&self, contour: &[IntPoint<i32>]) -> Ring {
        thin_out(contour, STRAIGHT_M)
            .iter()
            .map(|p| DVec2::new(p.x.into(), p.y.into()) / UNITS_PER_M + self.origin)
            .collect()
    }
}

pub(in crate::town) fn union(contours: &[Contour]) -> Shapes {
    let num_points = contours.iter().map(Vec::len).sum();
    let mut overlay = Overlay::new_custom(num_points, IntOverlayOptions::default(), Solver::FRAG);
    overlay.add_source(contours, ShapeType::Subject);
    overlay.overlay(OverlayRule::Subject, FillRule::NonZero)
}

/// Moves outlines out by `distance_m` (in where negative), round at the corners.
pub(in crate::town) fn grow(shapes: &Shapes, distance_m: f64) -> Shapes {
    // 20 degrees round small corners, 12 round others: polygons within 1 cm of their arcs.
    let max_step = Angle::from_bits((1_u32 << 31) / if distance_m.abs() < 0.6 { 9 } else { 15 });
    let join = IntLineJoin::Round(ArcOptions { max_step, ..ArcOptions::default() });
    let style = IntOutlineStyle::new((distance_m * UNITS_PER_M).round() as i32).line_join(join);
    let mut grown = shapes.outline(&style).unwrap_or_default();
    grown.iter_mut().flatten().for_each(|c| *c = thin_out(c, STRAIGHT_BETWEEN_M));
    grown
}

/// Closes cracks narrower than twice `crack_m`, takes off what strips are too wide, and fills holes below `hole_m2`.
fn clean(shapes: Shapes, crack_m: f64, hole_m2: f64) -> Shapes {
    let mut closed = grow(&grow(&shapes, crack_m), -crack_m - WIDEN_M);
    for shape in &mut closed {
        let mut index = 0;
        shape.retain(|contour| {
            index += 1;
            index == 1 || area_m2(contour).abs() >= hole_m2
        });
    }
    closed.retain(|shape| shape.first().is_some_and(|outer| area_m2(outer).abs() > 1.0));
    closed
}

fn area_m2(contour: &[IntPoint<i32>]) -> f64 {
    let cross =
        |a: &IntPoint<i32>, b: &IntPoint<i32>| f64::from(a.x) * f64::from(b.y) - f64::from(a.y) * f64::from(b.x);
    let next = contour.iter().cycle().skip(1);
    contour.iter().zip(next).map(|(a, b)| cross(a, b)).sum::<f64>() / (2.0 * UNITS_PER_M * UNITS_PER_M)
}

/// Drops the points of a ring that lie within `tolerance_m` of the line without them (Douglas and Peucker).
fn thin_out(ring: &[IntPoint<i32>], tolerance_m: f64) -> Contour {
    let n = ring.len();
    if n < 4 {
        return ring.to_vec();
    }
    let point = |p: &IntPoint<i32>| DVec2::new(p.x.into(), p.y.into());
    let at = |i: usize| point(&ring[if i < n { i } else { i - n }]);
    let reach = |i: &usize| (at(*i) - at(0)).length_squared();
    let far = (1..n).max_by(|a, b| reach(a).total_cmp(&reach(b))).unwrap_or(1);
    let mut keep = vec![false; n + 1];
    (keep[0], keep[far]) = (true, true);
    let mut todo = vec![(0, far), (far, n)];
    while let Some((a, b)) = todo.pop() {
        let (p, along) = (at(a), (at(b) - at(a)).normalize_or_zero());
        let off = |i: usize| (at(i) - p).perp_dot(along).abs();
        let (mut worst, mut worst_off) = (a, 0.0);
        for i in a + 1..b {
            let off = off(i);
            if off >= worst_off {
                (worst, worst_off) = (i, off);
            }
        }
        if worst_off > tolerance_m * UNITS_PER_M {
            keep[worst] = true;
            todo.push((a, worst));
            todo.push((worst, b));
        }
    }
    (0..n).filter(|i| keep[*i]).map(|i| ring[i]).collect()
}

/// The ring with points at most `step_m` apart.
pub(in crate::town) fn with_steps(ring: &[DVec2], step_m: f64) -> Ring {
    let mut out = Vec::with_capacity(ring.len());
    for (i, a) in ring.iter().enumerate() {
        let b = ring[(i + 1) % ring.len()];
        let pieces = ((b - *a).length() / step_m).ceil().max(1.0) as usize;
        out.extend((0..pieces).map(|k| *a + (b - *a) * (k as f64 / pieces as f64)));
    }
    out
}

/// Tells what lies inside a set of rings, by the even-odd rule, with the edges sorted into rows.
pub(in crate::town) struct Inside {
    min_y: f64,
    row_m: f64,
    /// The easternmost first.
    rows: Vec<Vec<(DVec2, DVec2)>>,
}

impl Inside {
    pub(in crate::town) fn new(rings: &[Ring]) -> Self {
        let ys = || rings.iter().flatten().map(|p| p.y);
        let (min_y, max_y) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
        let span = (max_y - min_y).max(0.0);
        let row_m = (span / 4000.0).max(1.0);
        let count = if span.is_finite() { (span / row_m) as usize + 1 } else { 0 };
        let mut rows = vec![Vec::new(); count];
        for ring in rings {
            for (i, a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                let (lo, hi) = ((a.y.min(b.y) - min_y) / row_m, (a.y.max(b.y) - min_y) / row_m);
                for row in rows.iter_mut().take(hi as usize + 1).skip(lo as usize) {
                    row.push((*a, b));
                }
            }
        }
        for row in &mut rows {
            row.sort_by(|a, b| farthest_x(b).total_cmp(&farthest_x(a)));
        }
        Self { min_y, row_m, rows }
    }

    pub(in crate::town) fn contains(&self, p: DVec2) -> bool {
        let row = (p.y - self.min_y) / self.row_m;
        if row.is_nan() || row < 0.0 {
            return false;
        }
        let Some(row) = self.rows.get(row as usize) else { return false };
        let crosses = |(a, b): &(DVec2, DVec2)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y))
        };
        // What ends well before the point is not to its right.
        row.iter().take_while(|edge| farthest_x(edge) > p.x - 1e-3).filter(|edge| crosses(edge)).count() % 2 == 1
    }
}

fn farthest_x((a, b): &(DVec2, DVec2)) -> f64 {
    a.x.max(b.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, PI};

    fn area(rings: &[Ring]) -> f64 {
        let twice = |r: &Ring| (0..r.len()).map(|i| r[i].perp_dot(r[(i + 1) % r.len()])).sum::<f64>();
        rings.iter().map(|r| twice(r) / 2.0).sum()
    }

    #[test]
    fn two_crossing_streets_have_the_areas_of_a_cross() {
        let (length, lane) = (100.0, 3.0);
        let mut network = RoadNetwork::straight(length, lane);
        for mut across in RoadNetwork::straight(length, lane).lanes {
            across.id.0 += 2;
            across.center.iter_mut().for_each(|p| *p = DVec3::new(-p.y, p.x, 0.0));
            network.lanes.push(across);
        }
        let regions = Regions::of(&network, None).unwrap();
        let width = 2.0 * lane;
        let rounded_inside = |r: f64| (4.0 - PI) * r * r; // four inner corners of radius r
        let cross = 2.0 * length * width - width * width + rounded_inside(CRACK_M.0);
        // Thinning may shift the 400 m of outline by some millimeters.
        assert!((area(&regions.carriageway) - cross).abs() < 1.0, "{} {cross}", area(&regions.carriageway));
        // Grown by the default 2 m: a wider cross with rounded outer corners.
        let (w, l) = (width + 4.0, length + 4.0);
        let outer = 2.0 * l * w - w * w - 2.0 * rounded_inside(2.0) + rounded_inside(CRACK_M.1);
        assert!((area(&regions.sidewalk) - outer).abs() < 1.5, "{} {outer}", area(&regions.sidewalk));
        let inside = Inside::new(&regions.sidewalk);
        assert!(inside.contains(DVec2::new(0.0, 4.0)) && !inside.contains(DVec2::new(8.0, 8.0)));
        assert!(inside.contains(DVec2::new(0.0, -51.0)) && !inside.contains(DVec2::new(0.0, -53.0)));
    }

    #[test]
    fn thinning_keeps_corners_and_drops_what_is_straight() {
        let ring: Contour =
            [(0, 0), (500, 2), (1000, 0), (1000, 900), (0, 1000)].map(|(x, y)| IntPoint::new(x, y)).into();
        assert_eq!(thin_out(&ring, 0.003).len(), 4);
        assert_eq!(thin_out(&ring, 0.001).len(), 5);
    }
}
