//! Where roads pass over others without a junction.

use std::collections::{BTreeMap, VecDeque};

use crate::network::{Lane, LaneKind};
use cadet_base::math::DVec3;

/// A road passes over another if it lies at least this far above it: less is no room for a car below a deck.
pub(crate) const CLEARANCE_M: f64 = 3.5;
/// Crossings nearer to each other than this, and by less at different heights, are of one bridge.
const JOIN_M: f64 = 45.0;
const ONE_DECK_M: f64 = 2.5;
/// A bridge that has two heights within this distance is a spiral's.
const SPIRAL_M: f64 = 4.0;
/// Lanes of one road lie over each other if their middles come nearer than by this share of what others overlap by.
const ONE_ROAD_SHARE: f64 = 0.5;
/// Points are looked for in squares of this size.
const CELL_M: f64 = 8.0;

/// A point of a lane over a point of another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// On the upper lane.
    pub upper: DVec3,
    /// On the lower lane.
    pub lower: DVec3,
    /// The upper lane and the lower one, as indices.
    pub lanes: [usize; 2],
    /// The lower one's point.
    pub point: usize,
}

/// All crossings of a bridge.
#[derive(Debug, Clone)]
pub(crate) struct Overpass {
    pub crossings: Vec<Crossing>,
}

impl Overpass {
    /// The overpasses of a network, of which each has a height of its own at every place.
    pub fn all(lanes: &[Lane]) -> Vec<Self> {
        Self::grouped(&crossings(lanes, CLEARANCE_M)).into_iter().filter(|o| !o.is_spiral()).collect()
    }

    /// The overpasses that crossings are of, those of spirals too.
    pub fn grouped(crossings: &[Crossing]) -> Vec<Self> {
        let cell = |p: DVec3| ((p.x / JOIN_M).floor() as i64, (p.y / JOIN_M).floor() as i64);
        let mut waiting: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
        for (k, crossing) in crossings.iter().enumerate() {
            waiting.entry(cell(crossing.upper)).or_default().push(k);
        }
        let mut is_grouped = vec![false; crossings.len()];
        let mut groups = Vec::new();
        for first in 0..crossings.len() {
            if std::mem::replace(&mut is_grouped[first], true) {
                continue;
            }
            let (mut group, mut queue) = (Vec::new(), VecDeque::from([first]));
            while let Some(k) = queue.pop_front() {
                let here = crossings[k].upper;
                group.push(crossings[k]);
                let (i, j) = cell(here);
                for (_, near) in (i - 1..=i + 1).flat_map(|i| waiting.range((i, j - 1)..=(i, j + 1))) {
                    for other in near {
                        let to = crossings[*other].upper - here;
                        let is_joined = to.truncate().length() < JOIN_M && to.z.abs() < ONE_DECK_M;
                        if is_joined && !std::mem::replace(&mut is_grouped[*other], true) {
                            queue.push_back(*other);
                        }
                    }
                }
            }
            groups.push(Self { crossings: group });
        }
        groups
    }

    /// Whether its road winds over itself, so that one place has two heights.
    pub fn is_spiral(&self) -> bool {
        let mut heights: BTreeMap<(i64, i64), (f64, f64)> = BTreeMap::new();
        self.crossings.iter().any(|c| {
            let square = ((c.upper.x / SPIRAL_M).floor() as i64, (c.upper.y / SPIRAL_M).floor() as i64);
            let (low, high) = heights.entry(square).or_insert((c.upper.z, c.upper.z));
            (*low, *high) = (low.min(c.upper.z), high.max(c.upper.z));
            *high - *low > ONE_DECK_M
        })
    }

    /// The crossing whose upper point is nearest in plan, and how far that is.
    pub fn nearest(&self, p: DVec3) -> (&Crossing, f64) {
        let distance_m = |c: &Crossing| (c.upper - p).truncate().length();
        let nearest = self.crossings.iter().min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        let nearest = nearest.expect("an overpass has crossings");
        (nearest, distance_m(nearest))
    }
}

/// Whether a lane is part of a road's surface.
fn is_surface(lane: &Lane) -> bool {
    !matches!(lane.kind, LaneKind::Other | LaneKind::Verge)
}

/// The points of lanes in one cell of a grid, by lane and point.
struct Cell {
    lowest_m: f64,
    points: Vec<(usize, usize)>,
}

