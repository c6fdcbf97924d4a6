//! A driver's way through the lanes: what lies ahead, and how fast its bends may be taken.

use std::collections::VecDeque;

use super::lane_graph::{LaneGraph, LanePosition};
use super::room::Needs;
use crate::footprint::Footprint;
use crate::params::TURNS_RAD;
use cadet_base::math::{self, DVec2, DVec3};
use cadet_base::plane::{nearest, piece_at};
use cadet_base::rng::Stream;
use cadet_town::{Lane, LaneId, LaneKind};

/// How much likelier than turning off it is that the ego, or another car, goes straight on; long vehicles keep to
/// where they fit.
pub(crate) const EGO_STRAIGHT_WEIGHT: f64 = 3.0;
pub(crate) const CAR_STRAIGHT_WEIGHT: f64 = 1.2;
pub(crate) const LONG_STRAIGHT_WEIGHT: f64 = 500.0;
/// How much less likely a way is that has no room for a vehicle.
const TOO_NARROW: f64 = 1e-5;
/// Draws of another way at a junction.
const OTHER_WAYS: u32 = 16;
/// How far ahead a route is always known: as far as others reckon with who comes to a junction, and on motorways.
const ROUTE_AHEAD_M: f64 = 110.0;
const ROUTE_AHEAD_S: f64 = 12.0;
const FAST_AHEAD_M: f64 = 450.0;

/// A place ahead on a route.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ahead {
    /// Distance from the car's middle.
    pub distance_m: f64,
    pub at: DVec2,
    /// Height of the road there.
    pub z_m: f64,
    pub tangent: DVec2,
}

impl Ahead {
    /// What a box of a size covers there that heads along the route at a speed.
    pub fn covered_by(&self, size_lwh: DVec3, speed_mps: f64) -> Footprint {
        Footprint {
            center: self.at,
            heading: self.tangent,
            half_length_m: size_lwh.x / 2.0,
            half_width_m: size_lwh.y / 2.0,
            z_m: self.z_m,
            velocity: self.tangent * speed_mps,
        }
    }

    /// What somebody would cover there, heading along the route.
    pub fn moved(&self, own: &Footprint) -> Footprint {
        Footprint { center: self.at, heading: self.tangent, z_m: self.z_m, ..*own }
    }
}

/// A car's way: the lane it is on, those that follow, and how far along it is.
#[derive(Debug, Clone)]
pub(crate) struct Route {
    /// The current lane first; never empty.
    pub lanes: VecDeque<LaneId>,
    /// Distance of the car's middle along the current lane.
    pub s_m: f64,
    /// Distance driven along the route until the current lane's start.
    base_m: f64,
    /// Offset to the left of the lane's middle that the driver keeps.
    pub offset_m: f64,
    /// Weight of going straight on against turning off.
    straight_weight: f64,
    needs: Needs,
    /// Of a cyclist: the distance kept from the border of a lane for cars that is at the curb.
    keeps_m: Option<f64>,
    choices: Stream,
}

impl Route {
    pub fn new(at: LanePosition, straight_weight: f64, choices: Stream, graph: &LaneGraph) -> Self {
        Self::with_needs(at, straight_weight, Needs::default(), choices, graph)
    }

    /// The route of a vehicle that does not fit everywhere.
    pub fn with_needs(
        at: LanePosition,
        straight_weight: f64,
        needs: Needs,
        choices: Stream,
        graph: &LaneGraph,
    ) -> Self {
        let LanePosition { lane, s_m, left_m: offset_m } = at;
        let lanes = VecDeque::from([lane]);
        let mut route = Self { lanes, s_m, base_m: 0.0, offset_m, straight_weight, needs, keeps_m: None, choices };
        route.extend(graph);
        route
    }

