//! The lanes as drivers know them: where they lead, how fast each bend may be taken, what is beside, where there is room.

use std::sync::Arc;

use super::abreast;
use super::room::{Needs, Room};
use crate::footprint::Footprint;
use crate::params::{COS_SAME_WAY, LEVEL_M};
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::plane::bounds;
use cadet_town::{GroundKind, Lane, LaneId, LaneKind, RightOfWay, RoadNetwork, Signals, Town};

/// Lateral acceleration that drivers accept in bends.
const LATERAL_MPS2: f64 = 2.0;
/// Routes no longer than this count as equally long.
const REACH_CAP_M: f64 = 600.0;

/// Lanes with a higher limit (90 km/h) are fast: drivers look farther there.
const FAST_MPS: f64 = 25.0;
/// Half the width of the widest lanes for bicycles.
const WIDE_M: f64 = 3.0;

/// A place on the lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LanePosition {
    pub lane: LaneId,
    /// Distance along the lane.
    pub s_m: f64,
    /// Distance to the left of the lane's middle.
    pub left_m: f64,
}

/// The lanes and how they lead on: what does not change about them, computed once.
pub(crate) struct LaneGraph {
    town: Arc<Town>,
    /// Speed that bend and limit allow at each point of each lane.
    allowed_mps: Vec<Vec<f64>>,
    /// How far one can drive from each lane's start, capped.
    reach_m: Vec<f64>,
    /// Bounds of each lane in the plane.
    bounds: Vec<(DVec2, DVec2)>,
    /// Width of the widest lane.
    widest_m: f64,
    room: Room,
    /// The lanes abreast of each, toward the middle of the road and toward the curb.
    beside: Vec<[Option<LaneId>; 2]>,
    right_of_way: Vec<Option<RightOfWay>>,
}

impl LaneGraph {
    /// Whether a place lies on a sidewalk.
    pub fn is_sidewalk(&self, place: DVec3) -> bool {
        self.town.ground.surface_near(place).is_some_and(|(_, kind)| kind == GroundKind::Sidewalk)
    }

    pub fn new(town: Arc<Town>) -> Self {
        let lanes = &town.network.lanes;
        let curvatures: Vec<Vec<f64>> = lanes.iter().map(curvatures).collect();
        let allowed_mps = lanes.iter().zip(&curvatures).map(|(l, c)| allowed_speeds(l, c)).collect();
        let room = Room::beside(curvatures);
        let bounds = lanes.iter().map(|l| bounds(l.center.iter().map(|p| p.truncate()))).collect();
        let widest_m = lanes.iter().flat_map(|l| &l.width_m).copied().fold(0.0, f64::max);
        let reach_m = reaches(&town.network);
        let beside = abreast::neighbors(lanes);
        let right_of_way = rights_of_way(&town);
        Self { town, allowed_mps, reach_m, bounds, widest_m, room, beside, right_of_way }
    }

    /// Whether a lane is a motorway's, or as fast.
    pub fn is_fast(&self, id: LaneId) -> bool {
        self.lane(id).speed_limit_mps > FAST_MPS
    }

    /// Whether drivers may leave a lane for the one beside it.
    pub fn allows_changes(&self, id: LaneId) -> bool {
        self.beside[id.0].iter().any(Option::is_some)
    }

    /// The lane toward the middle of the road in the same direction, if there is one: on the left where traffic keeps right.
    pub fn inner_of(&self, id: LaneId) -> Option<LaneId> {
        self.beside[id.0][0]
    }

    /// The lane toward the curb in the same direction, if there is one.
    pub fn outer_of(&self, id: LaneId) -> Option<LaneId> {
        self.beside[id.0][1]
    }

    /// Whether a lane begins, or ends, where the map does: nothing leads to it, or on from it, or from one beside it.
    pub fn begins_with_map(&self, lane: &Lane) -> bool {
        self.is_at_map_edge(lane, |lane| &lane.predecessors)
    }

    /// See [`Self::begins_with_map`].
    pub fn ends_with_map(&self, lane: &Lane) -> bool {
        self.is_at_map_edge(lane, |lane| &lane.successors)
    }

    fn is_at_map_edge(&self, lane: &Lane, next: impl Fn(&Lane) -> &Vec<LaneId>) -> bool {
        let beside = self.beside[lane.id.0].iter().flatten();
        next(lane).is_empty() && beside.into_iter().all(|id| next(self.lane(*id)).is_empty())
    }

