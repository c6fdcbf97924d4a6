//! Places to park: bays of the map, and stretches of kerb beside lanes wide enough.

use super::ParkingSpot;
use super::ground::{Ground, GroundKind};
use super::network::{Lane, LaneKind, RoadNetwork};
use crate::frames;
use crate::math::{DPose3, DVec2, DVec3};
use crate::rng::StreamKey;

/// Distance between the middles of spots: drawn per row.
const PITCH_M: (f64, f64) = (5.2, 6.0);
/// Bays narrower than this are tapering off.
const MIN_BAY_M: f64 = 1.8;
/// No kerbside parking this near to the end of a lane.
const CLEAR_OF_JUNCTION_M: f64 = 10.0;
/// Distance of a kerbside car's left flank from the middle of the lane beside it.
const CLEAR_OF_LANE_M: f64 = 1.65;
/// Room for a car in width; in a bay it lies towards the kerb.
const SPOT_WIDTH_M: f64 = 1.9;
const TYRE_TO_KERB_M: f64 = 0.1;
/// A kerbside car stands on the pavement with at most this much of its width, and people pass in what is left.
const MAX_ON_PAVEMENT_M: f64 = 1.3;
const LEFT_FOR_WALKERS_M: f64 = 0.9;
/// Kerbside rows need kerbs this straight over a car's length, bays this straight.
const MAX_TURN_RAD: f64 = 0.06;
const MAX_TURN_IN_BAY_RAD: f64 = 0.16;

/// Where cars may be parked: in the map's bays, and at the kerb of wide lanes without bays.
#[must_use]
pub fn parking_spots(network: &RoadNetwork, ground: &Ground, key: &StreamKey) -> Vec<ParkingSpot> {
    let mut spots = Vec::new();
    for lane in &network.lanes {
        let mut stream = key.indexed("town/parking", lane.id.0 as u64);
        let pitch = stream.range(PITCH_M.0, PITCH_M.1);
        match lane.kind {
            LaneKind::Parking => bays(lane, ground, pitch, &mut spots),
            LaneKind::Driving if lane.junction.is_none() => kerbside(lane, ground, pitch, &mut spots),
            _ => {}
        }
    }
    spots
}

fn bays(lane: &Lane, ground: &Ground, pitch: f64, spots: &mut Vec<ParkingSpot>) {
    let wide = |s: &f64| lane.width_at(*s) >= MIN_BAY_M;
    let reach: Vec<f64> = lane.s_m.iter().copied().filter(wide).collect();
    let (Some(from), Some(to)) = (reach.first(), reach.last()) else { return };
    let count = ((to - from) / pitch).floor() as usize;
    let margin = (to - from - count as f64 * pitch) / 2.0;
    for k in 0..count {
        let s = from + margin + (k as f64 + 0.5) * pitch;
        if turn_at(lane, s, pitch) > MAX_TURN_IN_BAY_RAD {
            continue;
        }
        let pose = lane.pose_at(s);
        let width_m = SPOT_WIDTH_M.min(lane.width_at(s));
        let right = ((lane.width_at(s) - width_m) / 2.0 - TYRE_TO_KERB_M).max(0.0);
        if let Some(world_from_spot) = stand(ground, &pose, -right, pitch, width_m) {
            spots.push(ParkingSpot { world_from_spot, length_m: pitch, width_m });
        }
    }
}

fn kerbside(lane: &Lane, ground: &Ground, pitch: f64, spots: &mut Vec<ParkingSpot>) {
    let (mut s, end) = (CLEAR_OF_JUNCTION_M + pitch / 2.0, lane.length_m() - CLEAR_OF_JUNCTION_M - pitch / 2.0);
    while s <= end {
        let pose = lane.pose_at(s);
        let right = kerbside_offset(lane, ground, s, pitch);
        if let Some(world_from_spot) = right.and_then(|r| stand(ground, &pose, -r, pitch, SPOT_WIDTH_M)) {
            spots.push(ParkingSpot { world_from_spot, length_m: pitch, width_m: SPOT_WIDTH_M });
        }
        s += pitch;
    }
}

/// By how much a lane turns over the length of a spot.
fn turn_at(lane: &Lane, s: f64, pitch: f64) -> f64 {
    lane.pose_at(s - pitch / 2.0).rotation.angle_between(lane.pose_at(s + pitch / 2.0).rotation)
}

/// How far right of the lane's middle a car may stand, if it may: the kerb must be where half a car fits.
fn kerbside_offset(lane: &Lane, ground: &Ground, s: f64, pitch: f64) -> Option<f64> {
    let (before, after) = (lane.pose_at(s - pitch / 2.0), lane.pose_at(s + pitch / 2.0));
    if turn_at(lane, s, pitch) > MAX_TURN_RAD {
        return None;
    }
    let flank = CLEAR_OF_LANE_M + SPOT_WIDTH_M;
    for pose in [before, lane.pose_at(s), after] {
        let kind = |right: f64| {
            let p = pose.transform_point(DVec3::new(0.0, -right, 0.0));
            ground.kind_at(p.x, p.y)
        };
        let kerb_is_far = kind(flank - MAX_ON_PAVEMENT_M) == Some(GroundKind::Road);
        let room_to_walk = kind(flank + LEFT_FOR_WALKERS_M) == Some(GroundKind::Pavement);
        if !(kerb_is_far && room_to_walk) {
            return None;
        }
    }
    Some(CLEAR_OF_LANE_M + SPOT_WIDTH_M / 2.0)
}

/// The pose of a car that stands `left_m` left of `lane_pose`, its wheels on the ground (half on a kerb, if need be).
fn stand(ground: &Ground, lane_pose: &DPose3, left_m: f64, length: f64, width: f64) -> Option<DPose3> {
    let forward = (lane_pose.rotation * DVec3::X).truncate().normalize_or_zero();
    let left = forward.perp();
    let middle = lane_pose.translation.truncate() + left * left_m;
    let wheel = |along: f64, across: f64| -> Option<DVec3> {
        let p: DVec2 = middle + forward * (along * length * 0.25) + left * (across * width * 0.38);
        Some(p.extend(ground.height_at(p.x, p.y)?))
    };
    let (front_left, front_right) = (wheel(1.0, 1.0)?, wheel(1.0, -1.0)?);
    let (rear_left, rear_right) = (wheel(-1.0, 1.0)?, wheel(-1.0, -1.0)?);
    let along = front_left + front_right - rear_left - rear_right;
    let across = front_left + rear_left - front_right - rear_right;
    let z = (front_left.z + front_right.z + rear_left.z + rear_right.z) / 4.0;
    Some(frames::facing(middle.extend(z), along, along.cross(across)))
}