    /// The route of a cyclist, in the middle of lanes for bicycles where there are any, and so far from the border at
    /// the curb of others.
    pub fn by_bicycle(
        lane: LaneId,
        s_m: f64,
        straight_weight: f64,
        keeps_m: f64,
        choices: Stream,
        graph: &LaneGraph,
    ) -> Self {
        let (lanes, needs) = (VecDeque::from([lane]), Needs::default());
        let keeps_m = Some(keeps_m);
        let mut route = Self { lanes, s_m, base_m: 0.0, offset_m: 0.0, straight_weight, needs, keeps_m, choices };
        route.offset_m = route.usual_m(graph.lane(lane), s_m);
        route.extend(graph);
        route
    }

    /// Where the vehicle's middle is.
    pub fn position(&self) -> LanePosition {
        LanePosition { lane: self.lanes[0], s_m: self.s_m, left_m: self.offset_m }
    }

    /// The offset to the left of a lane's middle at which a cyclist rides before anything is in the way; 0 for drivers.
    pub fn usual_m(&self, lane: &Lane, s_m: f64) -> f64 {
        match self.keeps_m {
            Some(keeps_m) if lane.kind != LaneKind::Biking => {
                lane.curb_side() * (lane.width_at(s_m) / 2.0 - keeps_m).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// The offset to the left of a lane's middle where the route leads over it. Between lanes for cars and lanes for bicycles
    /// what a cyclist keeps off the usual line stays the same.
    fn offset_on(&self, lane: &Lane, s_m: f64, graph: &LaneGraph) -> f64 {
        let here = graph.lane(self.lanes[0]);
        if self.keeps_m.is_none() || lane.kind == here.kind {
            return self.offset_m;
        }
        self.offset_m - self.usual_m(here, self.s_m) + self.usual_m(lane, s_m)
    }

    /// The route of a tram: along lanes that are known to the end of the line.
    pub fn along(lanes: VecDeque<LaneId>, s_m: f64) -> Self {
        let choices = Stream::from_seed("track", 0);
        let (base_m, offset_m, straight_weight, needs) = (0.0, 0.0, LONG_STRAIGHT_WEIGHT, Needs::default());
        Self { lanes, s_m, base_m, offset_m, straight_weight, needs, keeps_m: None, choices }
    }

    /// Whether the vehicle fits wherever it goes in the next `ahead_m`.
    pub fn fits(&self, ahead_m: f64, graph: &LaneGraph) -> bool {
        if !self.needs.is_some() {
            return true;
        }
        let route = self.foreseen(ahead_m, graph);
        let mut start_m = -self.s_m;
        route.lanes.iter().all(|lane| {
            let fits = start_m > ahead_m || graph.fits(*lane, self.needs);
            start_m += graph.lane(*lane).length_m();
            fits
        })
    }

    /// Whether the vehicle fits on a lane.
    pub fn may_use(&self, lane: LaneId, graph: &LaneGraph) -> bool {
        !self.needs.is_some() || graph.fits(lane, self.needs)
    }

    /// Goes on along a lane beside the current one, where it is now; returns the offset to the left of the new lane's
    /// middle, which it keeps.
    pub fn change_to(&mut self, lane: LaneId, graph: &LaneGraph) -> f64 {
        let (here, odometer_m) = (self.ahead(0.0, graph), self.odometer_m());
        let target = graph.lane(lane);
        let (s_m, _) = target.project(DVec3::new(here.at.x, here.at.y, target.center[0].z));
        self.lanes = VecDeque::from([lane]);
        (self.s_m, self.base_m, self.offset_m) = (s_m, odometer_m - s_m, 0.0);
        let middle = self.ahead(0.0, graph);
        self.offset_m = middle.tangent.perp_dot(here.at - middle.at);
        self.extend(graph);
        self.offset_m
    }

    /// Distance driven along the route.
    pub fn odometer_m(&self) -> f64 {
        self.base_m + self.s_m
    }

    /// Finds the car's middle on the route; calls `left` with each lane that it has left and the odometer at its end.
    pub fn track(&mut self, position: DVec3, graph: &LaneGraph, mut left: impl FnMut(LaneId, f64)) {
        for _ in 0..4 {
            let lane = graph.lane(self.lanes[0]);
            let s = project_near(lane, position, self.s_m);
            if s < lane.length_m() - 1e-6 || self.lanes.len() == 1 {
                self.s_m = s;
                break;
            }
            self.base_m += lane.length_m();
            left(lane.id, self.base_m);
            self.s_m = lane.length_m();
            let offset_m = self.offset_on(graph.lane(self.lanes[1]), 0.0, graph);
            self.lanes.pop_front();
            (self.s_m, self.offset_m) = (0.0, offset_m);
        }
        self.extend(graph);
    }

    fn extend(&mut self, graph: &LaneGraph) {
        let limit_mps = graph.lane(self.lanes[0]).speed_limit_mps;
        let is_fast = graph.is_fast(self.lanes[0]);
        let ahead_m = if is_fast { FAST_AHEAD_M } else { ROUTE_AHEAD_M.max(ROUTE_AHEAD_S * limit_mps) };
        self.extend_to(ahead_m, graph);
    }

    /// Takes another way at the next junction, if another leads on; whether it does.
    pub fn turn_elsewhere(&mut self, graph: &LaneGraph) -> bool {
        let is_across = |id: &LaneId| graph.lane(*id).junction.is_some();
        let Some(k) = self.lanes.iter().position(is_across).filter(|k| *k > 0) else { return false };
        let (before, refused) = (graph.lane(self.lanes[k - 1]), self.lanes[k]);
        let draws = (0..OTHER_WAYS).filter_map(|_| self.choose(before, graph)).collect::<Vec<_>>();
        let leads_on = |id: &LaneId| *id != refused && (!self.needs.is_some() || self.leads_on(*id, graph));
        let Some(other) = draws.into_iter().find(leads_on) else { return false };
        self.lanes.truncate(k);
        self.lanes.push_back(other);
        self.extend(graph);
        true
    }

    /// The way that will be driven, known farther ahead than drivers know it themselves.
    pub fn foreseen(&self, ahead_m: f64, graph: &LaneGraph) -> Self {
        let mut route = self.clone();
        route.extend_to(ahead_m, graph);
        route
    }

    fn extend_to(&mut self, ahead_m: f64, graph: &LaneGraph) {
        let mut ahead: f64 = self.lanes.iter().map(|l| graph.lane(*l).length_m()).sum::<f64>() - self.s_m;
        while ahead < ahead_m {
            let last = graph.lane(*self.lanes.back().expect("a route has a lane"));
            let Some(next) = self.choose(last, graph) else { break };
            ahead += graph.lane(next).length_m();
            self.lanes.push_back(next);
        }
    }

    /// One of the lanes that follow: at random, but no dead end where another way leads on.
    fn choose(&mut self, from: &Lane, graph: &LaneGraph) -> Option<LaneId> {
        // Cyclists take lanes for bicycles where there are any.
        let may_ride =
            self.keeps_m.is_some() && from.successors.iter().any(|s| graph.lane(*s).kind == LaneKind::Biking);
        let kind = match from.kind {
            LaneKind::Tram => LaneKind::Tram,
            _ if may_ride => LaneKind::Biking,
            _ => LaneKind::Driving,
        };
        let usable = || from.successors.iter().copied().filter(|s| graph.lane(*s).kind == kind);
        let longest = usable().map(|s| graph.reach_m(s)).fold(0.0, f64::max);
        let open: Vec<LaneId> = usable().filter(|s| graph.reach_m(*s) >= longest.min(250.0) - 1e-9).collect();
        let end = from.center[from.center.len() - 1] - from.center[from.center.len() - 2];
        let weights: Vec<f64> = open
            .iter()
            .map(|s| {
                let c = &graph.lane(*s).center;
                let out = c[c.len() - 1] - c[c.len() - 2];
                let turn = math::atan2(end.x * out.y - end.y * out.x, end.x * out.x + end.y * out.y).abs();
                let weight = match (turn < TURNS_RAD, turn < 2.5) {
                    (true, _) => self.straight_weight,
                    (false, true) => 1.0,
                    // Turning round is for dead ends.
                    (false, false) => 0.02,
                };
                if self.needs.is_some() && !self.leads_on(*s, graph) { TOO_NARROW * weight } else { weight }
            })
            .collect();
        let i = self.choices.weighted(&weights);
        open.get(i).copied()
    }

    /// Whether a lane has room for the vehicle, and what follows a junction has it, too.
    fn leads_on(&self, lane: LaneId, graph: &LaneGraph) -> bool {
        let is_fit = |id: &LaneId| graph.lane(*id).kind != LaneKind::Driving || graph.fits(*id, self.needs);
        is_fit(&lane) && (graph.lane(lane).junction.is_none() || graph.lane(lane).successors.iter().all(is_fit))
    }

    /// The place `distance_m` ahead of the car's middle (behind it down to the lane's start), and the direction there;
    /// beyond the route's end it goes straight on.
    pub fn ahead(&self, distance_m: f64, graph: &LaneGraph) -> Ahead {
        let mut s = self.s_m + distance_m;
        let mut lane = graph.lane(self.lanes[0]);
        for next in self.lanes.iter().skip(1) {
            if s <= lane.length_m() {
                break;
            }
            s -= lane.length_m();
            lane = graph.lane(*next);
        }
        let (i, share) = piece_at(&lane.s_m, s);
        let (a, b) = (lane.center[i - 1].truncate(), lane.center[i].truncate());
        let tangent = (b - a).normalize();
        let at = a + (b - a) * share + tangent.perp() * self.offset_on(lane, s, graph);
        let z_m = math::lerp(lane.center[i - 1].z, lane.center[i].z, share.clamp(0.0, 1.0));
        Ahead { distance_m, at, z_m, tangent }
    }

    /// Distance from the car's middle to where its road ends; `None` while nobody knows of an end.
    pub fn ends_in_m(&self, graph: &LaneGraph) -> Option<f64> {
        let last = graph.lane(*self.lanes.back()?);
        last.successors.is_empty().then(|| self.remaining_m(graph))
    }

    /// Whether the road ends with the map within a distance from the car's middle.
    pub fn leads_off_map(&self, within_m: f64, graph: &LaneGraph) -> bool {
        let last = self.lanes.back().map(|id| graph.lane(*id));
        last.is_some_and(|lane| {
            lane.successors.is_empty() && self.remaining_m(graph) < within_m && graph.ends_with_map(lane)
        })
    }

    /// Distance from the car's middle to the end of the known route.
    pub fn remaining_m(&self, graph: &LaneGraph) -> f64 {
        self.lanes.iter().map(|l| graph.lane(*l).length_m()).sum::<f64>() - self.s_m
    }

    /// The speed at which the bends and limits ahead can still be met, braking at `comfortable_mps2`.
    pub fn speed_for_bends(&self, speed_mps: f64, comfortable_mps2: f64, graph: &LaneGraph) -> f64 {
        let horizon_m = speed_mps * speed_mps / (2.0 * comfortable_mps2) + 8.0;
        let mut start_m = -self.s_m;
        let mut limit = f64::INFINITY;
        for id in &self.lanes {
            let lane = graph.lane(*id);
            let first = lane.s_m.partition_point(|v| *v + start_m < -1.0);
            for (s, v) in lane.s_m[first..].iter().zip(&graph.allowed_mps(*id)[first..]) {
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
    let last = lane.center.len() - 1;
    let first = lane.s_m.partition_point(|v| *v < hint_m - 3.0).clamp(1, last);
    let end = lane.s_m.partition_point(|v| *v <= hint_m + 6.0).clamp(first, last);
    let points = lane.center[first - 1..=end].iter().map(|p| p.truncate());
    nearest(points, &lane.s_m[first - 1..=end], position.truncate()).0
}
