//! Which streets have a lane for bicycles on the carriageway, and of which kind.

use crate::plan::{CycleLane, LineStyle, StreetKind};
use cadet_base::rng::Stream;

/// Share of those that cars may use, of streets that are no main roads and of main roads.
const ADVISORY_SHARE: (f64, f64) = (0.55, 0.2);
/// Width of a lane for bicycles alone, line included, and of one that cars may use (RASt 06, ERA 2010).
const WIDTH_M: f64 = 1.85;
const ADVISORY_M: (f64, f64) = (1.25, 1.5);
/// Share of those that are red in junctions.
const RED_SHARE: f64 = 0.35;
/// The lane beside it is not wider.
const WIDEST_LANE_M: f64 = 3.25;

/// Gives some of the streets that are faster than others cycle lanes on both sides.
pub(crate) fn draw(stream: &mut Stream, share: f64, styles: &mut [LineStyle]) {
    for style in styles {
        let (has_one, kind, red) = (stream.chance(share), stream.unit(), stream.chance(RED_SHARE));
        let advisory_m = (stream.within(ADVISORY_M) * 20.0).round() / 20.0;
        let is_fit = style.speed_kmh > 30 && style.country.is_none() && style.kind == StreetKind::Usual;
        if has_one && is_fit {
            let is_advisory = kind < if style.is_main_road() { ADVISORY_SHARE.1 } else { ADVISORY_SHARE.0 };
            let width_m = if is_advisory { advisory_m } else { WIDTH_M };
            style.cycle_lane = Some(CycleLane { width_m, is_advisory, is_red: red });
            style.lane_width_m = style.lane_width_m.min(WIDEST_LANE_M);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::ground::{Ground, GroundKind};
    use crate::network::{Lane, LaneKind, PaintColor, RoadNetwork};
    use crate::paint::{Paint, cycle_markings};
    use crate::plan::{SuburbConfig, generate};
    use crate::roadside::parking_spots;
    use cadet_base::math::DVec3;
    use cadet_base::rng::StreamKey;

    fn network(seed: u64) -> RoadNetwork {
        let config = SuburbConfig { blocks: (3, 3), main_share: 0.5, cycle_lane_share: 1.0, ..SuburbConfig::default() };
        generate(&StreamKey::scene(seed), &config).unwrap().network
    }

    /// The driving lane to the left of a cycle lane, and how far apart their edges are in the middle.
    fn beside<'a>(network: &'a RoadNetwork, lane: &Lane) -> Option<(&'a Lane, f64)> {
        let s_m = lane.length_m() / 2.0;
        let pose = lane.pose_at(s_m);
        let apart = |o: &Lane| {
            let (at_m, _) = o.project(pose.translation);
            let to = o.point_at(at_m) - pose.translation;
            (to.dot(pose.rotation * DVec3::Y) - (o.width_at(at_m) + lane.width_at(s_m)) / 2.0).abs()
        };
        let of_road = network.driving().filter(|o| o.road == lane.road);
        of_road.map(|o| (o, apart(o))).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    #[test]
    fn cycle_lanes_lie_right_of_the_driving_lanes_of_fast_streets_with_the_lines_of_their_kind() {
        let mut kinds = [0, 0];
        for seed in 0..8 {
            let network = network(seed);
            let ground = Ground::new(&network).unwrap();
            let spots = parking_spots(&network, &ground, &StreamKey::scene(seed));
            for lane in network.of_kind(LaneKind::Biking).filter(|l| l.junction.is_none()) {
                assert!(lane.speed_limit_mps > 10.0, "seed {seed}");
                let (s_m, width_m) = (lane.length_m() / 2.0, lane.width_at(lane.length_m() / 2.0));
                let is_advisory = (1.249..1.501).contains(&width_m);
                assert!(is_advisory || (width_m - 1.85).abs() < 1e-3, "seed {seed}: {width_m} m");
                kinds[usize::from(is_advisory)] += 1;
                let (driving, apart_m) = beside(&network, lane).unwrap();
                assert!(apart_m < 0.02, "seed {seed}: {apart_m} m from the driving lane");
                assert!((2.75..3.31).contains(&driving.width_at(s_m)), "seed {seed}: {} m", driving.width_at(s_m));
                // Carriageway up to the right edge.
                for right_m in [0.5 - width_m, 0.0, width_m / 2.0 - 0.1] {
                    let p = lane.pose_at(s_m).transform_point(DVec3::NEG_Y * right_m);
                    assert_eq!(ground.kind_at(p.x, p.y), Some(GroundKind::Road), "seed {seed}");
                }
                // The line on its left border: how much of it is painted, and how wide it is.
                let (mut painted_m, mut wide_m) = (0.0, 0.0_f64);
                for mark in &network.lane_marks {
                    let middle = mark.corners.iter().sum::<DVec3>() / 4.0;
                    let (at_m, _) = lane.project(middle);
                    let left = (middle - lane.point_at(at_m)).dot(lane.pose_at(at_m).rotation * DVec3::Y);
                    if at_m > 0.0 && at_m < lane.length_m() && (left - width_m / 2.0).abs() < 0.05 {
                        let [a, b, c, _] = mark.corners;
                        let (one, other) = ((b - a).length(), (c - b).length());
                        painted_m += one.max(other);
                        wide_m = wide_m.max(one.min(other));
                    }
                }
                let (share, expected_m) = (painted_m / lane.length_m(), if is_advisory { 0.12 } else { 0.25 });
                assert!((wide_m - expected_m).abs() < 0.02, "seed {seed}: a line of {wide_m} m, {width_m} m wide");
                let is_right = if is_advisory { (0.3..0.7).contains(&share) } else { (0.9..1.1).contains(&share) };
                assert!(
                    lane.length_m() < 12.0 || is_right,
                    "seed {seed}: {share} of the line of a lane of {width_m} m"
                );
                for spot in &spots {
                    let (_, off_m) = lane.project(spot.world_from_spot.translation);
                    assert!(off_m > (width_m + spot.width_m) / 2.0 + 0.2, "seed {seed}: a place {off_m} m from one");
                }
            }
        }
        assert!(kinds.iter().all(|n| *n > 10), "{kinds:?}");
    }

    #[test]
    fn cycle_lanes_lead_over_junctions_to_every_other_arm_without_a_gap() {
        let (mut onto_lanes, mut onto_streets) = (0, 0);
        for seed in 0..6 {
            let network = network(seed);
            for lane in network.of_kind(LaneKind::Biking) {
                assert!(
                    !lane.successors.is_empty() && !lane.predecessors.is_empty(),
                    "seed {seed}: {}",
                    lane.center[0]
                );
                let end = lane.center[lane.center.len() - 1];
                for next in lane.successors.iter().map(|id| network.lane(*id)) {
                    let gap_m = (next.center[0] - end).truncate().length();
                    if next.kind == LaneKind::Biking {
                        onto_lanes += usize::from(lane.junction.is_some());
                        assert!(gap_m < 0.02, "seed {seed}: {gap_m} m");
                    } else {
                        // To the place that cyclists have on streets without: a meter from the edge.
                        onto_streets += 1;
                        let expected_m = next.width_at(0.0) / 2.0 - 1.0;
                        assert!(lane.junction.is_some() && (gap_m - expected_m).abs() < 0.02, "seed {seed}: {gap_m} m");
                    }
                }
            }
        }
        assert!(onto_lanes > 50 && onto_streets > 50, "{onto_lanes} {onto_streets}");
    }

    #[test]
    fn bicycles_are_painted_on_cycle_lanes_and_coats_over_junctions() {
        let (mut white, mut red) = (0, 0);
        for seed in 0..12 {
            let network = network(seed);
            let mut paint = Paint::new(&|_| Some((0.0, true)), true);
            cycle_markings::draw(&network, &mut paint);
            for quad in &paint.quads {
                let middle = quad.corners.iter().sum::<DVec3>() / 4.0;
                let is_on = |l: &&Lane| {
                    let (s_m, off_m) = l.project(middle);
                    off_m < l.width_at(s_m) / 2.0 && l.junction.is_some() == (quad.color == PaintColor::Red)
                };
                assert!(network.of_kind(LaneKind::Biking).any(|l| is_on(&l)), "seed {seed}");
                let [a, b, c, _] = quad.corners;
                assert!((b - a).cross(c - b).z > 0.0, "seed {seed}: faces down");
                white += usize::from(quad.color == PaintColor::White);
                red += usize::from(quad.color == PaintColor::Red);
            }
        }
        assert!(white > 500 && red > 50, "{white} {red}");
    }

    #[test]
    fn where_none_are_asked_for_suburbs_keep_their_text() {
        for seed in 0..4 {
            let text = |share: f64| {
                let config = SuburbConfig { main_share: 0.3, cycle_lane_share: share, ..SuburbConfig::default() };
                generate(&StreamKey::scene(seed), &config).unwrap().xodr
            };
            let (without, with) = (text(0.0), text(1.0));
            assert!(!without.contains("biking") && with.contains("biking"), "seed {seed}");
        }
    }
}
