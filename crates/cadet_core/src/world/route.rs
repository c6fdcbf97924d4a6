//! Roads as a driver knows them: how fast each bend may be taken, what lies ahead, and the way through the lanes.

use std::collections::VecDeque;
use std::sync::Arc;

use super::footprint::Footprint;
use super::room::{Needs, Room};
use crate::math::{self, DVec2, DVec3};
use crate::rng::Stream;
use crate::town::{GroundKind, Lane, LaneId, LaneKind, RoadNetwork, Town};

/// Lateral acceleration that drivers accept in bends.
const LATERAL_MPS2: f64 = 2.0;
/// Routes no longer than this count as equally long.
const REACH_CAP_M: f64 = 600.0;
/// How much likelier than turning off it is that the ego, or another car, goes straight on; long vehicles keep to
/// where they fit.
pub(super) const EGO_STRAIGHT: f64 = 3.0;
pub(super) const CAR_STRAIGHT: f64 = 1.2;
pub(super) const LONG_STRAIGHT: f64 = 500.0;
/// How much less likely a way is that has no room for a vehicle.
const TOO_NARROW: f64 = 1e-5;
/// How far ahead a route is always known.
const ROUTE_AHEAD_M: f64 = 110.0;

/// What does not change about the roads, computed once.
pub(super) struct Roads {
    town: Arc<Town>,
    /// Speed that bend and limit allow at each point of each lane.
    allowed_mps: Vec<Vec<f64>>,
    /// How far one can drive from each lane's start, capped.
    reach_m: Vec<f64>,
    /// Bounds of each lane in the plane.
    bounds: Vec<(DVec2, DVec2)>,
    room: Room,
}

impl Roads {
    /// Whether a place lies on a sidewalk.
    pub fn is_sidewalk(&self, place: DVec2) -> bool {
        self.town.ground.kind_at(place.x, place.y) == Some(GroundKind::Sidewalk)
    }

    pub fn new(town: Arc<Town>) -> Self {
        let lanes = &town.network.lanes;
        let curvatures: Vec<Vec<f64>> = lanes.iter().map(curvatures).collect();
        let allowed_mps = lanes.iter().zip(&curvatures).map(|(l, c)| allowed_speeds(l, c)).collect();
        let room = Room::beside(&curvatures);
        let bounds = lanes
            .iter()
            .map(|l| {
                l.center.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), p| {
                    (lo.min(p.truncate()), hi.max(p.truncate()))
                })
            })
            .collect();
        let reach_m = reaches(&town.network);
        Self { town, allowed_mps, reach_m, bounds, room }
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

    pub fn lanes(&self) -> &[Lane] {
        &self.town.network.lanes
    }

    pub fn reach_m(&self, id: LaneId) -> f64 {
        self.reach_m[id.0]
    }

    /// Driving lanes whose bounds come within `within_m` of a place.
    pub fn driving_near(&self, at: DVec2, within_m: f64) -> impl Iterator<Item = &Lane> {
        self.lanes().iter().filter(move |l| {
            let (lo, hi) = self.bounds[l.id.0];
            l.kind == LaneKind::Driving && (at - at.clamp(lo, hi)).length() <= within_m
        })
    }

    /// The lanes on which a car may be put: for driving, outside junctions.
    pub fn open_lanes(&self) -> impl Iterator<Item = &Lane> {
        self.lanes().iter().filter(|l| l.kind == LaneKind::Driving && l.junction.is_none())
    }

    /// Whether a rectangle is at least `room_m` away from the middle of every driving lane.
    pub fn keeps_off_lanes(&self, rectangle: &Footprint, room_m: f64) -> bool {
        let reach_m = rectangle.half_length_m + rectangle.half_width_m + room_m;
        self.driving_near(rectangle.center, reach_m).all(|lane| {
            lane.center
                .iter()
                .map(|p| p.truncate())
                .filter(|p| (*p - rectangle.center).length() < reach_m)
                .all(|p| (rectangle.closest_point(p) - p).length() > room_m)
        })
    }

    /// The driving lane nearest to a place within `within_m`: (lane, distance along it, distance from it). With a
    /// heading, only lanes that run within 60 degrees of it.
    pub fn nearest(&self, at: DVec3, heading_rad: Option<f64>, within_m: f64) -> Option<(LaneId, f64, f64)> {
        let p = at.truncate();
        let mut best: Option<(LaneId, f64, f64)> = None;
        for lane in self.lanes().iter().filter(|l| l.kind == LaneKind::Driving) {
            let limit = best.map_or(within_m, |b| b.2);
            let (lo, hi) = self.bounds[lane.id.0];
            if (p - p.clamp(lo, hi)).length() > limit {
                continue;
            }
            let (s_m, distance_m) = lane.project(at);
            if distance_m >= limit {
                continue;
            }
            if let Some(heading) = heading_rad {
                let along = crate::frames::yaw_of(&lane.pose_at(s_m));
                if math::wrap_angle(along - heading).abs() > math::PI / 3.0 {
                    continue;
                }
            }
            best = Some((lane.id, s_m, distance_m));
        }
        best
    }
}

