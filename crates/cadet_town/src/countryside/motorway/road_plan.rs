//! What each road of a motorway has, and where its middle is.

use std::collections::BTreeMap;

use crate::network::{Lane, LaneKind, RoadNetwork};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::Polyline;
use cadet_base::rng::StreamKey;

/// Shares of the roads with a bridge, with a gantry on each side, and with a board beside it.
const BRIDGE_SHARE: f64 = 0.3;
pub(super) const GANTRY_SHARE: f64 = 0.3;
/// Where along a road a bridge may cross.
const BRIDGE_AT: (f64, f64) = (0.25, 0.75);
/// Share of motorways with a wall of concrete on the median.
const CONCRETE_SHARE: f64 = 0.4;

/// One road: the piece of a motorway between two of its ends.
pub(super) struct RoadPlan {
    pub road: u32,
    /// Points of its middle, and the distance along it at each.
    line: Polyline,
    /// From the middle to the asphalt's outer edge, and to its inner one.
    pub half_paved_m: f64,
    pub half_median_m: f64,
    pub num_lanes: usize,
    pub has_hard_shoulder: bool,
    pub speed_kmh: u32,
    /// Where a bridge crosses, if one does.
    pub bridge_m: Option<f64>,
    pub variant: usize,
    /// Whether a wall of concrete stands on the median, rather than a steel barrier.
    pub is_concrete: bool,
    /// How many half kilometers lie before it.
    pub number: usize,
}

impl RoadPlan {
    pub fn length_m(&self) -> f64 {
        self.line.length_m()
    }

    /// The middle of the median at a distance along the road, and the direction there.
    pub fn middle(&self, at_m: f64) -> (DVec2, DVec2) {
        (self.line.at(at_m), self.line.tangent(at_m))
    }

    /// Whether something that reaches so far to both sides keeps off the bridge.
    pub fn is_clear_of_bridge(&self, at_m: f64, reach_m: f64) -> bool {
        self.bridge_m.is_none_or(|bridge_m| (bridge_m - at_m).abs() > reach_m)
    }
}

/// Draws the plans of all roads.
pub(super) fn draw(key: &StreamKey, network: &RoadNetwork) -> Vec<RoadPlan> {
    let mut by_road: BTreeMap<u32, Vec<&Lane>> = BTreeMap::new();
    for lane in network.lanes.iter().filter(|l| l.junction.is_none()) {
        by_road.entry(lane.road).or_default().push(lane);
    }
    let is_concrete = key.stream("motorway/median").chance(CONCRETE_SHARE);
    let plan = |(number, (road, lanes)): (usize, (u32, Vec<&Lane>))| {
        let of = |kind: LaneKind| lanes.iter().filter(move |l| l.kind == kind).copied();
        let median = of(LaneKind::Median).next()?;
        let half_median_m = median.width_at(0.0);
        let points = (0..median.center.len())
            .map(|i| {
                let pose = median.pose_at(median.s_m[i]);
                let left = (pose.rotation * DVec3::Y).truncate().normalize_or_zero();
                // The other half of the median is to the left, as everything is on the other carriageway.
                median.center[i].truncate() + left * (median.width_m[i] / 2.0)
            })
            .collect();
        let line = Polyline::new(points);
        let paved_m: f64 =
            [LaneKind::Driving, LaneKind::Shoulder].into_iter().flat_map(of).map(|l| l.width_at(0.0)).sum();
        let widest_m = of(LaneKind::Shoulder).map(|l| l.width_at(0.0)).fold(0.0, f64::max);
        let mut s = key.indexed("motorway/road", number as u64);
        let (has_bridge, at, variant) = (s.chance(BRIDGE_SHARE), s.within(BRIDGE_AT), s.below(2));
        let driving = of(LaneKind::Driving).next()?;
        Some(RoadPlan {
            road,
            half_paved_m: half_median_m + paved_m / 2.0,
            half_median_m,
            num_lanes: of(LaneKind::Driving).count() / 2,
            has_hard_shoulder: widest_m > 1.5,
            speed_kmh: (driving.speed_limit_mps * 3.6).round() as u32,
            bridge_m: has_bridge.then(|| at * line.length_m()),
            variant,
            is_concrete,
            number,
            line,
        })
    };
    by_road.into_iter().enumerate().filter_map(plan).collect()
}