    /// Takes note of what stands for good, for those who are wider than cars.
    pub fn note_standing(&mut self, standing: &[Footprint]) {
        let mut room = std::mem::take(&mut self.room);
        for o in standing {
            room.note(o, self.driving_near(o.center, Room::reach_m(o)));
        }
        self.room = room;
    }

    /// Whether a lane has what a vehicle needs.
    pub fn fits(&self, id: LaneId, needs: Needs) -> bool {
        self.room.fits(self.lane(id), needs)
    }

    pub fn lane(&self, id: LaneId) -> &Lane {
        self.town.network.lane(id)
    }

    /// Whether a lane leads through a roundabout.
    pub fn is_in_roundabout(&self, id: LaneId) -> bool {
        self.town.network.is_in_roundabout(self.lane(id))
    }

    /// What traffic does at the junction at the end of a lane; `None` where there is none.
    pub fn right_of_way(&self, id: LaneId) -> Option<RightOfWay> {
        self.right_of_way[id.0]
    }

    /// The traffic lights.
    pub fn signals(&self) -> &Signals {
        &self.town.signals
    }

    /// Speed that bend and limit allow at each point of a lane.
    pub fn allowed_mps(&self, id: LaneId) -> &[f64] {
        &self.allowed_mps[id.0]
    }

    pub fn lanes(&self) -> &[Lane] {
        &self.town.network.lanes
    }

    pub fn reach_m(&self, id: LaneId) -> f64 {
        self.reach_m[id.0]
    }

    /// Driving lanes whose bounds come within `within_m` of a place.
    pub fn driving_near(&self, at: DVec2, within_m: f64) -> impl Iterator<Item = &Lane> {
        self.near(at, within_m, LaneKind::Driving)
    }

    fn near(&self, at: DVec2, within_m: f64, kind: LaneKind) -> impl Iterator<Item = &Lane> {
        self.lanes().iter().filter(move |l| {
            let (lo, hi) = self.bounds[l.id.0];
            l.kind == kind && (at - at.clamp(lo, hi)).length() <= within_m
        })
    }

    /// Whether a place is on a lane for bicycles, or nearer to it than that.
    pub fn is_on_cycle_lane(&self, at: DVec2, within_m: f64) -> bool {
        let reaches = |lane: &Lane| lane.width_at(lane.length_m() / 2.0) / 2.0 + within_m;
        self.near(at, WIDE_M + within_m, LaneKind::Biking).any(|l| l.project(at.extend(0.0)).1 < reaches(l))
    }

    /// The lanes on which a car may be put: for driving, outside junctions.
    pub fn open_lanes(&self) -> impl Iterator<Item = &Lane> {
        self.lanes().iter().filter(|l| l.kind == LaneKind::Driving && l.junction.is_none())
    }

    /// Whether a rectangle is at least `room_m` away from the middle of every driving lane.
    pub fn keeps_off_lanes(&self, rectangle: &Footprint, room_m: f64) -> bool {
        self.keeps_off(rectangle, LaneKind::Driving, (room_m, 0.0))
    }

    /// Whether a rectangle is at least `room_m` away from the middle of every lane for bicycles.
    pub fn keeps_off_cycle_lanes(&self, rectangle: &Footprint, room_m: f64) -> bool {
        self.keeps_off(rectangle, LaneKind::Biking, (room_m, 0.0))
    }

    /// Whether it lies outside every driving lane, and at least `room_m` away from its middle.
    pub fn is_beside_lanes(&self, rectangle: &Footprint, room_m: f64) -> bool {
        self.keeps_off(rectangle, LaneKind::Driving, (room_m, 0.5))
    }

    /// Whether it is a distance away from the middle of every lane, or the share of the lane's width if that is more.
    fn keeps_off(&self, rectangle: &Footprint, kind: LaneKind, (room_m, of_width): (f64, f64)) -> bool {
        let reach_m = rectangle.half_length_m + rectangle.half_width_m + room_m.max(of_width * self.widest_m);
        self.near(rectangle.center, reach_m, kind).all(|lane| {
            let mut points = lane.center.iter().map(|p| p.truncate()).zip(&lane.width_m);
            points.all(|(p, width_m)| !rectangle.rect().is_within(p, room_m.max(of_width * width_m)))
        })
    }