/// What bends and limit allow at each point.
fn allowed_speeds(lane: &Lane, curvatures: &[f64]) -> Vec<f64> {
    let allowed = |curvature: &f64| {
        let bend = if *curvature > 1e-4 { (LATERAL_MPS2 / curvature).sqrt() } else { f64::INFINITY };
        bend.max(2.0).min(lane.speed_limit_mps.max(2.0))
    };
    curvatures.iter().map(allowed).collect()
}

/// Curvature of the polyline at each point from the turn over about 3 m to either side.
fn curvatures(lane: &Lane) -> Vec<f64> {
    let at = |s: f64| {
        let s = s.clamp(0.0, lane.length_m());
        let i = lane.s_m.partition_point(|v| *v <= s).clamp(1, lane.center.len() - 1);
        let t = (s - lane.s_m[i - 1]) / (lane.s_m[i] - lane.s_m[i - 1]);
        lane.center[i - 1].truncate().lerp(lane.center[i].truncate(), t)
    };
    lane.s_m
        .iter()
        .map(|&s| {
            let half = 3.0_f64.min(lane.length_m() / 2.0);
            let s = s.clamp(half, lane.length_m() - half);
            let (a, b, c) = (at(s - half), at(s), at(s + half));
            let (ab, bc) = (b - a, c - b);
            let span = (ab.length() + bc.length()) / 2.0;
            let turn = math::atan2(ab.perp_dot(bc), ab.dot(bc)).abs();
            if span > 0.5 { turn / span } else { 0.0 }
        })
        .collect()
}

fn reaches(network: &RoadNetwork) -> Vec<f64> {
    let mut reach: Vec<f64> = network.lanes.iter().map(Lane::length_m).collect();
    // Sweeps until nothing grows; on a ring everything reaches the cap.
    for _ in 0..200 {
        let mut grew = false;
        for lane in network.lanes.iter().filter(|l| l.kind == LaneKind::Driving) {
            let onward = lane.successors.iter().map(|s| reach[s.0]).fold(0.0, f64::max);
            let now = (lane.length_m() + onward).min(REACH_CAP_M.max(lane.length_m()));
            grew |= now > reach[lane.id.0] + 1e-9;
            reach[lane.id.0] = now;
        }
        if !grew {
            break;
        }
    }
    reach
}

/// A place ahead on a route.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ahead {
    /// Distance from the car's middle.
    pub distance_m: f64,
    pub at: DVec2,
    pub tangent: DVec2,
}

/// A car's way: the lane it is on, those that follow, and how far along it is.
#[derive(Debug, Clone)]
pub(super) struct Route {
    /// The current lane first; never empty.
    pub lanes: VecDeque<LaneId>,
    /// Distance of the car's middle along the current lane.
    pub s_m: f64,
    /// Distance driven along the route until the current lane's start.
    base_m: f64,
    /// Offset to the left of the lane's middle that the driver keeps.
    pub offset_m: f64,
    /// Weight of going straight on against turning off.
    straight: f64,
    needs: Needs,
    choices: Stream,
}

