//! Where there is room for what is wider or longer than a van.

use crate::footprint::Footprint;
use cadet_base::math::{self, DVec2, DVec3};
use cadet_town::{Lane, LaneId};

/// How much wider than a truck its lane is, and what it keeps beside what stands.
const ROOM_IN_LANE_M: f64 = 0.22;
const ROOM_BESIDE_M: f64 = 0.25;
/// Aisles of car parks and lanes of a campus, which are no faster, are closed to what needs room.
const CLOSED_TO_TRUCKS_MPS: f64 = 6.0;
/// Vans shorter than this take every bend of a street; longer ones only bends of so much of their length.
const LONG_VAN_M: f64 = 5.6;
const VAN_RADIUS_OF_LENGTH: f64 = 1.2;
/// Nothing farther from a lane than this matters.
const FARTHEST_M: f64 = 4.0;
/// From a vehicle's middle to its rear axle, of its length.
const AXLE_OF_LENGTH: f64 = 0.24;
/// A nose swings out where the vehicle's middle is in a bend, up to so far behind and before.
const SWINGS_WITHIN_M: f64 = 6.0;
/// Bends flatter than this count as straight, and the room that a front corner keeps in tighter ones.
const BENDS_M: f64 = 100.0;
const ROOM_OUTSIDE_M: f64 = 0.15;

/// What a wide or long vehicle needs of the lanes that it takes; cars need nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Needs {
    pub width_m: f64,
    pub length_m: f64,
    pub radius_m: f64,
    /// Whether it needs lanes that are wider than itself.
    pub keeps_in_lane: bool,
}

impl Needs {
    /// Of a truck: what is long sweeps over curbs in tight bends.
    pub fn of_truck(size_lwh: DVec3) -> Self {
        let radius_m = 13.0 + 1.2 * (size_lwh.x - 7.2).max(0.0);
        Self { width_m: size_lwh.y, length_m: size_lwh.x, radius_m, keeps_in_lane: true }
    }

    /// Of what is no truck: a long van swings into the oncoming lane in tight bends.
    pub fn of_van(size_lwh: DVec3) -> Self {
        if size_lwh.x <= LONG_VAN_M {
            return Self::default();
        }
        let radius_m = VAN_RADIUS_OF_LENGTH * size_lwh.x;
        Self { width_m: size_lwh.y, length_m: size_lwh.x, radius_m, keeps_in_lane: false }
    }

    pub fn is_some(&self) -> bool {
        *self != Self::default()
    }

    /// How far from the line that its middle follows its outer front corner gets in a bend: the rear axle follows on
    /// a tighter circle about the same center.
    fn outside_m(&self, radius_m: f64) -> f64 {
        let axle_m = AXLE_OF_LENGTH * self.length_m;
        let axle_radius_m = (radius_m * radius_m - axle_m * axle_m).max(0.0).sqrt();
        math::hypot(axle_radius_m + self.width_m / 2.0, axle_m + self.length_m / 2.0) - radius_m
    }
}

/// What stands for good on the outer side of a bend.
#[derive(Debug, Clone, Copy)]
struct Outside {
    apart_m: f64,
    radius_m: f64,
}

/// The room that each lane offers.
#[derive(Debug, Default)]
pub(crate) struct Room {
    /// Radius of its tightest bend.
    tightest_m: Vec<f64>,
    /// From its middle to the nearest that stands beside it for good.
    clear_m: Vec<f64>,
    outside: Vec<Vec<Outside>>,
    /// At each point of its middle, to the left above 0.
    curvatures: Vec<Vec<f64>>,
}

impl Room {
    /// Of lanes of these curvatures, while nothing stands beside them.
    pub fn beside(curvatures: Vec<Vec<f64>>) -> Self {
        let tightest_m = curvatures.iter().map(|c| 1.0 / c.iter().map(|c| c.abs()).fold(1e-6, f64::max)).collect();
        let count = curvatures.len();
        Self { tightest_m, clear_m: vec![f64::INFINITY; count], outside: vec![Vec::new(); count], curvatures }
    }

    /// How far from its middle something that stands takes room from a lane.
    pub fn reach_m(o: &Footprint) -> f64 {
        o.half_length_m + o.half_width_m + FARTHEST_M
    }