    /// The place on the driving lane nearest to a point within `within_m`. With a heading, only lanes that run within 60
    /// degrees of it count.
    pub fn nearest(&self, at: DVec3, heading_rad: Option<f64>, within_m: f64) -> Option<LanePosition> {
        let p = at.truncate();
        let mut best: Option<(LaneId, f64, f64)> = None;
        for lane in self.lanes().iter().filter(|l| l.kind == LaneKind::Driving) {
            let limit = best.map_or(within_m, |b| b.2);
            let (lo, hi) = self.bounds[lane.id.0];
            if (p - p.clamp(lo, hi)).length() > limit {
                continue;
            }
            let (s_m, distance_m) = lane.project(at);
            if distance_m >= limit || (lane.point_at(s_m).z - at.z).abs() > LEVEL_M {
                continue;
            }
            if let Some(heading) = heading_rad {
                let along = cadet_base::frames::yaw_of(&lane.pose_at(s_m));
                if math::wrap_angle(along - heading).abs() > math::PI / 3.0 {
                    continue;
                }
            }
            best = Some((lane.id, s_m, distance_m));
        }
        best.map(|(lane, s_m, _)| {
            let (middle, left) = self.lane(lane).middle_and_left(s_m);
            LanePosition { lane, s_m, left_m: (p - middle.truncate()).dot(left) }
        })
    }
}

/// What bends and limit allow at each point.
fn allowed_speeds(lane: &Lane, curvatures: &[f64]) -> Vec<f64> {
    let allowed = |curvature: &f64| {
        let bend = if curvature.abs() > 1e-4 { (LATERAL_MPS2 / curvature.abs()).sqrt() } else { f64::INFINITY };
        bend.max(2.0).min(lane.speed_limit_mps.max(2.0))
    };
    curvatures.iter().map(allowed).collect()
}

/// Curvature of the polyline at each point, to the left above 0, from the turn over about 3 m to either side.
fn curvatures(lane: &Lane) -> Vec<f64> {
    let at = |s_m: f64| lane.point_at(s_m).truncate();
    lane.s_m
        .iter()
        .map(|&s| {
            let half = 3.0_f64.min(lane.length_m() / 2.0);
            let s = s.clamp(half, lane.length_m() - half);
            let (a, b, c) = (at(s - half), at(s), at(s + half));
            let (ab, bc) = (b - a, c - b);
            let span = (ab.length() + bc.length()) / 2.0;
            let turn = math::turn_rad(ab, bc);
            if span > 0.5 { turn / span } else { 0.0 }
        })
        .collect()
}

/// The right of way at each lane's end. A cycle lane has that of the lane for cars beside it.
fn rights_of_way(town: &Town) -> Vec<Option<RightOfWay>> {
    let network = &town.network;
    let of = |lane: &Lane| RightOfWay::of(lane, network, &town.signals);
    let beside = |lane: &Lane| {
        let arrives_with = |o: &&Lane| {
            let goes_along = o.end_tangent().dot(lane.end_tangent()) > COS_SAME_WAY;
            o.road == lane.road && o.junction.is_none() && goes_along
        };
        network.driving().filter(arrives_with).find_map(of)
    };
    let one = |lane: &Lane| match lane.kind {
        _ if lane.junction.is_some() => None,
        LaneKind::Driving => of(lane),
        LaneKind::Biking => beside(lane).or_else(|| of(lane)),
        _ => None,
    };
    network.lanes.iter().map(one).collect()
}

fn reaches(network: &RoadNetwork) -> Vec<f64> {
    let mut reach: Vec<f64> = network.lanes.iter().map(Lane::length_m).collect();
    // Sweeps until nothing grows; on a ring everything reaches the cap.
    let mut grew = true;
    while grew {
        grew = false;
        for lane in
            network.lanes.iter().filter(|l| matches!(l.kind, LaneKind::Driving | LaneKind::Tram | LaneKind::Biking))
        {
            let onward = lane.successors.iter().map(|s| reach[s.0]).fold(0.0, f64::max);
            let now = (lane.length_m() + onward).min(REACH_CAP_M.max(lane.length_m()));
            grew |= now > reach[lane.id.0] + 1e-9;
            reach[lane.id.0] = now;
        }
    }
    reach
}