/// All points of lanes that lie over others' by at least so much, by upper lane and point.
pub(crate) fn crossings(lanes: &[Lane], at_least_m: f64) -> Vec<Crossing> {
    let surfaces = || lanes.iter().enumerate().filter(|(_, lane)| is_surface(lane));
    let points = || surfaces().flat_map(|(_, lane)| &lane.center);
    let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
    if high - low < at_least_m || high.is_infinite() {
        return Vec::new();
    }
    let cell = |p: DVec3| ((p.x / CELL_M).floor() as i64, (p.y / CELL_M).floor() as i64);
    let mut by_cell: BTreeMap<(i64, i64), Cell> = BTreeMap::new();
    for (i, lane) in surfaces() {
        for (k, p) in lane.center.iter().enumerate() {
            let cell = by_cell.entry(cell(*p)).or_insert(Cell { lowest_m: p.z, points: Vec::new() });
            cell.lowest_m = cell.lowest_m.min(p.z);
            cell.points.push((i, k));
        }
    }
    let widest_m = surfaces().flat_map(|(_, lane)| &lane.width_m).copied().fold(0.0, f64::max);
    let mut crossings = Vec::new();
    for (upper, lane) in surfaces() {
        for (p, width_m) in lane.center.iter().zip(&lane.width_m) {
            let reach = ((width_m + widest_m) / 2.0 / CELL_M).ceil() as i64;
            let (i, j) = cell(*p);
            let near = (i - reach..=i + reach).flat_map(|i| by_cell.range((i, j - reach)..=(i, j + reach)));
            let below = near.map(|(_, cell)| cell).filter(|cell| p.z - cell.lowest_m >= at_least_m);
            for (lower, point) in below.flat_map(|cell| &cell.points).copied() {
                let (q, below) = (lanes[lower].center[point], &lanes[lower]);
                // Lanes of a banked road lie side by side and at other heights.
                let share = if below.road == lane.road { ONE_ROAD_SHARE } else { 1.0 };
                let overlaps = || (*p - q).truncate().length() < share * (width_m + below.width_m[point]) / 2.0;
                if p.z - q.z >= at_least_m && overlaps() {
                    crossings.push(Crossing { upper: *p, lower: q, lanes: [upper, lower], point });
                }
            }
        }
    }
    crossings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::RoadNetwork;

    /// Straight roads of two lanes, each at a height and turned by a right angle or not, with its middle at a place.
    fn roads(placed: &[(bool, f64, (f64, f64))]) -> Vec<Lane> {
        let mut lanes = Vec::new();
        for (road, (is_turned, z_m, (x, y))) in (0..).zip(placed) {
            for mut lane in RoadNetwork::straight(300.0, 3.5).lanes {
                let turned = |p: &DVec3| if *is_turned { DVec3::new(-p.y, p.x, 0.0) } else { *p };
                lane.center.iter_mut().for_each(|p| *p = turned(p) + DVec3::new(*x, *y, *z_m));
                lane.road = road;
                lanes.push(lane);
            }
        }
        lanes
    }

    #[test]
    fn roads_cross_where_one_has_room_below_the_other() {
        let count = |placed: &[(bool, f64, (f64, f64))]| Overpass::all(&roads(placed)).len();
        let under = (false, 0.0, (0.0, 0.0));
        assert_eq!(count(&[under, (true, 5.0, (0.0, 0.0))]), 1);
        assert_eq!(count(&[under, (true, -5.0, (0.0, 0.0))]), 1, "whichever road comes first");
        assert_eq!(count(&[under, (true, 0.0, (0.0, 0.0))]), 0, "a level crossing");
        assert_eq!(count(&[under, (true, 2.0, (0.0, 0.0))]), 0, "no room for a car");
        assert_eq!(count(&[under, (false, 5.0, (0.0, 12.0))]), 0, "side by side");
        // Two bridges, two carriageways on one, and three levels over each other.
        assert_eq!(count(&[under, (true, 5.0, (-60.0, 0.0)), (true, 5.0, (60.0, 0.0))]), 2);
        assert_eq!(count(&[under, (true, 5.0, (-6.0, 0.0)), (true, 5.0, (6.0, 0.0))]), 1);
        assert_eq!(count(&[under, (true, 5.0, (0.0, 0.0)), (false, 10.0, (0.0, 0.0))]), 2);
    }

    #[test]
    fn crossings_are_points_over_each_other() {
        let lanes = roads(&[(false, 0.0, (0.0, 0.0)), (true, 6.0, (20.0, 0.0))]);
        let overpasses = Overpass::all(&lanes);
        for crossing in &overpasses[0].crossings {
            assert_eq!([crossing.upper.z, crossing.lower.z], [6.0, 0.0]);
            assert!((crossing.upper - crossing.lower).truncate().length() < 3.5);
            assert_eq!(lanes[crossing.lanes[1]].center[crossing.point], crossing.lower);
        }
        let nearest = overpasses[0].nearest(DVec3::new(20.0, 40.0, 0.0));
        assert!((nearest.1 - 35.0).abs() < 2.0, "{nearest:?}");
    }

    #[test]
    fn the_lanes_of_a_banked_road_are_no_levels() {
        let mut lanes = RoadNetwork::straight(300.0, 5.0).lanes;
        // By 45 degrees.
        lanes.iter_mut().flat_map(|l| &mut l.center).for_each(|p| (p.y, p.z) = (p.y * 0.707, p.y * 0.707));
        assert!(crossings(&lanes, 1.5).is_empty());
    }

    #[test]
    fn a_road_that_winds_over_itself_is_no_bridge() {
        let mut lanes = RoadNetwork::straight(300.0, 3.5).lanes;
        for lane in &mut lanes {
            let turns = lane.s_m.iter().map(|s| s / 60.0);
            let place =
                |t: f64| cadet_base::plane::unit(t * cadet_base::math::TAU).extend(0.0) * 9.5 + DVec3::Z * 5.0 * t;
            lane.center = turns.map(place).collect();
        }
        assert!(Overpass::all(&lanes).is_empty() && !crossings(&lanes, CLEARANCE_M).is_empty());
    }
}