impl Route {
    pub fn new(lane: LaneId, s_m: f64, offset_m: f64, straight: f64, choices: Stream, roads: &Roads) -> Self {
        Self::with_needs(lane, s_m, offset_m, straight, Needs::default(), choices, roads)
    }

    /// The route of a vehicle that does not fit everywhere.
    pub fn with_needs(
        lane: LaneId,
        s_m: f64,
        offset_m: f64,
        straight: f64,
        needs: Needs,
        choices: Stream,
        roads: &Roads,
    ) -> Self {
        let mut route = Self { lanes: VecDeque::from([lane]), s_m, base_m: 0.0, offset_m, straight, needs, choices };
        route.extend(roads);
        route
    }

    /// Whether the vehicle fits wherever it goes in the next `ahead_m`.
    pub fn fits(&self, ahead_m: f64, roads: &Roads) -> bool {
        if !self.needs.is_some() {
            return true;
        }
        let route = self.foreseen(ahead_m, roads);
        let mut start_m = -self.s_m;
        route.lanes.iter().all(|lane| {
            let fits = start_m > ahead_m || roads.fits(*lane, self.needs);
            start_m += roads.lane(*lane).length_m();
            fits
        })
    }

    /// Distance driven along the route.
    pub fn odometer_m(&self) -> f64 {
        self.base_m + self.s_m
    }

    /// Finds the car's middle on the route; calls `left` with each lane that it has left and the odometer at its end.
    pub fn track(&mut self, position: DVec3, roads: &Roads, mut left: impl FnMut(LaneId, f64)) {
        for _ in 0..4 {
            let lane = roads.lane(self.lanes[0]);
            let s = project_near(lane, position, self.s_m);
            if s < lane.length_m() - 1e-6 || self.lanes.len() == 1 {
                self.s_m = s;
                break;
            }
            self.base_m += lane.length_m();
            left(lane.id, self.base_m);
            self.lanes.pop_front();
            self.s_m = 0.0;
        }
        self.extend(roads);
    }

    fn extend(&mut self, roads: &Roads) {
        self.extend_to(ROUTE_AHEAD_M, roads);
    }

    /// The way that will be driven, known farther ahead than drivers know it themselves.
    pub fn foreseen(&self, ahead_m: f64, roads: &Roads) -> Self {
        let mut route = self.clone();
        route.extend_to(ahead_m, roads);
        route
    }

    fn extend_to(&mut self, ahead_m: f64, roads: &Roads) {
        let mut ahead: f64 = self.lanes.iter().map(|l| roads.lane(*l).length_m()).sum::<f64>() - self.s_m;
        while ahead < ahead_m && self.lanes.len() < 64 {
            let last = roads.lane(*self.lanes.back().expect("a route has a lane"));
            let Some(next) = self.choose(last, roads) else { break };
            ahead += roads.lane(next).length_m();
            self.lanes.push_back(next);
        }
    }

    /// One of the lanes that follow: at random, but no dead end where another way leads on.
    fn choose(&mut self, from: &Lane, roads: &Roads) -> Option<LaneId> {
        // Lanes for bicycles lead on to others where there are any.
        let leads_on =
            from.kind == LaneKind::Biking && from.successors.iter().any(|s| roads.lane(*s).kind == from.kind);
        let kind = if leads_on { LaneKind::Biking } else { LaneKind::Driving };
        let usable = || from.successors.iter().copied().filter(|s| roads.lane(*s).kind == kind);
        let longest = usable().map(|s| roads.reach_m(s)).fold(0.0, f64::max);
        let open: Vec<LaneId> = usable().filter(|s| roads.reach_m(*s) >= longest.min(250.0) - 1e-9).collect();
        let end = from.center[from.center.len() - 1] - from.center[from.center.len() - 2];
        let weights: Vec<f64> = open
            .iter()
            .map(|s| {
                let c = &roads.lane(*s).center;
                let out = c[c.len() - 1] - c[c.len() - 2];
                let turn = math::atan2(end.x * out.y - end.y * out.x, end.x * out.x + end.y * out.y).abs();
                let weight = match (turn < 0.6, turn < 2.5) {
                    (true, _) => self.straight,
                    (false, true) => 1.0,
                    // Turning round is for dead ends.
                    (false, false) => 0.02,
                };
                if self.needs.is_some() && !self.leads_on(*s, roads) { TOO_NARROW * weight } else { weight }
            })
            .collect();
        let i = self.choices.weighted(&weights);
        open.get(i).copied()
    }

