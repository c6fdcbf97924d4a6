//! The ways through a junction: which lane leads to which.

use crate::plan::junction::{OnRing, Roundabout, StreetArm, StreetEnd};
use crate::plan::{PlanCurve, PlanPose};
use cadet_base::math::{PI, wrap_angle};

/// Ways that bend less than this go straight on.
pub(crate) const STRAIGHT_RAD: f64 = 0.6;

/// A way through a junction: from one lane at a street's end to one at another's.
#[derive(Debug, Clone)]
pub(crate) struct PlannedTurn {
    pub(crate) junction: usize,
    pub(crate) from: StreetEnd,
    pub(crate) to: StreetEnd,
    /// Which of the lanes of its direction it leaves and reaches, 0 beside the middle of the road.
    pub(crate) lanes: [usize; 2],
    /// From the left edge of the one lane to the left edge of the other.
    pub(crate) curve: PlanCurve,
    /// True where the turn follows the curb, and so carries the sidewalk round the corner.
    pub(crate) along_curb: bool,
    /// True for a track, which leads from the one street's to the other's; its curve is the middle of both roads.
    pub(crate) is_track: bool,
    /// Where it is on the ring of a roundabout, if it is.
    pub(crate) on_ring: Option<OnRing>,
    /// Width of the paved strip to its left, where medians stop at the junction: at its beginning and its end.
    pub(crate) paved_left_m: [f64; 2],
}

/// The ways from each arm of a junction to each other one, across it or round a roundabout; arms go round
/// counter-clockwise.
pub(crate) fn turns(junction: usize, arms: &[StreetArm], roundabout: Option<&Roundabout>) -> Vec<PlannedTurn> {
    let mut turns = Vec::new();
    for (i, from) in arms.iter().enumerate() {
        let bend = |to: &StreetArm| wrap_angle(to.heading_rad - from.heading_rad - PI);
        let others = || arms.iter().enumerate().filter(|(j, _)| *j != i);
        let mut pairs: Vec<Vec<[usize; 2]>> = others()
            .map(|(j, to)| {
                let counts = [from.style.lanes_per_side, to.style.lanes_per_side];
                lane_pairs(counts, bend(to), j == (i + 1) % arms.len())
            })
            .collect();
        // A lane that leads nowhere goes straight on as well as it can.
        let straightest =
            others().enumerate().min_by(|(_, (_, a)), (_, (_, b))| bend(a).abs().total_cmp(&bend(b).abs()));
        if let Some((best, (_, to))) = straightest {
            for lane in 0..from.style.lanes_per_side {
                if !pairs.iter().flatten().any(|[leaves, _]| *leaves == lane) {
                    pairs[best].push([lane, lane.min(to.style.lanes_per_side - 1)]);
                }
            }
        }
        let turn = |to: &StreetArm, curve: PlanCurve| PlannedTurn {
            junction,
            from: from.from,
            to: to.from,
            lanes: [0, 0],
            curve,
            along_curb: false,
            is_track: false,
            on_ring: None,
            paved_left_m: [0.0; 2],
        };
        for (_, to) in others() {
            if from.style.tracks.is_some() && to.style.tracks.is_some() && bend(to).abs() < STRAIGHT_RAD {
                let curve = PlanCurve::between(from.pose().reversed(), to.pose());
                turns.push(PlannedTurn { is_track: true, ..turn(to, curve) });
            }
        }
        for ((j, to), pairs) in others().zip(&pairs) {
            let outermost = [from, to].map(|arm| arm.style.lanes_per_side - 1);
            for lanes in pairs {
                let edge = |arm: &StreetArm, pose: PlanPose, lane: usize| {
                    let right_m = arm.style.median_width_m / 2.0 + lane as f64 * arm.style.lane_width_m;
                    pose.shifted_right(right_m)
                };
                let ends = (edge(from, from.pose().reversed(), lanes[0]), edge(to, to.pose(), lanes[1]));
                let (curve, on_ring) = match roundabout {
                    Some(ring) => ring.way(ends.0, ends.1),
                    None => (PlanCurve::between(ends.0, ends.1), None),
                };
                let is_inner_and_straight = *lanes == [0, 0] && bend(to).abs() < STRAIGHT_RAD;
                turns.push(PlannedTurn {
                    lanes: *lanes,
                    on_ring,
                    along_curb: j == (i + 1) % arms.len() && *lanes == outermost,
                    paved_left_m: [from, to]
                        .map(|arm| if is_inner_and_straight { arm.style.median_width_m / 2.0 } else { 0.0 }),
                    ..turn(to, curve)
                });
            }
        }
    }
    turns
}

/// Which lanes of the one street lead to which of the other: on the right the outermost, on the left the innermost,
/// straight on each to its own.
fn lane_pairs([leaves, reaches]: [usize; 2], bend_rad: f64, is_along_curb: bool) -> Vec<[usize; 2]> {
    let outermost = [leaves - 1, reaches - 1];
    let mut pairs = if bend_rad > STRAIGHT_RAD {
        vec![[0, 0]]
    } else if bend_rad < -STRAIGHT_RAD {
        vec![outermost]
    } else {
        (0..leaves.min(reaches)).map(|lane| [lane, lane]).collect()
    };
    if is_along_curb && !pairs.contains(&outermost) {
        pairs.push(outermost);
    }
    pairs
}
