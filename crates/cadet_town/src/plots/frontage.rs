//! Frontages: the outer edges of the streets, along which plots lie.

use crate::network::{Lane, LaneId, LaneKind, RoadNetwork};
use crate::placement::Site;
use cadet_base::math::DVec2;
use cadet_base::plane::{DistanceFrom, Polyline, piece_at};

/// The outer edge of a street's sidewalk on one side. Points run with the traffic beside it, so that the plots lie to
/// the **right** of it and the street to its left.
#[derive(Debug, Clone)]
pub(crate) struct Frontage {
    /// The road that it belongs to.
    pub road: u32,
    /// Points about 1 m apart.
    pub line: Polyline,
    /// Distance from each point to the outer edge of the carriageway.
    pub sidewalk_m: Vec<f64>,
    /// Speed limit of the lane beside it.
    pub speed_limit_mps: f64,
    /// Whether the road has a median or two lanes a direction.
    pub is_main_road: bool,
    /// The lane that ends where it does; `None` where it runs against the traffic.
    pub lane: Option<LaneId>,
}

impl Frontage {
    fn new(lane: &Lane, runs_along: bool, is_main_road: bool, mut edge: Vec<(DVec2, f64)>) -> Self {
        edge.dedup_by(|b, a| (b.0 - a.0).length() < 0.3);
        let (points, sidewalk_m) = edge.into_iter().unzip();
        Self {
            road: lane.road,
            line: Polyline::new(points),
            sidewalk_m,
            speed_limit_mps: lane.speed_limit_mps,
            is_main_road,
            lane: runs_along.then_some(lane.id),
        }
    }

    /// Length along the edge.
    pub fn length_m(&self) -> f64 {
        self.line.length_m()
    }

    /// The point at a distance along the edge.
    pub fn at(&self, s_m: f64) -> DVec2 {
        self.line.at(s_m.clamp(0.0, self.length_m()))
    }

    /// The direction of travel at a distance along the edge.
    pub fn along(&self, s_m: f64) -> DVec2 {
        self.line.tangent(s_m)
    }

    /// Away from the street at a distance along the edge.
    pub fn out(&self, s_m: f64) -> DVec2 {
        right_of(self.along(s_m))
    }

    /// The place so far behind the edge at a distance along it, or before it where negative.
    pub fn behind(&self, s_m: f64, behind_m: f64) -> DVec2 {
        self.at(s_m) + self.out(s_m) * behind_m
    }

    /// Width from the carriageway's edge to this edge.
    pub fn sidewalk_at(&self, s_m: f64) -> f64 {
        let (i, t) = piece_at(self.line.s_m(), s_m.clamp(0.0, self.length_m()));
        self.sidewalk_m[i - 1] + (self.sidewalk_m[i] - self.sidewalk_m[i - 1]) * t
    }

    /// The points strictly between two distances.
    pub fn between(&self, from_m: f64, to_m: f64) -> &[DVec2] {
        self.line.between(from_m, to_m)
    }
}

/// Distances up to a reach from every so many points of the streets' edges.
pub(crate) fn distance_from_streets(frontages: &[Frontage], step: usize, reach_m: f64) -> DistanceFrom {
    DistanceFrom::new(frontages.iter().flat_map(|f| f.line.points().iter().step_by(step).map(|p| [*p; 2])), reach_m)
}

/// To the right of a direction.
pub(crate) fn right_of(along: DVec2) -> DVec2 {
    DVec2::new(along.y, -along.x)
}

/// Signed lateral offset of a lane from a pose (left is positive) and its half width there; `None` where the lane does
/// not pass beside it.
fn beside(lane: &Lane, at: DVec2, along: DVec2, guess: &mut usize) -> Option<(f64, f64)> {
    // Lanes of one road run side by side: walk from the last index to the nearest point.
    let distance = |i: usize| (lane.center[i].truncate() - at).length_squared();
    let mut i = (*guess).min(lane.center.len() - 1);
    while i + 1 < lane.center.len() && distance(i + 1) <= distance(i) {
        i += 1;
    }
    while i > 0 && distance(i - 1) < distance(i) {
        i -= 1;
    }
    *guess = i;
    let d = lane.center[i].truncate() - at;
    // More than a sampling step ahead or behind: the lane ends before it comes here.
    if d.dot(along).abs() > 1.6 {
        return None;
    }
    Some((-d.dot(right_of(along)), lane.width_m[i] / 2.0))
}

/// The frontages of all streets, junctions left out.
pub(crate) fn frontages(network: &RoadNetwork, site: &Site) -> Vec<Frontage> {
    let open: Vec<&Lane> = network.lanes.iter().filter(|l| l.junction.is_none()).collect();
    let mut frontages = Vec::new();
    for lane in open.iter().filter(|l| l.kind == LaneKind::Driving) {
        let neighbors: Vec<&Lane> = open.iter().filter(|l| l.road == lane.road && l.id != lane.id).copied().collect();
        let mut guesses: Vec<usize> = neighbors.iter().map(|l| l.center.len() / 2).collect();
        let mut sides: [Vec<(DVec2, f64)>; 2] = [Vec::new(), Vec::new()];
        let mut inner = [0, 0];
        let mut num_wide = 0;
        let count = (lane.length_m().floor() as usize).max(1);
        for k in 0..=count {
            let s = lane.length_m() * k as f64 / count as f64;
            let pose = lane.pose_at(s);
            let at = pose.translation.truncate();
            let along = (pose.rotation * cadet_base::math::DVec3::X).truncate().normalize();
            let own = lane.width_at(s) / 2.0;
            // (outer edge of all lanes, of the carriageway, another driving lane on this side) right and left.
            let (mut outer, mut road, mut has_driving) = ([own; 2], [own; 2], [false; 2]);
            let mut abreast = 1;
            for (other, guess) in neighbors.iter().zip(&mut guesses) {
                let Some((offset, half)) = beside(other, at, along, guess) else { continue };
                let side = usize::from(offset > 0.0);
                outer[side] = outer[side].max(offset.abs() + half);
                if matches!(other.kind, LaneKind::Driving | LaneKind::Parking | LaneKind::Biking | LaneKind::Tram) {
                    road[side] = road[side].max(offset.abs() + half);
                }
                has_driving[side] |= other.kind == LaneKind::Driving && offset.abs() > 0.5;
                abreast += usize::from(other.kind == LaneKind::Driving);
            }
            num_wide += usize::from(abreast >= 4);
            for side in 0..2 {
                inner[side] += usize::from(has_driving[side]);
                let out = right_of(along) * if side == 0 { 1.0 } else { -1.0 };
                // Sidewalks that the map leaves out, but the ground has.
                let mut reach = outer[side];
                while reach < outer[side] + 4.0 && site.clearance_m(at + out * reach) < -0.1 {
                    reach += 0.2;
                }
                sides[side].push((at + out * reach, reach - road[side]));
            }
        }
        // Where two lane sections meet, the lanes of both are beside.
        let is_main_road =
            2 * num_wide > count || neighbors.iter().any(|l| matches!(l.kind, LaneKind::Median | LaneKind::Tram));
        // Along the left side the plots lie to the right the other way.
        sides[1].reverse();
        for (side, edge) in sides.into_iter().enumerate() {
            if inner[side] * 2 <= count {
                let frontage = Frontage::new(lane, side == 0, is_main_road, edge);
                if frontage.line.points().len() > 3 {
                    frontages.push(frontage);
                }
            }
        }
    }
    frontages
}
