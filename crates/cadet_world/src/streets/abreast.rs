//! Which lanes run side by side in one direction.

use std::collections::BTreeMap;

use crate::params::COS_SAME_WAY;
use cadet_base::math::DVec3;
use cadet_town::{Lane, LaneId, LaneKind};

/// Lanes are abreast if their middles are so far apart, as shares of the mean of their widths.
const APART: (f64, f64) = (0.75, 1.3);

/// The lanes beside each toward the middle of the road and toward the curb, outside junctions.
pub(crate) fn neighbors(lanes: &[Lane]) -> Vec<[Option<LaneId>; 2]> {
    let mut by_road: BTreeMap<u32, Vec<&Lane>> = BTreeMap::new();
    for lane in lanes.iter().filter(|l| l.kind == LaneKind::Driving && l.junction.is_none()) {
        by_road.entry(lane.road).or_default().push(lane);
    }
    let mut beside = vec![[None; 2]; lanes.len()];
    for of_road in by_road.values() {
        for lane in of_road {
            let middle_m = lane.length_m() / 2.0;
            let here = lane.pose_at(middle_m);
            let (along, inward) = (here.rotation * DVec3::X, here.rotation * DVec3::Y * -lane.curb_side());
            for other in of_road.iter().filter(|o| o.id != lane.id) {
                let (s_m, _) = other.project(here.translation);
                let there = other.pose_at(s_m);
                let to = there.translation - here.translation;
                let width_m = (lane.width_at(middle_m) + other.width_at(s_m)) / 2.0;
                let apart = to.dot(inward).abs() / width_m;
                // Lanes of another section lie before or behind.
                let is_abreast = to.dot(along).abs() < 2.0 && (there.rotation * DVec3::X).dot(along) > COS_SAME_WAY;
                if is_abreast && (APART.0..APART.1).contains(&apart) {
                    beside[lane.id.0][usize::from(to.dot(inward) < 0.0)] = Some(other.id);
                }
            }
        }
    }
    beside
}