    /// Whether a lane has room for the vehicle, and what follows a junction has it, too.
    fn leads_on(&self, lane: LaneId, roads: &Roads) -> bool {
        let is_fit = |id: &LaneId| roads.lane(*id).kind != LaneKind::Driving || roads.fits(*id, self.needs);
        is_fit(&lane) && (roads.lane(lane).junction.is_none() || roads.lane(lane).successors.iter().all(is_fit))
    }

    /// The place `distance_m` ahead of the car's middle (behind it down to the lane's start), and the direction there;
    /// beyond the route's end it goes straight on.
    pub fn ahead(&self, distance_m: f64, roads: &Roads) -> Ahead {
        let mut s = self.s_m + distance_m;
        let mut lane = roads.lane(self.lanes[0]);
        for next in self.lanes.iter().skip(1) {
            if s <= lane.length_m() {
                break;
            }
            s -= lane.length_m();
            lane = roads.lane(*next);
        }
        let i = lane.s_m.partition_point(|v| *v <= s).clamp(1, lane.center.len() - 1);
        let (a, b) = (lane.center[i - 1].truncate(), lane.center[i].truncate());
        let tangent = (b - a).normalize();
        let at = a + tangent * (s - lane.s_m[i - 1]) + tangent.perp() * self.offset_m;
        Ahead { distance_m, at, tangent }
    }

    /// Distance from the car's middle to the end of the known route.
    pub fn remaining_m(&self, roads: &Roads) -> f64 {
        self.lanes.iter().map(|l| roads.lane(*l).length_m()).sum::<f64>() - self.s_m
    }

    /// The speed at which the bends and limits ahead can still be met, braking at `comfortable_mps2`.
    pub fn speed_for_bends(&self, speed_mps: f64, comfortable_mps2: f64, roads: &Roads) -> f64 {
        let horizon_m = speed_mps * speed_mps / (2.0 * comfortable_mps2) + 8.0;
        let mut start_m = -self.s_m;
        let mut limit = f64::INFINITY;
        for id in &self.lanes {
            let lane = roads.lane(*id);
            let first = lane.s_m.partition_point(|v| *v + start_m < -1.0);
            for (s, v) in lane.s_m[first..].iter().zip(&roads.allowed_mps[id.0][first..]) {
                let d = s + start_m;
                if d > horizon_m {
                    return limit;
                }
                limit = limit.min((v * v + 2.0 * comfortable_mps2 * d.max(0.0)).sqrt());
            }
            start_m += lane.length_m();
        }
        limit
    }
}

/// Distance along a lane of the point nearest to `position`, looked for around `hint_m` only.
fn project_near(lane: &Lane, position: DVec3, hint_m: f64) -> f64 {
    let first = lane.s_m.partition_point(|v| *v < hint_m - 3.0).clamp(1, lane.center.len() - 1);
    let (mut best_s, mut best_d) = (hint_m, f64::INFINITY);
    for i in first..lane.center.len() {
        if lane.s_m[i - 1] > hint_m + 6.0 {
            break;
        }
        let (a, b) = (lane.center[i - 1].truncate(), lane.center[i].truncate());
        let (p, d) = (position.truncate() - a, b - a);
        let t = (p.dot(d) / d.length_squared()).clamp(0.0, 1.0);
        let distance = (p - d * t).length_squared();
        if distance < best_d {
            (best_d, best_s) = (distance, lane.s_m[i - 1] + (lane.s_m[i] - lane.s_m[i - 1]) * t);
        }
    }
    best_s
}