    /// Takes note of what stands for good beside lanes.
    pub fn note<'a>(&mut self, o: &Footprint, lanes: impl Iterator<Item = &'a Lane>) {
        for lane in lanes {
            let points = lane.center.iter().map(|p| p.truncate()).enumerate();
            let near = points.filter(|(_, p)| (*p - o.center).length() < Self::reach_m(o) + 2.0);
            let apart = near.map(|(i, p)| (i, o.closest_point(p) - p));
            let Some((i, to)) = apart.min_by(|a, b| a.1.length().total_cmp(&b.1.length())) else { continue };
            let LaneId(number) = lane.id;
            self.clear_m[number] = self.clear_m[number].min(to.length());
            let radius_m = 1.0 / self.bend_away_from(lane, i, to).max(1e-6);
            if radius_m < BENDS_M {
                self.outside[number].push(Outside { apart_m: to.length(), radius_m });
            }
        }
    }

    /// The tightest curvature near a point of a lane away from what lies in a direction; 0 where it bends toward it.
    fn bend_away_from(&self, lane: &Lane, point: usize, to: DVec2) -> f64 {
        let (first, last) = (point.saturating_sub(1), (point + 1).min(lane.center.len() - 1));
        let tangent = (lane.center[last] - lane.center[first]).truncate();
        let side = tangent.perp_dot(to).signum();
        let LaneId(number) = lane.id;
        let along = lane.s_m.iter().zip(&self.curvatures[number]);
        let near = along.filter(|(s_m, _)| (**s_m - lane.s_m[point]).abs() <= SWINGS_WITHIN_M);
        near.map(|(_, curvature)| -side * curvature).fold(0.0, f64::max)
    }

    /// Whether a lane has what a vehicle needs.
    pub fn fits(&self, lane: &Lane, needs: Needs) -> bool {
        let LaneId(number) = lane.id;
        // How far its corners swing out of a bend, or its flank into it.
        let tightest_m = self.tightest_m[number];
        let swing_m = needs.length_m * needs.length_m / (8.0 * tightest_m.max(needs.length_m));
        let width_m = needs.width_m + swing_m;
        let is_wide = lane.junction.is_some() || lane.width_m.iter().all(|w| *w >= width_m + ROOM_IN_LANE_M);
        let is_open = lane.speed_limit_mps > CLOSED_TO_TRUCKS_MPS;
        let is_clear = self.clear_m[number] >= width_m / 2.0 + ROOM_BESIDE_M;
        is_open
            && (!needs.keeps_in_lane || is_wide && is_clear)
            && tightest_m >= needs.radius_m
            && self.outside[number].iter().all(|o| o.apart_m >= needs.outside_m(o.radius_m) + ROOM_OUTSIDE_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::streets::LaneGraph;
    use crate::tests::towns;
    use cadet_base::plane::unit;
    use cadet_town::RoadNetwork;

    const BEND_M: f64 = 21.0;

    /// Whether a vehicle fits through a bend of 4.7 m to the left where something stands so far from the lane's middle,
    /// at an angle along it and to the right above 0.
    fn fits(needs: Needs, at_rad: f64, apart_m: f64) -> bool {
        let mut network = RoadNetwork::default();
        let mut points = towns::line(DVec2::new(BEND_M, -40.0), DVec2::new(BEND_M, -1.0));
        points.extend(towns::arc(DVec2::ZERO, BEND_M, 0.0, math::PI / 2.0));
        let id = towns::lane(&mut network, &points, None, &|_, _| 0.0);
        let lane = &mut network.lanes[id.0];
        (lane.width_m, lane.speed_limit_mps) = (vec![4.7; lane.center.len()], 10.0);
        let mut graph = LaneGraph::new(towns::town(network, towns::ground(90.0, 5.0, &|_, _| 0.0), Vec::new()));
        let out = unit(at_rad);
        let (half_length_m, half_width_m) = (0.3, 0.3);
        let away_m = BEND_M + apart_m + half_length_m * apart_m.signum();
        let post = Footprint {
            center: out * away_m,
            heading: out,
            half_length_m,
            half_width_m,
            z_m: 0.0,
            velocity: DVec2::ZERO,
        };
        graph.note_standing(&[post]);
        graph.fits(id, needs)
    }

    /// How far outside of a circle, on which its middle goes, a vehicle reaches whose rear axle goes along itself.
    fn reach_m(needs: Needs) -> f64 {
        let (axle_m, half_m) = (AXLE_OF_LENGTH * needs.length_m, needs.length_m / 2.0);
        let lag_rad = math::asin(axle_m / BEND_M);
        let heading = DVec2::new(math::sin(lag_rad), math::cos(lag_rad));
        let corner = DVec2::new(BEND_M, 0.0) + heading * half_m - heading.perp() * needs.width_m / 2.0;
        corner.length() - BEND_M
    }

    #[test]
    fn a_bus_keeps_out_of_bends_where_its_nose_would_swing_into_what_stands() {
        for needs in [Needs::of_truck(DVec3::new(12.4, 2.6, 3.0)), Needs::of_van(DVec3::new(7.0, 2.3, 2.7))] {
            let reach_m = reach_m(needs);
            assert!(reach_m > needs.width_m / 2.0 + 0.5, "{reach_m}");
            for at_rad in [0.3, 0.8, 1.2] {
                assert!(!fits(needs, at_rad, reach_m), "{at_rad}: a corner would touch");
                assert!(fits(needs, at_rad, reach_m + 0.3), "{at_rad}: its corner stays clear");
                assert!(fits(needs, at_rad, -needs.width_m / 2.0 - 0.9), "{at_rad}: inside of the bend");
            }
        }
        let car = Needs::of_van(DVec3::new(4.5, 1.8, 1.5));
        assert!(fits(car, 0.8, 1.3), "cars take every street");
    }
}
