//! Where carriageway, curb and sidewalk lie in plan: clean rings made from the strips of lanes.

mod inside;
mod shapes;

pub(crate) use inside::Inside;
pub(crate) use shapes::{Contour, Frame, Ring, Shapes, difference, grow, union, with_crossings, with_steps};
use shapes::{WIDEN_M, area_m2, clean};

use crate::ground::land::{Crop, Land, YardSurface};
use crate::network::{Lane, LaneKind, LaneSurface, RoadNetwork};
use cadet_base::error::{Error, Result};
use cadet_base::math::DVec2;
use cadet_base::plane::bounds;

/// Largest extent of a map: what 1 mm in 32 bits can hold, with room for the offsets' arithmetic.
const MAX_EXTENT_M: f64 = 40_000.0;
/// Width of a curb stone.
const CURB_WIDTH_M: f64 = 0.15;
/// Width of the stones that edge the bed of a track; they begin this far inside of it, so that no outline meets another.
const BED_EDGE_M: f64 = 0.14;
const BED_INSET_M: f64 = 0.04;
/// Cracks up to twice this are closed.
const CRACK_M: (f64, f64) = (0.4, 0.5);
/// Smaller islands in a carriageway, and smaller gaps between sidewalks, are filled.
const SMALL_HOLE_M2: (f64, f64) = (15.0, 60.0);
/// Width of the gravel along the asphalt of country roads.
const SHOULDER_M: f64 = 0.45;
/// Fields end so far from a ditch and from each other's middle line; smaller ones are left to grass.
const BALK_M: f64 = 0.5;
const LEAST_FIELD_M2: f64 = 250.0;

/// The regions of a road network in plan.
#[derive(Debug, Clone, Default)]
pub(crate) struct Regions {
    /// Outline of the carriageway: the foot of the curb.
    pub(crate) carriageway: Vec<Ring>,
    /// Outline of carriageway and curb stones.
    pub(crate) curb: Vec<Ring>,
    /// Outline of carriageway, curb stones and sidewalk.
    pub(crate) sidewalk: Vec<Ring>,
    /// Outline of medians, where grass grows inside of the curb stones.
    pub(crate) green: Vec<Ring>,
    /// Outline of the beds of tracks that are not paved with asphalt, stone edges left out, by what covers them.
    pub(crate) beds: Vec<(LaneSurface, Vec<Ring>)>,
    /// Outline of those beds with their edges of stone.
    pub(crate) bed_edges: Vec<Ring>,
    /// Lines along the middle of the sidewalk.
    pub(crate) walks: Vec<Ring>,
    /// Width of the sidewalk, curb stone included, wherever the map does not say more; 0 in open country.
    pub(crate) sidewalk_width_m: f64,
    /// Outline of country roads with their shoulders of gravel.
    pub(crate) shoulder: Vec<Ring>,
    /// Lines along which the ground beside country roads bends.
    pub(crate) roadside: Vec<Ring>,
    /// What grows where in open country.
    pub(crate) fields: Vec<(Crop, Vec<Ring>)>,
    /// Paved ground beside streets.
    pub(crate) yards: Vec<(YardSurface, Vec<Ring>)>,
}

fn is_paved(kind: LaneKind) -> bool {
    matches!(kind, LaneKind::Driving | LaneKind::Parking | LaneKind::Biking | LaneKind::Shoulder | LaneKind::Tram)
}

impl Regions {
    /// The regions of some lanes of a network, and of the land about it where that is open country.
    ///
    /// # Errors
    /// [`Error::Map`] where the network is larger than 40 km, or has no carriageway.
    pub(crate) fn of(network: &RoadNetwork, lanes: &[Lane], land: Option<&Land>) -> Result<Self> {
        let fail = |reason: String| Error::Map { map: "ground".to_owned(), reason };
        let (min, max) = extent(network);
        let extent_m = (max - min).max_element();
        if extent_m.is_nan() || extent_m > MAX_EXTENT_M {
            return Err(fail(format!("the network is {extent_m} m across, expected less than {MAX_EXTENT_M} m")));
        }
        let frame = frame_of(network);
        let strips = |keep: &dyn Fn(LaneKind) -> bool| -> Vec<Contour> {
            lanes.iter().filter(|l| keep(l.kind)).filter_map(|l| frame.strip(l)).collect()
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
            let is_bed = |l: &&Lane| l.kind == LaneKind::Tram && l.surface == surface && l.junction.is_none();
            let tracks = lanes.iter().filter(is_bed);
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
            ..Self::default()
        })
    }

    /// What some lanes of a network cover with the sidewalks beside them, and a margin.
    pub(crate) fn covered(network: &RoadNetwork, lanes: &[Lane], margin_m: f64) -> Vec<Ring> {
        let frame = frame_of(network);
        let strips: Vec<Contour> = lanes.iter().filter_map(|l| frame.strip(l)).collect();
        let sidewalk_m = if network.is_rural() { 0.0 } else { network.usual_sidewalk_m() };
        frame.rings(&grow(&union(&strips), sidewalk_m + margin_m))
    }

    /// Without curbs and sidewalks: everything ends where the asphalt does.
    fn in_open_country(frame: &Frame, carriageway: &Shapes, land: Option<&Land>) -> Self {
        let edge = frame.rings(carriageway);
        let outlines = Self { curb: edge.clone(), sidewalk: edge.clone(), carriageway: edge, ..Self::default() };
        let Some(land) = land else { return outlines };
        Self {
            shoulder: frame.rings(&grow(carriageway, SHOULDER_M)),
            roadside: land.roadside.bends_m().iter().flat_map(|m| frame.rings(&grow(carriageway, *m))).collect(),
            fields: fields(frame, carriageway, land),
            ..outlines
        }
    }
}

fn extent(network: &RoadNetwork) -> (DVec2, DVec2) {
    bounds(network.lanes.iter().flat_map(|l| &l.center).map(|p| p.truncate()))
}

/// The integers in which the lanes of a network are laid.
fn frame_of(network: &RoadNetwork) -> Frame {
    let (min, max) = extent(network);
    Frame { origin: ((min + max) / 2.0).round() }
}

/// What roads and balks leave of each parcel.
fn fields(frame: &Frame, carriageway: &Shapes, land: &Land) -> Vec<(Crop, Vec<Ring>)> {
    let roads: Vec<Contour> = grow(carriageway, land.roadside.reach_m() + BALK_M).into_iter().flatten().collect();
    let mut fields = Vec::new();
    for parcel in &land.parcels {
        let outline: Contour = parcel.outline.iter().map(|p| frame.point(*p)).collect();
        let left = difference(&[outline], &roads);
        for (piece, crop) in left.into_iter().zip(parcel.crops.iter().cycle()) {
            let shrunk = grow(&vec![piece], -BALK_M);
            for shape in shrunk.into_iter().filter(|s| s.first().is_some_and(|c| area_m2(c) > LEAST_FIELD_M2)) {
                fields.push((*crop, frame.rings(&vec![shape])));
            }
        }
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;
    use cadet_base::math::{DVec3, PI};
    use cadet_base::plane::edges;

    fn area(rings: &[Ring]) -> f64 {
        rings.iter().flat_map(|ring| edges(ring)).map(|[a, b]| a.perp_dot(b) / 2.0).sum()
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
        let regions = Regions::of(&network, &network.lanes, None).unwrap();
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
}
